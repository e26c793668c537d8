"""A killed recording is whole up to the last flush, is found again, and is finished without losing anything."""

from __future__ import annotations

import random
import subprocess
import sys
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from support.file_samples import codes, default_setup, int16_digitisation, result_of
from support.killing import LOST_S, Killer
from support.run_contents import read_markers, read_summary

from radargui.experiment.reprocess import NOTHING, recover, recover_run, unfinished_runs
from radargui.files.overview import read_overview
from radargui.files.run_file import read_run, run_is_complete
from radargui.files.run_results import finish_run, write_results
from radargui.files.run_writer import RunWriter
from radargui.model.errors import FileError
from radargui.model.recording import Block, Gap
from radargui.session.lock import SessionLockedError
from radargui.session.session import Session

NOW = datetime(2026, 11, 20, 15, 4, 5, tzinfo=UTC)
KILLS = 3
OTHER_PROGRAM = """
import sys
from pathlib import Path
from radargui.session.lock import SessionLock
lock = SessionLock(Path(sys.argv[1]))
print("held", flush=True)
sys.stdin.read()
"""


def leave(writer: RunWriter) -> None:
    """Leave the file of a run as it is now, as whoever is killed does."""
    there = writer.path.read_bytes()
    writer.close()
    writer.path.write_bytes(there)


def crashed(session: Session, count: int = 1700, *, gap: bool = True) -> tuple[Path, np.ndarray]:
    """Leave a run as a crash does; return its file and the samples handed to the writer."""
    writer = session.new_run(int16_digitisation(), started_at=NOW.isoformat())
    samples = codes(6, count)
    half = count // 2
    writer.write(Block(samples[:, :half], 0))
    writer.write(Block(samples[:, half:], half + (7 if gap else 0), Gap(half, 7, "overflow") if gap else None))
    writer.add_marker(3, "here")
    leave(writer)
    return writer.path, samples


@pytest.mark.timeout(60)
def test_a_recording_killed_at_any_moment_opens_and_keeps_all_but_the_last_moment(tmp_path: Path) -> None:
    killer = Killer(tmp_path, 10_000.0)
    chance = random.Random(20261120)
    killed = [killer.kill(chance.uniform(0.1, 1.3)) for _ in range(KILLS)]
    assert all(one.right for one in killed)
    assert max(one.lost_s for one in killed) <= LOST_S
    found = unfinished_runs(tmp_path / "data", tmp_path / "index.sqlite3")
    assert {one.path for one in found} == {one.run for one in killed if one.run}
    longest = max(killed, key=lambda one: one.kept)
    assert longest.run is not None
    before = read_run(longest.run).raw
    recovered = recover_run(longest.run, now=NOW)
    assert recovered.n_samples == longest.kept
    assert recovered.result is not None
    assert run_is_complete(longest.run)
    np.testing.assert_array_equal(read_run(longest.run).raw, before)


def test_a_recovered_run_is_marked_and_holds_what_was_flushed(tmp_path: Path) -> None:
    session = Session.create(tmp_path / "data", default_setup(), now=NOW)
    run, samples = crashed(session)
    session.close()
    (found,) = unfinished_runs(tmp_path / "data", tmp_path / "index.sqlite3")
    assert (found.path, found.duration_s) == (run, 1.5)
    assert recover(run, now=NOW) == 1500
    recording = read_run(run)
    np.testing.assert_array_equal(recording.raw, samples[:, :1500])
    assert recording.gaps == (Gap(850, 7, "overflow"),)
    assert read_markers(run)[0].text == "here"
    assert run_is_complete(run)
    with h5py.File(run) as file:
        assert file.attrs["recovered_at"].decode() == "2026-11-20T15:04:05+00:00"
        assert "overview" in file
    assert unfinished_runs(tmp_path / "data", tmp_path / "index.sqlite3") == ()
    write_results(run, result_of(recording))
    assert read_summary(run) is not None
    assert sorted(path.name for path in session.path.iterdir()) == ["run-0001.h5", "session.json"]


