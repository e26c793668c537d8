"""Many stored runs processed again: all of them, each once, whatever happens to one."""

from __future__ import annotations

import os
import shutil
import signal
import sys
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import h5py
import numpy as np
import pytest
from support.run_contents import read_summary
from support.small_setups import PLATE
from support.stored_runs import raw_digest, results_digest, store_runs

from radargui.experiment.batch import BatchOutcome, BatchTask, TablesTo, find_runs, run_local, work_on
from radargui.experiment.reprocess import process_run
from radargui.files import hdf5
from radargui.model.errors import CancelledError, FileError, ProcessingError, SetupError
from radargui.model.result import RunResult
from radargui.model.setup import Setup, parse_setup
from radargui.report.tables import write_tables


@pytest.fixture(scope="module")
def stored(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of two sessions with three runs; not to be changed."""
    folder = tmp_path_factory.mktemp("data")
    store_runs(folder / "2026" / "monday", 2)
    store_runs(folder / "2026" / "tuesday", 1)
    return folder


@pytest.fixture
def data(stored: Path, tmp_path: Path) -> Path:
    """The same, to be changed."""
    return Path(shutil.copytree(stored, tmp_path / "data"))


@dataclass(frozen=True)
class Killed:
    """Writes no tables: the process ends as if it had been killed."""

    name: str

    def __call__(self, result: RunResult, folder: Path) -> None:
        if result.recording.name == self.name:
            os.kill(os.getpid(), getattr(signal, "SIGKILL", signal.SIGTERM))
        write_tables(result, folder)


def runs_of(folder: Path) -> list[Path]:
    return [one.path for one in find_runs([folder]).runs]


def by_name(outcomes: list[BatchOutcome]) -> dict[str, str]:
    return {f"{one.run.parent.name}/{one.run.stem}": one.state for one in outcomes}


def test_runs_are_found_at_any_depth_each_once_with_a_place_of_its_own(stored: Path) -> None:
    session = stored / "2026" / "monday"
    found = find_runs([session, session / "run-0001.h5", stored])
    assert [one.path.relative_to(stored).as_posix() for one in found.runs] == [
        "2026/monday/run-0001.h5",
        "2026/monday/run-0002.h5",
        "2026/tuesday/run-0001.h5",
    ]
    assert [one.place.as_posix() for one in found.runs] == [
        "monday/run-0001",
        "monday/run-0002",
        "2026/tuesday/run-0001",
    ]
    assert not found.errors


@pytest.mark.skipif(sys.platform == "win32", reason="links need a privilege there")
def test_a_link_in_a_circle_is_not_followed(data: Path) -> None:
    (data / "2026" / "again").symlink_to(data)
    assert len(find_runs([data]).runs) == 3


def test_results_of_another_version_are_made_again(data: Path) -> None:
    run = runs_of(data)[0]
    process_run(run)
    with h5py.File(run, "r+") as file:
        file["results"].attrs["version"] = np.bytes_("0.0.1")
        hdf5.seal(file["results"].attrs)
    assert work_on(BatchTask(run)).state == "done"


def test_a_worker_of_another_version_does_not_mix_its_results_in(data: Path) -> None:
    outcome = work_on(replace(BatchTask(runs_of(data)[0]), version="9.9"))
    assert outcome.state == "failed"
    assert "the batch was started by 9.9" in str(outcome.error)


def _raise(error: BaseException) -> Callable[[float], None]:
    def tell(_: float) -> None:
        raise error

    return tell


@pytest.mark.parametrize(
    ("error", "state", "text"),
    [
        (CancelledError(), "stopped", ""),
        (MemoryError(), "failed", "memory"),
        (KeyError("x"), "failed", "unexpectedly: KeyError"),
    ],
)
def test_whatever_goes_wrong_is_an_outcome(data: Path, error: Exception, state: str, text: str) -> None:
    run = runs_of(data)[0]
    outcome = work_on(BatchTask(run), _raise(error))
    assert outcome.state == state
    assert text in str(outcome.error)
    assert read_summary(run) is None


def test_a_setup_that_does_not_fit_fails_that_run(data: Path) -> None:
    outcome = work_on(BatchTask(runs_of(data)[0], parse_setup(PLATE)))
    assert isinstance(outcome.error, ProcessingError)
    assert isinstance(work_on(BatchTask(runs_of(data)[0], changes={"processing.geometry": "x"})).error, SetupError)


def test_processes_do_what_one_process_does_and_a_bad_file_stops_nothing(data: Path) -> None:
    alone = data.with_name("alone")
    shutil.copytree(data, alone)
    for run in runs_of(alone):
        process_run(run)
    bad = data / "2026" / "monday" / "run-0003.h5"
    bad.write_bytes(b"\x89HDF\r\n\x1a\nand nothing else")
    before = [raw_digest(run) for run in runs_of(alone)]
    outcomes = list(run_local([BatchTask(run) for run in runs_of(data)], workers=2))
    assert by_name(outcomes) == {
        "monday/run-0001": "done",
        "monday/run-0002": "done",
        "monday/run-0003": "failed",
        "tuesday/run-0001": "done",
    }
    assert isinstance(next(one.error for one in outcomes if one.state == "failed"), FileError)
    bad.unlink()
    assert [results_digest(run) for run in runs_of(data)] == [results_digest(run) for run in runs_of(alone)]
    assert [raw_digest(run) for run in runs_of(data)] == before


def test_a_worker_that_is_killed_fails_its_run_only(data: Path, tmp_path: Path) -> None:
    runs = runs_of(data)
    tasks = [
        BatchTask(run, tables=TablesTo(tmp_path / "out" / run.parent.name / run.stem, Killed("run-0002"), _never))
        for run in runs
    ]
    outcomes = list(run_local(tasks, workers=2))
    assert sorted(by_name(outcomes).items()) == [
        ("monday/run-0001", "done"),
        ("monday/run-0002", "failed"),
        ("tuesday/run-0001", "done"),
    ]
    (error,) = [one.error for one in outcomes if one.error]
    assert "ended without an answer" in str(error)


def _never(folder: Path, setup: Setup) -> bool:
    return False


def test_closing_the_iterator_ends_the_workers_and_leaves_whole_files(data: Path) -> None:
    tasks = [BatchTask(run, force=True) for run in runs_of(data)] * 5
    outcomes = run_local(tasks, workers=1)
    assert next(outcomes).state == "done"
    outcomes.close()
    states = [results_digest(run) != "" for run in runs_of(data)]
    assert any(states)
    assert not list(data.rglob("*.part"))
