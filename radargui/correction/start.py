"""The start: an ellipse that stands still, fitted to one receiver's I and Q."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from radargui.model.arrays import FloatArray


@dataclass(frozen=True, slots=True)
class StillEllipse:
    """Hardware constants of one receiver, I = A cos(phi) + offset_i, Q = g A sin(phi + eps) + offset_q.

    Attributes
    ----------
    offset_i, offset_q
        Centre.
    log_gain
        ln g.
    skew_rad
        Quadrature error eps.
    amplitude
        A.
    """

    offset_i: float
    offset_q: float
    log_gain: float
    skew_rad: float
    amplitude: float


def fit_still_ellipse(i: FloatArray, q: FloatArray, weight: FloatArray) -> StillEllipse:
    """Fit I^2 + a Q^2 + b I Q + d I + e Q + f = 0 by weighted least squares; a circle where that fails.

    From the conic: g = a^-1/2, sin eps = -b g / 2, then the centre is where the gradient vanishes.

    Parameters
    ----------
    i, q
        Shape (n,), about one amplitude.
    weight
        Shape (n,), proportional to the arc that each point stands for.
    """
    root = np.sqrt(weight / weight.mean())
    ones = np.ones_like(i)
    columns = np.stack([q**2, i * q, i, q, ones], axis=1) * root[:, None]
    a, b, d, e, f = np.linalg.lstsq(columns, -(i**2) * root, rcond=None)[0]
    sine = -b / (2.0 * np.sqrt(a)) if a > 0 else np.inf
    if not (0.6 < a < 1.7 and abs(sine) < 0.35):
        d, e, f = np.linalg.lstsq(columns[:, 2:], -(i**2 + q**2) * root, rcond=None)[0]
        a, b, sine = 1.0, 0.0, 0.0
    centre = np.linalg.solve(np.array([[2.0, b], [b, 2.0 * a]]), -np.array([d, e]))
    level = centre @ np.array([[1.0, b / 2.0], [b / 2.0, a]]) @ centre - f
    amplitude = np.sqrt(max(level, 1e-6)) / np.sqrt(max(1.0 - sine**2, 0.1))
    return StillEllipse(
        float(centre[0]), float(centre[1]), float(-0.5 * np.log(a)), float(np.arcsin(sine)), float(amplitude)
    )


def circle_point(i: FloatArray, q: FloatArray, ellipse: StillEllipse) -> FloatArray:
    """Return X and Y without offset, gain ratio and quadrature error, shape (2, n)."""
    x = i - ellipse.offset_i
    y = (q - ellipse.offset_q) * np.exp(-ellipse.log_gain)
    return np.stack([x, (y - x * np.sin(ellipse.skew_rad)) / np.cos(ellipse.skew_rad)])
