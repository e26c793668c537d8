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
from radargui.correction.joint.mirrors import FLOOR, MirrorPlane
from radargui.correction.joint.repose import repose
from radargui.correction.joint.rounds import converge, positions, settle_breaks
from radargui.correction.joint.walls import search_wall
from radargui.correction.position_map import make_basis
from radargui.model.arrays import FloatArray

_BELOW_M = 0.010
_CONVINCING, _BEYOND_DOUBT = 25.0, 100.0
_GOOD_MISFIT, _LOST_MISFIT, _HOPELESS_MISFIT = 1.15, 4.0, 100.0
_GROWN_BIAS = 0.002
_MOST_WALLS = 2
_SHORTEST_LENGTH_M = 0.09
_OTHER_LENGTHS_M, _FEW_FRINGES = (0.14, 0.22), 6.0
_TEMPER, _LEAST_WEIGHT = 5.0, 0.01
_FIRST_ROUNDS, _LAST_ROUNDS = 4, 6


@dataclass(frozen=True)
class Chosen:
    """The joint solution and what was chosen on the way.

    Attributes
    ----------
    solution, ground
        The solution and its data.
    rivals
        Other solutions whose evidence does not rule them out, with their weights against the best: what they say and
        how far they lie away belongs to the uncertainty.
    choices
        Sentences for people.
    """

    solution: Solution
    ground: Ground
    rivals: tuple[tuple[Solution, float], ...]
    choices: tuple[str, ...]


@dataclass(frozen=True)
class _Attempts:
    """Joint solutions from the adaptive rounds under different assumptions."""

    ground: Ground
    found: Found
    drift: Drift
    normal: FloatArray
    tick: Callable[[], None]
    front_end: FloatArray | None

    def __call__(self, start: Round, length_m: float, *, reflects: bool) -> Solution:
        """Converge with bias maps of a correlation length, with or without a floor that reflects."""
        breaks = np.sort(np.concatenate([self.found.impact_s, self.found.turn_s]))
        motion = first_spline(self.ground, start.place, self.found.start_s, breaks)
        lowest = start.place[:, int(np.argmin(self.normal @ start.place))]
        floor = MirrorPlane(lowest - _BELOW_M * self.normal, self.normal, FLOOR)
        planes = (floor,) if reflects else ()
        posed = pose(self.ground, motion, circle_constants(start), planes, length_m, self.drift, self.front_end)
        return converge(self.ground, posed, _FIRST_ROUNDS, self.tick)


def choose_model(
    found: Found,
    drift: Drift,
    normal: FloatArray,
    tick: Callable[[], None],
    front_end: FloatArray | None = None,
) -> Chosen:
    """Converge without and with a floor, keep what the evidence prefers, settle the impacts, look for walls.

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
    front_end
        Prior of ln g and eps, shape (n_receivers, 4), see `front_end_prior`.
    """
    ground = replace(found.ground, bins=drift.widen(found.ground.bins))
    attempt = _Attempts(ground, found, drift, normal, tick, front_end)
    length = found.last.bias.length_m if found.last.bias is not None else _SHORTEST_LENGTH_M
    length = max(_SHORTEST_LENGTH_M, length)
    plain, floored = (attempt(found.last, length, reflects=reflects) for reflects in (False, True))
    if min(_typical_misfit(plain), _typical_misfit(floored)) > _LOST_MISFIT:
        floored = max(floored, attempt(found.first, length, reflects=True), key=log_evidence)
    gain = log_evidence(floored) - log_evidence(plain)
    tried = [plain, floored]
    solution = floored if gain > 0.0 else plain
    rivals = _rivals(solution, tried)
    solution = settle_breaks(ground, solution, normal, tick)
    if 0.0 < gain < _BEYOND_DOUBT:
        solution, gain = _doubted(ground, solution, tick)
    choices = [f"A floor that reflects is {'kept' if gain > 0.0 else 'left out'}: log evidence {gain:+.0f}."]
    if drift.count and not drift.level.any():
        choices.append("The offsets drift on the rest: slow functions of time are fitted.")
    elif drift.count:
        choices.append("1/f noise found on the rest: its slow part is fitted, its fast part widens the noise.")
    if float(np.ptp(found.last.phase_rad, axis=1).min()) < 2.0 * np.pi * _FEW_FRINGES:
        solution, others = _with_other_lengths(ground, solution, tick)
        rivals += others
    choices.append(f"Bias maps with a correlation length of {solution.problem.bases[0].length_m:.2f} m.")
    solution, undecided = _with_walls(ground, solution, normal, tick, choices)
    solution = converge(ground, Posed(solution.problem, solution.state), _LAST_ROUNDS, tick)
    choices.append(f"Misfit (chi-square) {', '.join(f'{value:.2f}' for value in chi_square(solution))}.")
    return Chosen(solution, ground, (*rivals, *undecided), tuple(choices))


