"""Converge alternatives side by side, and give up those that are hopelessly behind."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from radargui.estimation.select.converge import convergence
from radargui.estimation.select.wall_grid import WALLS
from radargui.estimation.solve.minimise import MinimiseSettings, Solution, log_evidence, minimise
from radargui.estimation.solve.problem import Start
from radargui.model.arrays import FloatArray
from radargui.system.cores import Lane, cores


@dataclass(frozen=True, slots=True)
class Score:
    """The state of an alternative while it runs.

    Attributes
    ----------
    ln_evidence
        ln E after its last round.
    n_mirrors
        Number of mirrors of its model.
    image_m
        Image of the release in the last of them, shape (3,); None without one.
    """

    ln_evidence: float
    n_mirrors: int
    image_m: FloatArray | None


def race(
    starts: Sequence[Start],
    rounds: int,
    round_done: Callable[[], None],
    max_behind: tuple[float, ...],
    met: Callable[[Score, Score], bool] = lambda one, other: False,
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
    with _Field(starts, rounds) as field:
        now = dict(field.step(range(len(starts))))
        alive = sorted(now)
        for number in range(2 * rounds):
            # then only those go on that have not come to their minimum
            if number < rounds:
                best = max(now[k].ln_evidence for k in alive)
                near = [k for k in alive if now[k].ln_evidence >= best - max_behind[min(number, len(max_behind) - 1)]]
                alive = [k for k in near if not any(met(now[j], now[k]) for j in near if j < k)]
            for k, one in field.step(alive):
                now[k] = one
                round_done()
        found = {k: field.solution(k) for k in alive}
        has_settled = any(one.settled for one in found.values())
        there = {k: one for k, one in found.items() if one.settled or not has_settled}
        return [there.get(k) for k in range(len(starts))]


FIRST = MinimiseSettings(renews_last=False)
"""Starts are only put in order: their evidence by the matrix of the step before orders them as well."""


def best_started(starts: Sequence[Start], most: int, round_done: Callable[[], None]) -> list[Start]:
    """Return the starts that are best after some steps, there."""
    with _Field(starts, None) as field:
        now: dict[int, Score] = {}
        for k, one in field.step(range(len(starts))):
            now[k] = one
            round_done()
        # at equal evidence the earlier, whichever told first
        best = sorted(sorted(now), key=lambda k: -now[k].ln_evidence)[:most]
        found = [field.solution(k) for k in best]
    return [Start(one.problem, one.state) for one in found]


def score_of(solution: Solution, ln_evidence: float) -> Score:
    """Return the score of an alternative with this ln E."""
    inputs = solution.problem.inputs
    image_m = last_image(solution, inputs.release_m) if inputs.planes else None
    return Score(ln_evidence, len(inputs.planes), image_m)


def same_place(one: Score, other: Score) -> bool:
    """Return whether the last mirrors of two alternatives are the same, at nearly the same ln E."""
    # as many mirrors, or there is nothing to compare
    if one.n_mirrors != other.n_mirrors or one.image_m is None or other.image_m is None:
        return False
    near = float(np.linalg.norm(one.image_m - other.image_m)) < WALLS.same_m
    return near and abs(one.ln_evidence - other.ln_evidence) < WALLS.level


def last_image(solution: Solution, point_m: FloatArray) -> FloatArray:
    """Return the image of a point in a solution's last mirror, shape (3,)."""
    unknown = solution.problem.layout.plane_unknowns(solution.state.theta)[-1]
    return solution.problem.inputs.planes[-1].image(point_m, unknown)


class _Field:
    """Alternatives on the available lanes; if another process fails, its work is done again here."""

    def __init__(self, starts: Sequence[Start], rounds: int | None) -> None:
        self._pieces = [(start, rounds) for start in starts]
        self._steps = [0] * len(starts)
        self._lanes: Sequence[Lane[Solution, Score]] = cores().lanes(_alternative, len(starts))

    def __enter__(self) -> _Field:
        try:
            self._begin()
        except OSError:
            self._begin_again()
        return self

    def __exit__(self, *_: object) -> None:
        try:
            for lane in self._lanes:
                lane.clear()
        except (EOFError, OSError):
            cores().give_up()

    def step(self, numbers: Sequence[int]) -> Iterator[tuple[int, Score]]:
        """Do one more round of each alternative; yield the scores of those that have not ended."""
        asked = sorted(numbers)
        answered: set[int] = set()
        try:
            for k, one in self._stepped(asked):
                answered.add(k)
                yield k, one
        except (EOFError, OSError):
            self._begin_again()
            for k, one in self._stepped(asked):
                if k not in answered:
                    yield k, one
        for k in asked:
            self._steps[k] += 1

    def solution(self, number: int) -> Solution:
        """Return an alternative as it is now."""
        try:
            return self._lane_of(number).result(number)
        except (EOFError, OSError):
            self._begin_again()
            return self._lane_of(number).result(number)

    def _lane_of(self, number: int) -> Lane[Solution, Score]:
        return self._lanes[number % len(self._lanes)]

    def _begin(self) -> None:
        for number, piece in enumerate(self._pieces):
            self._lane_of(number).begin(number, *piece)

    def _begin_again(self) -> None:
        cores().give_up()
        self._lanes = [Lane(_alternative)]
        self._begin()
        for number, steps in enumerate(self._steps):
            for _ in range(steps):
                list(self._stepped([number]))

    def _stepped(self, numbers: Sequence[int]) -> Iterator[tuple[int, Score]]:
        shares = [(lane, [k for k in numbers if self._lane_of(k) is lane]) for lane in self._lanes]
        at_work = [(lane, share) for lane, share in shares if share]
        # all are asked before the first answer is waited for
        for lane, share in at_work:
            lane.ask(share)
        for lane, _ in at_work:
            yield from lane.answer()


def _alternative(start: Start, rounds: int | None) -> Iterator[tuple[Solution, Score]]:
    """Yield a solution and its score after each round; without a number of rounds, after the first steps only."""
    if rounds is None:
        first = minimise(start, WALLS.first_steps, FIRST)
        yield first, score_of(first, log_evidence(first))
        return
    for solution, ln_evidence in convergence(start, rounds):
        yield solution, score_of(solution, ln_evidence)
