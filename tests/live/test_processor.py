"""Live processing against truth, block by block."""

from __future__ import annotations

import numpy as np
import pytest
from support.changed import changed
from support.simulated_once import simulate_once

from radargui.live.processor import LiveMemory, LiveProcessor
from radargui.live.track import LiveEstimate
from radargui.model.arrays import FloatArray
from radargui.model.setup import Setup, read_setup
from radargui.sources.simulated.model import SimulatedRadar, SimulatedSource
from radargui.system.resources import default_setup_path


@pytest.fixture(scope="module")
def setup() -> Setup:
    return read_setup(default_setup_path())


@pytest.fixture(scope="module")
def short(setup: Setup) -> Setup:
    """The same with fewer bounces."""
    return changed(setup, simulation={"restitution": 0.6, "rest_s": 0.4, "settle_s": 0.4})


def live_errors(
    setup: Setup, *, block: int = 667, run: int = 0, memory: LiveMemory | None = None
) -> tuple[FloatArray, FloatArray]:
    """Return the distance of the live position from the truth after the first fringe, in m, and all of it."""
    recording, truth = simulate_once(setup, run)
    live = LiveProcessor(setup, recording.digitisation, memory)
    estimates = [
        live.push(recording.raw[:, begin : begin + block], begin) for begin in range(0, recording.n_samples, block)
    ]
    index = np.concatenate([estimate.index for estimate in estimates])
    position = np.concatenate([estimate.position_m for estimate in estimates], axis=1)
    assert (np.diff(index) > 0).all()
    assert np.isfinite(position).all()
    error = np.linalg.norm(position - truth.position_m[:, index], axis=0)
    moved = np.abs(truth.path_m[:, index] - truth.path_m[:, :1]).max(axis=0) > setup.radar.wavelength_m
    assert estimates[0].moving is False
    assert any(estimate.moving for estimate in estimates)
    assert estimates[-1].moving is False
    return error[int(np.argmax(moved)) :], error


def rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def test_an_inverted_q_gives_the_same_track_and_shows_its_q_as_it_is_wired(short: Setup) -> None:
    recording, _ = simulate_once(short)
    raw = recording.raw.copy()
    # 0 V is code 0
    raw[1::2] *= -1
    straight = LiveProcessor(short, recording.digitisation)
    mirrored = LiveProcessor(changed(short, radar={"phase_sign": -1}), recording.digitisation)
    n_known = 0
    for begin in range(0, recording.n_samples, 667):
        one, other = (
            live.push(own[:, begin : begin + 667]) for live, own in ((straight, recording.raw), (mirrored, raw))
        )
        assert other.position_m == pytest.approx(one.position_m, abs=1e-9)
        known = np.isfinite(one.q)
        assert other.q[known] == pytest.approx(-one.q[known], abs=1e-9)
        n_known += int(known.sum())
    assert n_known > 0


@pytest.mark.parametrize("block", [400, 5000])
def test_the_live_track_follows_a_bouncing_drop_within_0_15_mm(short: Setup, block: int) -> None:
    after, whole = live_errors(short, block=block)
    assert rms(after) < 0.15e-3
    assert whole.max() < 1e-3


@pytest.mark.parametrize(
    ("simulation", "bound_m"),
    [({"reflection": 0.1}, 0.2e-3), ({"reflection": 0.2}, 0.2e-3), ({"mismatch": 0.1}, 0.5e-3), ({"seed": 3}, 0.2e-3)],
)
def test_the_live_track_is_true_also_with_reflections_and_strong_mismatch(
    short: Setup, simulation: dict[str, float], bound_m: float
) -> None:
    after, _ = live_errors(changed(short, simulation=simulation))
    assert rms(after) < bound_m


def test_what_a_run_taught_is_there_from_the_first_sample_of_the_next(short: Setup) -> None:
    memory = LiveMemory()
    assert not memory.is_warm
    live_errors(short, memory=memory)
    assert memory.is_warm
    recording, truth = simulate_once(short, 1)
    live = LiveProcessor(short, recording.digitisation, memory)
    late = 0
    for begin in range(0, recording.n_samples, 667):
        samples = recording.raw[:, begin : begin + 667]
        estimate = live.push(samples, begin)
        late = max(late, begin + samples.shape[1] - int(estimate.index[-1]))
        assert np.isfinite(estimate.i).all()
        error = estimate.position_m - truth.position_m[:, estimate.index]
        assert np.linalg.norm(error, axis=0).max() < 1e-3
    assert late < 16


def test_a_tracer_that_is_carried_back_is_followed_and_is_at_its_release_again(setup: Setup) -> None:
    source = SimulatedSource(setup, repeat=True)
    live = LiveProcessor(setup, source.open())
    source.start()
    estimates: list[LiveEstimate] = []
    n = 0
    while n < 8 * setup.daq.rate_hz:
        block = source.read()
        assert block is not None
        estimates.append(live.push(block.samples, block.first_index))
        n = block.end_index
    index = np.concatenate([estimate.index for estimate in estimates])
    position = np.concatenate([estimate.position_m for estimate in estimates], axis=1)
    error = np.linalg.norm(position - source.truth(0, n).position_m[:, index], axis=0)
    assert rms(error) < 0.2e-3
    back = position[:, np.abs(index / setup.daq.rate_hz - 5.2).argmin()]
    assert back == pytest.approx(setup.tracer.release_position_m)


