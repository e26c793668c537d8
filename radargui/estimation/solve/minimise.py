"""Minimise the joint problem by damped Gauss-Newton, and compute its evidence."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import uniform_filter1d

from radargui.estimation.forward.parameters import with_nearest_angles
from radargui.estimation.forward.stated_floor import stated_term
from radargui.estimation.solve.assemble import MAX_DAMPING, Assembled, assemble
from radargui.estimation.solve.normal import FactoredNormal
from radargui.estimation.solve.priors import PRIORS
from radargui.estimation.solve.problem import JointProblem, Linearised, Start, State, linearise
from radargui.model.arrays import FloatArray
from radargui.model.errors import SolveError


@dataclass(frozen=True, slots=True)
class MinimiseSettings:
    """When Gauss-Newton stops. Chosen by hand; decisions 24, 38, 39 and 41 have what others cost.

    Attributes
    ----------
    close
        A step that gains less in cost (ln likelihood) is the last: an unknown 0.3 of its deviation off costs as much.
    nothing
        Foretold to gain less than this, no step is taken.
    min_flight_s
        Two breaks never come closer: no bin would lie between them.
    max_farther
        Farther from the release than the nearest antenna, a step leads less than so many times as far as the motion
        that it begins from: where it is known at all, it does not double.
    """

    close: float = 0.05
    nothing: float = 0.005
    min_flight_s: float = 1e-3
    max_farther: float = 1.5


MINIMISE = MinimiseSettings()
_LOCAL_BINS = 41  # of the local chi-square: 82 residuals of a receiver, whose mean of squares scatters by 16 %


@dataclass(frozen=True)
class Solution:
    """A state, the problem linearised there, and the factored normal matrix; the damping that the last step needed."""

    problem: JointProblem
    state: State
    at: Linearised
    normal: FactoredNormal
    settled: bool
    damping: int = 0


def solved_at(start: Start) -> Solution:
    """Return a start as a solution, no step taken: not a minimum, a place to search from."""
    at = linearise(start.problem, start.state)
    normal = assemble(start.problem, start.state, at).factor()
    return Solution(start.problem.placed(start.state.theta), start.state, replace(at, waves=None), normal, False)


def minimise(start: Start, steps: int, settings: MinimiseSettings = MINIMISE, damping: int = 0) -> Solution:
    """Take up to `steps` Gauss-Newton steps; stop where a step gains less than `close` in cost.

    Parameters
    ----------
    start, steps, settings
        Where they begin, how many, and when they end.
    damping
        Of the first step.

    Raises
    ------
    SolveError
        The normal matrix cannot be factored.
    """
    problem, state = start.problem, start.state
    at, settled = linearise(problem, state), False
    assembled = assemble(problem, state, at)
    for _ in range(steps):
        step, damping = _improve(problem, state, at, assembled, damping, settings)
        if step is None:
            settled = damping <= MAX_DAMPING
            break
        state, at = step.state, step.at
        assembled = assemble(problem, state, at)
        # in ln likelihood: less than what any unknown could be told apart by
        settled = step.gained < settings.close
        if settled:
            break
    # the waves have served: kept with every alternative they would be most of its memory
    problem = problem.placed(state.theta)
    return Solution(problem, state, replace(at, waves=None), assembled.factor(), settled, damping)


@dataclass(frozen=True)
class _Step:
    """Where a step leads, and what it gains there in cost."""

    state: State
    at: Linearised
    gained: float


def _improve(
    problem: JointProblem,
    state: State,
    at: Linearised,
    assembled: Assembled,
    damping: int,
    settings: MinimiseSettings,
) -> tuple[_Step | None, int]:
    """Return the first of ever more damped steps that lowers the cost, None where none does, and the next damping."""
    first = damping
    while damping <= MAX_DAMPING:
        trial, foretold = _step(problem, state, assembled, damping, settings)
        if trial is not None:
            if foretold < settings.nothing:
                break
            trial_at = linearise(problem, trial)
            gained = at.cost - trial_at.cost
            if gained >= 0.0:
                # what was just refused would be refused again
                return _Step(trial, trial_at, gained), max(damping - 1, 0) if damping == first else damping
            # rounding, not curvature: more damping would only shorten the step
            if foretold < settings.close or -gained < settings.close / 5.0:
                break
        damping += 1
    return None, damping


def _step(
    problem: JointProblem, state: State, assembled: Assembled, damping: int, settings: MinimiseSettings
) -> tuple[State | None, float]:
    """Return the state after a damped step, None where the matrix cannot be factored or no body moves so, and its gain.

    What it should gain in cost at the least: half its way down the slope.
    """
    try:
        step = assembled.factor(damping).solve(-assembled.slope)
    except SolveError:
        return None, 0.0
    foretold, n_motion = -0.5 * float(assembled.slope @ step), state.coefficients.size
    # x, y, z are interleaved in the matrix, so that its band stays narrow
    coefficients = state.coefficients + step[:n_motion].reshape(-1, 3)
    # signals of antennas that are off may turn an angle round and round, where the setup would pull for ever
    theta = with_nearest_angles(state.theta + step[n_motion:], problem.layout, problem.prior.mean)
    if not _is_possible(problem, coefficients, state, theta, settings):
        return None, foretold
    return State(coefficients, theta), foretold


def _is_possible(
    problem: JointProblem, coefficients: FloatArray, before: State, theta: FloatArray, settings: MinimiseSettings
) -> bool:
    """Return whether breaks stay apart and the tracer on this side of the antennas, on a motion like that `before`.

    A spline lies within the hull of its coefficients: all of them on the release's side of the plane through an
    antenna, across the way from the release, mean that the tracer does not come to it. Farther from the release than
    the nearest antenna it goes by no more than half as far again as before.
    """
    inputs = problem.inputs
    # breaks that pass each other would exchange their impacts
    edge = np.concatenate([problem.spline.edge_s[:1], theta[problem.layout.breaks], problem.spline.edge_s[-1:]])
    if (np.diff(edge) <= settings.min_flight_s).any():
        return False
    away_m = np.vstack([inputs.antennas.transmitter_m, inputs.antennas.receivers_m]) - inputs.release_m
    distance_m = np.linalg.norm(away_m, axis=1)
    nearest_m, farthest_m = distance_m.min(), np.linalg.norm(coefficients, axis=1).max()
    # within this ball it is on the right side of every plane
    if farthest_m < nearest_m:
        return True
    limit_m = settings.max_farther * np.linalg.norm(before.coefficients, axis=1).max()
    return bool(farthest_m < limit_m and (coefficients @ away_m.T < distance_m**2).all())


def log_evidence(solution: Solution) -> float:
    """Return the Laplace approximation of the log evidence, noise scale and the equation's deviations included.

    ln E = -cost - ln det H / 2 - sum ln sd_prior - 3 sum ln sd_equation - sum over the channels' bins of ln noise scale
    and what the deviations' own priors say.
    """
    problem, log_determinant = solution.problem, solution.normal.log_determinant()
    stated = stated_term(solution.state.theta, problem.layout, problem.placed(solution.state.theta).inputs)
    # without the terms of the deviations a model could widen its priors until anything fits
    n_used = int(problem.use.sum())
    return (
        -solution.at.cost
        - 0.5 * log_determinant
        - float(np.log(problem.prior.sd).sum())
        - (0.0 if stated is None else stated.log_deviations)
        - 3.0 * float(np.log(problem.equation_sd).sum())
        - 2.0 * n_used * float(np.log(problem.noise_scale).sum())
        - sum(float(problem.prior.sd[one.index[0]]) / one.scale for one in problem.prior.groups)
        - float(problem.equation_sd[solution.at.equation.rows.is_flight].sum()) / PRIORS.off_flight_m_s2
    )


def chi_square(solution: Solution) -> FloatArray:
    """Return each receiver's mean squared residual in units of the white noise, shape (n_receivers,)."""
    return np.asarray(local_chi_square(solution.problem, solution.at)[:, solution.problem.use].mean(axis=1))


def local_chi_square(problem: JointProblem, at: Linearised) -> FloatArray:
    """Return the squared residual of both channels averaged over about 40 bins, shape (n_receivers, n_bins)."""
    return np.asarray(uniform_filter1d(receiver_misfits(problem, at), _LOCAL_BINS, axis=1, mode="nearest"))


def receiver_misfits(problem: JointProblem, at: Linearised) -> FloatArray:
    """Return the squared residual of both channels in units of the white noise, shape (n_receivers, n_bins)."""
    square = np.where(problem.use, at.residual**2 / problem.bins.expected, 1.0)
    # against the white noise, not against what the misfit has made of it
    return np.asarray(square.reshape(-1, 2, square.shape[1]).mean(axis=1) * problem.noise_scale[:, None] ** 2)
