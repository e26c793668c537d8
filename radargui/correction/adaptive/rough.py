"""Rough phases: still ellipses on pooled samples, good enough to count fringes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import uniform_filter1d

from radargui.correction.bins import pool
from radargui.correction.signals import Signals
from radargui.correction.start import StillEllipse, circle_point, fit_still_ellipse
from radargui.model.arrays import BoolArray, FloatArray

_POOL_S = 1e-4
_SMOOTH_S = 1e-3
_SHORT_CHORD, _HALF_AS_WIDE = 1.2, 0.5


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
        ellipses.append(ellipse)
    ellipses = _arcs_completed(smooth, moving, ellipses, signals.scale_v)
    for i, q, ellipse in zip(pooled.value[0::2], pooled.value[1::2], ellipses, strict=True):
        x, y = circle_point(i, q, ellipse)
        phases.append(np.unwrap(np.arctan2(y, x)))
    phase = np.array(phases)
    slope = np.gradient(uniform_filter1d(phase, 2 * width, axis=1, mode="nearest"), pooled.time_s, axis=1)
    turns = np.abs(uniform_filter1d(slope, width, axis=1, mode="nearest")).max(axis=0) / (2.0 * np.pi)
    return RoughPhases(pooled.time_s, phase, turns, tuple(ellipses))


def _arcs_completed(
    smooth: FloatArray, moving: BoolArray, ellipses: list[StillEllipse], scale_v: FloatArray
) -> list[StillEllipse]:
    """Return the ellipses; a receiver that saw less than a fifth of a turn gets a circle as large as the others'.

    A short arc does not tell its circle: the radius is taken from the receivers that saw more, gain ratio one and
    quadrature error zero, and the centre on the side where the offset is smaller.
    """
    chord, middle, along = [], [], []
    for pair in smooth.reshape(-1, 2, smooth.shape[1]):
        mean = pair[:, moving].mean(axis=1)
        apart = pair[:, moving] - mean[:, None]
        _, axes = np.linalg.eigh(apart @ apart.T)
        run = axes[:, 1] @ apart
        chord.append(float(run.max() - run.min()))
        middle.append(mean + axes[:, 1] * 0.5 * (run.max() + run.min()))
        along.append(axes[:, 1])
    size = np.array(chord) * scale_v
    radius_v = 0.5 * float(np.median(size[size > _HALF_AS_WIDE * size.max()]))
    out = list(ellipses)
    for k in np.flatnonzero(size < _SHORT_CHORD * radius_v):
        radius = radius_v / float(scale_v[k])
        across = np.array([-along[k][1], along[k][0]]) * np.sqrt(max(radius**2 - (0.5 * chord[k]) ** 2, 0.0))
        centre = min((middle[k] + across, middle[k] - across), key=lambda c: float(c @ c))
        out[k] = StillEllipse(float(centre[0]), float(centre[1]), 0.0, 0.0, radius)
    return out


def _drop_outliers(i: FloatArray, q: FloatArray, weight: FloatArray, ellipse: StillEllipse) -> StillEllipse:
    """Fit again without points nearer to the centre than a fifth of the amplitude or farther than three."""
    radius = np.hypot(*circle_point(i, q, ellipse)) / ellipse.amplitude
    keep = (radius > 0.2) & (radius < 3.0)
    if keep.mean() < 0.5:
        return ellipse
    return fit_still_ellipse(i[keep], q[keep], weight[keep])
