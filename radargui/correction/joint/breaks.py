"""Breaks of the motion: velocities on both sides, new ones where the motion turns sharply, weak ones dropped."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix, kron
from scipy.sparse.linalg import splu

from radargui.correction.joint.minimise import Solution
from radargui.correction.joint.motion_spline import MotionSpline, make_spline
from radargui.model.arrays import BoolArray, FloatArray

_SHARP_JERK_M_S3 = 30.0
_APART_S = 0.008
_GRID_S = 0.001
_LEAST_JUMP_M_S, _SIGNIFICANT = 0.12, 7.0
_LEAST_SPEED_M_S = 0.04
_LEAST_DIP_M = 1e-4
_GRAVITY_M_S2 = 9.81
_LEAST_FLIGHT_S, _MOST_BOUNCES, _SAME_SHARE = 0.010, 12, 1.15
_MOST_THROWN, _DOUBT_M_S, _MOST_ELSE_M_S2 = 2.0, 0.5, 30.0


@dataclass(frozen=True, slots=True)
class BreakSpeeds:
    """Velocities along the floor's normal at the breaks.

    Attributes
    ----------
    time_s
        Shape (n_breaks,).
    before_m_s, after_m_s, u_jump_m_s
        Same shape; up is positive.
    """

    time_s: FloatArray
    before_m_s: FloatArray
    after_m_s: FloatArray
    u_jump_m_s: FloatArray

    def are_impacts(self) -> BoolArray:
        """Return where the tracer comes down, goes up, and jumps by more than max(0.12 m/s, 7 u)."""
        jump = self.after_m_s - self.before_m_s
        enough = jump > np.maximum(_LEAST_JUMP_M_S, _SIGNIFICANT * self.u_jump_m_s)
        turns = (self.before_m_s < -_LEAST_SPEED_M_S) & (self.after_m_s > _LEAST_SPEED_M_S)
        return np.asarray(enough & turns & self.are_possible())

    def are_kinks(self) -> BoolArray:
        """Return where the velocity jumps up at all.

        A weak break costs nothing; one taken away again bends the motion around it when a bounce was there.
        """
        return np.asarray((self.after_m_s > self.before_m_s) & self.are_possible())

    def are_possible(self) -> BoolArray:
        """Return where a body could do so: not thrown up with twice the speed, not flung down from the break before.

        Between two breaks closer than the bins the spline is held by nothing.
        """
        thrown = self.after_m_s > _MOST_THROWN * np.maximum(-self.before_m_s, 0.0) + _DOUBT_M_S
        flight = np.diff(self.time_s)
        changed = np.abs(self.before_m_s[1:] - self.after_m_s[:-1] + _GRAVITY_M_S2 * flight)
        held = np.concatenate([[True], changed < _DOUBT_M_S + _MOST_ELSE_M_S2 * flight])[: self.time_s.size]
        return np.asarray(~thrown & held)

    def expected_impacts(self, end_s: float) -> FloatArray:
        """Return when a body that bounces on lands after the last impact, while its flights take 10 ms or more.

        A flight that starts upward with v lasts 2 v / g; every impact takes away the same share of the speed.
        """
        impacts = self.are_impacts()
        if not impacts.any():
            return np.zeros(0)
        shares = -self.after_m_s[impacts] / self.before_m_s[impacts]
        share, moment = float(np.median(shares)), float(self.time_s[impacts][-1])
        # the last one may have been drawn away by a bounce that is still missing
        speed = min(float(shares[-1]), _SAME_SHARE * share) * -float(self.before_m_s[impacts][-1])
        out: list[float] = []
        while len(out) < _MOST_BOUNCES:
            moment += 2.0 * speed / _GRAVITY_M_S2
            if 2.0 * speed / _GRAVITY_M_S2 < _LEAST_FLIGHT_S or moment > end_s - _LEAST_FLIGHT_S:
                break
            out.append(moment)
            speed *= min(share, 1.0)
        return np.array(out)


def break_speeds(solution: Solution, normal: FloatArray) -> BreakSpeeds:
    """Return the velocities on both sides of each break with the uncertainty of their difference."""
    spline = solution.at.spline
    moments = spline.break_s
    if moments.size == 0:
        return BreakSpeeds(moments, moments, moments, moments)
    before, after = one_sided_slopes(spline)
    rows = csr_matrix(kron(after - before, normal[None], format="csr"))
    along = solution.state.coefficients @ normal
    u = np.sqrt(solution.normal.row_variances([rows])[0])
    return BreakSpeeds(moments, before @ along, after @ along, u)


def side_covariance(solution: Solution, normal: FloatArray) -> FloatArray:
    """Return the covariance of the velocities (before, after) along the normal at each break, (n_breaks, 2, 2)."""
    spline = solution.at.spline
    if spline.break_s.size == 0:
        return np.zeros((0, 2, 2))
    before, after = one_sided_slopes(spline)
    rows = [csr_matrix(kron(part, normal[None], format="csr")) for part in (before, after, before + after)]
    own, other, both = solution.normal.row_variances(rows)
    cross = 0.5 * (both - own - other)
    return np.stack([np.stack([own, cross], axis=1), np.stack([cross, other], axis=1)], axis=1)


def one_sided_slopes(spline: MotionSpline) -> tuple[csr_matrix, csr_matrix]:
    """Return the matrices of the velocity just before and just after each break, shapes (n_breaks, size).

    A cubic's slope at the end of four even points: (-11 f0 + 18 f1 - 9 f2 + 2 f3) / (6 h).
    """
    edge, out = spline.edge_s, []
    last = np.array([1.0 - share[-2] for share in spline.fractions[:-1]]) * np.diff(edge)[:-1]
    first = np.array([share[1] for share in spline.fractions[1:]]) * np.diff(edge)[1:]
    for h in (-last / 3.0, first / 3.0):
        four = spline.design((edge[1:-1, None] + h[:, None] * np.arange(4)).ravel())
        weight = np.array([-11.0, 18.0, -9.0, 2.0]) / (6.0 * h[:, None])
        rows = csr_matrix((weight.ravel(), np.arange(weight.size), 4 * np.arange(h.size + 1)))
        out.append(csr_matrix(rows @ four))
    return out[0], out[1]


def sharp_turns(solution: Solution, normal: FloatArray) -> FloatArray:
    """Return times where the motion turns from down to up by 0.1 mm in 8 ms, at high jerk, away from breaks."""
    spline = solution.at.spline
    grid = np.arange(spline.edge_s[0] + _APART_S, spline.edge_s[-1] - _APART_S, _GRID_S)
    height = spline.offset(grid, solution.state.coefficients @ normal)
    turn = np.flatnonzero((height[1:-1] < height[:-2]) & (height[1:-1] <= height[2:])) + 1
    reach = round(_APART_S / _GRID_S)
    left, right = height[np.maximum(turn - reach, 0)], height[np.minimum(turn + reach, height.size - 1)]
    turn = turn[np.minimum(left, right) - height[turn] > _LEAST_DIP_M]
    _, middle, _ = spline.jerk()
    jerk = solution.problem.jerk_sd[np.searchsorted(middle, grid[turn]).clip(0, middle.size - 1)]
    near = np.abs(grid[turn][:, None] - spline.edge_s[None]).min(axis=1) < _APART_S
    return np.asarray(grid[turn][(jerk > _SHARP_JERK_M_S3) & ~near])


def misfit_times(solution: Solution) -> FloatArray:
    """Return the middles of 10 ms windows whose residuals are far above the typical: the motion is too stiff there."""
    problem = solution.problem
    label = np.floor((problem.bins.time_s - problem.spline.edge_s[0]) / 0.010).astype(np.intp)
    square = np.where(problem.use, solution.at.residual**2, 1.0).mean(axis=0)
    label -= label[0]
    count = np.bincount(label)
    mean = np.bincount(label, weights=square) / np.maximum(count, 1)
    typical = max(1.0, float(np.median(mean[count > 0])))
    doubt = 4.0 * np.sqrt(2.0 / np.maximum(count * solution.at.residual.shape[0], 1))
    bad = (count > 0) & (mean > typical * (1.5 + doubt))
    middle = np.bincount(label, weights=problem.bins.time_s) / np.maximum(count, 1)
    return np.asarray(middle[bad & (middle > problem.spline.edge_s[0])])


def respline(
    old: MotionSpline, coefficients: FloatArray, break_s: FloatArray, sharp_s: FloatArray
) -> tuple[MotionSpline, FloatArray]:
    """Return a spline with other breaks that follows the old motion, finer near `sharp_s`, and its coefficients."""
    new = make_spline(float(old.edge_s[0]), float(old.edge_s[-1]), break_s, sharp_s)
    count = 8 * (sum(new.spans) + 4)
    grid = np.sort(np.concatenate([np.linspace(old.edge_s[0], old.edge_s[-1], count), new.edge_s]))
    design = new.design(grid)
    jerk, _, _ = new.jerk()
    normal = (design.T @ design + 1e-14 * (jerk.T @ jerk)).tocsc()
    return new, np.asarray(splu(normal).solve(design.T @ old.offset(grid, coefficients)))
