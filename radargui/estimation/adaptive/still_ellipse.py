"""Fit a constant ellipse to one receiver's I and Q as a start (Heydemann 1981)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.model.front_end import point_of


@dataclass(frozen=True, slots=True)
class EllipseSettings:
    """Which conics count as an ellipse of a front end; others give way to a circle. Chosen by hand.

    Attributes
    ----------
    least_g2_inverse, most_g2_inverse
        Range of a = 1/g^2: gain ratios from 0.77 to 1.29.
    most_sine
        Largest |sin eps|: 20 degrees.
    least_square
        Least A^2, in squares of the scaled samples, so that a degenerate conic has a size.
    """

    least_g2_inverse: float = 0.6
    most_g2_inverse: float = 1.7
    most_sine: float = 0.35
    least_square: float = 1e-6


ELLIPSES = EllipseSettings()


@dataclass(frozen=True, slots=True)
class StillEllipse:
    """Constants of one receiver, I = A cos(phi) + offset_i, Q = g A sin(phi + eps) + offset_q.

    Attributes
    ----------
    offset_i, offset_q
        Centre.
    log_gain
        ln g.
    quadrature_error_rad
        eps.
    amplitude
        A.
    """

    offset_i: float
    offset_q: float
    log_gain: float
    quadrature_error_rad: float
    amplitude: float

    @property
    def gain_ratio(self) -> float:
        """The gain ratio g."""
        return float(np.exp(self.log_gain))

    def point(self, i: FloatArray, q: FloatArray) -> FloatArray:
        """Return X and Y without offset, gain ratio and quadrature error, shape (2, n)."""
        return point_of(i - self.offset_i, q - self.offset_q, self.gain_ratio, self.quadrature_error_rad)


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
    # I^2 has the coefficient one: no ellipse of a front end lacks it, where f vanishes for one through the origin
    columns = np.stack([q**2, i * q, i, q, ones], axis=1) * root[:, None]
    a, b, d, e, f = np.linalg.lstsq(columns, -(i**2) * root, rcond=None)[0]
    sine = -b / (2.0 * np.sqrt(a)) if a > 0 else np.inf
    # no front end is like this: a short arc has led the conic astray, and a circle has two unknowns fewer
    if not (ELLIPSES.least_g2_inverse < a < ELLIPSES.most_g2_inverse and abs(sine) < ELLIPSES.most_sine):
        d, e, f = np.linalg.lstsq(columns[:, 2:], -(i**2 + q**2) * root, rcond=None)[0]
        a, b, sine = 1.0, 0.0, 0.0
    centre = np.linalg.solve(np.array([[2.0, b], [b, 2.0 * a]]), -np.array([d, e]))
    level = centre @ np.array([[1.0, b / 2.0], [b / 2.0, a]]) @ centre - f
    # with I = A cos(phi) and Q = g A sin(phi + eps) the conic's level about its centre is A^2 cos^2 eps
    amplitude = np.sqrt(max(level, ELLIPSES.least_square)) / np.sqrt(1.0 - sine**2)
    return StillEllipse(
        float(centre[0]), float(centre[1]), float(-0.5 * np.log(a)), float(np.arcsin(sine)), float(amplitude)
    )
