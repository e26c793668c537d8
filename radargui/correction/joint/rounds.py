"""Rounds of the joint estimate: minimise, move the maps with the motion, re-estimate the priors."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from radargui.correction.adaptive.rounds import Ground
from radargui.correction.joint.breaks import break_speeds, misfit_times, respline, sharp_turns
from radargui.correction.joint.first_state import Posed, pose_again
from radargui.correction.joint.hyper import update_noise, update_priors
from radargui.correction.joint.minimise import Solution, local_chi_square, log_evidence, minimise
from radargui.model.arrays import FloatArray

_STEPS = 6
_ENOUGH = 0.2
_BREAK_ROUNDS = 6
_SAME_S = 0.0015
_CASCADES, _NO_WORSE = 3, 1.02


def converge(ground: Ground, posed: Posed, rounds: int, tick: Callable[[], None]) -> Solution:
    """Alternate Gauss-Newton with updates of maps and priors until the evidence settles.

    Parameters
    ----------
    ground, posed
        Data; problem and start.
    rounds
        At most this many.
    tick
        Called once a round; may raise to cancel.
    """
    evidence = -np.inf
    solution = minimise(posed.problem, posed.state, _STEPS)
    for number in range(rounds):
        tick()
        problem = update_priors(solution)
        if number >= 2:
            problem = replace(problem, noise_scale=update_noise(solution).noise_scale)
        solution = minimise(problem.at_places(positions(ground, solution)), solution.state, _STEPS)
        now = log_evidence(solution)
        if number > 3 and abs(now - evidence) < _ENOUGH:
            break
        evidence = now
    return solution


def settle_breaks(ground: Ground, solution: Solution, normal: FloatArray, tick: Callable[[], None]) -> Solution:
    """Add breaks where the motion turns sharply, drop those without a jump, until neither changes.

    First the body is let bounce on from its last impact: one break too few between short flights draws its neighbour
    away. A break that was dropped is not tried again at the same place. Of the rounds whose misfit is within 2 % of the
    smallest the one with most impacts, best known, is returned (evidences are not comparable between different knots).
    """
    sharp, refused = np.zeros(0), np.zeros(0)
    solution = _bounced_on(ground, solution, normal, tick)
    seen = [solution]
    for number in range(_BREAK_ROUNDS):
        speeds = break_speeds(solution, normal)
        good = speeds.are_kinks()
        inserted = solution.problem.prior.mean[solution.problem.layout.breaks]
        refused = np.concatenate([refused, inserted[~good]])
        last = number == _BREAK_ROUNDS - 1
        new = np.zeros(0) if last else _away(sharp_turns(solution, normal), refused)
        stiff = misfit_times(solution) if new.size == 0 else np.zeros(0)
        if new.size == 0 and good.all() and (stiff.size == 0 or sharp.size > 0):
            break
        sharp = np.concatenate([sharp, stiff])
        breaks = np.sort(np.concatenate([speeds.time_s[good], new]))
        motion = respline(solution.at.spline, solution.state.coefficients, breaks, sharp)
        solution = converge(ground, pose_again(ground, solution, motion), 4, tick)
        seen.append(solution)
    enough = _NO_WORSE * min(_misfit(one) for one in seen)
    return max((one for one in seen if _misfit(one) <= enough), key=lambda one: _impacts(one, normal))


def _impacts(solution: Solution, normal: FloatArray) -> tuple[int, float]:
    """Return how many impacts there are, and less the uncertainty of the least known jump."""
    speeds = break_speeds(solution, normal)
    impacts = speeds.are_impacts()
    return int(impacts.sum()), -float(speeds.u_jump_m_s[impacts].max(initial=0.0))


def _bounced_on(ground: Ground, solution: Solution, normal: FloatArray, tick: Callable[[], None]) -> Solution:
    """Return the solution with breaks where the body should land next, as long as that finds more impacts."""
    for _ in range(_CASCADES):
        speeds = break_speeds(solution, normal)
        impacts = speeds.are_impacts()
        expected = speeds.expected_impacts(float(solution.at.spline.edge_s[-1]))
        if expected.size == 0:
            break
        before = speeds.time_s[speeds.time_s <= speeds.time_s[impacts][-1]]
        breaks = np.concatenate([before, expected])
        motion = respline(solution.at.spline, solution.state.coefficients, breaks, np.zeros(0))
        trial = converge(ground, pose_again(ground, solution, motion), 4, tick)
        more = _impacts(trial, normal)[0] > int(impacts.sum())
        if not more or _misfit(trial) > _NO_WORSE * _misfit(solution):
            break
        solution = trial
    return solution


def _misfit(solution: Solution) -> float:
    return float(local_chi_square(solution).mean())


def _away(moments: FloatArray, others: FloatArray) -> FloatArray:
    near = np.abs(moments[:, None] - others[None]) < _SAME_S
    return moments[~near.any(axis=1)]


def positions(ground: Ground, solution: Solution) -> FloatArray:
    """Return the positions at the bins, shape (3, n_bins)."""
    return np.asarray((solution.at.design @ solution.state.coefficients + ground.release_m).T)