def test_a_run_that_a_failure_ended_is_recovered_with_all_its_samples(tmp_path: Path) -> None:
    session = Session.create(tmp_path, default_setup(), now=NOW)
    samples = codes(6, 700)
    writer = session.new_run(int16_digitisation(), started_at="")
    writer.write(Block(samples, 0))
    writer.close(complete=False)
    assert not run_is_complete(writer.path)
    assert recover(writer.path, now=NOW) == 700
    np.testing.assert_array_equal(read_run(writer.path).raw, samples)


def test_what_is_being_recorded_is_not_offered(tmp_path: Path) -> None:
    session = Session.create(tmp_path / "data", default_setup(), now=NOW)
    with session.new_run(int16_digitisation(), started_at="") as writer:
        assert unfinished_runs(tmp_path / "data", tmp_path / "index.sqlite3") == ()
        assert session.recording == writer.path
    assert session.recording is None


def test_a_run_is_named_as_recorded_from_before_its_file_is_there(tmp_path: Path) -> None:
    session = Session.create(tmp_path, default_setup(), now=NOW)
    named: list[bool] = []

    def make(path: Path, *given: Any, **header: Any) -> RunWriter:
        named.append(session.records(path) and not path.exists())
        return RunWriter(path, *given, **header)

    writer = session.new_run(int16_digitisation(), make, started_at="")
    assert named == [True]
    assert session.records(writer.path)
    writer.close()
    assert not session.records(writer.path)


def test_results_are_not_stored_in_a_run_that_is_being_recorded(tmp_path: Path) -> None:
    session = Session.create(tmp_path, default_setup(), now=NOW)
    samples = codes(6, 1600)
    with session.new_run(int16_digitisation(), started_at="") as writer:
        writer.write(Block(samples[:, :1000], 0))
        with pytest.raises(FileError, match=r"has not ended.*radargui recover"):
            write_results(writer.path, result_of(read_run(writer.path)))
        writer.write(Block(samples[:, 1000:], 1000))
    np.testing.assert_array_equal(read_run(writer.path).raw, samples)


def test_one_without_a_sample_is_set_aside(tmp_path: Path) -> None:
    session = Session.create(tmp_path, default_setup(), now=NOW)
    run, _ = crashed(session, 10, gap=False)
    recovered = recover_run(run, now=NOW)
    assert (recovered.n_samples, recovered.result, recovered.error) == (0, None, None)
    assert Session.open(session.path).rejected == {"run-0001.h5": NOTHING}
    assert run.is_file()


def test_a_whole_run_is_refused_and_left_as_it_was(tmp_path: Path) -> None:
    session = Session.create(tmp_path, default_setup(), now=NOW)
    with session.new_run(int16_digitisation(), started_at="") as writer:
        writer.write(Block(codes(6, 20), 0))
    before = writer.path.read_bytes()
    with pytest.raises(FileError, match="nothing to recover"):
        recover(writer.path, now=NOW)
    assert writer.path.read_bytes() == before
    assert sorted(path.name for path in session.path.glob("run*")) == ["run-0001.h5"]


def test_a_file_with_half_a_row_of_chunks_is_kept_beside(tmp_path: Path) -> None:
    path = tmp_path / "run-0001.h5"
    writer = RunWriter(path, int16_digitisation(), started_at="")
    writer.write(Block(codes(6, 1000), 0))
    leave(writer)
    with h5py.File(path, "r+") as file:
        file["raw"].resize(1500, axis=1)
        file["raw"][0, 1000:] = 1
    before = path.read_bytes()
    assert finish_run(path, now="2026-11-20") == 1000
    assert (tmp_path / "run-0001.h5.unfinished").read_bytes() == before
    np.testing.assert_array_equal(read_run(path).raw, codes(6, 1000))
    assert read_overview(path).n_samples == 1000


def test_a_session_that_another_program_writes_to_is_not_touched(tmp_path: Path) -> None:
    session = Session.create(tmp_path, default_setup(), now=NOW)
    run, _ = crashed(session)
    session.close()
    before = run.read_bytes()
    held = subprocess.Popen(
        [sys.executable, "-c", OTHER_PROGRAM, str(session.path)], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    )
    with held:
        assert held.stdout is not None
        assert held.stdout.readline()
        with pytest.raises(SessionLockedError):
            recover(run, now=NOW)
        held.communicate(b"")
    assert run.read_bytes() == before
