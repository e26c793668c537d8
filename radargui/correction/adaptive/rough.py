"""Rough phases: still ellipses on pooled samples, good enough to count fringes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import uniform_filter1d

from radargui.correction.bins import pool
from radargui.correction.signals import Signals
from radargui.correction.start import StillEllipse, circle_point, fit_still_ellipse
from radargui.model.arrays import FloatArray

_POOL_S = 1e-4
_SMOOTH_S = 1e-3


@dataclass(frozen=True, slots=True)
class RoughPhases:
    """Phases by still ellipses.

    Attributes
    ----------
    time_s
        Shape (n,).
    phase_rad
        Unwrapped, shape (n_receivers, n).
    turns_hz
        Fringes per second of the fastest receiver, smoothed, shape (n,).
    ellipses
        One a receiver.
    """

    time_s: FloatArray
    phase_rad: FloatArray
    turns_hz: FloatArray
    ellipses: tuple[StillEllipse, ...]


def rough_phases(signals: Signals, onset_s: float) -> RoughPhases:
    """Fit a still ellipse to each receiver's moving part and unwrap its phase."""
    pooled = pool(signals, _POOL_S)
    spacing = float(np.median(np.diff(pooled.time_s)))
    width = max(1, round(_SMOOTH_S / spacing))
    smooth = uniform_filter1d(pooled.value, width, axis=1, mode="nearest")
    moving = pooled.time_s >= onset_s
    phases, ellipses = [], []
    for i, q, smooth_i, smooth_q in zip(
        pooled.value[0::2], pooled.value[1::2], smooth[0::2], smooth[1::2], strict=True
    ):
        arc = np.hypot(np.gradient(smooth_i), np.gradient(smooth_q))
        noise = float(np.median(arc[~moving])) if (~moving).sum() > 10 else 0.0
        arc = np.sqrt(np.maximum(arc**2 - noise**2, 0.05 * noise**2 + 1e-12))
        weight = np.minimum(arc, np.quantile(arc[moving], 0.9))[moving]
        ellipse = fit_still_ellipse(i[moving], q[moving], weight)
        for _ in range(2):
            ellipse = _drop_outliers(i[moving], q[moving], weight, ellipse)
        x, y = circle_point(i, q, ellipse)
        phases.append(np.unwrap(np.arctan2(y, x)))
        ellipses.append(ellipse)
    phase = np.array(phases)
    slope = np.gradient(uniform_filter1d(phase, 2 * width, axis=1, mode="nearest"), pooled.time_s, axis=1)
    turns = np.abs(uniform_filter1d(slope, width, axis=1, mode="nearest")).max(axis=0) / (2.0 * np.pi)
    return RoughPhases(pooled.time_s, phase, turns, tuple(ellipses))


def _drop_outliers(i: FloatArray, q: FloatArray, weight: FloatArray, ellipse: StillEllipse) -> StillEllipse:
    """Fit again without points nearer to the centre than a fifth of the amplitude or farther than three."""
    radius = np.hypot(*circle_point(i, q, ellipse)) / ellipse.amplitude
    keep = (radius > 0.2) & (radius < 3.0)
    if keep.mean() < 0.5:
        return ellipse
    return fit_still_ellipse(i[keep], q[keep], weight[keep])
