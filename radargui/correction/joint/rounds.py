"""Rounds of the joint estimate: minimise, move the maps with the motion, re-estimate the priors."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from radargui.correction.adaptive.place import range_law
from radargui.correction.adaptive.rounds import Ground
from radargui.correction.joint.hyper import update_noise, update_priors
from radargui.correction.joint.minimise import Solution, log_evidence, minimise
from radargui.correction.joint.problem import JointProblem, State
from radargui.correction.position_map import PositionBasis

_STEPS = 6
_ENOUGH = 0.2


def converge(
    ground: Ground,
    problem: JointProblem,
    state: State,
    bases: tuple[PositionBasis, PositionBasis],
    rounds: int,
    tick: Callable[[], None],
) -> Solution:
    """Alternate Gauss-Newton with updates of maps and priors until the evidence settles.

    Parameters
    ----------
    ground, problem, state, bases
        Data, what is asked, where to start, the map functions.
    rounds
        At most this many.
    tick
        Called once a round; may raise to cancel.
    """
    evidence = -np.inf
    solution = minimise(problem, state, _STEPS)
    for number in range(rounds):
        tick()
        problem = update_priors(solution)
        if number >= 2:
            problem = _scaled(problem, solution)
        place = (solution.at.design @ solution.state.coefficients + ground.release_m).T
        law = range_law(place, ground.antennas, ground.release_m)
        problem = problem.with_maps(bases[0](place), bases[1](place), law)
        solution = minimise(problem, solution.state, _STEPS)
        now = log_evidence(solution)
        if number > 3 and abs(now - evidence) < _ENOUGH:
            break
        evidence = now
    return solution


def _scaled(problem: JointProblem, solution: Solution) -> JointProblem:
    return JointProblem(**{**problem.__dict__, "noise_scale": update_noise(solution).noise_scale})
