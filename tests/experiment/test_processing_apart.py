"""Runs processed in a process of their own: the same results, what stands meanwhile, and how it ends."""

from __future__ import annotations

import multiprocessing
import shutil
from collections.abc import Iterator
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest
from support.changed import changed
from support.one_run import record_run
from support.run_contents import read_run_truth, read_summary
from support.simulated_setup import simulated_setup

from radargui.experiment.finished import BegunJob, FinishedJob
from radargui.experiment.processing_apart import ProcessingApart
from radargui.experiment.series import Experiment
from radargui.files.run_file import read_run
from radargui.model.errors import CancelledError, FileError, ProcessingError
from radargui.model.result import RunResult
from radargui.processing.process import STOPPED
from radargui.session.session import Session
from radargui.sources.simulated.model import SimulatedSource

NOW = datetime(2026, 11, 20, 15, 4, 5, tzinfo=UTC)


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> FinishedJob:
    """A run without a result, not to be changed."""
    setup = simulated_setup(snr_db=45.0, mismatch=0.005, beamwidth_deg=90.0, restitution=0.5, rest_s=0.5, settle_s=0.5)
    setup = changed(
        setup,
        recording={"pretrigger_s": 0.3, "quiet_s": 0.3, "maximum_s": 5.0, "wait_s": 20.0},
        processing={"correction": "ellipse"},
    )
    session = Session.create(tmp_path_factory.mktemp("recorded"), setup, now=NOW)
    experiment = Experiment(setup, lambda _: SimulatedSource(setup), session, process=False, live=False, patient=True)
    path = record_run(experiment).path
    session.close()
    assert path is not None
    return FinishedJob(path, setup, 0, None)


@pytest.fixture
def stored(recorded: FinishedJob, tmp_path: Path) -> FinishedJob:
    folder = shutil.copytree(recorded.path.parent, tmp_path / "session")
    return replace(recorded, path=folder / recorded.path.name)


@pytest.fixture(scope="module")
def apart() -> Iterator[ProcessingApart]:
    """One process for the tests that leave it as it is: a second to start."""
    process = ProcessingApart()
    process.start()
    yield process
    process.close()


def never(_: RunResult) -> None:
    pytest.fail("no preliminary result was to come")


def test_a_process_apart_tells_what_stands_and_keeps_it_where_it_is_cancelled(
    apart: ProcessingApart, stored: FinishedJob
) -> None:
    job = replace(stored, setup=changed(stored.setup, processing={"correction": "joint"}))
    stood: list[RunResult] = []

    def enough(_: float) -> None:
        if stood:
            raise CancelledError

    result, _ = apart.process(job, enough, stood.append)
    assert [one.preliminary for one in stood] == [True]
    assert np.array_equal(stood[0].recording.raw, read_run(stored.path).raw)
    assert result.preliminary
    assert result.findings[0] == STOPPED
    summary = read_summary(stored.path)
    assert summary is not None
    assert (summary["correction"], summary["preliminary"]) == ("flights", True)


@pytest.mark.slow
def test_a_job_that_waits_for_a_long_one_has_its_preliminary_result_meanwhile_and_once(
    apart: ProcessingApart, stored: FinishedJob
) -> None:
    job = replace(stored, setup=changed(stored.setup, processing={"correction": "joint"}))
    waiting = replace(job, path=stored.path.with_name("run-0002.h5"))
    shutil.copy(job.path, waiting.path)
    told: list[str] = []

    def progress(_: float) -> None:
        if told == ["run-0001"]:
            apart.announce(waiting, lambda result: told.append(result.recording.name))
            told.append("announced")
        if told[-1:] == ["run-0002"]:
            raise CancelledError

    first, _ = apart.process(job, progress, lambda result: told.append(result.recording.name))
    assert told == ["run-0001", "announced", "run-0002"]
    second, _ = apart.process(waiting, progress, never)
    assert [result.recording.name for result in (first, second)] == ["run-0001", "run-0002"]
    assert first.preliminary
    assert second.preliminary


