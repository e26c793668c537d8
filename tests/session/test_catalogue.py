"""The catalogue finds sessions by what is known of them; the folders are the truth, the index only makes it quick."""

from __future__ import annotations

import os
import shutil
import sqlite3
from dataclasses import replace
from datetime import UTC, date, datetime
from pathlib import Path

import pytest
from support.file_samples import codes, default_setup, int16_digitisation, result_of
from support.found_sessions import find_sessions, look

from radargui.files.run_file import read_run
from radargui.files.run_results import write_results
from radargui.model.recording import Block
from radargui.model.result import Bounces
from radargui.model.setup import changed
from radargui.session.catalogue import Catalogue, Query, default_index_path
from radargui.session.session import Session

NOW = datetime(2026, 11, 20, 15, 4, 5, tzinfo=UTC)


def run_with(session: Session, e: float | None, marker: str = "") -> Path:
    with session.new_run(int16_digitisation(), started_at=NOW.isoformat()) as writer:
        writer.write(Block(codes(6, 60), 0))
        if marker:
            writer.mark(marker)
    if e is not None:
        result = result_of(read_run(writer.path))
        first = replace(result.bounces.impacts[0], e=e)
        write_results(writer.path, replace(result, bounces=Bounces((first,), result.bounces.free_fall)))
    return writer.path


@pytest.fixture
def data(tmp_path: Path) -> Path:
    folder = tmp_path / "data"
    steel = Session.create(
        folder, default_setup(), operator="Ada", sample="10 mm Steel", target="glass", setup_name="bench", now=NOW
    )
    run_with(steel, 0.9)
    steel.reject(run_with(steel, 0.1), "hand in the picture")
    other = changed(default_setup(), {"transmitter.distance_m": 0.9})
    deep = folder / "2026" / "december"
    wood = Session.create(
        deep, other, operator="Änne", sample="wood", notes="damp DAY", now=NOW.replace(month=12, day=3)
    )
    run_with(wood, 0.5, marker="door opened")
    wood.mark("Lüfter an", now=NOW)
    run_with(wood, None)
    return folder


def names(catalogue: Catalogue, query: Query) -> list[str]:
    return [one.sample for one in look(catalogue, query)]


def test_sessions_are_found_by_each_thing_that_is_known(data: Path, tmp_path: Path) -> None:
    steel, wood = ["10 mm Steel"], ["wood"]
    with Catalogue(data, tmp_path / "index") as catalogue:
        for query, found in (
            (Query(), wood + steel),
            (Query(operator="ada"), steel),
            (Query(operator="ÄNNE"), wood),
            (Query(since=date(2026, 11, 21)), wood),
            (Query(since=date(2026, 11, 20), until=date(2026, 11, 20)), steel),
            (Query(sample="steel"), steel),
            (Query(sample="GLASS"), steel),
            (Query(setup_name="Ben"), steel),
            (Query(antennas=default_setup()), steel),
            (Query(e_min=0.85, e_max=0.95), steel),
            (Query(e_max=0.2), []),
            (Query(e_min=0.4), wood + steel),
            (Query(text="damp day"), wood),
            (Query(text="DOOR damp"), wood),
            (Query(text="lüfter"), wood),
            (Query(text="hand picture"), steel),
            (Query(text="hand damp"), []),
            (Query(operator="a_a"), []),
            (Query(operator="%"), []),
            (Query(text="'; DROP TABLE sessions; --"), []),
        ):
            assert names(catalogue, query) == found, query


def test_a_coefficient_above_one_is_found_by_its_least_value_alone(data: Path, tmp_path: Path) -> None:
    session = Session.create(data, default_setup(), sample="superball", now=NOW.replace(hour=17))
    run_with(session, 1.02)
    session.close()
    with Catalogue(data, tmp_path / "index") as catalogue:
        assert names(catalogue, Query(e_min=1.0)) == ["superball"]


def test_a_session_whose_day_is_not_known_is_on_no_day(data: Path, tmp_path: Path) -> None:
    (data / "damaged").mkdir()
    (data / "damaged" / "session.json").write_text("{", encoding="utf-8")
    with Catalogue(data, tmp_path / "index") as catalogue:
        assert [one.name for one in look(catalogue) if one.problem] == ["damaged"]
        assert names(catalogue, Query(until=date(2030, 1, 1))) == ["wood", "10 mm Steel"]
        assert names(catalogue, Query(since=date(2000, 1, 1))) == ["wood", "10 mm Steel"]


def test_a_line_tells_what_came_of_the_runs_that_count(data: Path, tmp_path: Path) -> None:
    with Catalogue(data, tmp_path / "index") as catalogue:
        wood, steel = look(catalogue)
        assert (steel.n_runs, steel.n_rejected) == (2, 1)
        assert [(drop.name, drop.e, drop.origin.kind) for drop in steel.drops] == [("run-0001", 0.9, "simulated")]
        assert (wood.n_runs, wood.n_unfinished) == (2, 0)
        assert [drop.e for drop in wood.drops] == [0.5, None]
        assert wood.path == data / "2026" / "december" / "2026-12-03T15-04-05"
        first, second = catalogue.runs(wood.path)
    assert (first.summary["e"], second.summary, first.duration_s) == (0.5, {}, 0.06)


