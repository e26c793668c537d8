"""Smoothing that keeps the Doppler and takes the noise away, to find extremes and slopes."""

from __future__ import annotations

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.model.weighed_sums import savitzky_golay

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