def test_samples_lost_in_motion_leave_the_place_unknown_until_the_next_rest(setup: Setup) -> None:
    recording, _ = simulate_once(setup)
    live = LiveProcessor(setup, recording.digitisation)
    for begin in range(0, 30000, 1000):
        live.push(recording.raw[:, begin : begin + 1000], begin)
    assert live.push(recording.raw[:, 30000:31000], 30000).moving
    lost = live.push(recording.raw[:, 32000:33000], 1_000_000)
    assert lost.index[0] >= 1_000_000
    assert np.isnan(lost.position_m).all()
    assert lost.began_anew
    index = 1_001_000
    for _ in range(20):
        estimate = live.push(recording.raw[:, :1000], index)
        index += 1000
    assert estimate.position_m[:, -1] == pytest.approx(setup.tracer.release_position_m)
    assert estimate.began_anew, "nobody knows whether that is its release, until a run is armed"
    live.at_release()
    assert not live.push(recording.raw[:, :1000], index).began_anew


def test_a_release_lost_in_a_gap_gives_no_track_from_the_release(setup: Setup) -> None:
    recording, truth = simulate_once(setup)
    fallen = int(np.argmax(truth.position_m[2] < truth.position_m[2, 0] - 0.1))
    live = LiveProcessor(setup, recording.digitisation)
    for begin in range(0, 20000, 1000):
        assert not live.push(recording.raw[:, begin : begin + 1000], begin).began_anew
    after = [live.push(recording.raw[:, k : k + 500], k) for k in range(fallen, fallen + 5000, 500)]
    assert np.isnan(np.concatenate([one.position_m for one in after[1:]], axis=1)).all()
    assert all(one.began_anew for one in after)


@pytest.mark.parametrize(("lost_s", "anew"), [(0.02, False), (1.0, True)])
def test_a_gap_at_rest_counts_where_the_tracer_may_have_fallen_in_it(setup: Setup, lost_s: float, anew: bool) -> None:
    recording, _ = simulate_once(changed(setup, simulation={"scene": "rest"}))
    live = LiveProcessor(setup, recording.digitisation)
    live.push(recording.raw[:, :5000], 0)
    at = 5000 + round(lost_s * setup.daq.rate_hz)
    estimate = live.push(recording.raw[:, 5000:9000], at)
    assert estimate.began_anew is anew
    assert estimate.position_m[:, -1] == pytest.approx(setup.tracer.release_position_m)


def test_when_a_run_is_armed_the_tracer_is_at_its_release(setup: Setup) -> None:
    radar = SimulatedRadar(setup, repeat=True)
    n_samples = simulate_once(setup)[0].n_samples
    live = LiveProcessor(setup, radar.digitisation)
    # in the hand, on the way back from the floor
    for begin in range(0, n_samples + 25000, 1000):
        estimate = live.push(radar.samples(begin, 1000), begin)
    assert -0.10 < estimate.position_m[2, -1] < 0.10
    live.at_release()
    assert live.push(radar.samples(0, 1000)).position_m[:, -1] == pytest.approx(setup.tracer.release_position_m)


def test_one_receiver_has_a_live_path_and_no_position(setup: Setup) -> None:
    plain = setup.model_dump(by_alias=True)
    plain["receiver"], plain["daq"]["channels"] = plain["receiver"][:1], None
    single = Setup.model_validate(plain)
    recording, truth = simulate_once(single)
    live = LiveProcessor(single, recording.digitisation)
    estimates = [live.push(recording.raw[:, k : k + 1000], k) for k in range(0, recording.n_samples, 1000)]
    change = np.concatenate([estimate.change_m for estimate in estimates], axis=1)
    index = np.concatenate([estimate.index for estimate in estimates])
    true = truth.path_m[:, index] - truth.path_m[:, :1]
    assert np.sqrt(np.mean((change - true) ** 2)) < 1e-3


def test_a_sphere_at_rest_stays_at_its_release(setup: Setup) -> None:
    still = changed(setup, simulation={"scene": "rest"})
    recording, _ = simulate_once(still)
    estimate = LiveProcessor(still, recording.digitisation).push(recording.raw)
    assert estimate.position_m == pytest.approx(
        np.repeat(np.array(still.tracer.release_position_m)[:, None], estimate.index.size, axis=1)
    )


def test_arming_while_the_sphere_lies_on_the_floor_does_not_move_it_to_its_release(setup: Setup) -> None:
    radar = SimulatedRadar(setup, repeat=True)
    recording, truth = simulate_once(setup)
    live = LiveProcessor(setup, radar.digitisation)
    count, back = recording.n_samples, recording.n_samples + 70000
    for begin in range(0, count, 1000):
        live.push(radar.samples(begin, min(1000, count - begin)), begin)
    live.at_release()
    wrong = []
    for begin in range(count, back, 1000):
        estimate = live.push(radar.samples(begin, 1000), begin)
        if estimate.index.size:
            true = radar.truth(begin, 1000).position_m[:, estimate.index - begin]
            wrong.append(np.linalg.norm(estimate.position_m - true, axis=0))
    assert truth.position_m[2, -1] == pytest.approx(-0.14)
    assert np.nanmax(np.concatenate(wrong)) < 20e-3


def test_the_phase_of_a_metal_sphere_is_not_taken_for_motion(short: Setup) -> None:
    clean = {"mismatch": 0.0, "snr_db": 60.0, "sphere": "metal", "lateral_speed_m_s": 0.05}
    plain = changed(short, simulation=clean)
    told = changed(plain, transmitter={"polarization_deg": 0.0})
    as_point, as_metal = (rms(live_errors(one)[0]) for one in (plain, told))
    assert as_metal < 0.15e-3
    assert as_point > 2.0 * as_metal
