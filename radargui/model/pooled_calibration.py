"""Make a calibration of what the drops of a session say of the antennas."""

import math
from collections.abc import Sequence

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.model.calibrated_setup import value_at
from radargui.model.calibration import Calibration, Origin
from radargui.model.setup import Setup
from radargui.model.setup_pool import RunLikelihood, known_setup
from radargui.model.setup_posterior import unknown_inputs

_STEP = 1e-3
"""Share of an input's u over which the change of a value is taken."""


def pooled_calibration(runs: Sequence[RunLikelihood], setup: Setup, origin: Origin) -> Calibration | None:
    """Return the antennas as runs determine them together; None if none of them says anything of this setup's antennas.

    The release stays as stated, because that of the next drop is another one.

    Parameters
    ----------
    runs
        In the order of their recording; see `known_setup` for which of them count.
    setup
        What states the antennas.
    origin
        Of the calibration.
    """
    pool = known_setup(runs, (), setup)
    if pool is None:
        return None
    inputs, deviation = unknown_inputs(setup)
    names = _names(setup, is_beside=any(one.key.startswith("transmitter.position_m") for one in inputs))
    before = _values(setup, names)
    by_input = np.stack([(_values(one.moved(setup, _STEP), names) - before) / _STEP for one in inputs], axis=1)
    mean, covariance = np.array(pool.mean), by_input @ np.array(pool.covariance) @ by_input.T
    u_before = np.sqrt(((by_input * deviation) ** 2).sum(axis=1))
    known_as_before = bool((np.diag(covariance) > 0.99**2 * u_before**2).any())
    verdict = "usable" if known_as_before else "good"
    reason = f"{', '.join(pool.runs)} together, with what the setup stated."
    return Calibration(names, before, before + by_input @ mean, u_before, covariance, (), (), verdict, reason, origin)


def _names(setup: Setup, *, is_beside: bool) -> tuple[str, ...]:
    receivers = [f"receiver.{n}.{name}" for n in range(1, setup.n_receivers + 1) for name in _ANTENNA]
    is_placed = is_beside or setup.transmitter.position_m is not None
    sender = [f"transmitter.position_m.{axis}" for axis in "xyz"] if is_placed else ["transmitter.distance_m"]
    return (*receivers, *sender)


_ANTENNA = ("tilt_deg", "azimuth_deg", "distance_m")


def _values(setup: Setup, names: Sequence[str]) -> FloatArray:
    place = dict(zip("xyz", setup.transmitter.place_m, strict=True))
    # where the transmitter is stated by its distance, and stands beside its axis all the same
    values = [place[name[-1]] if name.startswith("transmitter.position") else value_at(setup, name) for name in names]
    return np.array([math.nan if one is None else one for one in values])