def _begun(stored: FinishedJob) -> tuple[BegunJob, float]:
    """Return a run until 0.2 s after its first touch-down, and when that is."""
    recording = read_run(stored.path)
    truth = read_run_truth(stored.path)
    assert truth is not None
    impact_s = float(truth.impact_time_s[0])
    flown = round((impact_s + 0.2) * recording.digitisation.sample_rate_hz)
    return BegunJob(replace(recording, raw=recording.raw[:, :flown]), stored.setup), impact_s


def test_of_a_run_that_is_still_recorded_the_flights_tell_e(apart: ProcessingApart, stored: FinishedJob) -> None:
    job, impact_s = _begun(stored)
    told: list[RunResult | None] = []
    apart.announce_begun(job, told.append)
    apart.await_begun(lambda: True)
    # nothing is waited for any more
    apart.await_begun(lambda: True)
    (result,) = told
    assert result is not None
    assert result.preliminary
    first = result.bounces.impacts[0]
    assert (first.method, first.valid) == ("flights", True)
    assert first.time_s == pytest.approx(impact_s, abs=5e-4)
    assert first.e == pytest.approx(0.5, abs=4.0 * first.u_stated)


def test_a_result_so_far_that_nobody_wants_any_more_is_given_up(apart: ProcessingApart, stored: FinishedJob) -> None:
    told: list[RunResult | None] = []
    apart.announce_begun(_begun(stored)[0], told.append)
    apart.await_begun(lambda: False)
    assert told == [None]
    # the next job is not stopped by that
    result, _ = apart.process(stored, lambda _: None, never)
    assert result.status == "ok"


def test_a_result_so_far_comes_between_two_rounds_of_another_job(apart: ProcessingApart, stored: FinishedJob) -> None:
    told: list[RunResult | None] = []
    job, _ = _begun(stored)

    def progress(_: float) -> None:
        if not told:
            apart.announce_begun(job, told.append)

    result, _ = apart.process(stored, progress, never)
    apart.await_begun(lambda: True)
    assert result.status == "ok"
    assert [one is not None for one in told] == [True]


def test_a_process_that_cannot_be_started_says_so_and_can_be_closed(
    stored: FinishedJob, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(_: object) -> None:
        raise OSError(11, "Resource temporarily unavailable")

    monkeypatch.setattr("multiprocessing.context.SpawnProcess.start", refuse)
    apart = ProcessingApart()
    with pytest.raises(ProcessingError, match=r"cannot be started: .*Resource temporarily unavailable"):
        apart.process(stored, lambda _: None, never)
    apart.close()


def test_a_process_apart_gives_the_same_result_and_keeps_it(stored: FinishedJob) -> None:
    once: list[float] = []
    twice: list[float] = []
    apart = ProcessingApart()
    try:
        result, agreement = apart.process(stored, once.append, never)
        with pytest.raises(CancelledError):
            apart.process(stored, lambda _: (_ for _ in ()).throw(CancelledError), never)
        again, _ = apart.process(stored, twice.append, never)
        missing = FinishedJob(stored.path.with_name("run-0009.h5"), stored.setup, 0, None)
        with pytest.raises(FileError, match=r"run-0009\.h5: no such file"):
            apart.process(missing, lambda _: None, never)
        for child in multiprocessing.active_children():
            if child.name == "radargui-processing":
                child.kill()
        with pytest.raises(ProcessingError, match="ended without an answer"):
            apart.process(stored, lambda _: None, never)
    finally:
        apart.close()
        apart.close()
    assert agreement is None
    assert result.status == again.status == "ok"
    assert np.array_equal(result.recording.raw, read_run(stored.path).raw)
    assert result.track is not None
    summary = read_summary(stored.path)
    assert summary is not None
    assert summary["e"] == pytest.approx(result.bounces.impacts[0].e)
    assert once == twice
    assert once == sorted(once)
    assert len(once) > 5
    # the last tenth is for what is done with the result
    assert (once[0], once[-1]) == (0.0, 0.97)
