"""By how much the antennas of a setup may turn the vertical (method 4, Flight)."""

from __future__ import annotations

import numpy as np

from radargui.geometry.path_length import path_gradient, place_antennas
from radargui.model.arrays import FloatArray
from radargui.model.assumed import CLOCK, TILT, uncertain_inputs
from radargui.model.setup import Setup


def u_vertical_rad(setup: Setup) -> float:
    """Return the standard uncertainty of each horizontal part of a vertical fall, over the fall.

    A fall dz changes the paths by J dz. Antennas that are taken to stand elsewhere make of it J'^-1 J dz at the
    release, which leans. Inputs are independent, as in the budget: their squares add up. Infinite where the sphere
    counts as a point: what it scatters turns a fall, too.
    """
    if setup.transmitter.polarization_deg is None:
        return float("inf")
    down = _gradient(setup)[:, 2]
    square = np.zeros(2)
    for one in uncertain_inputs(setup):
        # the floor and the clock have no part in the paths
        if one.u > 0.0 and one.key not in (TILT, CLOCK):
            turned = np.linalg.lstsq(_gradient(one.moved(setup)), down, rcond=None)[0]
            square += (turned[:2] / turned[2]) ** 2
    return float(np.sqrt(square.mean()))


def _gradient(setup: Setup) -> FloatArray:
    """Return J = dL/dp at the release, shape (n_receivers, 3)."""
    release = np.asarray(setup.tracer.release_position_m)
    return path_gradient(release[:, None], place_antennas(setup))[:, :, 0]
