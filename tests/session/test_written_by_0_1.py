"""What version 0.1 has written still opens, lists, shows its results and can be processed (see its README)."""

from __future__ import annotations

import shutil
import tomllib
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pytest
from support.found_sessions import look
from support.run_contents import read_markers

import radargui
from radargui.experiment.reprocess import process_run, recover
from radargui.files.run_file import read_run, read_run_setup, run_is_complete
from radargui.files.stored_results import read_stored_results
from radargui.model.setup import Setup, dump_setup, parse_setup, read_setup
from radargui.restitution.series import series_of
from radargui.session.catalogue import Catalogue
from radargui.session.lock import FILE_NAME, owner_of
from radargui.session.session import Session

WRITTEN = Path(__file__).parent.parent / "data" / "written_by_0.1"
SETUPS = sorted((WRITTEN / "setups").glob("*.toml"))
E_OF_SCENE = 0.8
STORED = {
    "two-drops": ("joint", 0.799922),
    "one-receiver": ("adaptive", None),
    "published": ("published", 0.799991),
    "imported": ("ellipse", 0.800003),
}
NOW = datetime(2027, 1, 2, 3, 4, 5, tzinfo=UTC)


@pytest.fixture
def sessions(tmp_path: Path) -> Path:
    return Path(shutil.copytree(WRITTEN / "sessions", tmp_path / "sessions"))


@pytest.mark.parametrize("file", SETUPS, ids=lambda file: file.stem)
def test_a_setup_reads_and_says_the_same_when_written_again(file: Path) -> None:
    setup = read_setup(file)
    assert parse_setup(dump_setup(setup), "written again") == setup


def test_all_six_shipped_setups_and_one_with_every_key_are_there() -> None:
    assert [file.stem for file in SETUPS] == [
        "clean",
        "default",
        "every-key",
        "granular-bed",
        "high-speed",
        "one-receiver",
        "physical",
    ]


def test_no_value_of_the_setup_with_every_key_is_lost() -> None:
    given = tomllib.loads((WRITTEN / "setups" / "every-key.toml").read_text())
    read = read_setup(WRITTEN / "setups" / "every-key.toml").model_dump(mode="json", by_alias=True)

    def want(part: Any, whole: Any, place: str) -> None:
        if isinstance(part, dict):
            for key, value in part.items():
                want(value, whole[key], f"{place}.{key}")
        elif isinstance(part, list):
            assert len(part) == len(whole), place
            for number, value in enumerate(part):
                want(value, whole[number], f"{place}[{number}]")
        else:
            assert whole == (pytest.approx(part, rel=1e-12) if isinstance(part, float) else part), place

    want(given, read, "")


def test_a_session_says_what_it_was_given(sessions: Path) -> None:
    session = Session.open(sessions / "two-drops")
    info = session.info
    assert session.read_only == ""
    assert (info.operator, info.sample, info.target) == ("N. N.", "steel 10 mm", "glass plate")
    assert info.notes == "Written by 0.1\nsecond line: µm, <b>, =1+1"
    assert (info.calibration.made_at, info.calibration.origin) == ("2026-11-01", "nominal angles")
    assert [(entry.run, entry.index) for entry in info.journal] == [
        ("run-0001.h5", 1160),
        ("run-0002.h5", 1160),
        ("", None),
    ]
    assert session.rejected == {"run-0002.h5": "hand in the field of view"}
    assert [path.name for path in session.run_paths()] == ["run-0001.h5"]
    first, _ = session.run_paths(with_rejected=True)
    assert [(marker.index, marker.text) for marker in read_markers(first)] == [(1160, "knocked on the table")]
    session.close()


def test_all_sessions_are_listed_with_their_figures(sessions: Path, tmp_path: Path) -> None:
    with Catalogue(sessions, tmp_path / "index.sqlite") as catalogue:
        found = {summary.name: summary for summary in look(catalogue)}
        assert set(found) == {*STORED, "interrupted"}
        assert not any(summary.problem for summary in found.values())
        assert (found["two-drops"].n_runs, found["two-drops"].n_rejected) == (2, 1)
        assert found["interrupted"].n_unfinished == 1
        for name, (_, e) in STORED.items():
            series = series_of(found[name].drops)
            assert series.e.mean == (None if e is None else pytest.approx(e, abs=1e-6))
            assert series.kind == "simulated"


@pytest.mark.parametrize("name", STORED)
def test_stored_results_are_shown(sessions: Path, name: str) -> None:
    correction, e = STORED[name]
    (stored,) = read_stored_results(sessions / name / "run-0001.h5")
    assert (stored.summary["status"], stored.summary["correction"], stored.version) == ("ok", correction, "0.1.0")
    assert stored.summary["e"] == (None if e is None else pytest.approx(e, abs=1e-6))
    assert isinstance(stored.setup, Setup)


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.slow if name == "two-drops" else ()) for name in STORED]
)
def test_a_run_can_be_processed_again_with_its_own_setup(sessions: Path, name: str) -> None:
    correction, e = STORED[name]
    run = sessions / name / "run-0001.h5"
    samples = read_run(run).raw
    result = process_run(run)
    assert result.status == "ok"
    assert result.corrected is not None
    assert result.corrected.method == correction
    if e is not None:
        assert result.bounces.impacts[0].valid
        assert result.bounces.impacts[0].e == pytest.approx(E_OF_SCENE, abs=1e-3)
    assert (read_run(run).raw == samples).all()


def test_the_door_for_programmers_opens_it(sessions: Path) -> None:
    result = radargui.process(radargui.open_run(sessions / "published" / "run-0001.h5"))
    assert (result.status, result.correction) == ("ok", "published")
    assert result.bounces[0].e == pytest.approx(E_OF_SCENE, abs=1e-3)


def test_an_interrupted_run_is_found_and_finished(sessions: Path) -> None:
    folder = sessions / "interrupted"
    owner = owner_of(folder)
    assert owner is not None
    assert owner.computer == "laboratory"
    assert "laboratory" in Session.open(folder).read_only
    # what the message asks for where that computer is gone
    (folder / FILE_NAME).unlink()
    session = Session.open(folder)
    (run,) = (path for path in session.run_paths() if not run_is_complete(path))
    assert recover(run, now=NOW) == 1200
    session.close()
    assert run_is_complete(run)
    assert read_run_setup(run) == session.setup
    assert [marker.text for marker in read_markers(run)] == ["the lamp flickers"]
