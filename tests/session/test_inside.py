"""Nothing that a file or an option says makes the program write outside the folder it works in."""

from __future__ import annotations

import json
from datetime import UTC, datetime
from pathlib import Path

import h5py
import pytest
from hypothesis import HealthCheck, given, settings, strategies as st
from support.file_samples import default_setup, write_run
from support.found_sessions import find_sessions

from radargui.files.formats import EXPORT_FORMATS
from radargui.model.errors import SessionError
from radargui.session.session import Session
from radargui.session.transfer import plan_export

NOW = datetime(2026, 11, 20, tzinfo=UTC)
OUTSIDE = (
    "..",
    ".",
    "",
    "../x",
    "a/../../x",
    "/x",
    "\\x",
    "C:x",
    "C:\\x",
    "a\0b",
    "a\nb",
    "con",
    "NUL.txt",
    " x",
    "x.",
)


def everything(folder: Path) -> set[str]:
    return {path.relative_to(folder).as_posix() for path in folder.rglob("*")}


@pytest.mark.parametrize("name", OUTSIDE)
def test_a_session_cannot_be_named_out_of_its_folder(tmp_path: Path, name: str) -> None:
    with pytest.raises(SessionError, match="cannot be the name"):
        Session.create(tmp_path / "data", default_setup(), name=name, now=NOW)
    assert everything(tmp_path) <= {"data"}


@settings(deadline=None, max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.text(max_size=12) | st.text("./\\ :ab", max_size=8))
def test_whatever_the_name_a_session_is_one_folder_below_the_data(tmp_path: Path, name: str) -> None:
    data = tmp_path / "data"
    try:
        session = Session.create(data, default_setup(), name=name, now=NOW)
    except SessionError:
        return
    assert session.path.resolve().parent == data.resolve()


@pytest.mark.parametrize("name", ["../../x", "/x", "C:\\x", "..", ""])
def test_the_name_in_a_session_record_leads_nowhere(tmp_path: Path, name: str) -> None:
    session = Session.create(tmp_path / "data", default_setup(), name="s", now=NOW)
    record = session.path / "session.json"
    record.write_text(json.dumps({**json.loads(record.read_text(encoding="utf-8")), "name": name}), encoding="utf-8")
    write_run(session.path / "run-0001.h5", 40)
    before = everything(tmp_path)
    opened = Session.open(session.path)
    opened.update(notes="more")
    assert [one.path for one in find_sessions(tmp_path / "data")] == [session.path]
    list(plan_export(session.path, EXPORT_FORMATS["csv"]).carry_out())
    assert everything(tmp_path) - before == {"data/s/export", "data/s/export/run-0001.csv"}


def test_only_files_named_as_runs_count_as_runs(tmp_path: Path) -> None:
    session = Session.create(tmp_path / "data", default_setup(), name="s", now=NOW)
    for name in ("run-1.h5", "run-0001.h5.part", "xrun-0001.h5", "run-0001.hdf5", "run-0001.h5 "):
        (session.path / name).write_bytes(b"x")
    assert session.run_paths() == ()


@pytest.mark.parametrize("kind", list(EXPORT_FORMATS))
def test_texts_in_a_run_lead_an_export_nowhere(tmp_path: Path, kind: str) -> None:
    folder = tmp_path / "s"
    folder.mkdir()
    write_run(folder / "run-0001.h5", 40)
    with h5py.File(folder / "run-0001.h5", "r+") as file:
        for place in (file, file["raw"]):
            del place.attrs["attributes_crc32"]
            place.attrs["channel_names"] = ["../../I1", "/Q1", "C:\\I2", "Q2\n# x", "I3,Q9", "</script>"]
            place.attrs["device"] = "../../x"
    (run,) = plan_export(folder, EXPORT_FORMATS[kind], tmp_path / "out").carry_out()
    made = {path.relative_to(tmp_path).as_posix() for path in run.value}
    assert everything(tmp_path) <= {"s", "s/run-0001.h5", "out", *made}
    assert all(name.startswith("out/run-0001.") for name in made)
