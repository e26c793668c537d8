"""Find where the motion needs further breaks or finer knots: sharp turns and intervals of large misfit."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import maximum_filter1d

from radargui.estimation.forward.motion_spline import MotionSpline, SplineMotion, make_spline
from radargui.estimation.solve.changed_problem import span_jerk_sd
from radargui.estimation.solve.minimise import Solution
from radargui.estimation.solve.normal import solve_band
from radargui.model.arrays import FloatArray, IntArray


@dataclass(frozen=True, slots=True)
class BreakSettings:
    """Where further breaks are sought. Chosen by hand where nothing else is said.

    Attributes
    ----------
    sharp_jerk_m_s3
        The motion turns sharply where the deviation of the jerk exceeds this: a fall has less than 1, a pendulum less
        than 10.
    apart_s, min_dip_m
        A sharp turn is at least `apart_s` from every break, and within that time at least `min_dip_m` deep, as of a
        body thrown up at 0.05 m/s.
    kick_m_s, kick_side_s
        A wall beside the fall throws the body back: within `kick_side_s` its velocity along the floor changes by
        `kick_m_s` more than before and after. Mirrors that are not found yet make waves of up to 0.1 m/s.
    beside_s, line_s, clear_s
        A wall met within `beside_s` of an impact is sought by straight lines along the floor of length `line_s` on both
        sides of it: one begins at `beside_s`, the other at `clear_s`.
    min_beside_s
        Least time to an impact: nearer to it lines do not determine the instant.
    grid_s
        Step of the grid on which turns are sought.
    window_s, misfit_share, misfit_sigmas
        Windows whose mean squared residual is so many times the typical one, plus so many of its deviations, get finer
        knots.
    smoothing
        Weight of the jerk when a spline is carried to other knots, s^6: fills what no grid point sees.
    """

    sharp_jerk_m_s3: float = 30.0
    apart_s: float = 0.008
    min_dip_m: float = 1e-4
    kick_m_s: float = 0.15
    kick_side_s: float = 0.008
    beside_s: float = 0.022
    line_s: float = 0.016
    clear_s: float = 0.002
    min_beside_s: float = 0.002
    grid_s: float = 0.001
    window_s: float = 0.010
    misfit_share: float = 1.5
    misfit_sigmas: float = 4.0
    smoothing: float = 1e-14


BREAKS = BreakSettings()


def sharp_turns(solution: Solution, normal: FloatArray, settings: BreakSettings = BREAKS) -> FloatArray:
    """Return times (n,) where the motion turns from down to up by 0.1 mm in 8 ms, at high jerk, away from breaks.

    Parameters
    ----------
    solution
        Converged.
    normal
        Upward normal of the floor, shape (3,).
    settings
        What is sharp.
    """
    spline = solution.at.spline
    # 1 ms: the fastest bounce worth finding lasts ten
    grid = np.arange(spline.edge_s[0] + settings.apart_s, spline.edge_s[-1] - settings.apart_s, settings.grid_s)
    height = spline.offset(grid, solution.state.coefficients @ normal)
    # a bounce that has no break yet: the spline turns as sharply as its jerk lets it
    turn = np.flatnonzero((height[1:-1] < height[:-2]) & (height[1:-1] <= height[2:])) + 1
    reach = round(settings.apart_s / settings.grid_s)
    # a ripple of the mismatch is a minimum too, but none of 0.1 mm on both sides
    left, right = height[np.maximum(turn - reach, 0)], height[np.minimum(turn + reach, height.size - 1)]
    turn = turn[np.minimum(left, right) - height[turn] > settings.min_dip_m]
    middle = spline.span_middles()
    jerk = span_jerk_sd(solution.problem, spline)[np.searchsorted(middle, grid[turn]).clip(0, middle.size - 1)]
    near = np.abs(grid[turn][:, None] - spline.edge_s[None]).min(axis=1) < settings.apart_s
    return np.asarray(grid[turn][(jerk > settings.sharp_jerk_m_s3) & ~near])


def side_kicks(solution: Solution, normal: FloatArray, settings: BreakSettings = BREAKS) -> FloatArray:
    """Return times (n,), away from breaks, where the velocity along the floor jumps: there the body met a wall.

    With the mean velocities v1 to v4 over four windows, two on either side, the jump is v3 - v2 less the change that
    goes on before and after; an even acceleration, as on a circle, gives none. Parameters as for `sharp_turns`.
    """
    spline, width = solution.at.spline, round(settings.kick_side_s / settings.grid_s)
    grid = np.arange(spline.edge_s[0], spline.edge_s[-1], settings.grid_s)
    # two windows and half of one between them on either side
    reach = 2 * width + width // 2
    if grid.size <= 2 * reach:
        return np.zeros(0)
    place = spline.offset(grid, solution.state.coefficients)
    aside = place - np.outer(place @ normal, normal)
    speed = (aside[width:] - aside[:-width]) / settings.kick_side_s
    begins = [-reach, -reach + width, width // 2, width // 2 + width]
    middle = np.arange(reach, grid.size - reach)
    v1, v2, v3, v4 = (speed[middle + begin] for begin in begins)
    kick = np.linalg.norm(2.0 * (v3 - v2) - (v4 - v1), axis=1)
    # a jump shows from both sides of it, too, by half: the largest of its neighbourhood is the place
    largest = maximum_filter1d(kick, 2 * reach + 1)
    found = grid[middle[(kick == largest) & (kick > settings.kick_m_s)]]
    # an impact may kick, too: no window reaches over one
    near = np.abs(found[:, None] - spline.edge_s[None]).min(axis=1) < reach * settings.grid_s
    # what pushes at the release is no wall: a break there would end the first flight before it begins
    near |= found < solution.problem.released_s
    return np.asarray(found[~near])


def kicks_beside(
    motion: SplineMotion, normal: FloatArray, gravity_m_s2: float, settings: BreakSettings = BREAKS
) -> tuple[FloatArray, IntArray]:
    """Return times beside breaks, too near for `side_kicks`, where a wall was met, and the numbers of these breaks.

    An impact changes the velocity at once: the lines along the floor before and after it meet there. Where they miss
    each other by x = x_after - x_before along the velocity's jump v, they meet later by -x v / v^2.
    """
    spline, wide = motion.spline, settings.line_s
    line = np.linspace(0.0, wide, round(wide / settings.grid_s) + 1)
    found: list[tuple[float, int]] = []
    for number, (before, at, after) in enumerate(
        zip(spline.edge_s[:-2], spline.break_s, spline.edge_s[2:], strict=True)
    ):
        for sign in (-1.0, 1.0):
            # on the wall's side from behind it on, on the other from the impact on
            back, on = (settings.clear_s, settings.beside_s)[:: int(sign)]
            if at - before < back + wide or after - at < on + wide:
                continue
            away = np.stack([line - wide - back, line + on])
            place = spline.offset(at + away.ravel(), motion.coefficients)
            # along a floor that leans it falls, too, and a parabola is no line
            place[:, 2] += gravity_m_s2 / 2.0 * away.ravel() ** 2
            aside = (place - np.outer(place @ normal, normal)).reshape(2, -1, 3)
            (v1, x1), (v2, x2) = (np.polyfit(t, x, 1) for t, x in zip(away, aside, strict=True))
            kick = v2 - v1
            if np.linalg.norm(kick) < settings.kick_m_s:
                continue
            late = -float((x2 - x1) @ kick / (kick @ kick))
            if settings.min_beside_s < sign * late < settings.beside_s:
                found.append((float(at) + late, number))
    return np.array([time for time, _ in found]), np.array([number for _, number in found], dtype=np.intp)


def misfit_times(solution: Solution, settings: BreakSettings = BREAKS) -> FloatArray:
    """Return the middles (n,) of 10 ms windows of large residuals, where the spline is too stiff."""
    problem = solution.problem
    label = np.floor((problem.bins.time_s - problem.spline.edge_s[0]) / settings.window_s).astype(np.intp)
    square = np.where(problem.use, solution.at.residual**2, 1.0).mean(axis=0)
    label -= label[0]
    count = np.bincount(label)
    mean = np.bincount(label, weights=square) / np.maximum(count, 1)
    # against the record's own misfit: a wall that is missing everywhere asks for no knots
    typical = max(1.0, float(np.median(mean[count > 0])))
    doubt = settings.misfit_sigmas * np.sqrt(2.0 / np.maximum(count * solution.at.residual.shape[0], 1))
    bad = (count > 0) & (mean > typical * (settings.misfit_share + doubt))
    middle = np.bincount(label, weights=problem.bins.time_s) / np.maximum(count, 1)
    return np.asarray(middle[bad & (middle > problem.spline.edge_s[0])])


def respline(old: MotionSpline, coefficients: FloatArray, break_s: FloatArray, sharp_s: FloatArray) -> SplineMotion:
    """Return the motion on a spline with other breaks that follows the old motion, finer near `sharp_s`.

    Parameters
    ----------
    old, coefficients
        Its spline, and its coefficients, shape (size, 3).
    break_s, sharp_s
        Times of the new breaks, and where knots are finer, shapes (n,).

    Raises
    ------
    SolveError
        The new spline is not determined by the old motion.
    """
    # more points than unknowns: the old curve decides, not the spacing
    new = make_spline(float(old.edge_s[0]), float(old.edge_s[-1]), break_s, sharp_s)
    count = 8 * (sum(new.spans) + 4)
    grid = np.sort(np.concatenate([np.linspace(old.edge_s[0], old.edge_s[-1], count), new.edge_s]))
    rows, (jerk, _, _) = new.rows(grid), new.jerk()
    band = rows.gram(np.ones(grid.size)) + jerk.gram(np.full(jerk.first.size, BREAKS.smoothing))
    return SplineMotion(new, solve_band(band[:, 1:], rows.transposed(old.offset(grid, coefficients))))
