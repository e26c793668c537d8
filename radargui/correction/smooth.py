"""Smoothing that keeps the Doppler and takes the noise away, to find extremes and slopes."""

from __future__ import annotations

import numpy as np
from numpy.polynomial import polynomial
from scipy.signal import oaconvolve, savgol_coeffs, savgol_filter

from radargui.model.arrays import FloatArray

SMOOTHING_S = 0.001
_WIDE = 256


def smooth(
    x: FloatArray, sample_rate_hz: float, *, window_s: float = SMOOTHING_S, order: int = 2, slope: bool = False
) -> FloatArray:
    """Return a least-squares parabola's value (or slope per second) around each sample (Savitzky & Golay 1964).

    Parameters
    ----------
    x
        Shape (..., n_samples).
    sample_rate_hz
        Rate of the samples.
    window_s
        Width of the window; a window of under five samples leaves `x` as it is.
    order
        Order of the polynomial.
    slope
        Give the first derivative per second instead.
    """
    window = min(2 * round(0.5 * window_s * sample_rate_hz) + 1, 2 * ((x.shape[-1] - 1) // 2) + 1)
    # too few samples for a parabola that smooths
    if window < order + 3:
        return np.gradient(x, 1.0 / sample_rate_hz, axis=-1) if slope else x
    return savitzky_golay(x, window, order, derivative=int(slope), spacing=1.0 / sample_rate_hz)


def savitzky_golay(x: FloatArray, window: int, order: int, *, derivative: int = 0, spacing: float = 1.0) -> FloatArray:
    """Return scipy's `savgol_filter` along the last axis; a wide window goes by Fourier transforms.

    Parameters
    ----------
    x
        Shape (..., n_samples).
    window
        Odd number of samples, at most n_samples.
    order
        Order of the polynomial.
    derivative, spacing
        Which derivative to give, and the distance of the samples for it.
    """
    if window < _WIDE or not np.isfinite(x).all():
        return np.asarray(savgol_filter(x, window, order, deriv=derivative, delta=spacing, axis=-1), dtype=np.float64)
    half = window // 2
    weights = savgol_coeffs(window, order, deriv=derivative, delta=spacing)
    middle = oaconvolve(x, weights.reshape((1,) * (x.ndim - 1) + (window,)), mode="valid", axes=-1)
    place = (np.arange(window) - half) / half

    def edge(part: FloatArray, at: slice) -> FloatArray:
        fit = polynomial.polyfit(place, part.reshape(-1, window).T, order)
        fit = polynomial.polyder(fit, derivative, scl=1.0 / (half * spacing))
        return np.asarray(polynomial.polyval(place[at], fit), np.float64).reshape(*part.shape[:-1], half)

    begin, end = edge(x[..., :window], slice(0, half)), edge(x[..., -window:], slice(-half, None))
    return np.asarray(np.concatenate([begin, middle, end], axis=-1), dtype=np.float64)
