"""Search reflecting walls over azimuth and distance where the misfit asks for them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.ndimage import maximum_filter1d

from radargui.estimation.select.converge import converge
from radargui.estimation.select.loose_maps import bias_deviations
from radargui.estimation.select.race import best_started, last_image, race
from radargui.estimation.select.wall_grid import (
    WALLS,
    WallSettings,
    linearised_gains,
    stiffened,
    upright_planes,
    wall_grid,
    wall_towards,
)
from radargui.estimation.solve.changed_problem import carried_places, positions_at_bins, problem_with_mirrors
from radargui.estimation.solve.minimise import Solution, log_evidence, minimise, solved_at
from radargui.estimation.solve.problem import JointProblem, Start, State
from radargui.model.arrays import FloatArray


@dataclass(frozen=True)
class WallTrial:
    """A converged solution with one more wall and what it gains in log evidence."""

    solution: Solution
    gain: float


@dataclass(frozen=True)
class WallSearch:
    """The result of a search.

    Attributes
    ----------
    tried
        Converged solutions with one more wall, the best first.
    foretold
        Linearised gains of the grid's places at the last look; empty before.
    """

    tried: tuple[WallTrial, ...] = ()
    foretold: FloatArray = field(default_factory=lambda: np.zeros(0))

    @property
    def gain(self) -> float:
        """The gain of the best wall; the predicted one if none was tried."""
        return self.tried[0].gain if self.tried else float(self.foretold.max(initial=-np.inf))

    def with_more(self, trials: Sequence[Solution | None], without: float) -> WallSearch:
        """Return the search with more that were tried, gains counted from the ln E without the wall."""
        more = [WallTrial(trial, log_evidence(trial) - without) for trial in trials if trial is not None]
        return replace(self, tried=tuple(sorted([*self.tried, *more], key=lambda one: -one.gain)))


def search_wall(
    solution: Solution,
    normal: FloatArray,
    round_done: Callable[[], None],
    *,
    thorough: bool,
    settings: WallSettings = WALLS,
) -> WallSearch:
    """Search one more wall over azimuth and distance.

    Every wall of a grid gets its linearised evidence with everything else marginalised; the best few are converged,
    because the linearised ranking is not reliable. The search is repeated with the best wall taken out again, as long
    as that gains: a motion bent by a wall that is not in the model hides where the wall stands.

    Parameters
    ----------
    solution
        The model without the wall, converged.
    normal
        Upward normal of the floor, shape (3,).
    round_done
        Called once a round; may raise to cancel.
    thorough
        False: converge fewer, and stop after the coarse search unless it finds something.
    settings
        Grid and limits.
    """
    search = _search_from(solution, normal, round_done, thorough, settings)
    if not search.tried or not bent_by_maps(search.tried[0].solution):
        return search
    # a level motion that maps have bent hides every wall: where the best leaves them loose, from stiff ones too
    again = _search_from(with_stiff_maps(solution), normal, round_done, thorough, settings)
    without = log_evidence(search.tried[0].solution) - search.gain
    return search.with_more([one.solution for one in again.tried], without)


def bent_by_maps(solution: Solution) -> bool:
    """Return whether bias maps are looser than maps with nothing left to explain, and no flight holds the motion."""
    return bool(bias_deviations(solution).max() > WALLS.stiff_bias) and not solution.problem.in_flight.any()


def with_stiff_maps(solution: Solution) -> Solution:
    """Return the minimum with maps as stiff as if nothing were left to explain: of a motion that they do not bend."""
    return minimise(Start(stiffened(solution.problem), solution.state), WALLS.stiff_steps)


def _search_from(
    solution: Solution,
    normal: FloatArray,
    round_done: Callable[[], None],
    thorough: bool,
    settings: WallSettings,
) -> WallSearch:
    # distances count from the middle of the motion: there a wall's detour turns as the search believes
    mirrors, middle = solution.problem.inputs.planes, positions_at_bins(solution).mean(axis=1)
    azimuth, distance = wall_grid(settings)
    base, search, before, without, likeliest = solution, WallSearch(), -np.inf, -np.inf, -np.inf
    for number in range(settings.searches):
        planes = upright_planes(middle, normal, azimuth, distance, settings)
        gains = linearised_gains(base, planes, round_done, settings)
        search, likeliest = replace(search, foretold=gains), max(likeliest, float(gains.max()))
        # where no wall stands, none has gained so much more than was foretold
        if likeliest < -settings.convincing:
            return search
        most = settings.carried if thorough and number == 0 else settings.carried_again
        # maxima, not the best places: neighbours of one maximum converge to the same wall
        numbers = peaks(gains.reshape(azimuth.size, -1), around=True)[: settings.tried]
        starts = best_started([problem_with_mirrors(base, (*mirrors, planes[k])) for k in numbers], most, round_done)
        trials = race(starts, settings.rounds, round_done, settings.max_behind)
        if number == 0:
            # evidence moves while priors are re-estimated: the model without the wall goes through the same rounds, and
            # not in the race, in which its bias maps would lead at first
            bare = converge(problem_with_mirrors(solution, mirrors), settings.rounds, round_done)
            without = log_evidence(bare)
        search = search.with_more(trials, without)
        promising = -settings.convincing if thorough else settings.promising
        # what is kept looks around again as it walks; what no place of the grid shows hides behind no motion
        if search.gain > settings.beyond_doubt or max(likeliest, search.gain) < -settings.worthwhile:
            return search
        if search.gain < max(before + settings.worthwhile, promising):
            break
        before, best = search.gain, search.tried[0].solution
        # what the wall has straightened stays straight: from there its place shows better than from the bent motion
        base = without_last_mirror(best, solution.problem)
    return _run_off(search, round_done, settings)


def _run_off(search: WallSearch, round_done: Callable[[], None], settings: WallSettings) -> WallSearch:
    """Return a search whose nearly equal best have gone on: after a few rounds they are not yet what they will be."""
    level = [one for one in search.tried if one.gain > search.gain - settings.level]
    if len(level) < 2:
        return search
    without = log_evidence(level[0].solution) - level[0].gain
    starts = [Start(one.solution.problem, one.solution.state) for one in level]
    trials = race(starts, settings.last_rounds, round_done, settings.max_behind)
    return replace(search, tried=search.tried[len(level) :]).with_more(trials, without)


def without_last_mirror(solution: Solution, problem: JointProblem) -> Solution:
    """Return a solution's state in the problem that lacks its last mirror: not a minimum, a place to search from."""
    place, there = carried_places(problem.layout, solution.problem.layout)
    # with the bias maps of a problem without the wall: those of the other have shrunk
    theta = np.zeros(problem.layout.size)
    theta[place] = solution.state.theta[there]
    bare = replace(problem, spline=solution.problem.spline)
    return solved_at(Start(bare, State(solution.state.coefficients, theta)))


def place_of_last(solution: Solution, middle_m: FloatArray, normal: FloatArray) -> tuple[float, float]:
    """Return azimuth (rad) and distance (m) of a solution's last mirror from a point, (3,), for the floor's normal."""
    return wall_towards(last_image(solution, middle_m) - middle_m, normal)


def peaks(table: FloatArray, *, around: bool) -> list[int]:
    """Return the flat indices of the local maxima, the highest first.

    Parameters
    ----------
    table
        Shape (n_azimuths, n_distances).
    around
        Whether the azimuths go round.
    """
    across = maximum_filter1d(table, 3, axis=0, mode="wrap" if around else "nearest")
    highest = np.maximum(across, maximum_filter1d(table, 3, axis=1, mode="nearest"))
    top, gain = ((table == highest) & np.isfinite(table)).ravel(), table.ravel()
    return [int(k) for k in np.argsort(np.where(top, gain, -np.inf))[::-1] if top[k]]
