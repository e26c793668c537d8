"""How e and g follow a motion that is shifted a little, as by antennas that stand elsewhere than the setup says."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse.linalg import splu

from radargui.model.arrays import FloatArray
from radargui.restitution.flight_fit import FlightFit

_LEAST_SMOOTH = 1e-14


@dataclass(frozen=True, slots=True)
class FlightShift:
    """First-order response of the fitted flights to a shift of the motion they were fitted to.

    The flights minimise (x(q) - x0)^T Lambda (x(q) - x0) / 2, so that with J = dx/dq, N = J^T Lambda J + prior a shift
    d of x0 moves them by dq = N^-1 J^T Lambda d: gravity, drag and impacts share it as they share the samples.

    Attributes
    ----------
    fit
        The flights.
    normal
        Away from the floor, shape (3,).
    """

    fit: FlightFit
    normal: FloatArray

    def __call__(self, time_s: FloatArray, moved_m: FloatArray) -> tuple[float, float]:
        """Return the changes of the first e and of g; NaN where unknown, as e without an impact.

        Parameters
        ----------
        time_s, moved_m
            Shift of the position at some times, shapes (n,) and (3, n); NaN where unknown.
        """
        shift = self._coefficients(time_s, moved_m)
        if shift is None:
            return float("nan"), float("nan")
        change = self.fit.response @ shift.ravel()
        if self.fit.impact_s.size == 0:
            return float("nan"), float(change[0])
        before, after = float(self.fit.before_m_s[0] @ self.normal), float(self.fit.after_m_s[0] @ self.normal)
        d_before, d_after = float(change[3:6] @ self.normal), float(change[6:9] @ self.normal)
        return -d_after / before + after * d_before / before**2, float(change[0])

    def _coefficients(self, time_s: FloatArray, moved_m: FloatArray) -> FloatArray | None:
        """Return the shift of the kept coefficients against the start, shape (size, 3); None where it is not known."""
        spline, size = self.fit.spline, self.fit.response.shape[1] // 3
        last = float(spline.knots()[size + 1])
        known = np.isfinite(moved_m).all(axis=0) & (time_s >= spline.edge_s[0]) & (time_s <= last)
        if known.sum() < size:
            return None
        design = spline.design(time_s[known])[:, :size]
        jerk, _, _ = spline.jerk()
        jerk = jerk[:, :size]
        normal = (design.T @ design + _LEAST_SMOOTH * (jerk.T @ jerk)).tocsc()
        moved = moved_m[:, known] - moved_m[:, known][:, :1]
        return np.asarray(splu(normal).solve(np.ascontiguousarray(design.T @ moved.T)))
