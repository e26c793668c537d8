"""Move a wall that was found step by step, because motion and maps hold it in place."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from radargui.estimation.select.converge import converge
from radargui.estimation.select.race import best_started, last_image, race
from radargui.estimation.select.wall_grid import WALLS, linearised_gains, upright_planes, wall_grid
from radargui.estimation.select.walls import (
    bent_by_maps,
    peaks,
    place_of_last,
    with_stiff_maps,
    without_last_mirror,
)
from radargui.estimation.solve.changed_problem import positions_at_bins, problem_with_mirrors
from radargui.estimation.solve.minimise import Solution, log_evidence
from radargui.estimation.solve.problem import Start
from radargui.model.arrays import FloatArray


@dataclass(frozen=True, slots=True)
class WalkSettings:
    """How a wall is moved. Chosen by hand on the drops of decision 0034.

    Attributes
    ----------
    turns_deg
        Changes of azimuth that are tried: none (only the prior of the place is renewed), one within that prior, and one
        beyond it.
    nearer_or_farther
        Factors on the distance that are tried in the same direction: one wall stood 8 cm too far, 90 in ln E below the
        true one; no turn led there, but each distance between 0.8 and 0.9 of it did.
    own_reach
        Places nearer than this share of its distance (30 degrees) are reached by its own steps.
    tried_elsewhere
        Number of other likely places from which a few steps are taken; the best of them takes part. In 50 drops with a
        wall none of two that ran along was the best in the end; with four 29 laboratory drops came out the same.
    steps
        Largest number of moves, as long as ln E grows by `WallSettings.worthwhile`.
    min_move
        A wall that moves by less than this share of its distance (7 degrees) has only converged.
    max_deviations
        A wall more deviations than this from where it was sought is held back by the prior of its place. One more move
        is made, which renews that prior (one wall stood 2.7 off, and 115 in ln E below the true one 4 degrees away).
    max_behind
        As in `WallSettings`. In eight steps of four drops the best in the end was 229 behind after the first minimum at
        the most, and led after the first round.
    rounds_again
        Rounds of a level motion that begins again from stiff maps because they are loose in the end.
    """

    turns_deg: tuple[float, ...] = (0.0, -12.0, 12.0, -24.0, 24.0)
    nearer_or_farther: tuple[float, ...] = (0.82, 1.22)
    own_reach: float = 0.5
    tried_elsewhere: int = 2
    steps: int = 4
    min_move: float = 0.12
    max_deviations: float = 2.0
    max_behind: tuple[float, float] = (500.0, 30.0)
    rounds_again: int = 10


WALK = WalkSettings()


def walked(
    solution: Solution, normal: FloatArray, round_done: Callable[[], None], settings: WalkSettings = WALK
) -> list[Solution]:
    """Return a solution and others whose last wall was moved, as long as the evidence grew, the best first.

    A trial begins without its wall's reflection and converges to the nearest maximum. There the motion fits this wall,
    and the prior of its place holds it. It is overcome by moving the wall but keeping its reflections and the motion,
    with deviations begun again. The whole grid is evaluated again first, because the walls were compared with a motion
    bent for want of a wall, or with a false break: a false wall was 88 ahead in ln E of one that is 220 better without
    such a break.

    Parameters
    ----------
    solution
        With the wall, converged.
    normal
        Upward normal of the floor, shape (3,).
    round_done
        Called once a round; may raise to cancel.
    settings
        How it is moved.
    """
    found = [solution]
    for step in range(settings.steps):
        best = found[0]
        middle = positions_at_bins(best).mean(axis=1)
        azimuth, distance = place_of_last(best, middle, normal)
        turned = azimuth + np.radians(settings.turns_deg)
        shifted = distance * np.array(settings.nearer_or_farther)
        planes = upright_planes(middle, normal, turned, np.array([max(distance, WALLS.nearest_m)]))
        planes += upright_planes(middle, normal, np.array([azimuth]), shifted[shifted > WALLS.nearest_m])
        here = best.problem.inputs.planes
        starts = [problem_with_mirrors(best, (*here[:-1], one)) for one in planes]
        if step == 0:
            starts += _elsewhere(best, normal, round_done, settings)
        more = filter(None, race(starts, WALLS.rounds, round_done, settings.max_behind))
        found = sorted([*found, *more], key=log_evidence, reverse=True)
        # where it stays it only converges, which needs no turns
        moved = last_image(found[0], middle) - last_image(best, middle)
        stays = float(np.linalg.norm(moved)) < 2.0 * distance * settings.min_move
        settled = stays or log_evidence(found[0]) < log_evidence(best) + WALLS.worthwhile
        # from the same wall all would begin and end the same
        if found[0] is best or (settled and not _is_held(found[0], settings.max_deviations)):
            break
    if bent_by_maps(found[0]):
        # the wall stands, the maps that stood for it have not gone
        stiff = with_stiff_maps(found[0])
        again = converge(problem_with_mirrors(stiff, found[0].problem.inputs.planes), settings.rounds_again, round_done)
        if log_evidence(again) > log_evidence(found[0]) + WALLS.worthwhile:
            found = [again, *found]
    return found


def _is_held(solution: Solution, most: float) -> bool:
    """Return whether the last wall stands farther from where it was sought than so many deviations."""
    problem = solution.problem
    unknown = problem.layout.plane_unknowns(solution.state.theta)[-1]
    return bool((np.abs(unknown) > most * np.array(problem.inputs.planes[-1].deviations)).any())


def _elsewhere(
    solution: Solution, normal: FloatArray, round_done: Callable[[], None], settings: WalkSettings
) -> list[Start]:
    """Return the places of the grid for the last wall after it was taken out of a motion that it has straightened.

    Only places that its own steps do not reach count.
    """
    others = solution.problem.inputs.planes[:-1]
    base = without_last_mirror(solution, problem_with_mirrors(solution, others).problem)
    planes = upright_planes(positions_at_bins(base).mean(axis=1), normal, *wall_grid())
    gains = linearised_gains(base, planes, round_done).reshape(WALLS.azimuths, -1)
    likeliest = [planes[k] for k in peaks(gains, around=True)]
    image_m, middle = last_image(solution, solution.problem.inputs.release_m), solution.problem.inputs.release_m
    reach_m = settings.own_reach * float(np.linalg.norm(image_m - middle))
    far = [one for one in likeliest if np.linalg.norm(one.image(middle, np.zeros(3)) - image_m) > reach_m]
    starts = [problem_with_mirrors(base, (*others, one)) for one in far[: settings.tried_elsewhere]]
    return best_started(starts, 1, round_done)
