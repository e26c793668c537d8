"""A session on disk: made before anything is recorded, never in the way of another, found again."""

from __future__ import annotations

import json
import os
import shutil
import sys
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from support.file_samples import codes, default_setup, int16_digitisation
from support.found_sessions import find_sessions
from support.simulated_setup import simulated_setup

from radargui.files.run_file import read_run, read_run_setup
from radargui.files.run_writer import RunWriter
from radargui.model.errors import FileError, SessionError
from radargui.model.recording import Block
from radargui.model.setup import dump_setup
from radargui.processing.result_of_run import result_of_run
from radargui.report.report import write_report
from radargui.session.info import default_data_folder, own_subfolder
from radargui.session.session import Session
from radargui.session.transfer import plan_export

NOW = datetime(2026, 11, 20, 15, 4, 5, tzinfo=UTC)


def record(session: Session, count: int = 700) -> Path:
    samples = codes(6, count)
    with session.new_run(int16_digitisation(), started_at="2026-11-20T15:04:06+00:00", trigger_index=9) as writer:
        writer.write(Block(samples, 0))
    np.testing.assert_array_equal(read_run(writer.path).raw, samples)
    return writer.path


def test_a_session_is_a_folder_named_by_its_time_with_its_record(tmp_path: Path) -> None:
    session = Session.create(
        tmp_path / "deep" / "data", default_setup(), operator="Änne", notes="10 mm steel\nno wind", now=NOW
    )
    assert session.path == tmp_path / "deep" / "data" / "2026-11-20T15-04-05"
    session.close()
    assert [path.name for path in session.path.iterdir()] == ["session.json"]
    content = json.loads((session.path / "session.json").read_text(encoding="utf-8"))
    assert content["operator"] == "Änne"
    assert content["created_at"] == "2026-11-20T15:04:05+00:00"
    assert content["setup"]["receiver"][0]["tilt_deg"] == default_setup().receiver[0].tilt_deg
    assert {"radargui", "python", "numpy", "h5py"} <= set(content["versions"])


def test_what_was_created_is_opened_again(tmp_path: Path) -> None:
    session = Session.create(tmp_path, default_setup(), operator="A", notes="n", now=NOW)
    record(session)
    again = Session.open(session.path)
    assert again.info == session.info
    assert again.setup == default_setup()
    assert again.run_paths() == session.run_paths() == (session.path / "run-0001.h5",)


def test_sessions_of_the_same_second_or_name_never_collide(tmp_path: Path) -> None:
    names = [Session.create(tmp_path, default_setup(), now=NOW).path.name for _ in range(3)]
    assert names == ["2026-11-20T15-04-05", "2026-11-20T15-04-05-2", "2026-11-20T15-04-05-3"]
    named = [Session.create(tmp_path, default_setup(), name="steel ball", now=NOW) for _ in range(2)]
    assert [one.path.name for one in named] == ["steel ball", "steel ball-2"]
    assert named[1].info.name == "steel ball-2"


