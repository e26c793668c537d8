"""The overview shows every extreme of a run without its samples; the thumbnail its height."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest
from support.file_samples import codes, int16_digitisation, result_of, volts

from radargui.files.overview import OverviewMaker, read_overview
from radargui.files.run_card import read_thumbnail
from radargui.files.run_file import read_run
from radargui.files.run_results import write_results
from radargui.files.run_writer import RunWriter
from radargui.model.recording import Block, Digitisation, iq_names


def extremes(samples: np.ndarray, size: int) -> tuple[np.ndarray, np.ndarray]:
    starts = np.arange(0, samples.shape[1], size)
    return np.minimum.reduceat(samples, starts, axis=1), np.maximum.reduceat(samples, starts, axis=1)


@pytest.mark.parametrize("count", [1, 63, 64, 65, 5000, 40_001])
def test_each_bin_holds_the_lowest_and_highest_of_its_samples(tmp_path: Path, count: int) -> None:
    path = tmp_path / "run.h5"
    samples = codes(6, count)
    with RunWriter(path, int16_digitisation(), started_at="") as writer:
        for first in range(0, count, 777):
            writer.write(Block(samples[:, first : first + 777], first))
    digitisation = int16_digitisation()
    for least in (1, 300, 1_000_000):
        found = read_overview(path, least)
        lowest, highest = extremes(samples, found.bin_samples)
        np.testing.assert_array_equal(found.lowest, digitisation.volts(lowest))
        np.testing.assert_array_equal(found.highest, digitisation.volts(highest))
        assert found.n_samples == count
    with h5py.File(path, "a") as file:
        del file["overview"]
    computed = read_overview(path)
    np.testing.assert_array_equal(computed.lowest, digitisation.volts(extremes(samples, computed.bin_samples)[0]))


def test_bins_grow_with_the_run_so_that_memory_does_not() -> None:
    samples = codes(2, 64 * 16 * 5 + 100)
    maker = OverviewMaker(2, np.int16, max_bins=16)
    for first in range(0, samples.shape[1], 333):
        maker.add(samples[:, first : first + 333])
    (lowest, highest), size = maker.level()
    assert size == 64 * 8
    wanted = extremes(samples, size)
    np.testing.assert_array_equal(lowest, wanted[0])
    np.testing.assert_array_equal(highest, wanted[1])


def test_a_factor_below_zero_turns_lowest_and_highest_round(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    samples = codes(2, 500)
    with RunWriter(path, Digitisation(iq_names(1), 1000.0, ((0.0, -2.0),) * 2), started_at="") as writer:
        writer.write(Block(samples, 0))
    found = read_overview(path)
    assert (found.lowest <= found.highest).all()
    assert found.highest.max() == -2.0 * samples.min()


def test_samples_that_are_no_numbers_are_passed_over(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    samples = volts(2, 200)
    samples[0, 10] = np.nan
    samples[1, :64] = np.nan
    with RunWriter(path, Digitisation(iq_names(1), 1000.0), started_at="") as writer:
        writer.write(Block(samples, 0))
    found = read_overview(path)
    assert found.highest[0, 0] == np.nanmax(samples[0, :64])
    assert np.isnan(found.lowest[1, 0])
    assert not np.isnan(found.lowest[1, 1])


def test_a_thumbnail_follows_the_height(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    with RunWriter(path, int16_digitisation(), started_at="") as writer:
        writer.write(Block(codes(6, 5000), 0))
    assert read_thumbnail(path) is None
    result = result_of(read_run(path))
    write_results(path, result)
    found = read_thumbnail(path)
    assert found is not None
    assert result.track is not None
    assert found.time_s.size <= 2 * 128
    assert (np.nanmin(found.z_m), np.nanmax(found.z_m)) == (
        result.track.position_m[2].min(),
        result.track.position_m[2].max(),
    )
    assert np.isfinite(found.z_m).all()
    assert result.paths is not None
    piece = (np.arange(5000) >= 2345).astype(np.intp)
    write_results(path, replace(result, paths=replace(result.paths, piece=piece)))
    broken = read_thumbnail(path)
    assert broken is not None
    size = 40
    assert np.flatnonzero(np.isnan(broken.z_m)).tolist() == [2 * (2345 // size), 2 * (2345 // size) + 1]
