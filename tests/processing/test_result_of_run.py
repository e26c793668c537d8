"""A stored result stands for the computing as long as it is current; else it is computed again, and nothing written."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest
from support.changed import changed
from support.same_result import assert_same_result
from support.stored_runs import SETUP, store_runs

from radargui.files import hdf5
from radargui.files.run_file import read_run
from radargui.files.run_results import results_are_current, write_results
from radargui.files.run_writer import RunWriter
from radargui.model.front_end import FrontEnd, FrontEndPrior
from radargui.model.recording import Block, Gap
from radargui.model.result import RunResult
from radargui.model.setup import Setup
from radargui.processing.process import cut_short, process
from radargui.processing.result_of_run import DAMAGED, result_of_run

PRIOR = FrontEndPrior(("run-0001", "run-0003"), (FrontEnd(1.02, 0.001, -0.7, 0.03),) * 3, used=False)


def kept(path: Path, setup: Setup) -> RunResult:
    """Return what a run file gives, and fail where it is computed."""
    return result_of_run(path, setup, lambda _: pytest.fail("it was computed"))


def computed(path: Path, setup: Setup) -> RunResult:
    """Return what a run file gives, and fail where it is not computed."""
    told: list[float] = []
    result = result_of_run(path, setup, told.append)
    assert told, "nothing was computed"
    return result


@pytest.fixture
def run(tmp_path: Path) -> Path:
    """A run with its result."""
    (path,) = store_runs(tmp_path / "session", 1)
    write_results(path, process(read_run(path), SETUP))
    return path


def with_results(path: Path, change: Callable[[h5py.Group], object]) -> None:
    with h5py.File(path, "r+") as file:
        change(file["results"])
        hdf5.seal(file["results"].attrs)


@pytest.mark.parametrize(
    "tables",
    [
        {"processing": {"correction": "joint"}},
        {"processing": {"correction": "published"}},
        {"processing": {"correction": "ellipse", "geometry": "plane"}},
        {"processing": {"correction": "none"}},
        {"processing": {"correction": "published"}, "receiver": 1},
    ],
)
def test_what_was_stored_is_what_was_computed(tmp_path: Path, tables: dict[str, object]) -> None:
    (path,) = store_runs(tmp_path / "session", 1)
    recording, n_receivers = read_run(path), int(tables.pop("receiver", 3))
    setup = changed(SETUP, **tables)
    known, path = recording.digitisation, tmp_path / "first-bounce.h5"
    if n_receivers == 1:
        setup = changed(setup, daq={"channels": None}).model_copy(update={"receiver": setup.receiver[:1]})
        known = replace(known, channel_names=known.channel_names[:2], scaling=known.scaling and known.scaling[:2])
    with RunWriter(path, known, started_at="") as writer:
        # the joint estimate takes longest over the last small bounces
        writer.write(Block(recording.raw[: 2 * n_receivers, :1500], 0))
    recording = read_run(path)
    wanted = process(recording, setup)
    assert wanted.corrected is not None
    assert wanted.corrected.method == setup.processing.correction
    assert (wanted.track is None) == (n_receivers == 1)
    write_results(path, wanted)
    assert_same_result(kept(path, setup), wanted)


def test_gaps_prior_and_an_answer_without_motion_come_back_too(tmp_path: Path) -> None:
    (path,) = store_runs(tmp_path / "session", 1)
    recording, again = read_run(path), tmp_path / "run-0002.h5"
    with RunWriter(again, recording.digitisation, started_at="") as writer:
        writer.write(Block(recording.raw[:, :300], 0))
        writer.write(Block(recording.raw[:, 300:], 360, Gap(300, 60, "overflow")))
    cut = replace(process(read_run(again), SETUP), front_end_prior=PRIOR)
    assert cut.segment is not None
    assert cut.segment.first > 300
    write_results(again, cut)
    assert_same_result(kept(again, SETUP), cut)
    nothing = process(replace(recording, raw=recording.raw[:, :300]), SETUP)
    assert nothing.status == "no_motion"
    write_results(path, replace(nothing, recording=recording))
    assert_same_result(kept(path, SETUP), replace(nothing, recording=recording))


def test_pieces_of_the_paths_come_back_and_older_files_have_one(run: Path) -> None:
    whole = process(read_run(run), SETUP)
    assert whole.paths is not None
    one_piece = replace(whole, paths=replace(whole.paths, piece=None))
    piece = np.arange(whole.recording.n_samples) // 700
    pieces = replace(whole, paths=replace(whole.paths, piece=piece))
    write_results(run, pieces)
    assert_same_result(kept(run, SETUP), pieces)
    with h5py.File(run, "a") as file:
        assert file["results/paths/piece"].compression == "gzip"
        assert file["results/paths/piece"].chunks == file["results/track/valid"].chunks
        del file["results/paths/piece"]
    assert_same_result(kept(run, SETUP), one_piece)


def test_a_preliminary_result_is_given_as_it_is(run: Path) -> None:
    stopped = cut_short(replace(process(read_run(run), SETUP), preliminary=True))
    write_results(run, stopped)
    assert_same_result(kept(run, SETUP), stopped)
    assert not results_are_current(run, SETUP), "a batch makes up for it"


def test_with_another_setup_it_is_computed_and_the_file_stays(run: Path) -> None:
    before = run.read_bytes()
    for tables in ({"processing": {"geometry": "plane"}}, {"tracer": {"release_position_m": (0.0, 0.0, 0.1201)}}):
        other = changed(SETUP, **tables)
        assert_same_result(computed(run, other), process(read_run(run), other))
    assert run.read_bytes() == before


@pytest.mark.parametrize(
    "change",
    [
        lambda results: results.attrs.__setitem__("version", np.bytes_("0.0.1")),
        lambda results: results.attrs.__setitem__("format_version", 99),
        lambda results: results.attrs.__setitem__("raw_crc32", results.attrs["raw_crc32"] + np.uint32(1)),
        lambda results: results.attrs.__delitem__("raw_crc32"),
    ],
    ids=["another version", "another format", "other samples", "unknown samples"],
)
def test_results_of_something_else_do_not_count(run: Path, change: Callable[[h5py.Group], object]) -> None:
    with_results(run, change)
    assert not results_are_current(run, SETUP)
    assert computed(run, SETUP).status == "ok"


def test_a_file_of_before_is_read_and_computed_and_not_written(run: Path) -> None:
    def as_before(results: h5py.Group) -> None:
        del results["corrected"]
        for key in ("format_version", "raw_crc32", "segment", "excerpt"):
            del results.attrs[key]

    with_results(run, as_before)
    before = run.read_bytes()
    assert_same_result(computed(run, SETUP), process(read_run(run), SETUP))
    assert run.read_bytes() == before


def test_damaged_results_are_computed_again_and_one_sentence_says_so(run: Path) -> None:
    whole = run.read_bytes()
    wanted = process(read_run(run), SETUP)
    for name in ("paths/change_m", "corrected/i", "track/valid", "bounces"):
        with h5py.File(run) as file:
            place = file[f"results/{name}"].id.get_chunk_info(0)
        content = bytearray(whole)
        middle = place.byte_offset + place.size // 2
        content[middle : middle + 4] = bytes(255 - byte for byte in content[middle : middle + 4])
        run.write_bytes(content)
        found = computed(run, SETUP)
        assert found.warnings == (DAMAGED.text, *wanted.warnings), name
        assert_same_result(replace(found, findings=wanted.findings), wanted)
    run.write_bytes(whole)
    with h5py.File(run, "r+") as file:
        file["results"].attrs["segment"] = (0, 1, 0, 0)
    assert computed(run, SETUP).findings[0] == DAMAGED
    with_results(run, lambda results: results.attrs.__setitem__("segment", (0, 1 << 40, 0, 0)))
    assert computed(run, SETUP).findings[0] == DAMAGED


def test_results_for_display_take_little_room(run: Path) -> None:
    with h5py.File(run) as file:
        results = file["results"]
        assert results["corrected/i"].dtype == results["paths/phase_rad"].dtype == np.float32
        assert results["paths/change_m"].dtype == results["track/u_position_m"].dtype == np.float64