@pytest.mark.parametrize("name", ["", " a", "a.", "a/b", "..", "a\\b", "c:d", "NUL", "com1.txt", "a\nb", "what?"])
def test_a_name_that_windows_cannot_have_is_refused(tmp_path: Path, name: str) -> None:
    with pytest.raises(SessionError, match="cannot be the name of a session"):
        Session.create(tmp_path, default_setup(), name=name, now=NOW)
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_cannot_be_written_is_refused_before_recording(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    blocked = tmp_path / "file"
    blocked.write_text("", encoding="utf-8")
    with pytest.raises(SessionError, match="No session can be made"):
        Session.create(blocked / "below", default_setup(), now=NOW)

    def full(_: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(SessionError, match="the disk is full"):
        Session.create(tmp_path, default_setup(), now=NOW)


@pytest.mark.skipif(sys.platform == "win32", reason="this limit is POSIX")
@pytest.mark.parametrize("n_bytes", [0, 500])
def test_a_disk_too_full_for_its_record_is_told_and_leaves_no_folder(tmp_path: Path, n_bytes: int) -> None:
    import resource

    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (n_bytes, hard))
    try:
        with pytest.raises(SessionError, match="cannot be written"):
            Session.create(tmp_path, default_setup(), now=NOW)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert list(tmp_path.iterdir()) == []


def test_operator_and_notes_are_replaced_in_one_step(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    session = Session.create(tmp_path, default_setup(), operator="A", notes="first", now=NOW)
    session.update(notes="second")
    session.update(operator="B")
    assert (session.info.operator, session.info.notes) == ("B", "second")
    assert Session.open(session.path).info == session.info

    def fail(*_: object) -> None:
        raise OSError(13, "Permission denied")

    monkeypatch.setattr(Path, "replace", fail)
    with pytest.raises(SessionError, match="Permission denied"):
        session.update(notes="third")
    assert session.info.notes == "second"
    assert Session.open(session.path).info.notes == "second"


def test_runs_are_numbered_on_and_never_overwritten(tmp_path: Path) -> None:
    session = Session.create(tmp_path, default_setup(), now=NOW)
    first, second = record(session), record(session)
    first.unlink()
    third = record(Session.open(session.path))
    (session.path / "run-0007.h5").write_bytes(b"")
    (session.path / "run-0010.txt").write_bytes(b"")
    eighth = record(session)
    assert [path.name for path in (first, second, third, eighth)] == [
        "run-0001.h5",
        "run-0002.h5",
        "run-0003.h5",
        "run-0008.h5",
    ]
    (session.path / "run-10000.h5").write_bytes(b"")
    assert [path.name for path in session.run_paths()][-2:] == ["run-0008.h5", "run-10000.h5"]


def test_two_programs_recording_into_one_session_take_different_numbers(tmp_path: Path) -> None:
    session = Session.create(tmp_path, default_setup(), now=NOW)

    def later(path: Path, *given: Any, **header: Any) -> RunWriter:
        # the other program was quicker
        if path.name == "run-0001.h5":
            RunWriter(path, *given, **header).close()
        return RunWriter(path, *given, **header)

    with session.new_run(int16_digitisation(), later, started_at="") as writer:
        assert writer.path.name == "run-0002.h5"


def test_a_run_holds_the_setup_of_its_session(tmp_path: Path) -> None:
    session = Session.create(tmp_path, default_setup(), now=NOW)
    path = record(session)
    assert read_run_setup(path) == session.setup
    assert read_run(path).trigger_index == 9


def test_what_the_setup_left_to_defaults_is_not_given_after_opening_again(tmp_path: Path) -> None:
    setup = simulated_setup()
    assert "normal" not in setup.floor.model_fields_set
    path = Session.create(tmp_path, setup, now=NOW).path
    found = Session.open(path).setup
    assert found == setup
    assert found.floor.model_fields_set == setup.floor.model_fields_set
    assert dump_setup(found) == dump_setup(setup)
    record = path / "session.json"
    content = json.loads(record.read_text(encoding="utf-8"))
    content["setup"]["floor"]["height_m"] = -0.2
    for given in (content["setup_given"], ["no table"]):
        record.write_text(json.dumps({**content, "setup_given": given}), encoding="utf-8")
        assert Session.open(path).setup.floor.height_m == -0.2, "what was corrected by hand counts"


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"", "is damaged"),
        (b"{", "is damaged"),
        (b"[]", "holds no table"),
        (b"\xff\xfe", "is damaged"),
        (b'{"name": "a"}', "created_at is missing|is damaged"),
        (b"[" * 100_000, "is damaged"),
    ],
)
def test_a_damaged_record_is_told_and_its_runs_stay(tmp_path: Path, content: bytes, said: str) -> None:
    session = Session.create(tmp_path, default_setup(), now=NOW)
    path = record(session)
    (session.path / "session.json").write_bytes(content)
    with pytest.raises(SessionError, match=said) as refused:
        Session.open(session.path)
    assert "\n" not in str(refused.value)
    assert read_run(path).n_samples == 700
    (found,) = find_sessions(tmp_path)
    assert found.n_runs == 1
    assert "is damaged" in found.problem


