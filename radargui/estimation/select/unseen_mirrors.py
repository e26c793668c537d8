"""Compute what mirrors that nothing excludes would do to the motion, linearised over all places."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from radargui.estimation.select.wall_grid import TOGETHER, WALLS, LinearisedSearch, upright_planes, wall_grid
from radargui.estimation.select.walls import peaks
from radargui.estimation.solve.changed_problem import positions_at_bins
from radargui.estimation.solve.minimise import Solution
from radargui.estimation.solve.problem import State
from radargui.model.arrays import FloatArray, pieces
from radargui.physics.mirrors import FLOOR, MirrorPlane, has_floor


@dataclass(frozen=True, slots=True)
class UnseenSettings:
    """Which of the possible mirrors count. Chosen by hand.

    Attributes
    ----------
    floor_below_m
        Distances of a possible floor below the lowest place; farther ones are those of walls.
    min_weight
        Least weight of all places together, the same as of an alternative.
    floor_reflection
        Deviation of real and imaginary part of T and R of a floor: tables and plates reflect 0.1 to 0.3.
    places, stand_for
        At most so many of the likeliest places stand for all, fewer if they hold this share of the weight.
    directions
        Number of directions in which they move the motion: in a drop of six fringes three hold 99 %.
    """

    floor_below_m: tuple[float, ...] = (0.01, 0.02, 0.04)
    min_weight: float = 0.01
    floor_reflection: float = 0.15
    places: int = 48
    stand_for: float = 0.98
    directions: int = 3


UNSEEN = UnseenSettings()


def unseen_mirrors(
    solution: Solution,
    normal: FloatArray,
    temper: float,
    foretold: FloatArray | None = None,
    settings: UnseenSettings = UNSEEN,
) -> tuple[list[State], float]:
    """Return the states to which possible mirrors would move the solution, each with its weight.

    If the motion can imitate a mirror, the evidence of that mirror (T and R marginalised) is near one: nothing speaks
    for or against it. A wall beside a mirror, or a floor where there is none, is as likely beforehand as none, each
    place of its grid alike, and its T and R have the posterior N(-A^-1 g, A^-1). The second moments of these movements
    are given as states along their largest directions.

    Parameters
    ----------
    solution
        Converged.
    normal
        Upward normal of the floor, shape (3,).
    temper
        Log evidence counts divided by this.
    foretold
        Predicted gains of the grid's walls if none was tried, because none would convince. Each of the highest maxima
        is then beforehand as likely as no wall, like those that are tried elsewhere.
    settings
        How many count.
    """
    here, place_m, grid = solution.problem.inputs.planes, positions_at_bins(solution), wall_grid()
    trials: list[tuple[LinearisedSearch, list[MirrorPlane]]] = []
    weights: list[FloatArray] = []

    def weigh(search: LinearisedSearch, planes: list[MirrorPlane], gains: FloatArray | None = None) -> None:
        prior = np.full(len(planes), 1.0 / len(planes))
        if gains is None:
            gains = np.concatenate([search.gains(planes[part]) for part in pieces(len(planes), TOGETHER)])
        else:
            prior[peaks(gains.reshape(grid[0].size, -1), around=True)[: WALLS.carried]] = 1.0
        weights.append(prior * np.exp(np.minimum(gains, 0.0) / temper))
        trials.append((search, planes))

    if here:
        weigh(LinearisedSearch(solution, WALLS), upright_planes(place_m.mean(axis=1), normal, *grid), foretold)
    if not has_floor(here):
        lowest = place_m[:, np.argmin(normal @ place_m)]
        below = [MirrorPlane(lowest - away * normal, normal, FLOOR) for away in (*settings.floor_below_m, *grid[1])]
        # the maps as they are: stiff ones would lend a floor what they hold, and one that was compared seems likely
        as_they_are = replace(
            WALLS, reflection=settings.floor_reflection, stiff_bias=np.inf, stiff_log_amplitude=np.inf
        )
        weigh(LinearisedSearch(solution, as_they_are), below)
    weight = np.concatenate(weights)
    if weight.sum() < settings.min_weight:
        return [], 0.0
    # what is far less likely moves the second moments by nothing
    likeliest = np.argsort(-weight)[: settings.places]
    n_likely = int(np.searchsorted(np.cumsum(weight[likeliest]), settings.stand_for * weight.sum())) + 1
    # exactly so many: where all gains are above zero all weigh alike
    share = np.zeros(weight.size)
    share[likeliest[:n_likely]] = weight[likeliest[:n_likely]] / weight[likeliest[:n_likely]].sum()
    shares = np.split(share, np.cumsum([one.size for one in weights])[:-1])
    moved = np.hstack([_moved(*one, own) for one, own in zip(trials, shares, strict=True) if own.any()])
    n_motion = trials[0][0].n_motion
    # largest in what they do to the places: coefficients and reflections have no unit in common
    at_bins = np.concatenate([solution.at.design @ moved[axis:n_motion:3] for axis in range(3)])
    _, vectors = np.linalg.eigh(at_bins.T @ at_bins)
    # as many solutions of one weight: each stands so much farther away
    directions = np.sqrt(settings.directions) * (moved @ vectors[:, -settings.directions :])
    state = solution.state
    states = [
        State(state.coefficients + one[:n_motion].reshape(-1, 3), state.theta + one[n_motion:]) for one in directions.T
    ]
    return states, float(weight.sum()) / settings.directions


def _moved(search: LinearisedSearch, planes: list[MirrorPlane], share: FloatArray) -> FloatArray:
    """Return what the mean of T and R, and each of their standard deviations, moves, (n_motion + n_global, n).

    One column for each place with a share, multiplied by the root of that share.
    """
    places = np.flatnonzero(share)
    slope, a, half = search.marginal([planes[k] for k in places])
    both = -search.normal.back_solve(half)
    root = np.linalg.inv(np.linalg.cholesky(a))
    spread = root.transpose(0, 2, 1)
    values = np.concatenate([-spread @ (root @ slope[:, :, None]), spread], axis=2)
    values *= np.sqrt(share[places])[:, None, None]
    out = both.reshape(len(both), places.size, -1).swapaxes(0, 1) @ values
    return np.asarray(out.swapaxes(0, 1).reshape(len(both), -1))
