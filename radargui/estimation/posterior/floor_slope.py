"""Read the slope of the reflecting floor from the estimate's mirror."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from radargui.estimation.solve.minimise import Solution
from radargui.model.arrays import FloatArray
from radargui.physics.mirrors import FLOOR


@dataclass(frozen=True, slots=True)
class FloorSlope:
    """How the floor that reflects leans.

    Attributes
    ----------
    slope
        (n_x, n_y) / n_z of its normal n, shape (2,).
    covariance
        Posterior, shape (2, 2).
    by_global
        Derivatives by the unknowns at `places`, shape (2, 2).
    places
        Of its tilts among the global parameters.
    """

    slope: FloatArray
    covariance: FloatArray
    by_global: FloatArray
    places: slice


def floor_slope(solution: Solution) -> FloorSlope | None:
    """Return the slope of a solution's floor, None where it has none."""
    problem = solution.problem
    unknowns = problem.layout.plane_unknowns(solution.state.theta)
    for number, (plane, unknown) in enumerate(zip(problem.inputs.planes, unknowns, strict=True)):
        if plane.name == FLOOR:
            first = problem.layout.planes.start + 3 * number
            # a shift along the normal leans nothing: of three unknowns two count
            places = slice(first, first + 2)
            slope, by_tilts = plane.lean(unknown)
            covariance = by_tilts @ solution.normal.global_covariance[places, places] @ by_tilts.T
            return FloorSlope(slope, np.asarray(covariance), by_tilts, places)
    return None
