"""Runs of a session processed in order: each is given what those before it found out about the front ends."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from types import ModuleType

import pytest
from support.changed import changed
from support.stored_runs import SETUP, store_runs

from radargui.experiment import finished, reprocess
from radargui.experiment.batch import task
from radargui.files.run_results import write_results
from radargui.files.stored_results import read_prior
from radargui.model.channel_quality import ChannelQuality
from radargui.model.front_end import FrontEndPrior
from radargui.model.recording import Recording
from radargui.model.result import RunResult
from radargui.model.setup import Setup
from radargui.model.setup_pool import SetupPrior
from radargui.processing.long_recording import read_for_processing
from radargui.processing.process import process
from radargui.session.session import Session

JOINT = changed(SETUP, processing={"correction": "joint"})
Given = list[FrontEndPrior | None]


@pytest.fixture
def runs(tmp_path: Path) -> tuple[Path, Path]:
    """Two runs of a session, of which the first found its front ends by the joint correction."""
    session = Session.create(tmp_path, JOINT, now=datetime(2026, 11, 20, tzinfo=UTC))
    recorded = store_runs(tmp_path / "recorded", 2)
    first, second = (Path(shutil.copy(run, session.path / run.name)) for run in recorded)
    write_results(first, found(first))
    return first, second


def found(path: Path) -> RunResult:
    result = process(read_for_processing(path), SETUP)
    assert result.corrected is not None
    constants = {"gain_ratio": 1.0, "u_gain_ratio": 1e-3, "quadrature_error_deg": 0.0, "u_quadrature_error_deg": 0.1}
    channels = tuple(ChannelQuality(channel.name, **constants) for channel in result.corrected.channels)
    return replace(result, setup=JOINT, corrected=replace(result.corrected, method="joint", channels=channels))


@pytest.fixture
def given_in(monkeypatch: pytest.MonkeyPatch) -> Callable[[ModuleType], Given]:
    """Make a module process quickly, and tell the priors it gave."""

    def watch(module: ModuleType) -> Given:
        given: Given = []

        def quick(
            recording: Recording,
            setup: Setup,
            progress: object = None,
            standing: object = None,
            front_ends: FrontEndPrior | None = None,
            others: SetupPrior | None = None,
        ) -> RunResult:
            assert others is None
            given.append(front_ends)
            return replace(process(recording, SETUP), setup=setup, front_end_prior=front_ends)

        monkeypatch.setattr(module, "process", quick)
        return given

    return watch


def test_a_run_processed_again_is_given_the_runs_before_it(
    runs: tuple[Path, Path], given_in: Callable[[ModuleType], Given]
) -> None:
    given = given_in(reprocess)
    reprocess.process_run(runs[1], JOINT)
    reprocess.process_run(runs[0], JOINT)
    assert given[0] is not None
    assert given[0].runs == ("run-0001",)
    assert given[1] is None
    assert read_prior(runs[1], JOINT) == given[0]


def test_a_run_just_recorded_is_given_the_runs_before_it(
    runs: tuple[Path, Path], given_in: Callable[[ModuleType], Given]
) -> None:
    given = given_in(finished)
    finished.process_finished(finished.FinishedJob(runs[1], JOINT, 0, None), lambda _: None, lambda _: None)
    assert given[-1] is not None
    assert given[-1].runs == ("run-0001",)


def test_a_batch_keeps_the_prior_a_result_had_whoever_ends_first(
    runs: tuple[Path, Path], given_in: Callable[[ModuleType], Given]
) -> None:
    given_in(reprocess)
    had = reprocess.process_run(runs[1], JOINT).front_end_prior
    given = given_in(task)
    for run in runs:
        assert task.work_on(task.BatchTask(run, JOINT, {"processing.geometry": "plane"})).state == "done"
    assert given == [None, had]
