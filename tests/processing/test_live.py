"""Live processing against truth, block by block."""

from __future__ import annotations

import numpy as np
import pytest
from support.changed import changed

from radargui.model.resources import default_setup_path
from radargui.model.setup import Setup
from radargui.model.setup_file import read_setup
from radargui.processing.live import LiveProcessor
from radargui.sources.simulated.recording import simulate_recording


@pytest.fixture(scope="module")
def setup() -> Setup:
    return read_setup(default_setup_path())


@pytest.mark.parametrize("block", [400, 667, 5000])
def test_the_live_track_follows_a_bouncing_drop_within_half_a_millimetre(setup: Setup, block: int) -> None:
    recording, truth = simulate_recording(setup)
    live = LiveProcessor(setup, recording.digitisation)
    estimates = [
        live.push(recording.raw[:, begin : begin + block], begin) for begin in range(0, recording.n_samples, block)
    ]
    index = np.concatenate([estimate.index for estimate in estimates])
    position = np.concatenate([estimate.position_m for estimate in estimates], axis=1)
    assert (np.diff(index) > 0).all()
    assert np.isfinite(position).all()
    error = np.linalg.norm(position - truth.position_m[:, index], axis=0)
    assert np.sqrt(np.mean(error**2)) < 0.5e-3
    assert error.max() < 3e-3
    assert estimates[0].moving is False
    assert any(estimate.moving for estimate in estimates)
    assert estimates[-1].moving is False


def test_a_jump_of_the_index_starts_anew_at_the_release(setup: Setup) -> None:
    recording, _ = simulate_recording(setup)
    live = LiveProcessor(setup, recording.digitisation)
    for begin in range(0, 40000, 1000):
        live.push(recording.raw[:, begin : begin + 1000], begin)
    estimate = live.push(recording.raw[:, :1000], 1_000_000)
    assert estimate.index[0] >= 1_000_000
    assert estimate.position_m[:, 0] == pytest.approx(setup.tracer.release_position_m)


def test_one_receiver_has_a_live_path_and_no_position(setup: Setup) -> None:
    plain = setup.model_dump(by_alias=True)
    plain["receiver"], plain["daq"]["channels"] = plain["receiver"][:1], None
    single = Setup.model_validate(plain)
    recording, truth = simulate_recording(single)
    live = LiveProcessor(single, recording.digitisation)
    estimates = [live.push(recording.raw[:, k : k + 1000], k) for k in range(0, recording.n_samples, 1000)]
    change = np.concatenate([estimate.change_m for estimate in estimates], axis=1)
    index = np.concatenate([estimate.index for estimate in estimates])
    true = truth.path_m[:, index] - truth.path_m[:, :1]
    assert np.sqrt(np.mean((change - true) ** 2)) < 1e-3


def test_a_sphere_at_rest_stays_at_its_release(setup: Setup) -> None:
    still = changed(setup, simulation={"scene": "rest"})
    recording, _ = simulate_recording(still)
    estimate = LiveProcessor(still, recording.digitisation).push(recording.raw)
    assert estimate.position_m == pytest.approx(
        np.repeat(np.array(still.tracer.release_position_m)[:, None], estimate.index.size, axis=1)
    )
