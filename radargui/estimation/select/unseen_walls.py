"""What walls that the samples do not exclude would make of the motion, linearised over all places (method 4, Walls)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_triangular

from radargui.estimation.forward.mirrors import MirrorPlane
from radargui.estimation.select.wall_grid import WALLS, LinearisedSearch, upright_planes, wall_grid
from radargui.estimation.solve.changed_problem import positions_at_bins
from radargui.estimation.solve.minimise import Solution
from radargui.estimation.solve.problem import State
from radargui.model.arrays import FloatArray, pieces


@dataclass(frozen=True, slots=True)
class UnseenSettings:
    """How many of the possible walls count. Chosen by hand.

    Attributes
    ----------
    least_weight
        Less than this, all places together, is nothing: the same as of an alternative.
    places
        The likeliest so many stand for all; of 320 they hold most of the weight, or none is likely.
    directions
        In which they move the motion: in a drop of six fringes three hold 99 %.
    """

    least_weight: float = 0.01
    places: int = 48
    directions: int = 3


UNSEEN = UnseenSettings()


def unseen_walls(
    solution: Solution, normal: FloatArray, temper: float, settings: UnseenSettings = UNSEEN
) -> tuple[list[State], float]:
    """Return the state moved as walls that may be there would move it, and the weight of each against the solution.

    The evidence of one more wall, its reflections T and R marginalised, is near one where the motion can make what it
    would: nothing speaks for such a wall, nothing against it. It is as likely beforehand as none, each place of the
    grid alike, and its T and R have the posterior N(-A^-1 g, A^-1). Second moments of what they move, largest
    directions first, are given as that many states.

    Parameters
    ----------
    solution
        Converged.
    normal
        Upward normal of the floor, shape (3,).
    temper
        Log evidence counts divided by this.
    settings
        How many count.
    """
    search, middle = LinearisedSearch(solution, WALLS), positions_at_bins(solution).mean(axis=1)
    planes = upright_planes(middle, normal, *wall_grid())
    gains = np.concatenate([search.gains(planes[part]) for part in pieces(len(planes), search.together)])
    weight = np.exp(np.minimum(gains, 0.0) / temper) / len(planes)
    if weight.sum() < settings.least_weight:
        return [], 0.0
    likeliest = np.argsort(-weight)[: min(settings.places, np.count_nonzero(weight))]
    share = weight[likeliest] / weight[likeliest].sum()
    moved = np.hstack([np.sqrt(own) * _moved(search, planes[k]) for own, k in zip(share, likeliest, strict=True)])
    n_motion = search.n_motion
    at_bins = np.concatenate([solution.at.design @ moved[axis:n_motion:3] for axis in range(3)])
    _, vectors = np.linalg.eigh(at_bins.T @ at_bins)
    # as many solutions of one weight: each stands so much farther away
    directions = np.sqrt(settings.directions) * (moved @ vectors[:, -settings.directions :])
    state = solution.state
    states = [
        State(state.coefficients + one[:n_motion].reshape(-1, 3), state.theta + one[n_motion:]) for one in directions.T
    ]
    return states, float(weight.sum()) / settings.directions


def _moved(search: LinearisedSearch, plane: MirrorPlane) -> FloatArray:
    """Return what the mean of T and R, and each of their standard deviations, moves, (n_motion + n_global, 1 + n)."""
    slope, a, half, lower = search.marginal([plane])
    normal = search.normal
    by_global = -solve_triangular(normal.schur[0], lower, lower=True, trans="T", check_finite=False)
    by_motion = -normal.motion.back_solve(half + normal.half @ by_global)
    root = np.linalg.inv(np.linalg.cholesky(a[0]))
    values = np.column_stack([-root.T @ (root @ slope[0]), root.T])
    return np.asarray(np.concatenate([by_motion, by_global]) @ values)
