"""What the setup states as unknowns with a prior: antennas, release, wavelength (method 4, Flights first)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.model.assumed import uncertain_inputs
from radargui.model.setup import Setup
from radargui.physics.path_length import Antennas, antennas_at, receiver_values


@dataclass(frozen=True, slots=True)
class StatedSetup:
    """Values of the setup and the directions in which they are uncertain, each with a standard deviation of one.

    Attributes
    ----------
    keys
        Keys of the setup: the transmitter's place, tilt, azimuth and distance of each receiver, the release, and the
        logarithm of the wavelength.
    stated
        What the setup says, in the units of its keys, shape (n_keys,).
    inputs
        Which uncertain input of the setup each direction is (`UncertainInput.key`).
    directions
        Covariance = directions^T directions, shape (n_directions, n_keys).
    wavelength_m
        As stated.
    """

    keys: tuple[str, ...]
    stated: FloatArray
    inputs: tuple[str, ...]
    directions: FloatArray
    wavelength_m: float

    @property
    def n_receivers(self) -> int:
        """Number of receivers."""
        return (len(self.keys) - 7) // 3

    @property
    def release(self) -> slice:
        """Places of the release."""
        return slice(len(self.keys) - 4, len(self.keys) - 1)

    def antennas(self, values: FloatArray) -> Antennas:
        """Return the antennas of values (n_keys,)."""
        return antennas_at(values[3 : self.release.start].reshape(-1, 3).T, values[:3])

    def wavenumber(self, values: FloatArray) -> float:
        """Return K of values (n_keys,), 1/m."""
        return 2.0 * np.pi / self.wavelength_m * float(np.exp(-values[-1]))

    def receiver_slopes(self, values: FloatArray) -> FloatArray:
        """Return the derivatives of each receiver's place , (n_receivers, 3, 3), by its tilt, azimuth and distance."""
        tilt, azimuth, distance = values[3 : self.release.start].reshape(-1, 3).T
        (st, sa), (ct, ca) = (turned(np.radians([tilt, azimuth])) for turned in (np.sin, np.cos))
        degree = np.pi / 180.0
        by_tilt = degree * distance * np.array([ct * ca, ct * sa, -st])
        by_azimuth = degree * distance * np.array([-st * sa, st * ca, np.zeros_like(st)])
        return np.array([by_tilt, by_azimuth, [st * ca, st * sa, ct]]).T


def setup_unknowns(setup: Setup) -> StatedSetup:
    """Return the unknowns of a setup with the uncertainties that it states, else the assumed ones."""
    receivers = [f"receiver[{n}].{name}" for n in range(1, setup.n_receivers + 1) for name in _OF_A_RECEIVER]
    place = [f"transmitter.position_m[{axis}]" for axis in (1, 2, 3)]
    release = [f"tracer.release_position_m[{axis}]" for axis in (1, 2, 3)]
    keys = (*place, *receivers, *release, _WAVELENGTH)
    stated = [*setup.transmitter.place_m, *receiver_values(setup).T.ravel(), *setup.tracer.release_position_m, 0.0]
    found = {one: row for one, row in _directions(setup, keys) if row.any()}
    directions = np.array([*found.values()]).reshape(-1, len(keys))
    return StatedSetup(keys, np.array(stated), tuple(found), directions, setup.radar.wavelength_m)


_OF_A_RECEIVER = ("tilt_deg", "azimuth_deg", "distance_m")
_WAVELENGTH = "radar.log_wavelength"


def _directions(setup: Setup, keys: tuple[str, ...]) -> Iterator[tuple[str, FloatArray]]:
    for one in uncertain_inputs(setup):
        row = np.zeros(len(keys))
        for key, by in one.together or ((one.key, one.u),):
            if key == "radar.frequency_hz":
                row[-1] -= by / setup.radar.frequency_hz
            elif key == "radar.refractive_index":
                row[-1] -= by
            elif key == "transmitter.distance_m":
                row[2] += by
            elif key in keys:
                row[keys.index(key)] += by
        yield one.key, row
