"""Converge alternatives side by side, and give up those that are hopelessly behind."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from radargui.estimation.select.converge import begun, next_round
from radargui.estimation.select.wall_grid import WALLS
from radargui.estimation.solve.minimise import Solution, log_evidence, minimise
from radargui.estimation.solve.problem import Start
from radargui.model.arrays import FloatArray
from radargui.system.cores import cores


def race(
    starts: Sequence[Start],
    rounds: int,
    round_done: Callable[[], None],
    max_behind: tuple[float, ...],
) -> list[Solution | None]:
    """Return the solutions of some starts as `converge` would, None for those that fell hopelessly behind.

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
            alive = [k for k in alive if now[k].ln_evidence >= best - max_behind[min(number, len(max_behind) - 1)]]
        going = [k for k in alive if not now[k].has_ended(rounds)]
        for k, one in zip(going, cores().map(next_round, [now[k] for k in going]), strict=True):
            now[k] = one
            round_done()
    has_settled = any(now[k].solution.settled for k in alive)
    there = {k: now[k].solution for k in alive if now[k].solution.settled or not has_settled}
    return [there.get(k) for k in range(len(starts))]


def best_started(starts: Sequence[Start], most: int, round_done: Callable[[], None]) -> list[Start]:
    """Return the starts that are best after some steps, there."""
    tried = []
    for one in cores().map(_first_steps, starts):
        tried.append(one)
        round_done()
    best = sorted(tried, key=log_evidence, reverse=True)[:most]
    return [Start(one.problem, one.state) for one in best]


def _first_steps(start: Start) -> Solution:
    return minimise(start, WALLS.first_steps)


def last_image(solution: Solution, point_m: FloatArray) -> FloatArray:
    """Return the image of a point in a solution's last mirror, shape (3,)."""
    unknown = solution.problem.layout.plane_unknowns(solution.state.theta)[-1]
    return solution.problem.inputs.planes[-1].image(point_m, unknown)
