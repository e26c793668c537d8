"""Rounds of the joint estimate: minimise, move the maps with the motion, re-estimate the priors."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from radargui.correction.adaptive.place import range_law
from radargui.correction.adaptive.rounds import Ground
from radargui.correction.joint.breaks import break_speeds, misfit_times, respline, sharp_turns
from radargui.correction.joint.first_state import Posed, joint_constants, pose
from radargui.correction.joint.hyper import update_noise, update_priors
from radargui.correction.joint.minimise import Solution, log_evidence, minimise
from radargui.correction.joint.problem import State
from radargui.model.arrays import FloatArray

_STEPS = 6
_ENOUGH = 0.2
_BREAK_ROUNDS = 6
_SAME_S, _GROUP_S = 0.004, 0.06


def converge(ground: Ground, posed: Posed, rounds: int, tick: Callable[[], None]) -> Solution:
    """Alternate Gauss-Newton with updates of maps and priors until the evidence settles.

    Parameters
    ----------
    ground, posed
        Data; problem, start and map functions.
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
        place = positions(ground, solution)
        law = range_law(place, ground.antennas, ground.release_m)
        problem = problem.with_maps(posed.bases[0](place), posed.bases[1](place), law)
        solution = minimise(problem, solution.state, _STEPS)
        now = log_evidence(solution)
        if number > 3 and abs(now - evidence) < _ENOUGH:
            break
        evidence = now
    return solution


def settle_breaks(
    ground: Ground, solution: Solution, normal: FloatArray, bias_length_m: float, tick: Callable[[], None]
) -> Solution:
    """Add breaks where the motion turns sharply, drop those without a jump, until neither changes.

    Of turns close to each other only the first is taken at a time, because what follows a missing break is wrong; a
    break that was dropped is not tried again.
    """
    sharp, refused = np.zeros(0), np.zeros(0)
    for number in range(_BREAK_ROUNDS):
        speeds = break_speeds(solution, normal)
        good = speeds.are_kinks()
        refused = np.concatenate([refused, speeds.time_s[~good]])
        new = _first_of_each(_away(sharp_turns(solution, normal), refused)) if number < _BREAK_ROUNDS - 1 else np.zeros(0)
        stiff = misfit_times(solution) if new.size == 0 else np.zeros(0)
        if new.size == 0 and good.all() and (stiff.size == 0 or sharp.size > 0):
            break
        sharp = np.concatenate([sharp, stiff])
        breaks = np.sort(np.concatenate([speeds.time_s[good], new]))
        motion = respline(solution.at.spline, solution.state.coefficients, breaks, sharp)
        constants = joint_constants(solution.problem, solution.state.theta)
        posed = carry_mirrors(solution, pose(ground, motion, constants, solution.problem.stage.planes, bias_length_m))
        solution = converge(ground, posed, 4, tick)
    return solution


def _away(moments: FloatArray, others: FloatArray) -> FloatArray:
    near = np.abs(moments[:, None] - others[None]) < _SAME_S
    return moments[~near.any(axis=1)]


def _first_of_each(moments: FloatArray) -> FloatArray:
    """Return the first of each group of moments less than 60 ms apart."""
    return moments[np.diff(moments, prepend=-np.inf) > _GROUP_S]


def carry_mirrors(solution: Solution, posed: Posed) -> Posed:
    """Start the mirrors of a newly posed problem from those of a solution."""
    theta, old, new = posed.state.theta.copy(), solution.problem.layout, posed.problem.layout
    theta[new.planes] = solution.state.theta[old.planes]
    theta[new.forward] = solution.state.theta[old.forward]
    for before, after in zip(old.receivers, new.receivers, strict=True):
        theta[after.backward] = solution.state.theta[before.backward]
        theta[after.ghost] = solution.state.theta[before.ghost]
    return replace(posed, state=State(posed.state.coefficients, theta))


def positions(ground: Ground, solution: Solution) -> FloatArray:
    """Return the positions at the bins, shape (3, n_bins)."""
    return np.asarray((solution.at.design @ solution.state.coefficients + ground.release_m).T)
