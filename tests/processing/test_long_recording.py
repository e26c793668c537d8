"""Of a long recording the stretch around a motion is processed, with the same result, times and gaps."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.same_result import assert_same_result
from support.simulated_recording import simulate_recording
from support.simulated_setup import simulated_setup

from radargui.files.run_file import read_run
from radargui.files.run_results import write_results
from radargui.files.run_writer import RunWriter
from radargui.model.errors import FileError
from radargui.model.recording import Block, Gap, Recording
from radargui.processing.long_recording import LengthLimits, read_excerpt, read_for_processing, shortened
from radargui.processing.process import process
from radargui.processing.result_of_run import result_of_run
from radargui.signals.long_motion import find_long_motion

RATE_HZ = 5000.0
SETUP = simulated_setup(daq={"rate_hz": RATE_HZ}, mismatch=0.0, snr_db=50.0, restitution=0.5, settle_s=0.4, rest_s=0.6)


@pytest.fixture(scope="module")
def drop() -> Recording:
    return simulate_recording(SETUP)[0]


SHORT = LengthLimits(20_000, 30_000, 7_001)


def rest(drop: Recording, seconds: float) -> np.ndarray:
    quiet = drop.raw[:, :2000]
    there_and_back = np.concatenate([quiet, quiet[:, ::-1]], axis=1)
    return np.tile(there_and_back, (1, round(seconds * RATE_HZ / there_and_back.shape[1])))


def long(drop: Recording, before_s: float = 12.0, after_s: float = 8.0) -> Recording:
    return replace(drop, raw=np.concatenate([rest(drop, before_s), drop.raw, rest(drop, after_s)], axis=1))


def test_an_ordinary_recording_is_left_as_it_is(drop: Recording) -> None:
    assert shortened(drop, SHORT) is drop


def test_the_result_of_a_long_recording_is_that_of_the_drop_in_it(drop: Recording) -> None:
    alone, whole = process(drop, SETUP), long(drop)
    result = process(shortened(whole, SHORT), SETUP)
    excerpt = result.recording.excerpt
    assert excerpt is not None
    assert excerpt.of_samples == whole.n_samples
    assert result.recording.n_samples < drop.n_samples + 3.0 * RATE_HZ
    assert result.track is not None
    assert result.track.time_s.size == result.recording.n_samples
    first, wanted = result.bounces.impacts[0], alone.bounces.impacts[0]
    assert first.time_s == pytest.approx(12.0 + wanted.time_s, abs=2e-4)
    assert first.e == pytest.approx(wanted.e, abs=2e-3)
    assert any("around the motion" in warning for warning in result.warnings)


def test_a_run_file_gives_the_same_excerpt_as_the_samples(drop: Recording, tmp_path: Path) -> None:
    whole = long(drop)
    path = tmp_path / "run-0001.h5"
    with RunWriter(path, whole.digitisation, started_at="", trigger_index=60_500) as writer:
        writer.write(Block(whole.raw[:, :5000], 0))
        writer.write(Block(whole.raw[:, 5000:], 5100, Gap(5000, 100, "overflow")))
    found = read_for_processing(path, SHORT)
    wanted = shortened(read_run(path), SHORT)
    np.testing.assert_array_equal(found.raw, wanted.raw)
    np.testing.assert_array_equal(found.time_s(), wanted.time_s())
    assert (found.gaps, found.excerpt, found.trigger_index) == (wanted.gaps, wanted.excerpt, 60_500)
    assert found.excerpt is not None
    assert found.time_s()[0] == (found.excerpt.first_stored + 100) / RATE_HZ
    result = process(found, SETUP)
    assert result.status == "ok"
    before = read_run(path).raw
    write_results(path, result)
    np.testing.assert_array_equal(read_run(path).raw, before)
    # the result is not computed again
    assert_same_result(result_of_run(path, SETUP, lambda _: pytest.fail("it was computed")), result)
    with pytest.raises(FileError, match="no such excerpt"):
        read_excerpt(path, replace(found.excerpt, of_samples=found.excerpt.of_samples + 1))


def test_gaps_within_the_excerpt_keep_their_place(drop: Recording) -> None:
    whole = long(drop)
    end = whole.n_samples
    for place in (100, 61_000, 63_000, end - 100):
        cut = replace(whole, gaps=(Gap(50, 7, "a"), Gap(place + 7, 40, "b")))
        part = shortened(cut, SHORT)
        assert part.excerpt is not None
        inside = slice(part.excerpt.first_stored, part.excerpt.last_stored)
        np.testing.assert_array_equal(part.index(), cut.index()[inside])
        np.testing.assert_array_equal(part.raw, cut.raw[:, inside])


def test_where_nothing_moves_the_answer_is_no_motion(drop: Recording) -> None:
    result = process(shortened(replace(drop, raw=rest(drop, 10.0)), SHORT), SETUP)
    assert result.status == "no_motion"
    assert any("nothing moves" in warning for warning in result.warnings)


def test_of_several_motions_one_is_processed_and_the_number_told(drop: Recording) -> None:
    raw = np.concatenate([long(drop).raw, long(drop).raw], axis=1)
    result = process(shortened(replace(drop, raw=raw), SHORT), SETUP)
    assert result.status == "ok"
    assert any("longest of 2 motions" in warning for warning in result.warnings)


def test_a_motion_without_end_is_cut_to_what_memory_allows(drop: Recording) -> None:
    turning = np.sin(2.0 * np.pi * 40.0 * np.arange(100_000) / RATE_HZ)
    noise = np.random.default_rng(1).normal(0.0, 0.001, (6, 100_000))
    found = find_long_motion([turning + noise], RATE_HZ, 30_000)
    assert found is not None
    assert (found.first, found.last, found.cut) == (0, 30_000, True)


def test_pieces_of_any_length_give_the_same_motion(drop: Recording) -> None:
    volts = long(drop).volts()
    found = set()
    for size in (3_333, 10_000, 80_001, volts.shape[1]):
        pieces = (volts[:, first : first + size] for first in range(0, volts.shape[1], size))
        found.add(find_long_motion(pieces, RATE_HZ, 1 << 20))
    assert len(found) == 1
    assert find_long_motion([], RATE_HZ, 100) is None


def test_rest_never_takes_the_place_of_the_motion(drop: Recording) -> None:
    found = find_long_motion([long(drop).volts()], RATE_HZ, 4000)
    assert found is not None
    assert found.last - found.first == 4000
    moving = 12.6 * RATE_HZ
    assert moving - 1100 <= found.first <= moving
    assert found.cut
