"""`radargui sessions`, `recover`, `compare`, and `record --like`."""

from __future__ import annotations

import json
import shutil
from datetime import UTC, datetime
from pathlib import Path

import pytest
from support.command_line import Command
from support.file_samples import codes, int16_digitisation
from support.run_contents import read_summary

from radargui.files.run_file import run_is_complete
from radargui.model.recording import Block
from radargui.session.session import Session

NOW = datetime(2026, 11, 20, 15, 4, 5, tzinfo=UTC)


@pytest.fixture
def session(recorded: Path, tmp_path: Path) -> Session:
    folder = tmp_path / "documents" / "RadarGUI" / recorded.name
    shutil.copytree(recorded, folder)
    return Session.open(folder)


def crash(session: Session) -> Path:
    writer = session.new_run(int16_digitisation(), started_at=NOW.isoformat())
    writer.write(Block(codes(6, 1200), 0))
    # as it is now, whoever is killed leaves it
    there = writer.path.read_bytes()
    writer.close()
    writer.path.write_bytes(there)
    session.close()
    return writer.path


def test_sessions_are_found_and_told(command: Command, session: Session) -> None:
    session.update(operator="Ada", sample="steel", notes="first\ntry")
    data = session.path.parent
    ended = command("sessions", data, "--operator", "ada", "--text", "TRY", "--e", "0.1:", "--since", "2020-01-01")
    assert ended.status == 0
    assert session.path.name in ended.out
    assert "first try" in ended.out
    assert "run-0002.h5" in command("sessions", data, "--runs").out
    assert "No such session" in command("sessions", data, "--e", ":0.01").out
    assert command("sessions", session.path).out.count(session.path.name) == 1


def test_sessions_of_the_users_own_folder_need_no_path(
    command: Command, session: Session, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    assert session.path.name in command("sessions").out
    monkeypatch.setattr("platformdirs.user_documents_dir", lambda: str(tmp_path / "none"))
    assert command("sessions").status == 0


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--since", "yesterday"], "--since = 'yesterday', allowed: a day like 2026-11-20"),
        (["--e", "much"], "--e = 'much', allowed: LOW:HIGH"),
        (["--e", "0.9:0.7"], "--e = '0.9:0.7', allowed: LOW:HIGH"),
        (["--e", "nan:"], "--e = 'nan:', allowed: LOW:HIGH"),
        (["nowhere"], "nowhere is no folder"),
    ],
)
def test_wrong_questions_are_refused(command: Command, arguments: list[str], said: str) -> None:
    ended = command("sessions", *arguments)
    assert ended.status == 2
    assert said in ended.error


def test_sessions_are_found_by_a_setup_file_with_the_same_antennas(
    command: Command, session: Session, setup_file: Path
) -> None:
    assert session.path.name in command("sessions", session.path.parent, "--setup", setup_file).out
    text = setup_file.read_text(encoding="utf-8").replace("distance_m = 0.7", "distance_m = 0.9")
    setup_file.write_text(text, encoding="utf-8")
    assert "No such session" in command("sessions", session.path.parent, "--setup", setup_file).out


def test_a_run_file_is_said_to_be_no_session(command: Command, session: Session) -> None:
    run = session.path / "run-0001.h5"
    assert f"{run} is not a session: it holds no session.json." in command("report", run).error


def test_a_damaged_run_is_not_called_one_that_can_be_finished(command: Command, session: Session) -> None:
    (session.path / "run-0001.h5").write_bytes(b"")
    listed = command("sessions", session.path.parent).out
    assert "2, 1 unreadable" in listed
    assert "recover" not in listed
    assert "No unfinished run" in command("recover", session.path.parent).out


def test_an_unfinished_run_is_shown_recovered_and_told(command: Command, session: Session) -> None:
    run = crash(session)
    data = session.path.parent
    before = run.read_bytes()
    assert "run-0003.h5" in command("recover", data, "--list").out
    assert run.read_bytes() == before
    listed = command("sessions", data).out
    assert "1 unfinished" in listed
    assert "radargui recover" in listed
    ended = command("recover", run)
    assert ended.status == 0
    assert "recovered" in ended.out
    assert run_is_complete(run)
    assert read_summary(run) is not None
    assert "No unfinished run" in command("recover", data).out
    assert "recovered" in command("sessions", data, "--runs").out


def test_a_run_that_another_computer_may_still_record_is_left_and_told(command: Command, session: Session) -> None:
    run = crash(session)
    owner = {"computer": "laboratory", "process": 10250, "since": "2026-11-20T12:47:58+00:00"}
    lock = session.path / "session.lock"
    lock.write_text(f" {json.dumps(owner)}", encoding="utf-8")
    for path in (session.path.parent, session.path, run):
        ended = command("recover", path)
        assert ended.err.startswith(f"{run} is left out: process 10250 on laboratory since 2026-11-20T12:47:58+00:00 ")
        assert f"delete {lock} and recover again" in ended.err
        assert ended.out == f"No other unfinished run in {path}.\n"
        assert ended.status == 0
    lock.unlink()
    assert "recovered" in command("recover", run).out


def test_nothing_there_is_told_from_nothing_found(command: Command, session: Session, tmp_path: Path) -> None:
    (tmp_path / "new").mkdir()
    assert command("sessions", tmp_path / "new").out == f"No session in {tmp_path / 'new'}.\n"
    data = session.path.parent
    assert command("sessions", data, "--operator", "nobody").out == f"No such session in {data}.\n"
    for run in session.path.glob("*.h5"):
        run.unlink()
    assert command("figures", session.path, "--output", tmp_path / "figures").out.startswith("1 figure as PDF")


def test_recovery_without_anything_to_do_or_without_a_place(command: Command, tmp_path: Path) -> None:
    assert command("recover", tmp_path).status == 0
    assert command("recover", tmp_path / "none").status == 2


def test_results_are_compared_kept_and_compared_again(command: Command, session: Session) -> None:
    path = session.path
    assert "no result before" in command("compare", path).out
    tried = command("compare", path, "--geometry", "plane")
    assert tried.status == 0
    assert "processing.geometry: exact -> plane" in tried.out
    assert "mean e of 2 runs" in tried.out
    kept = command("compare", path, "--geometry", "plane", "--keep")
    assert command("compare", path).out == kept.out == tried.out
    assert command("compare", path, "--keep").status == 2
    assert command("compare", path, "--geometry", "flat").status == 2
    assert command("compare", path / "none").status == 1


def test_a_session_is_set_up_as_another_one(command: Command, session: Session, tmp_path: Path) -> None:
    session.update(operator="Ada", sample="steel")
    session.close()
    other = tmp_path / "other"
    ended = command("record", "--fast", "--like", session.path, "--sample", "brass", "--notes", "n", "--output", other)
    assert ended.status == 0
    (made,) = (Session.open(path, write=False) for path in other.iterdir())
    assert made.setup == session.setup
    assert (made.info.operator, made.info.sample, made.info.notes) == ("Ada", "brass", "n")
    assert made.info.calibration == session.info.calibration
    assert "setup file small.toml" in made.info.calibration.origin
    assert command("record", "--fast", "--like", session.path, "--setup", "x.toml").status == 2
