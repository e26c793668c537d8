"""Which model: with or without a floor that reflects, with walls where the misfit asks; the evidence decides."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from radargui.correction.adaptive.found import Found
from radargui.correction.adaptive.rounds import Ground
from radargui.correction.joint.drift import Drift
from radargui.correction.joint.first_state import Posed, circle_constants, first_spline, pose
from radargui.correction.joint.minimise import Solution, chi_square, local_chi_square, log_evidence
from radargui.correction.joint.mirrors import MirrorPlane
from radargui.correction.joint.rounds import converge, settle_breaks
from radargui.correction.joint.walls import search_wall
from radargui.model.arrays import FloatArray

_BELOW_M = 0.010
_CONVINCING = 10.0
_GOOD_MISFIT = 1.1
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
    motion = first_spline(ground, found.last.place, found.start_s, found.impact_s)
    length = found.last.bias.length_m if found.last.bias is not None else _SHORTEST_LENGTH_M
    constants = circle_constants(found.last)
    lowest = found.last.place[:, int(np.argmin(normal @ found.last.place))]
    floor = MirrorPlane(lowest - _BELOW_M * normal, normal, "floor")
    tried = []
    for planes in ((), (floor,)):
        posed = pose(ground, motion, constants, planes, max(_SHORTEST_LENGTH_M, length), drift)
        tried.append(converge(ground, posed, _FIRST_ROUNDS, tick))
    gain = log_evidence(tried[1]) - log_evidence(tried[0])
    reflects = gain > _CONVINCING
    choices = [
        f"A floor that reflects is {'kept' if reflects else 'left out'}: log evidence {gain:+.0f}.",
        f"Bias maps with a correlation length of {max(_SHORTEST_LENGTH_M, length):.2f} m.",
    ]
    if drift.count:
        choices.append("1/f noise found on the rest: its slow part is fitted, its fast part widens the noise.")
    solution = settle_breaks(ground, tried[1] if reflects else tried[0], normal, tick)
    for _ in range(_MOST_WALLS):
        if np.median(local_chi_square(solution), axis=1).max() < _GOOD_MISFIT:
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
