"""Fit one ellipse to I and Q: offset, gain ratio and quadrature error (Heydemann 1981)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.model.errors import ProcessingError
from radargui.model.front_end import channels_of, point_of


@dataclass(frozen=True, slots=True)
class Ellipse:
    """I = i0 + A cos(phase), Q = q0 + g A sin(phase + eps), in volts or in the scale of the samples that it is of.

    Attributes
    ----------
    i0_v, q0_v
        Centre.
    amplitude_v
        A, amplitude of I.
    gain_ratio
        g, amplitude of Q over amplitude of I.
    quadrature_error_rad
        eps, departure of Q from 90 degrees after I.
    """

    i0_v: float
    q0_v: float
    amplitude_v: float
    gain_ratio: float
    quadrature_error_rad: float

    def apply(self, pair_v: FloatArray) -> FloatArray:
        """Return I and Q on the unit circle: X = (I - i0) / A, Y = ((Q - q0) / (g A) - X sin eps) / cos eps.

        Parameters
        ----------
        pair_v
            Volts, shape (2, n_samples).
        """
        x = (pair_v[0] - self.i0_v) / self.amplitude_v
        y = (pair_v[1] - self.q0_v) / self.amplitude_v
        return point_of(x, y, self.gain_ratio, self.quadrature_error_rad)

    def outline_v(self, count: int) -> FloatArray:
        """Return one turn of it in volts, shape (2, count)."""
        phase = np.linspace(0.0, 2.0 * np.pi, count)
        z = self.amplitude_v * np.exp(1j * phase)
        shown = channels_of(z, z, self.gain_ratio, self.quadrature_error_rad)
        return np.asarray(np.array([[self.i0_v], [self.q0_v]]) + shown)


def fit_ellipse(pair_v: FloatArray) -> Ellipse:
    """Fit the ellipse by direct least squares of the conic (Halir & Flusser 1998).

    Parameters
    ----------
    pair_v
        I and Q in volts, finite, shape (2, n_samples).

    Raises
    ------
    ProcessingError
        The samples lie on no ellipse: too short an arc, or no signal.
    """
    centre = pair_v.mean(axis=1)
    # without it the powers of volts and of millivolts make the scatter matrix singular
    spread = max(float(np.sqrt(((pair_v - centre[:, None]) ** 2).mean())), 1e-300)
    x, y = (pair_v - centre[:, None]) / spread
    a, b, c, d, e, f = _conic(x, y)
    # the centre is where the gradient of the conic vanishes
    determinant = 4.0 * a * c - b * b
    x0, y0 = (b * e - 2.0 * c * d) / determinant, (b * d - 2.0 * a * e) / determinant
    level = a * x0 * x0 + b * x0 * y0 + c * y0 * y0 - f
    # X = cos, Y = g sin(phase + eps): the cross term of their conic is -2 sin(eps) / g
    sine = -b / (2.0 * np.sqrt(a * c))
    amplitude = np.sqrt(level / (a * (1.0 - sine**2)))
    if not np.isfinite(amplitude) or amplitude <= 0.0:
        raise no_ellipse()
    i0_v, q0_v = float(x0 * spread + centre[0]), float(y0 * spread + centre[1])
    return Ellipse(i0_v, q0_v, float(amplitude * spread), float(np.sqrt(a / c)), float(np.arcsin(sine)))


def circle_through(pair_v: FloatArray, weight: FloatArray | None = None) -> Ellipse:
    """Fit a circle by least squares, linear in its centre: short arcs that lead a conic astray have one too.

    Parameters
    ----------
    pair_v
        I and Q, finite, shape (2, n_samples).
    weight
        Of each sample, shape (n_samples,); None: all alike.
    """
    mean_v = pair_v.mean(axis=1, keepdims=True)
    weight = np.ones(pair_v.shape[1]) if weight is None else weight
    columns = np.stack([*(2.0 * (pair_v - mean_v)), np.ones_like(weight)], axis=1)
    square = ((pair_v - mean_v) ** 2).sum(axis=0)
    root = np.sqrt(weight)
    (i0_v, q0_v, level), *_ = np.linalg.lstsq(columns * root[:, None], square * root, rcond=None)
    # the weighted mean of the squared distances from the centre
    amplitude_v = max(float(np.sqrt(max(level + i0_v**2 + q0_v**2, 0.0))), 1e-300)
    return Ellipse(float(i0_v + mean_v[0, 0]), float(q0_v + mean_v[1, 0]), amplitude_v, 1.0, 0.0)


def _conic(x: FloatArray, y: FloatArray) -> FloatArray:
    """Return a..f of a x^2 + b xy + c y^2 + d x + e y + f = 0 with 4ac - b^2 = 1, a > 0."""
    quadratic = np.stack([x * x, x * y, y * y], axis=1)
    linear = np.stack([x, y, np.ones_like(x)], axis=1)
    s1, s2, s3 = quadratic.T @ quadratic, quadratic.T @ linear, linear.T @ linear
    try:
        t = -np.linalg.solve(s3, s2.T)
        reduced = s1 + s2 @ t
        constrained = np.stack([reduced[2] / 2.0, -reduced[1], reduced[0] / 2.0])
        vectors = np.real(np.linalg.eig(constrained)[1])
    except np.linalg.LinAlgError:
        raise no_ellipse() from None
    # one of the three is an ellipse (Halir & Flusser 1998); noise may leave it the smallest by a hair
    form = 4.0 * vectors[0] * vectors[2] - vectors[1] ** 2
    if not (form > 0).any():
        raise no_ellipse()
    best = vectors[:, int(np.argmax(form))]
    return np.asarray(np.concatenate([best, t @ best]) * np.sign(best[0]))


def no_ellipse() -> ProcessingError:
    """Return the error of samples that lie on none."""
    return ProcessingError(
        "I and Q lie on no ellipse",
        reasons=["the tracer moves less than half a fringe", "the signal is too weak"],
        remedy="Use a longer drop or a stronger signal.",
    )
