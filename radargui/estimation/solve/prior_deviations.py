"""Re-estimate the deviations of the priors from the posterior (MacKay 1992), and the noise scale from the misfit."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from scipy.ndimage import gaussian_filter1d

from radargui.estimation.forward.equation_of_motion import EquationRows
from radargui.estimation.forward.motion_spline import MotionSpline
from radargui.estimation.solve.minimise import Solution, local_chi_square
from radargui.estimation.solve.priors import PRIORS, Prior
from radargui.estimation.solve.problem import JointProblem
from radargui.model.arrays import FloatArray


@dataclass(frozen=True, slots=True)
class DeviationSettings:
    """How deviations are re-estimated.

    Attributes
    ----------
    lowest_jerk_m_s3, highest_jerk_m_s3
        Limits of the jerk's deviation: free fall with drag has below 1 m/s^3; a contact of milliseconds 10^5.
    lowest_off_m_s2, highest_off_m_s2
        Limits of the deviation from the equation of flight: a drag coefficient that changes with speed makes a
        thousandth, a flight that is none as much as gravity.
    largest_change
        Largest change of a deviation in one round, as a factor: its estimate is right only near the minimum that it
        comes from.
    window_spans
        Deviation of the Gaussian window over the spans. Chosen by hand: 30 ms distinguish a fall from the push of a
        bed.
    min_square
        Added to the sum of squares, in units of the lowest deviation's square, so that a motion that obeys its equation
        keeps a deviation above zero.
    min_determined
        Least number of well determined coefficients, which rounding can make zero. Chosen by hand.
    largest_noise_step
        Largest growth of the noise scale in one round, as a factor: a misfit that the next round removes shall not
        widen it.
    """

    lowest_jerk_m_s3: float = 0.3
    highest_jerk_m_s3: float = 1e5
    lowest_off_m_s2: float = 1e-3
    highest_off_m_s2: float = 10.0
    largest_change: float = 10.0
    window_spans: float = 3.0
    min_square: float = 0.01
    min_determined: float = 1e-2
    largest_noise_step: float = 1.3


DEVIATIONS = DeviationSettings()


def update_priors(solution: Solution, settings: DeviationSettings = DEVIATIONS) -> JointProblem:
    """Return the problem with map, mirror and jerk deviations re-estimated from a solution.

    s^2 = sum w^2 / gamma, gamma = number of coefficients - sum Cov_kk / s^2 (MacKay 1992).
    """
    problem = solution.problem
    prior = reestimated(problem.prior, solution.state.theta, solution.normal.global_variances(), settings)
    return replace(problem, prior=prior, equation_sd=_equation_deviation(solution, settings))


def reestimated(old: Prior, theta: FloatArray, variance: FloatArray, settings: DeviationSettings = DEVIATIONS) -> Prior:
    """Return the prior with its groups' deviations re-estimated from theta and its variances, (n_global,) both."""
    sd = old.sd.copy()
    for group in old.groups:
        index = group.index
        w = theta[index] - old.mean[index]
        # coefficients that the data leave alone count for nothing: they would make every deviation small
        determined = max(index.size - float((variance[index] / sd[index] ** 2).sum()), settings.min_determined)
        before = float(sd[index[0]])
        # the minimum of w^2 / 2 s^2 + gamma ln s + s / scale
        wanted = float(np.sqrt((w @ w) / (determined + before / group.scale)))
        # the fixed point is reached in steps: far from it gamma is not the one that belongs to it
        limited = np.clip(wanted, before / settings.largest_change, before * settings.largest_change)
        sd[index] = float(np.clip(limited, group.lowest, group.highest))
    return Prior(old.mean, sd, old.groups)


def _equation_deviation(solution: Solution, settings: DeviationSettings) -> FloatArray:
    """Return sd = sqrt(sum d^2 / number well determined) of the equation's rows, in a window that no break divides.

    Neither does the end of the release, because its jerk is no reason to let the fall bend.
    """
    problem, equation, old = solution.problem, solution.at.equation, solution.problem.equation_sd
    # gamma counts what the data determine of each row, x, y and z together: a fall has no direction to favour
    variance = np.trace(solution.normal.covariance().of_rows(equation.rows.rows), axis1=1, axis2=2)
    square = (equation.value**2).sum(axis=1)
    determined = np.clip(3.0 - variance / old**2, 0.0, 3.0)
    in_flight = equation.rows.is_flight
    lowest = np.where(in_flight, settings.lowest_off_m_s2, settings.lowest_jerk_m_s3)
    highest = np.where(in_flight, settings.highest_off_m_s2, settings.highest_jerk_m_s3)
    # as in `reestimated`, with the prior of a deviation from the equation of flight
    determined += np.where(in_flight, old / PRIORS.off_flight_m_s2, 0.0)
    out = np.empty_like(square)
    # an impact must not make the flights beside it bend, nor the hand that lets go the fall
    for part in rows_together(equation.rows, solution.at.spline, problem.released_s):
        both = np.stack([square[part], determined[part]])
        top, low = gaussian_filter1d(both, settings.window_spans, mode="nearest", truncate=2.0)
        least = settings.min_square * lowest[part] ** 2
        out[part] = np.sqrt((top + least) / np.maximum(low, settings.min_determined))
    limited = np.clip(out, old / settings.largest_change, old * settings.largest_change)
    return np.asarray(np.clip(limited, lowest, highest))


def rows_together(rows: EquationRows, spline: MotionSpline, released_s: float) -> list[slice]:
    """Return the runs of the equation's rows that no break and not the end of the release divide.

    Parameters
    ----------
    rows, spline
        The motion's equation and its spline.
    released_s
        End of the release.
    """
    middle_s = spline.span_middles()
    # the release is no break: velocity goes on, but a hand acted before it
    kind = np.stack([rows.segment, middle_s[rows.span] > released_s, rows.is_flight])
    edges = np.flatnonzero((np.diff(kind, axis=1) != 0).any(axis=0)) + 1
    return [slice(first, last) for first, last in pairwise([0, *edges.tolist(), rows.span.size])]


def updated_noise_scale(solution: Solution, settings: DeviationSettings = DEVIATIONS) -> FloatArray:
    """Return each receiver's factor on its noise, raised where the misfit asks for it, shape (n_receivers,).

    The median over the record counts, so that a short misfit (unresolved bounces) does not spoil the rest.
    """
    # Birge ratio, never below one: noise was measured from the samples themselves
    typical = np.median(local_chi_square(solution.problem, solution.at), axis=1)
    # the misfit is a square, the scale a factor on the deviation
    wanted = np.sqrt(np.maximum(typical, 1.0))
    return np.minimum(wanted, settings.largest_noise_step * solution.problem.noise_scale)
