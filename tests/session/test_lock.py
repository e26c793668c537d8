"""Two programs at once: one writes to a session, the other may look; a lock left behind by a crash holds nobody up."""

from __future__ import annotations

import errno
import json
import os
import platform
import subprocess
import sys
from datetime import UTC, datetime
from pathlib import Path

import pytest
from support.file_samples import codes, default_setup, int16_digitisation

from radargui.model.recording import Block
from radargui.processing.result_of_run import result_of_run
from radargui.report.report import write_report
from radargui.session.lock import Owner, SessionLock, SessionLockedError, SessionReadOnlyError, owner_of
from radargui.session.session import Session

NOW = datetime(2026, 11, 20, 15, 4, 5, tzinfo=UTC)

OTHER_PROGRAM = """
import sys
from pathlib import Path
from radargui.session.session import Session
session = Session.open(Path(sys.argv[1]))
print("read-only" if session.read_only else "writing", flush=True)
print(session.read_only, flush=True)
sys.stdin.read()
"""


def other_program(folder: Path) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-c", OTHER_PROGRAM, str(folder)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        encoding="utf-8",
        env={**os.environ, "PYTHONPATH": str(Path(__file__).resolve().parents[2]), "PYTHONIOENCODING": "utf-8"},
    )


def left_behind(folder: Path, owner: Owner) -> None:
    text = json.dumps({"computer": owner.computer, "process": owner.process, "since": owner.since})
    (folder / "session.lock").write_text(text, encoding="utf-8")


def ended_process() -> int:
    with subprocess.Popen([sys.executable, "-c", ""]) as process:
        process.wait()
    return process.pid


def test_a_second_program_opens_it_read_only_and_says_who_has_it(tmp_path: Path) -> None:
    session = Session.create(tmp_path, default_setup(), now=NOW)
    with other_program(session.path) as other:
        said, why = other.communicate("", timeout=60)[0].splitlines()[:2]
    assert said == "read-only"
    assert f"being written by another program (process {os.getpid()} on this computer" in why
    with session.new_run(int16_digitisation(), started_at="") as writer:
        writer.write(Block(codes(6, 10), 0))


def test_what_another_program_writes_can_be_looked_at_but_not_changed(tmp_path: Path) -> None:
    session = Session.create(tmp_path, default_setup(), now=NOW)
    with session.new_run(int16_digitisation(), started_at="") as writer:
        writer.write(Block(codes(6, 100), 0))
    session.close()
    with other_program(session.path) as other:
        assert other.stdout is not None
        assert other.stdout.readline() == "writing\n"
        mine = Session.open(session.path)
        assert "being written by another program" in mine.read_only
        assert mine.run_paths() == (writer.path,)
        owner = owner_of(session.path)
        assert owner is not None
        assert owner.process == other.pid
        for forbidden in (
            lambda: mine.update(notes="x"),
            lambda: mine.reject(writer.path, "x"),
            lambda: mine.mark("x", now=NOW),
            lambda: mine.new_run(int16_digitisation(), started_at=""),
        ):
            with pytest.raises(SessionLockedError):
                forbidden()
        other.kill()
    # a killed program holds nothing
    assert (session.path / "session.lock").exists()
    assert owner_of(session.path) is None
    again = Session.open(session.path)
    assert again.read_only == ""
    again.update(notes="mine again")


def test_parts_of_one_program_share_the_right_and_the_last_one_gives_it_back(tmp_path: Path) -> None:
    first = Session.create(tmp_path, default_setup(), now=NOW)
    second = Session.open(first.path)
    first.close()
    assert (first.path / "session.lock").exists()
    second.update(notes="still mine")
    with pytest.raises(SessionReadOnlyError, match="was closed"):
        first.update(notes="late")
    second.close()
    second.close()
    assert not (first.path / "session.lock").exists()


def test_a_session_that_nobody_uses_any_more_is_free(tmp_path: Path) -> None:
    path = Session.create(tmp_path, default_setup(), now=NOW).path
    assert not (path / "session.lock").exists()


def test_looking_takes_no_lock(tmp_path: Path) -> None:
    path = Session.create(tmp_path, default_setup(), now=NOW).path
    session = Session.open(path, write=False)
    assert "for looking only" in session.read_only
    assert sorted(one.name for one in path.iterdir()) == ["session.json"]


def test_a_lock_of_a_dead_process_is_taken_over_one_of_another_computer_is_not(tmp_path: Path) -> None:
    left_behind(tmp_path, Owner(platform.node(), ended_process(), "2026-11-20T15:00:00+00:00"))
    SessionLock(tmp_path).release()
    left_behind(tmp_path, Owner("another-pc", 12, "2026-11-20T15:00:00+00:00"))
    with pytest.raises(SessionLockedError, match=r"another-pc since 2026.*delete session\.lock"):
        SessionLock(tmp_path)
    assert owner_of(tmp_path) is not None


def test_where_the_disk_knows_no_locks_the_process_named_in_a_marker_counts(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def unsupported(*_: object) -> None:
        raise OSError(errno.EOPNOTSUPP, "Operation not supported")

    monkeypatch.setattr("filelock.FileLock._acquire", unsupported)
    marker = tmp_path / "session.lock.held"
    mine = SessionLock(tmp_path)
    assert marker.exists()
    held = marker.read_text(encoding="utf-8")
    assert held.splitlines()[0] == str(os.getpid())
    mine.release()
    assert not marker.exists()
    marker.write_text(held.replace(str(os.getpid()), str(ended_process()), 1), encoding="utf-8")
    SessionLock(tmp_path).release()
    parent = f"{os.getppid()}\n{held.splitlines()[1]}\n"
    marker.write_text(parent, encoding="utf-8")
    with pytest.raises(SessionLockedError):
        SessionLock(tmp_path)


@pytest.mark.parametrize("content", [b"", b"{", b"[1]", b"\xff" * 50, b'{"computer": 1}'])
def test_a_damaged_lock_file_holds_nobody_up(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "session.lock").write_bytes(content)
    taken = SessionLock(tmp_path)
    owner = owner_of(tmp_path)
    assert owner is not None
    assert owner.process == os.getpid()
    taken.release()
    assert not (tmp_path / "session.lock").exists()


def test_a_session_on_a_read_only_disk_can_be_reviewed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = Session.create(tmp_path / "disk", default_setup(), now=NOW).path

    def read_only(*_: object) -> int:
        raise OSError(30, "Read-only file system")

    monkeypatch.setattr(os, "open", read_only)
    session = Session.open(path)
    assert "Read-only file system" in session.read_only
    with pytest.raises(SessionReadOnlyError):
        session.update(notes="x")
    monkeypatch.undo()
    report = write_report(session, result_of_run, tmp_path / "elsewhere", now=NOW)
    assert report.html.is_file()
    assert sorted(one.name for one in path.iterdir()) == ["session.json"]
