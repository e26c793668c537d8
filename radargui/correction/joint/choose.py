"""Which model: with or without a floor that reflects, with walls where the misfit asks; the evidence decides."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from radargui.correction.adaptive.found import Found
from radargui.correction.adaptive.rounds import Ground, Round
from radargui.correction.joint.drift import Drift
from radargui.correction.joint.first_state import Posed, circle_constants, first_spline, pose
from radargui.correction.joint.minimise import Solution, chi_square, local_chi_square, log_evidence
from radargui.correction.joint.mirrors import MirrorPlane
from radargui.correction.joint.rounds import converge, settle_breaks
from radargui.correction.joint.walls import search_wall
from radargui.model.arrays import FloatArray

_BELOW_M = 0.010
_CONVINCING = 10.0
_GOOD_MISFIT, _LOST_MISFIT, _HOPELESS_MISFIT = 1.15, 4.0, 100.0
_GROWN_BIAS = 0.005
_MOST_WALLS = 2
_SHORTEST_LENGTH_M = 0.09
_FIRST_ROUNDS, _LAST_ROUNDS = 4, 6


@dataclass(frozen=True)
class Chosen:
    """The joint solution and what was chosen on the way."""

    solution: Solution
    ground: Ground
    choices: tuple[str, ...]


def choose_model(found: Found, drift: Drift, normal: FloatArray, tick: Callable[[], None]) -> Chosen:
    """Converge without and with a floor, keep what the evidence prefers, settle the impacts, converge.

    Parameters
    ----------
    found
        The adaptive rounds.
    drift
        Slow noise.
    normal
        Upward normal of the floor, shape (3,).
    tick
        Called once a round; may raise to cancel.
    """
    ground = replace(found.ground, bins=drift.widen(found.ground.bins))
    length = found.last.bias.length_m if found.last.bias is not None else _SHORTEST_LENGTH_M
    length = max(_SHORTEST_LENGTH_M, length)

    breaks = np.sort(np.concatenate([found.impact_s, found.turn_s]))

    def attempt(start: Round, reflects: bool) -> Solution:
        motion = first_spline(ground, start.place, found.start_s, breaks)
        lowest = start.place[:, int(np.argmin(normal @ start.place))]
        floor = MirrorPlane(lowest - _BELOW_M * normal, normal, "floor")
        posed = pose(ground, motion, circle_constants(start), (floor,) if reflects else (), length, drift)
        return converge(ground, posed, _FIRST_ROUNDS, tick)

    plain, floored = attempt(found.last, False), attempt(found.last, True)
    if min(_typical_misfit(plain), _typical_misfit(floored)) > _LOST_MISFIT:
        floored = max(floored, attempt(found.first, True), key=log_evidence)
    gain = log_evidence(floored) - log_evidence(plain)
    reflects = gain > _CONVINCING
    choices = [
        f"A floor that reflects is {'kept' if reflects else 'left out'}: log evidence {gain:+.0f}.",
        f"Bias maps with a correlation length of {length:.2f} m.",
    ]
    if drift.count:
        choices.append("1/f noise found on the rest: its slow part is fitted, its fast part widens the noise.")
    solution = settle_breaks(ground, floored if reflects else plain, normal, tick)
    for _ in range(_MOST_WALLS):
        if not _asks_for_walls(solution):
            break
        with_wall, gain = search_wall(ground, solution, normal, tick)
        choices.append(
            f"A wall that reflects is {'kept' if gain > _CONVINCING else 'left out'}: log evidence {gain:+.0f}."
        )
        if gain < _CONVINCING:
            break
        solution = settle_breaks(ground, with_wall, normal, tick)
    solution = converge(ground, Posed(solution.problem, solution.state), _LAST_ROUNDS, tick)
    choices.append(f"Misfit (chi-square) {', '.join(f'{value:.2f}' for value in chi_square(solution))}.")
    return Chosen(solution, ground, tuple(choices))


def _typical_misfit(solution: Solution) -> float:
    """Return the largest over the receivers of the median local chi-square."""
    return float(np.median(local_chi_square(solution), axis=1).max())


def _asks_for_walls(solution: Solution) -> bool:
    """Return whether residuals, or bias maps that grow although a floor is there, ask for another reflector."""
    problem = solution.problem
    if _typical_misfit(solution) > _HOPELESS_MISFIT:
        return False
    bias = max(float(problem.prior.sd[own.bias_i.start]) for own in problem.layout.receivers)
    return _typical_misfit(solution) > _GOOD_MISFIT or (len(problem.stage.planes) > 0 and bias > _GROWN_BIAS)
