"""Onset: the time when the tracer leaves its rest."""

from __future__ import annotations

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from radargui.model.arrays import FloatArray

_BLOCK_S = 0.005
_WINDOW, _AHEAD, _FEWEST = 60, 3, 10
_LONG_ENOUGH = 30
_THRESHOLD = 6.0
_MOST_WANDER = 0.02


def find_onset(time_s: FloatArray, value: FloatArray) -> float | None:
    """Return the time of the last block that still looks like the rest, None where nothing moves.

    Means over 5 ms are compared with what the 0.3 s that end 15 ms before them foretell: a parabola, so that offsets
    may drift (a straight line while the rest is short). The tracer moves where two blocks in turn differ by
    more than 6 standard deviations in the root mean square over the channels. A rest that is looked at as a whole would
    take the slow beginning of a pendulum for drift.

    Parameters
    ----------
    time_s
        Shape (n_samples,).
    value
        Shape (n_channels, n_samples).

    Returns
    -------
    float or None
        -inf where the record starts in motion (less than 50 ms of rest).
    """
    label = ((time_s - time_s[0]) / _BLOCK_S).astype(np.intp)
    first = np.flatnonzero(np.diff(label, prepend=-1))
    count = np.diff(np.append(first, label.size))
    mean = np.add.reduceat(value, first, axis=1) / count
    if first.size < 2 * _FEWEST:
        return float("-inf")
    early = np.diff(value[:, : first[2 * _FEWEST - 1]], axis=1)
    white = np.median(np.abs(early), axis=1) / 0.95 / np.sqrt(count[0]) + 1e-12
    size = np.stack([white, np.maximum(white, _MOST_WANDER * np.median(value.std(axis=1)))])
    if _wanders(mean[:, :_FEWEST], size):
        return float("-inf")
    away = _departures(mean, size) > _THRESHOLD
    lasting = np.flatnonzero(away[:-1] & away[1:])
    return float(time_s[first[_FEWEST + _AHEAD + lasting[0]]]) if lasting.size else None


def _wanders(mean: FloatArray, size: FloatArray) -> bool:
    """Return whether blocks (n_channels, n) differ from a straight line by more than a rest may."""
    apart = mean - mean @ _Foresight(mean.shape[1], 1).smooth
    return bool(np.sqrt(((apart / size[1][:, None]) ** 2).mean(axis=0)).max() > _THRESHOLD)


class _Foresight:
    """A polynomial through n blocks in turn: its values there, and its value some blocks later."""

    def __init__(self, count: int, degree: int) -> None:
        place = (np.arange(count) - count - _AHEAD) / _WINDOW
        powers = np.vander(place, degree + 1, increasing=True)
        solve = np.linalg.solve(powers.T @ powers, powers.T)
        self.smooth = powers @ solve
        self.ahead: FloatArray = solve[0]
        self.freedom = count - degree - 1
        self.widening = float(np.sqrt(1.0 + self.ahead @ self.ahead))

    def departure(self, before: FloatArray, now: FloatArray, size: FloatArray) -> FloatArray:
        """Return how far blocks lie from what was foretold, in deviations, root mean square over the channels.

        Parameters
        ----------
        before
            Shape (n_channels, n_windows, count).
        now
            Shape (n_channels, n_windows).
        size
            Smallest and largest deviation of a block, shape (2, n_channels).
        """
        rest = before - before @ self.smooth
        deviation = np.sqrt((rest**2).sum(axis=2) / self.freedom)
        deviation = np.clip(deviation, size[0][:, None], size[1][:, None]) * self.widening
        return np.asarray(np.sqrt((((now - before @ self.ahead) / deviation) ** 2).mean(axis=0)))


def _departures(mean: FloatArray, size: FloatArray) -> FloatArray:
    """Return the departure of each block from the first that can be foretold on."""
    n = mean.shape[1]
    growing = range(_FEWEST, min(_WINDOW, n - _AHEAD))
    out = [
        _Foresight(count, 2 if count >= _LONG_ENOUGH else 1).departure(
            mean[:, None, :count], mean[:, [count + _AHEAD]], size
        )
        for count in growing
    ]
    if n > _WINDOW + _AHEAD:
        windows = sliding_window_view(mean, _WINDOW, axis=1)[:, : n - _WINDOW - _AHEAD]
        out.append(_Foresight(_WINDOW, 2).departure(windows, mean[:, _WINDOW + _AHEAD :], size))
    return np.concatenate(out)