def settle(folder: Path) -> None:
    """Let all files look as if they had been written a minute ago."""
    for path in folder.rglob("*"):
        before = path.stat().st_mtime - 60.0
        os.utime(path, (before, before))


def test_what_is_written_again_in_the_same_instant_is_read_again(data: Path, tmp_path: Path) -> None:
    (steel,) = find_sessions(data, Query(sample="steel"))
    run = steel.path / "run-0001.h5"
    whole = run.read_bytes()
    written = run.stat().st_mtime_ns
    with Catalogue(data, tmp_path / "index") as catalogue:
        run.write_bytes(bytes(len(whole)))  # as it is while its writer has not ended
        os.utime(run, ns=(written, written))
        catalogue.refresh()
        assert [bool(one.problem) for one in catalogue.runs(steel.path)] == [True, False]
        run.write_bytes(whole)
        os.utime(run, ns=(written, written))
        catalogue.refresh()
        assert [bool(one.problem) for one in catalogue.runs(steel.path)] == [False, False]


def test_only_what_has_changed_is_read_again(data: Path, tmp_path: Path) -> None:
    settle(data)
    with Catalogue(data, tmp_path / "index") as catalogue:
        assert catalogue.refresh() == 6
    with Catalogue(data, tmp_path / "index") as catalogue:
        assert catalogue.refresh() == 0
        (steel,) = look(catalogue, Query(sample="steel"))
        dates = {run: run.stat().st_mtime_ns for run in steel.path.glob("*.h5")}
        session = Session.open(steel.path)
        session.restore(steel.path / "run-0002.h5")
        session.update(notes="new words")
        session.close()
        settle(steel.path)
        for run in steel.path.glob("*.h5"):
            os.utime(run, ns=(dates[run], dates[run]))
        assert catalogue.refresh() == 1
        (steel,) = look(catalogue, Query(text="new words"))
        assert (steel.n_rejected, [drop.e for drop in steel.drops]) == (0, [0.9, 0.1])
        (steel.path / "run-0001.h5").unlink()
        assert look(catalogue, Query(sample="steel"))[0].n_runs == 1
        shutil.rmtree(steel.path)
        assert names(catalogue, Query()) == ["wood"]
        (data / "2026").rename(data / "last year")
        assert names(catalogue, Query()) == ["wood"]


def test_an_index_that_is_damaged_old_or_unwritable_is_made_anew(data: Path, tmp_path: Path) -> None:
    index = tmp_path / "index"
    for spoil in (
        lambda: index.write_bytes(b"no database at all" * 100),
        lambda: index.write_bytes(index.read_bytes()[:5000]),
        index.unlink,
        lambda: _change(index, "PRAGMA user_version = 99"),
        lambda: _change(index, "DROP TABLE runs"),
        lambda: _change(index, "ALTER TABLE sessions DROP COLUMN notes"),
    ):
        with Catalogue(data, index) as catalogue:
            assert len(look(catalogue)) == 2
        spoil()
    with Catalogue(data, index) as catalogue:
        assert len(look(catalogue)) == 2
    blocked = tmp_path / "file"
    blocked.write_text("", encoding="utf-8")
    with Catalogue(data, blocked / "index") as catalogue:
        assert len(look(catalogue)) == 2


def test_an_index_that_another_program_keeps_to_itself_is_done_without(data: Path, tmp_path: Path) -> None:
    index = tmp_path / "index"
    with Catalogue(data, index) as first:
        look(first)
    other = sqlite3.connect(index, isolation_level=None)
    other.execute("BEGIN EXCLUSIVE")
    with Catalogue(data, index) as catalogue:
        assert len(look(catalogue)) == 2
    assert index.is_file()
    other.execute("ROLLBACK")
    other.close()


def test_links_hidden_folders_and_files_are_passed_over(data: Path, tmp_path: Path) -> None:
    shutil.copytree(data / "2026", data / ".hidden")
    (data / "readme.txt").write_text("", encoding="utf-8")
    (data / "empty").mkdir()
    assert len(find_sessions(data)) == 2
    assert find_sessions(tmp_path / "none") == ()


def test_a_file_that_is_no_run_is_told_and_the_rest_is_listed(data: Path, tmp_path: Path) -> None:
    (steel,) = find_sessions(data, Query(sample="steel"))
    (steel.path / "run-0009.h5").write_bytes(b"nothing")
    with Catalogue(data, tmp_path / "index") as catalogue:
        catalogue.refresh()
        assert [bool(run.problem) for run in catalogue.runs(steel.path)] == [False, False, True]


def test_an_index_that_fails_while_it_is_open_is_gone_on_without(data: Path, tmp_path: Path) -> None:
    index = tmp_path / "index"
    with Catalogue(data, index) as catalogue:
        index.write_bytes(b"no index any more" * 1000)
        assert names(catalogue, Query()) == ["wood", "10 mm Steel"]
    assert index.read_bytes().startswith(b"no index")


def test_each_data_folder_has_an_index_of_its_own(tmp_path: Path) -> None:
    assert default_index_path(tmp_path) != default_index_path(tmp_path / "other")
    assert default_index_path(tmp_path) == default_index_path(tmp_path / "x" / "..")


def _change(index: Path, statement: str) -> None:
    with sqlite3.connect(index) as database:
        database.execute(statement)
    database.close()
