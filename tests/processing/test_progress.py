"""The share done of a run only grows, whatever has to begin anew, and goes on growing while it does."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from benchmarks.scoring.budget import with_correction
from benchmarks.world.broken.drops import make_drop
from benchmarks.world.generic.draw import draw_scene
from benchmarks.world.generic.scene import make_record
from support.changed import changed
from support.simulated_recording import simulate_recording
from support.small_setups import quick_setup

from radargui.model.errors import ProcessingError
from radargui.model.front_end import FrontEnd, FrontEndPrior
from radargui.model.recording import Recording
from radargui.model.result import RunResult
from radargui.model.setup import Setup
from radargui.processing.measured_motion import Progress, Report
from radargui.processing.process import process

Path = Callable[[Report], RunResult]


def rejected_receiver(report: Report) -> RunResult:
    """One of four receivers that only the correction finds drowned: the others are corrected anew."""
    drop = make_drop(3, "whole", 4)
    raw = drop.recording.raw.astype(float)
    pair = raw[2:4]
    pair += np.random.default_rng(1).normal(0.0, 1.2 * pair.std(), pair.shape)
    recording = replace(drop.recording, raw=np.round(raw).astype(np.int16))
    result = process(recording, with_correction(drop.setup, "ellipse"), report)
    assert any("go on without it" in one for one in result.warnings)
    return result


def with_prior(report: Report) -> RunResult:
    """A drop of two fringes: a second joint estimate with what earlier runs know."""
    fixed = {"rate_hz": 5000.0, "snr_db": 35.0, "skew_s": 0.0, "floor": 0.0, "wall": 0.0, "flicker": 0.0, "drag": 0.0}
    scene = draw_scene(
        4, "physical", "drop", height_m=0.02, e=0.7, drift_m_s=0.01, n_receivers=3, moving_s=0.3, **fixed
    )
    front_ends = tuple(
        FrontEnd(own.gain, 1.1e-3, float(np.degrees(own.quadrature_rad)), 0.055) for own in scene.receiving
    )
    record = make_record(scene)
    prior = FrontEndPrior(("run-0001", "run-0002"), front_ends)
    result = process(record.recording, changed(record.setup, processing={"correction": "joint"}), report, None, prior)
    assert result.front_end_prior == prior
    return result


def small_drop() -> tuple[Recording, Setup]:
    setup = changed(quick_setup(), daq={"rate_hz": 2000.0}, processing={"correction": "joint"})
    return simulate_recording(setup)[0], setup


def adaptive_instead(report: Report) -> RunResult:
    """The joint estimate fails halfway."""

    def fail_once(share: float) -> None:
        report(share)
        if share > 0.4 and not failed:
            failed.append(share)
            raise ProcessingError("No solution.")

    failed: list[float] = []
    result = process(*small_drop(), fail_once)
    assert any("the adaptive one was used" in one for one in result.warnings)
    return result


def published_instead(report: Report) -> RunResult:
    """No estimate can be made: the published procedure stands."""

    def fail(_: RunResult) -> None:
        raise ProcessingError("The receivers disagree.")

    # what does not fall has its preliminary result by circles
    record = make_record(draw_scene(9, "generic", "circle", moving_s=0.4, rate_hz=2000.0, snr_db=35.0))
    result = process(record.recording, changed(record.setup, processing={"correction": "joint"}), report, fail)
    assert any("the published one was used" in one for one in result.warnings)
    return result


def at_once(report: Report) -> RunResult:
    setup = changed(quick_setup(), daq={"rate_hz": 2000.0})
    return process(simulate_recording(setup)[0], setup, report)


@pytest.mark.parametrize(
    "path",
    [
        at_once,
        rejected_receiver,
        pytest.param(with_prior, marks=pytest.mark.slow),
        pytest.param(adaptive_instead, marks=pytest.mark.slow),
        pytest.param(published_instead, marks=pytest.mark.slow),
    ],
)
def test_no_path_runs_back(path: Path) -> None:
    shares: list[float] = []
    path(shares.append)
    assert shares == sorted(shares)
    assert 0.0 < shares[0] <= 0.1
    assert 0.9 < shares[-1] <= 1.0
    if path in (rejected_receiver, with_prior):
        # the second attempt, too, is seen to go on
        assert np.diff([*shares, 1.0]).max() < 0.3


def test_an_attempt_begins_where_the_last_one_has_come_to_and_leaves_something_to_the_next() -> None:
    told: list[float] = []
    progress = Progress(told.append)
    progress.reach(0.1)
    for _ in range(4):
        attempt = progress.attempt()
        for share in (0.0, 0.5, 0.2, 1.0):
            attempt(share)
    assert told == sorted(told)
    assert len(set(told)) == 9
    assert told[-1] < 1.0


def test_what_it_raises_ends_the_work_also_where_nothing_has_grown() -> None:
    def refuse(share: float) -> None:
        if share >= 0.5:
            raise InterruptedError

    progress = Progress(refuse)
    progress.reach(0.4)
    with pytest.raises(InterruptedError):
        progress.reach(0.6)
    with pytest.raises(InterruptedError):
        progress.reach(0.2)
