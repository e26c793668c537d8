"""Store the lowest and highest sample of each bin at several levels, so that a picture reads no samples."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from radargui.files import hdf5, run_layout as layout
from radargui.model.arrays import FloatArray, RawArray, lowest_and_highest

FINEST_BIN = 64
"""Samples in a bin of the finest level of a short run: lowest and highest then take 3 % of the room of the samples."""
MAX_BINS = 1 << 18
"""Bins of the finest level; a longer run gets larger ones, so that memory stays bounded overnight (6 MB of int16)."""
STEP = 16
"""Bins of one level that make one of the next: all levels above the finest add 1/15 to it."""
FEWEST_BINS = 2048
"""A level with fewer bins has none above it: as many as a wide picture has pixels."""


@dataclass(frozen=True, slots=True)
class Overview:
    """Lowest and highest sample of each bin.

    Attributes
    ----------
    lowest, highest
        Shape (n_channels, n_bins), in the unit of the run (volts); NaN where a bin holds no number.
    bin_samples
        Stored samples in a bin; the last one may hold fewer.
    n_samples
        Stored samples of each channel in all.
    sample_rate_hz
        Rate of each channel.
    channel_names
        One a row.
    """

    lowest: FloatArray
    highest: FloatArray
    bin_samples: int
    n_samples: int
    sample_rate_hz: float
    channel_names: tuple[str, ...]


class OverviewMaker:
    """Makes the finest level while samples come, in bounded memory.

    Parameters
    ----------
    n_channels, dtype
        As the samples.
    max_bins
        Of the finest level.
    """

    def __init__(self, n_channels: int, dtype: Any, max_bins: int = MAX_BINS) -> None:
        self._bin, self._max_bins = FINEST_BIN, max_bins
        self._room = np.empty((2, n_channels, max_bins), dtype=dtype)
        self._n_bins = 0
        self._left = np.empty((n_channels, 0), dtype=dtype)

    def add(self, samples: RawArray) -> None:
        """Take the samples that follow, shape (n_channels, n)."""
        samples = np.concatenate([self._left, samples], axis=1)
        done = 0
        while (count := (samples.shape[1] - done) // self._bin) > 0:
            if self._n_bins == self._max_bins:
                self._n_bins, self._bin = self._n_bins // 2, 2 * self._bin
                self._room[:, :, : self._n_bins] = _coarsened(self._room, 2)
                continue
            take = min(count, self._max_bins - self._n_bins)
            ends = lowest_and_highest(samples[:, done : done + take * self._bin], self._bin)
            self._room[:, :, self._n_bins : self._n_bins + take] = ends
            self._n_bins += take
            done += take * self._bin
        self._left = samples[:, done:].copy()

    def level(self) -> tuple[NDArray[Any], int]:
        """Return lowest and highest, shape (2, n_channels, n_bins), and samples a bin; the last one may hold fewer."""
        left = lowest_and_highest(self._left, self._bin)
        return np.concatenate([self._room[:, :, : self._n_bins], left], axis=2), self._bin


def _coarsened(ends: NDArray[Any], step: int) -> NDArray[Any]:
    return np.stack([lowest_and_highest(ends[0], step)[0], lowest_and_highest(ends[1], step)[1]])


def write_overview(file: Any, maker: OverviewMaker, unit: str) -> None:
    """Store the levels in an open run file, in place of older ones."""
    if layout.OVERVIEW in file:
        del file[layout.OVERVIEW]
    group = file.create_group(layout.OVERVIEW)
    ends, size = maker.level()
    while ends.shape[2]:
        level = group.create_group(f"level_{len(group)}")
        level.attrs["bin_samples"] = size
        for name, values in zip(("lowest", "highest"), ends, strict=True):
            hdf5.store(level, name, values, layout.LARGEST_CHUNK, unit=unit)
        if ends.shape[2] < FEWEST_BINS:
            return
        ends, size = _coarsened(ends, STEP), size * STEP


def read_overview(path: Path, min_bins: int = 2000) -> Overview:
    """Return the coarsest stored level with at least so many bins, else the finest; computed where none is stored.

    Parameters
    ----------
    path
        Run file.
    min_bins
        About the width of the picture in pixels.

    Raises
    ------
    FileError
        Unreadable, damaged, or no run file.
    """
    with hdf5.opened(path, "a run file", layout.is_run) as file:
        raw = hdf5.dataset(file, layout.RAW, path, (2,))
        digitisation = layout.read_digitisation(raw, path)
        found, count = _stored(file, path, min_bins), int(raw.shape[1])
        if found is None:
            count = layout.whole_samples(raw)
            found = _computed(raw, count)
        (lowest, highest), size = found
        # a negative factor in the scaling turns them round
        low, high = np.sort([digitisation.volts(lowest), digitisation.volts(highest)], axis=0)
        return Overview(low, high, size, count, digitisation.sample_rate_hz, digitisation.channel_names)


def _stored(file: Any, path: Path, min_bins: int) -> tuple[Any, int] | None:
    n_channels, count = file[layout.RAW].shape
    levels = []
    for level in file[layout.OVERVIEW].values() if layout.OVERVIEW in file else ():
        size = int(hdf5.number(level.attrs, "bin_samples") or 0)
        lowest, highest = (hdf5.dataset(level, name, path, (2,)) for name in ("lowest", "highest"))
        if size >= 1 and lowest.shape == highest.shape == (n_channels, -(-count // size)):
            levels.append((lowest, highest, size))
    if not levels:
        return None
    levels.sort(key=lambda level: level[2], reverse=True)
    best = next((level for level in levels if level[0].shape[1] >= min_bins), levels[-1])
    return (best[0][:], best[1][:]), best[2]


def _computed(raw: Any, count: int) -> tuple[Any, int]:
    maker = OverviewMaker(raw.shape[0], raw.dtype)
    for place in layout.stored_pieces(raw, count):
        maker.add(raw[:, place])
    return maker.level()
