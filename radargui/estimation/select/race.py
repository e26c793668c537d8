"""Converge alternatives side by side, and give up those that are hopelessly behind."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from radargui.estimation.select.converge import Converging, begun, next_round
from radargui.estimation.select.wall_grid import WALLS
from radargui.estimation.solve.minimise import MinimiseSettings, Solution, log_evidence, minimise
from radargui.estimation.solve.problem import Start
from radargui.model.arrays import FloatArray
from radargui.system.cores import cores


def race(
    starts: Sequence[Start],
    rounds: int,
    round_done: Callable[[], None],
    max_behind: tuple[float, ...],
    met: Callable[[Converging, Converging], bool] = lambda one, other: False,
) -> list[Solution | None]:
    """Return the solutions of some starts as `converge` would, None for those that fell hopelessly behind, or met.

    Alternatives that have not reached a minimum are given up, too, unless none has, because their evidence cannot be
    compared.

    Within `radargui.system.cores.on_cores` they run side by side, with the same result.

    Parameters
    ----------
    starts
        Starts whose evidences are comparable.
    rounds, round_done
        As of `converge`.
    max_behind
        How far in ln E an alternative may be behind the best, after the first minimum and after each round; the last
        one stays.
    met
        Function that says whether two have reached the same maximum; the later in the list is then given up.

    Raises
    ------
    SolveError
        The normal matrix of one cannot be factored.
    """
    now = dict(enumerate(cores().map(begun, starts)))
    alive = sorted(now)
    for number in range(2 * rounds):
        # then only those go on that have not come to their minimum
        if number < rounds:
            best = max(now[k].ln_evidence for k in alive)
            near = [k for k in alive if now[k].ln_evidence >= best - max_behind[min(number, len(max_behind) - 1)]]
            alive = [k for k in near if not any(met(now[j], now[k]) for j in near if j < k)]
        going = [k for k in alive if not now[k].has_ended(rounds)]
        for k, one in zip(going, cores().map(next_round, [now[k] for k in going]), strict=True):
            now[k] = one
            round_done()
    has_settled = any(now[k].solution.settled for k in alive)
    there = {k: now[k].solution for k in alive if now[k].solution.settled or not has_settled}
    return [there.get(k) for k in range(len(starts))]


FIRST = MinimiseSettings(renews_last=False)
"""Starts are only put in order: their evidence by the matrix of the step before orders them as well."""


def best_started(starts: Sequence[Start], most: int, round_done: Callable[[], None]) -> list[Start]:
    """Return the starts that are best after some steps, there."""
    tried = []
    for one in cores().map(_first_steps, starts):
        tried.append(one)
        round_done()
    best = sorted(tried, key=log_evidence, reverse=True)[:most]
    return [Start(one.problem, one.state) for one in best]


def _first_steps(start: Start) -> Solution:
    return minimise(start, WALLS.first_steps, FIRST)


def same_place(one: Converging, other: Converging) -> bool:
    """Return whether the last mirrors of two alternatives are the same, at nearly the same ln E."""
    planes, others = (each.solution.problem.inputs.planes for each in (one, other))
    # as many mirrors, or there is nothing to compare
    if len(planes) != len(others) or not planes:
        return False
    first, second = (last_image(each.solution, each.solution.problem.inputs.release_m) for each in (one, other))
    near = float(np.linalg.norm(first - second)) < WALLS.same_m
    return near and abs(one.ln_evidence - other.ln_evidence) < WALLS.level


def last_image(solution: Solution, point_m: FloatArray) -> FloatArray:
    """Return the image of a point in a solution's last mirror, shape (3,)."""
    unknown = solution.problem.layout.plane_unknowns(solution.state.theta)[-1]
    return solution.problem.inputs.planes[-1].image(point_m, unknown)