def _doubted(ground: Ground, solution: Solution, tick: Callable[[], None]) -> tuple[Solution, float]:
    """Return the solution with its floor or without, and what the floor gains now that the breaks are settled."""
    with_floor, bare = (
        converge(ground, repose(solution, planes), _FIRST_ROUNDS, tick)
        for planes in (solution.problem.stage.planes, ())
    )
    gain = log_evidence(with_floor) - log_evidence(bare)
    return (with_floor if gain > 0.0 else bare), gain


def _with_other_lengths(
    ground: Ground, solution: Solution, tick: Callable[[], None]
) -> tuple[Solution, tuple[tuple[Solution, float], ...]]:
    """Return the solution with the bias maps' correlation length that the evidence prefers, and the others.

    Only once the breaks are settled do evidences tell lengths apart.
    """
    planes, visited = solution.problem.stage.planes, positions(ground, solution)[:, ~ground.rest]
    bases = [None, *(make_basis(visited, length) for length in _OTHER_LENGTHS_M)]
    tried = [converge(ground, repose(solution, planes, bias), _FIRST_ROUNDS, tick) for bias in bases]
    best = max(tried, key=log_evidence)
    return best, _rivals(best, tried)


def _with_walls(
    ground: Ground, solution: Solution, normal: FloatArray, tick: Callable[[], None], choices: list[str]
) -> tuple[Solution, list[tuple[Solution, float]]]:
    """Add the walls that the evidence keeps; tells `choices`.

    Where something reflects, walls too weak to convince stay possible, and so do other places of one that convinces:
    they are returned with their weights.
    """
    undecided: list[tuple[Solution, float]] = []
    for number in range(_MOST_WALLS):
        asked = _asks_for_walls(solution) if number == 0 else _typical_misfit(solution) > _GOOD_MISFIT
        if not asked and not (number == 0 and solution.problem.stage.planes):
            break
        search = search_wall(ground, solution, normal, tick, thorough=asked)
        kept = search.gain > _CONVINCING
        choices.append(f"A wall that reflects is {'kept' if kept else 'left out'}: log evidence {search.gain:+.0f}.")
        best = search.gain if kept else 0.0
        undecided = [(trial, _weight(gain - best)) for trial, gain in search.tried[1 if kept else 0 :]]
        if not kept:
            break
        solution = settle_breaks(ground, search.tried[0][0], normal, tick)
    return solution, [rival for rival in undecided if rival[1] > _LEAST_WEIGHT]


def _weight(gain: float) -> float:
    """Return the tempered weight of a rival against the best, exp(log evidence gained / 5), at most one."""
    return float(np.exp(min(0.0, gain) / _TEMPER))


def _rivals(best: Solution, tried: list[Solution]) -> tuple[tuple[Solution, float], ...]:
    """Return the other solutions with their weights, those above 1 % of the best."""
    out = []
    for solution in tried:
        weight = _weight(log_evidence(solution) - log_evidence(best))
        if solution is not best and weight > _LEAST_WEIGHT:
            out.append((solution, weight))
    return tuple(out)


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
