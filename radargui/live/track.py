"""Hold what the live thread has estimated last, for other threads to read.

The live estimate of the newest samples.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from dataclasses import dataclass, replace

import numpy as np

from radargui.model.arrays import CircularBuffer, FloatArray, IntArray


@dataclass(frozen=True, slots=True)
class LiveEstimate:
    """What the newest samples say; columns are block means.

    Attributes
    ----------
    index
        Absolute sample index of each column, shape (n,), ascending; samples of the first fringes come late, when the
        correction is known.
    i, q
        Corrected, in amplitudes, Q as it is wired, shape (n_receivers, n); NaN while the correction is not known.
    change_m
        Change of path length from the rest, shape (n_receivers, n); NaN while unknown.
    position_m
        Shape (3, n); the release position at rest, NaN while unknown or with fewer than three receivers.
    moving
        Whether the tracer moves now.
    began_anew
        Whether the track was lost, or samples were lost while the tracer may have moved. Later positions count from the
        following rest as if it were the release, until the tracer is known to hang there.
    doubt
        Why the place is unknown, in a few words; empty where it is known, where a new rest was found, or where there is
        nothing to say.
    shaken
        Absolute sample index up to which the trigger has looked, and how hard the voltages shook since it looked
        before (see `MotionTrigger.shaking`); None where nothing is new.
    """

    index: IntArray
    i: FloatArray
    q: FloatArray
    change_m: FloatArray
    position_m: FloatArray
    moving: bool
    began_anew: bool = False
    doubt: str = ""
    shaken: tuple[int, float] | None = None

    def without_place(self) -> LiveEstimate:
        """Return the same estimate with the place unknown."""
        change, position = np.full(self.change_m.shape, np.nan), np.full(self.position_m.shape, np.nan)
        return replace(self, change_m=change, position_m=position)


MAXIMUM_COLUMNS = 400_000
"""Bounds the memory of an hour: 13 numbers of 8 bytes each with three receivers, 42 MB; chosen by hand."""
_LOOKS_HZ = 100
"""The trigger looks at each block of samples: they come ten to fifty times a second."""


@dataclass(frozen=True, slots=True)
class LiveSpan:
    """Consecutive live estimates.

    Attributes
    ----------
    index
        Absolute sample index of each column, shape (n,).
    time_s
        index / rate, shape (n,).
    i, q
        Corrected, in amplitudes, shape (n_receivers, n); NaN before the correction is known.
    change_m
        Change of path length, shape (n_receivers, n); NaN while unknown.
    position_m
        Centre of the sphere, shape (3, n); NaN while unknown.
    """

    index: IntArray
    time_s: FloatArray
    i: FloatArray
    q: FloatArray
    change_m: FloatArray
    position_m: FloatArray


class LiveTrack:
    """The last estimates of the live thread; memory is allocated once.

    Parameters
    ----------
    n_receivers
        Rows of I, of Q and of path length.
    sample_rate_hz
        Rate that the indices count at.
    length_s
        Time span held; less where the estimates are so dense that they exceed `MAXIMUM_COLUMNS`.
    estimates_hz
        Estimates per second; None: one a sample.
    """

    def __init__(
        self, n_receivers: int, sample_rate_hz: float, length_s: float, estimates_hz: float | None = None
    ) -> None:
        columns = min(math.ceil(length_s * (estimates_hz or sample_rate_hz)), MAXIMUM_COLUMNS)
        self._n = n_receivers
        self._rate_hz = sample_rate_hz
        # the index above the values: whole numbers are exact in them far beyond any recording
        self._columns = CircularBuffer(3 * n_receivers + 4, columns, np.float64)
        self._shaken = CircularBuffer(2, math.ceil(_LOOKS_HZ * length_s), np.float64)
        self.moving = False
        self.began_anew = False
        self.doubt = ""
        """All three: see `LiveEstimate`."""

    @property
    def latest(self) -> int:
        """Absolute sample index after the last estimate."""
        end = self._columns.end
        return self._index_at(end - 1) + 1 if end else 0

    def append(self, estimate: LiveEstimate) -> None:
        """Add estimates; their indices ascend. The live thread only."""
        self.moving, self.began_anew, self.doubt = estimate.moving, estimate.began_anew, estimate.doubt
        if estimate.shaken is not None and math.isfinite(estimate.shaken[1]):
            self._shaken.extend(np.array([estimate.shaken]).T)
        if estimate.index.size == 0:
            return
        values = (estimate.index[None], estimate.i, estimate.q, estimate.change_m, estimate.position_m)
        self._columns.extend(np.concatenate(values))

    def since(self, index: int) -> LiveSpan:
        """Return all estimates held at absolute sample index `index` and later."""
        held = range(self._columns.first, self._columns.end)
        _, columns = self._columns.copy(held.start + bisect_left(held, index, key=self._index_at), held.stop)
        n, at = self._n, columns[0].astype(np.intp)
        return LiveSpan(at, at / self._rate_hz, *np.split(columns[1:], (n, 2 * n, 3 * n)))

    def shaken_since(self, index: int) -> FloatArray:
        """Return how hard the voltages shook since a sample index: that index and `MotionTrigger.shaking`, (2, n)."""
        _, looks = self._shaken.copy(self._shaken.first, self._shaken.end)
        return np.asarray(looks[:, looks[0] >= index])

    def _index_at(self, column: int) -> int:
        """Return the sample index of a column; a column overwritten meanwhile is older than anything asked for."""
        _, found = self._columns.copy(column, column + 1)
        return int(found[0, 0]) if found.size else -1