def test_a_setup_in_the_record_that_is_wrong_is_named_by_key_and_value(tmp_path: Path) -> None:
    session = Session.create(tmp_path, default_setup(), now=NOW)
    path = session.path / "session.json"
    content = json.loads(path.read_text(encoding="utf-8"))
    content["setup"]["receiver"][1]["tilt_deg"] = 500.0
    path.write_text(json.dumps(content), encoding="utf-8")
    with pytest.raises(SessionError, match=r"receiver\[2\]\.tilt_deg = 500\.0"):
        Session.open(session.path)


def test_a_folder_without_a_record_is_no_session(tmp_path: Path) -> None:
    with pytest.raises(SessionError, match="is not a session"):
        Session.open(tmp_path)
    with pytest.raises(SessionError, match="is not a session"):
        Session.open(tmp_path / "none")


def test_the_catalogue_lists_the_newest_first_and_nothing_else(tmp_path: Path) -> None:
    for hour, name in ((9, None), (11, "b"), (10, "a")):
        Session.create(tmp_path, default_setup(), operator=str(hour), name=name, now=NOW.replace(hour=hour))
    record(Session.open(tmp_path / "a"))
    (tmp_path / "other").mkdir()
    (tmp_path / "file.txt").write_text("", encoding="utf-8")
    found = find_sessions(tmp_path)
    assert [(one.name, one.operator, one.n_runs) for one in found] == [
        ("b", "11", 0),
        ("a", "10", 1),
        ("2026-11-20T09-04-05", "9", 0),
    ]
    assert find_sessions(tmp_path / "none") == ()


def test_a_time_without_offset_is_taken_as_local(tmp_path: Path) -> None:
    session = Session.create(tmp_path, default_setup(), now=datetime(2026, 1, 2, 3, 4, 5))  # noqa: DTZ001
    assert session.path.name == "2026-01-02T03-04-05"
    assert datetime.fromisoformat(session.info.created_at).tzinfo is not None


def test_the_data_folder_of_the_user_is_named_after_the_program() -> None:
    assert default_data_folder().name == "RadarGUI"
    assert default_data_folder().is_absolute()


def test_a_session_of_a_newer_version_is_called_newer_and_not_damaged(tmp_path: Path) -> None:
    session = Session.create(tmp_path, default_setup(), now=NOW)
    run = record(session)
    record_file = session.path / "session.json"
    content = json.loads(record_file.read_text(encoding="utf-8"))
    record_file.write_text(json.dumps({**content, "schema_version": 2, "setup": {"new": 1}}), encoding="utf-8")
    with pytest.raises(SessionError, match=r"newer version of RadarGUI \(its format is 2, this version knows 1\)"):
        Session.open(session.path)
    with h5py.File(run, "r+") as file:
        file.attrs["format_version"] = 2
    with pytest.raises(FileError, match=r"run-0001\.h5 was written by a newer version of RadarGUI"):
        read_run(run)


def test_an_empty_session_can_be_taken_away_again_and_no_other(tmp_path: Path) -> None:
    empty, noted, used = (Session.create(tmp_path, default_setup(), name=name, now=NOW) for name in "abc")
    noted.mark("the cable was loose", now=NOW)
    record(used)
    assert [session.discard_empty() for session in (empty, noted, used)] == [True, False, False]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["b", "c"]
    # the next run goes into the same one
    assert not noted.read_only
    assert not used.read_only


def test_a_folder_that_was_deleted_meanwhile_is_made_again_for_the_next_run(tmp_path: Path) -> None:
    session = Session.create(tmp_path, default_setup(), operator="A", now=NOW)
    shutil.rmtree(session.path)
    record(session)
    assert Session.open(session.path, write=False).info == session.info


@pytest.mark.skipif(sys.platform == "win32", reason="links need a right there")
@pytest.mark.parametrize("name", ["report", "export"])
def test_a_folder_for_results_that_leads_out_of_the_session_is_not_followed(tmp_path: Path, name: str) -> None:
    session = Session.create(tmp_path / "data", default_setup(), now=NOW)
    record(session)
    outside = tmp_path / "outside"
    outside.mkdir()
    (session.path / name).symlink_to(outside, target_is_directory=True)
    with pytest.raises(SessionError, match=f"{name} is a link out of the session, to {outside}"):
        write_report(session, result_of_run) if name == "report" else plan_export(session.path, "csv")
    assert not list(outside.iterdir())
    assert own_subfolder(session.path, "figures") == session.path / "figures"
