"""A circle that follows the signal: live correction of one receiver with a memory of about 1.5 fringes."""

from __future__ import annotations

import numpy as np

from radargui.correction.ellipse import Ellipse, fit_ellipse
from radargui.model.arrays import FloatArray
from radargui.model.errors import ProcessingError

START_FRINGES = 1.5
MEMORY_FRINGES = 1.5
LEAST_ARC_RAD = 2.0 * np.pi * START_FRINGES


class CircleFollower:
    """Causal correction: an ellipse through the first 1.5 fringes, then a circle refitted with slow forgetting.

    The ellipse gives the constants of the hardware (gain ratio, quadrature error); centre and radius then follow the
    tracer by recursive least squares of x^2 + y^2 = 2 a x + 2 b y + c, weighted by the phase passed, so that a slow
    stretch does not outweigh a fast one.
    """

    def __init__(self) -> None:
        self._ellipse: Ellipse | None = None
        self._normal = np.zeros((3, 3))
        self._right = np.zeros(3)
        self._centre = np.zeros(2)
        self._radius = 1.0

    @property
    def started(self) -> bool:
        """Whether the first 1.5 fringes have been seen."""
        return self._ellipse is not None

    def start(self, pair_v: FloatArray) -> bool:
        """Try to find the ellipse in the motion so far, volts of shape (2, n_samples); True once it is found."""
        if pair_v.shape[1] < 12:
            return False
        try:
            ellipse = fit_ellipse(pair_v)
        except ProcessingError:
            return False
        x, y = ellipse.apply(pair_v)
        phase = np.unwrap(np.arctan2(y, x))
        if not np.ptp(phase) >= LEAST_ARC_RAD or float(np.std(np.hypot(x, y))) > 0.25:
            return False
        self._ellipse = ellipse
        self._learn(x, y, phase)
        return True

    def follow(self, pair_v: FloatArray) -> FloatArray:
        """Return corrected I and Q of the next samples, shape (2, n_samples), and learn from them."""
        if self._ellipse is None:
            return np.full(pair_v.shape, np.nan)
        x, y = self._ellipse.apply(pair_v)
        corrected = self._corrected(x, y)
        self._learn(x, y, np.unwrap(np.arctan2(corrected[1], corrected[0])))
        return corrected

    def correct(self, pair_v: FloatArray) -> FloatArray:
        """Return corrected I and Q, shape (2, n_samples), without learning."""
        if self._ellipse is None:
            return np.full(pair_v.shape, np.nan)
        return self._corrected(*self._ellipse.apply(pair_v))

    def _corrected(self, x: FloatArray, y: FloatArray) -> FloatArray:
        return np.stack([x - self._centre[0], y - self._centre[1]]) / self._radius

    def _learn(self, x: FloatArray, y: FloatArray, phase_rad: FloatArray) -> None:
        step = np.abs(np.gradient(phase_rad)) if phase_rad.size > 1 else np.zeros_like(phase_rad)
        passed = np.cumsum(step[::-1])[::-1] - step
        fade = 1.0 / (2.0 * np.pi * MEMORY_FRINGES)
        weight = step * np.exp(-passed * fade)
        keep = np.exp(-float(step.sum()) * fade)
        rows = np.stack([2.0 * x, 2.0 * y, np.ones_like(x)])
        self._normal = keep * self._normal + (rows * weight) @ rows.T
        self._right = keep * self._right + (rows * weight) @ (x * x + y * y)
        scale = float(np.trace(self._normal))
        if scale <= 0.0 or np.linalg.cond(self._normal) > 1e4:
            return
        a, b, c = np.linalg.solve(self._normal, self._right)
        radius = np.sqrt(max(c + a * a + b * b, 1e-6))
        if np.hypot(a, b) < 1.5 and 0.2 < radius < 5.0:
            self._centre, self._radius = np.array([a, b]), float(radius)
