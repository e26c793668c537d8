"""Results that were made with other settings stay beside the present ones."""

from __future__ import annotations

import os
import time
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
from support.file_samples import result_of, write_run

from radargui.files import hdf5
from radargui.files.run_file import read_run
from radargui.files.run_results import rewritten, write_results
from radargui.files.stored_results import read_stored_results, read_whole_result
from radargui.model.setup import changed


def test_the_figures_before_are_kept_and_the_present_ones_come_last(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    samples = write_run(path)
    assert read_stored_results(path) == ()
    first = result_of(read_run(path))
    plane = replace(first, setup=changed(first.setup, {"processing.geometry": "plane"}))
    other = replace(first, setup=changed(first.setup, {"processing.correction": "ellipse"}))
    for result in (first, first, plane, other, plane, first):
        write_results(path, result)
    stored = read_stored_results(path)
    assert [one.is_present for one in stored] == [False, False, False, True]
    assert [one.setup for one in stored] == [first.setup, plane.setup, other.setup, first.setup]
    assert all(one.summary["e"] == 0.8 for one in stored)
    assert all(one.thumbnail is not None for one in stored)
    with h5py.File(path) as file:
        assert "track" not in file["earlier_results/000001"]
        assert file["earlier_results/000001/bounces"]["e"].tolist() == [0.8, 0.5]
    np.testing.assert_array_equal(read_run(path).raw, samples)


def test_what_was_decided_is_stored_with_the_results(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    write_run(path)
    made = result_of(read_run(path))
    write_results(path, made)
    found = read_whole_result(path, made.setup, lambda _: read_run(path))
    assert found is not None
    assert found.corrected is not None
    assert found.corrected.decisions == ("A floor is kept.",)
    with h5py.File(path, "r+") as file:
        del file["results"].attrs["decisions"]
        hdf5.seal(file["results"].attrs)
    older = read_whole_result(path, made.setup, lambda _: read_run(path))
    assert older is not None
    assert older.corrected is not None
    assert older.corrected.decisions == ()


def test_walls_that_were_met_and_the_drag_of_flights_are_stored_with_the_impacts(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    write_run(path)
    made = result_of(read_run(path))
    first = made.bounces.impacts[0].time_s
    bounces = replace(made.bounces, braked_1_m=0.07, walls_s=(0.1234567890123, 0.2), with_walls_s=(first,))
    write_results(path, replace(made, bounces=bounces))
    found = read_whole_result(path, made.setup, lambda _: read_run(path))
    assert found is not None
    assert (found.bounces.braked_1_m, found.bounces.walls_s) == (0.07, (0.1234567890123, 0.2))
    # the very instants: they are looked up among those of the impacts
    assert found.bounces.with_walls_s == (found.bounces.impacts[0].time_s,)
    with h5py.File(path, "r+") as file:
        attributes = file["results/bounces"].attrs
        for name in ("braked_1_m", "walls_s", "with_walls_s"):
            del attributes[name]
        hdf5.seal(attributes)
    older = read_whole_result(path, made.setup, lambda _: read_run(path))
    assert older is not None
    assert (older.bounces.braked_1_m, older.bounces.walls_s, older.bounces.with_walls_s) == (None, (), ())


def test_results_of_another_version_are_kept_too(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    write_run(path)
    result = result_of(read_run(path))
    write_results(path, result)
    with h5py.File(path, "r+") as file:
        file["results"].attrs["version"] = np.bytes_("0.0.1")
        hdf5.seal(file["results"].attrs)
    write_results(path, result)
    assert read_stored_results(path)[0].version == "0.0.1"
    assert len(read_stored_results(path)) == 2


def test_two_programs_that_write_a_run_anew_do_not_share_a_working_file(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    samples = write_run(path)
    with rewritten(path, "it cannot be saved") as (source, target):
        # the other program stores its results while this one is at it
        write_results(path, result_of(read_run(path)))
        hdf5.copy_attributes(source, target)
        for name in source:
            source.copy(name, target)
    np.testing.assert_array_equal(read_run(path).raw, samples)
    assert sorted(tmp_path.iterdir()) == [path]


def test_a_working_file_that_a_crash_left_behind_is_taken_away_after_a_day(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    write_run(path)
    old, young = tmp_path / "run.h5.12-1.part", tmp_path / "run.h5.13-1.part"
    for left in (old, young):
        left.write_bytes(b"half")
    before = time.time() - 2 * 86_400
    os.utime(old, (before, before))
    write_results(path, result_of(read_run(path)))
    assert sorted(one.name for one in tmp_path.iterdir()) == ["run.h5", "run.h5.13-1.part"]
