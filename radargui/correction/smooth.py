"""Smoothing that keeps the Doppler and takes the noise away, to find extremes and slopes."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.polynomial import legendre

from radargui.model.arrays import FloatArray
from radargui.model.weighed_sums import weighed_sums

SMOOTHING_S = 0.001


def smooth(x: FloatArray, sample_rate_hz: float, *, window_s: float = SMOOTHING_S, slope: bool = False) -> FloatArray:
    """Return a least-squares parabola's value (or slope per second) around each sample (Savitzky & Golay 1964).

    Parameters
    ----------
    x
        Shape (..., n_samples).
    sample_rate_hz
        Rate of the samples.
    window_s
        Width of the window; a window of under five samples leaves `x` as it is.
    slope
        Give the first derivative per second instead.
    """
    window = min(2 * round(0.5 * window_s * sample_rate_hz) + 1, 2 * ((x.shape[-1] - 1) // 2) + 1)
    # too few samples for a parabola that smooths
    if window < 5:
        return np.gradient(x, 1.0 / sample_rate_hz, axis=-1) if slope else x
    return savitzky_golay(x, window, derivative=int(slope), spacing=1.0 / sample_rate_hz)


def savitzky_golay(x: FloatArray, window: int, *, derivative: int = 0, spacing: float = 1.0) -> FloatArray:
    """Return a least-squares parabola around each sample along the last axis (Savitzky & Golay 1964).

    At the ends that of the first or the last window.

    Parameters
    ----------
    x
        Shape (..., n_samples).
    window
        Odd number of samples, at most n_samples.
    derivative, spacing
        Which derivative to give, and the distance of the samples for it.
    """
    half, unit = window // 2, spacing**derivative
    fit, values = _parabolas(window, derivative)
    weights = np.asarray(values[half] @ fit) / unit
    rows = [weighed_sums(row, weights) for row in x.reshape(-1, x.shape[-1])]
    middle = np.stack(rows).reshape(*x.shape[:-1], -1)
    begin, end = x[..., :window] @ fit.T @ values[:half].T, x[..., -window:] @ fit.T @ values[half + 1 :].T
    return np.asarray(np.concatenate([begin / unit, middle, end / unit], axis=-1), dtype=np.float64)


@lru_cache(maxsize=8)
def _parabolas(window: int, derivative: int) -> tuple[FloatArray, FloatArray]:
    """Return what fits a parabola to a window's samples, (3, window), and its derivative at each of them."""
    half = max(window // 2, 1)
    place = np.arange(-half, half + 1) / half
    # Legendre's: powers of the place would be nearly alike
    columns = legendre.legvander(place, 2)
    slopes = [legendre.legder(unit, derivative) for unit in np.eye(3)]
    values = np.stack([legendre.legval(place, slope) for slope in slopes], axis=1) / half**derivative
    return np.asarray(np.linalg.pinv(columns), dtype=np.float64), np.asarray(values, dtype=np.float64)
