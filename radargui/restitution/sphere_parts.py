"""What the sphere may add to path lengths where its size and the polarisations are known within their u (method 6)."""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations_with_replacement

import numpy as np

from radargui.geometry.scattering import scattering_delay_m, supposed_delays_m
from radargui.model.arrays import FloatArray
from radargui.model.assumed import DIAMETER, uncertain_inputs
from radargui.model.setup import Setup

FIELD_POINTS, LEAST_OF_FIELD = 200, 1e-6
"""Places at which a smooth field of place is computed; share of the strongest below which no direction is visited."""
LEAST_PART = 1e-2
"""Share of the largest part below which a part of paths is none: independent parts are fewer than polarisations."""
LEAST_M = 1e-12
"""In place of the reach of a coordinate that stays the same, so that nothing is divided by zero."""


def sphere_parts_m(position_m: FloatArray, setup: Setup) -> FloatArray:
    """Return what the sphere may add to the paths, in independent parts, each of one standard uncertainty.

    By its diameter and the polarisations where they are stated, else that of a few polarisations, of which none is
    likelier: their mean square counts.

    Parameters
    ----------
    position_m
        Places (3, n), NaN where unknown.
    setup
        Sphere, antennas, polarisations.

    Returns
    -------
    FloatArray
        Metres, shape (n_parts, n_receivers, n), 0 where the place is unknown.
    """
    if setup.transmitter.polarization_deg is None:
        parts = smooth_in_place(position_m, lambda place_m: supposed_delays_m(place_m, setup))
        parts = parts / np.sqrt(len(parts))
    else:
        here, inputs = scattering_delay_m(position_m, setup), uncertain_inputs(setup)
        others = [one.moved(setup) for one in inputs if one.u > 0.0 and _is_of_sphere(one.key)]
        parts = np.array([scattering_delay_m(position_m, other) - here for other in others]).reshape(-1, *here.shape)
    flat = np.nan_to_num(parts).reshape(len(parts), position_m.shape[1] * setup.n_receivers)
    if not flat.any():
        return np.zeros((0, setup.n_receivers, position_m.shape[1]))
    # numbers of deviation one turned among themselves are such numbers again
    sizes, turned = np.linalg.eigh(flat @ flat.T)
    large = sizes > LEAST_PART**2 * sizes[-1]
    return np.asarray((turned[:, large].T @ flat).reshape(-1, setup.n_receivers, position_m.shape[1]))


def _is_of_sphere(key: str) -> bool:
    return key == DIAMETER or key.endswith("polarization_deg")


def smooth_in_place(position_m: FloatArray, field: Callable[[FloatArray], FloatArray]) -> FloatArray:
    """Return a smooth field of place (..., n) at places (3, n), computed at few of them.

    Between these a polynomial of third degree: the phase of a sphere's echo changes by fractions of a millimetre over
    the whole motion. NaN where the place is.
    """
    known = np.flatnonzero(np.isfinite(position_m).all(axis=0))
    if known.size <= FIELD_POINTS:
        return field(position_m)
    few = position_m[:, known[:: known.size // FIELD_POINTS]]
    centre = few.mean(axis=1, keepdims=True)
    unit = np.maximum(np.ptp(few, axis=1, keepdims=True), LEAST_M)
    there = field(few)
    columns, *_ = np.linalg.lstsq(
        _cubic((few - centre) / unit).T, there.reshape(-1, few.shape[1]).T, rcond=LEAST_OF_FIELD
    )
    out = columns.T @ _cubic((position_m - centre) / unit)
    return np.asarray(out.reshape(*there.shape[:-1], -1))


def _cubic(place: FloatArray) -> FloatArray:
    """Return the twenty products of up to three coordinates of places (3, n), shape (20, n)."""
    x = np.concatenate([np.ones((1, place.shape[1])), place])
    return np.stack([x[a] * x[b] * x[c] for a, b, c in combinations_with_replacement(range(4), 3)])
