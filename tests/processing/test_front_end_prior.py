"""A short drop with what earlier runs know about the front ends: better with it, not spoiled where it is wrong."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from benchmarks.world.generic.draw import draw_scene
from benchmarks.world.generic.scene import SceneRecord, make_record
from support.changed import changed

from radargui.model.front_end import FrontEnd, FrontEndPrior
from radargui.model.result import RunResult
from radargui.model.setup import Setup
from radargui.processing.process import process

RUNS = ("run-0001", "run-0002", "run-0003")


@pytest.fixture(scope="module")
def short() -> SceneRecord:
    """A drop of 2 cm: about two fringes."""
    fixed = {"rate_hz": 5000.0, "snr_db": 35.0, "skew_s": 0.0, "floor": 0.0, "wall": 0.0, "flicker": 0.0, "drag": 0.0}
    fixed["moving_s"] = 0.3
    return make_record(draw_scene(4, "physical", "drop", height_m=0.02, e=0.7, drift_m_s=0.01, n_receivers=3, **fixed))


@pytest.fixture(scope="module")
def setup(short: SceneRecord) -> Setup:
    return changed(short.setup, processing={"correction": "joint"})


def true_front_ends(record: SceneRecord) -> tuple[FrontEnd, ...]:
    return tuple(
        FrontEnd(own.gain, 1.1e-3, float(np.degrees(own.quadrature_rad)), 0.055) for own in record.scene.receiving
    )


def gain_errors(record: SceneRecord, result: RunResult) -> np.ndarray:
    assert result.corrected is not None
    assert result.corrected.method == "joint"
    pairs = zip(result.corrected.channels, record.scene.receiving, strict=True)
    return np.array([(channel.gain_ratio or 0.0) - own.gain for channel, own in pairs])


@pytest.mark.slow
def test_a_short_drop_finds_its_front_ends_better_with_what_is_known_and_says_from_where(
    short: SceneRecord, setup: Setup
) -> None:
    alone = process(short.recording, setup)
    assert alone.front_end_prior is None
    known = FrontEndPrior(RUNS, true_front_ends(short))
    helped = process(short.recording, setup, front_ends=known)
    assert helped.front_end_prior == known
    assert np.abs(gain_errors(short, helped)).max() < 0.3 * np.abs(gain_errors(short, alone)).max()
    assert not any("front ends" in warning for warning in helped.warnings)
    assert helped.corrected is not None
    assert helped.corrected.channels[0].prior_runs == RUNS
    assert (helped.corrected.channels[0].u_gain_ratio or 1.0) < 0.002


@pytest.mark.slow
def test_a_run_with_another_mixer_is_not_spoiled_and_says_so(short: SceneRecord, setup: Setup) -> None:
    first, *others = true_front_ends(short)
    wrong = FrontEndPrior(RUNS, (replace(first, gain_ratio=first.gain_ratio + 0.05), *others))
    result = process(short.recording, setup, front_ends=wrong)
    assert result.front_end_prior == replace(wrong, used=False)
    assert any("run-0001 to run-0003 say" in w and "(receiver 1: gain" in w for w in result.warnings)
    assert np.abs(gain_errors(short, result)).max() < 0.02
