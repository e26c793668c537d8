"""The hum of the mains: learned from the rest before a motion, taken away from the motion while it happens."""

from __future__ import annotations

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.motion.mains import MAINS_HZ, harmonics

HARMONICS = 3
LEAST_REST_S = 0.2
FREQUENCY_SD_HZ = 0.05
"""How far the mains are from their nominal frequency."""
_SEARCH_HZ = np.linspace(-0.15, 0.15, 7)
_LEAST_RATE = 2.5
"""Samples in a period of the highest harmonic."""
_SIGNIFICANT = 4.0
"""An amplitude below so many of its standard deviations is taken for noise."""


class Hum:
    """Sines at the mains frequency and its harmonics, one amplitude and phase a channel; nothing before `learn`."""

    def __init__(self) -> None:
        self._frequency_hz = 0.0
        self._weights: FloatArray | None = None

    @property
    def frequency_hz(self) -> float | None:
        """Frequency found; None where there is no hum."""
        return None if self._weights is None else self._frequency_hz

    def learn(self, means_v: FloatArray, time_s: FloatArray) -> None:
        """Learn from a rest.

        The frequency is the one near 50 or 60 Hz that leaves least, its distance from nominal paid for as if it were
        drawn with a standard deviation of 0.05 Hz; then amplitudes and phases are linear least squares.

        Parameters
        ----------
        means_v
            Finite volts, shape (n_channels, n).
        time_s
            Shape (n,), on the time axis that `at` will be asked on.
        """
        self._weights = None
        n = time_s.size
        if n < 8 or time_s[-1] - time_s[0] < LEAST_REST_S:
            return
        if (n - 1) / (time_s[-1] - time_s[0]) < _LEAST_RATE * HARMONICS * max(MAINS_HZ):
            return
        centred = means_v - means_v.mean(axis=1, keepdims=True)
        noise = np.maximum(np.diff(centred, axis=1).std(axis=1) / np.sqrt(2.0), 1e-12)
        scaled = centred / noise[:, None]
        best = (np.inf, 0.0)
        for nominal in MAINS_HZ:
            for away in _SEARCH_HZ:
                rows = _rows(time_s, nominal + away, 1)
                explained = _explained(rows, scaled)
                best = min(best, (float((away / FREQUENCY_SD_HZ) ** 2 - explained), nominal + float(away)))
        rows = _rows(time_s, best[1], HARMONICS)
        weights = np.linalg.lstsq(rows.T, centred.T, rcond=None)[0][: 2 * HARMONICS]
        left = centred - weights.T @ rows[: 2 * HARMONICS]
        sd = np.maximum(left.std(axis=1), 1e-12) * np.sqrt(2.0 / n)
        size = np.hypot(weights[0::2], weights[1::2])
        weights[np.repeat(size < _SIGNIFICANT * sd, 2, axis=0)] = 0.0
        if weights.any():
            self._frequency_hz, self._weights = best[1], weights

    def at(self, time_s: FloatArray) -> FloatArray | float:
        """Return the hum in volts, shape (n_channels, n); 0.0 where there is none."""
        if self._weights is None:
            return 0.0
        return np.asarray(self._weights.T @ harmonics(time_s, self._frequency_hz, range(1, HARMONICS + 1)))


def _rows(time_s: FloatArray, frequency_hz: float, highest: int) -> FloatArray:
    line = np.stack([np.ones_like(time_s), time_s - time_s.mean()])
    return np.concatenate([harmonics(time_s, frequency_hz, range(1, highest + 1)), line])


def _explained(rows: FloatArray, values: FloatArray) -> float:
    """Return the sum of squares that the rows explain, all channels together."""
    products = rows @ values.T
    return float((products * np.linalg.solve(rows @ rows.T, products)).sum())
