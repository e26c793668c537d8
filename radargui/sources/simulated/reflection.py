"""Reflectors: the container's bottom, and the antennas seen in it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from radargui.geometry.antennas import Antennas
from radargui.geometry.reflectors import mirror
from radargui.model.arrays import FloatArray
from radargui.model.errors import SetupError
from radargui.model.setup import Setup
from radargui.sources.simulated.floor import contact_plane
from radargui.sources.simulated.seeds import Stream, generator
from radargui.sources.simulated.waves import Antenna, Lobe, Waves, aimed_antenna


@dataclass(frozen=True, slots=True)
class Reflector:
    """A plane n.x = d that reflects waves.

    Attributes
    ----------
    normal
        Unit vector, shape (3,).
    distance_m
        d.
    coefficient
        Complex reflection coefficient.
    """

    normal: FloatArray
    distance_m: float
    coefficient: complex


def bottom_reflector(setup: Setup) -> Reflector:
    """Return the container's bottom: one radius of the sphere below its centre at the impact.

    The coefficient's magnitude is the size of `reflection`, its phase is drawn from the seed.

    Raises
    ------
    SetupError
        There is no floor below the release.
    """
    plane = contact_plane(setup)
    phase = generator(setup.simulation.seed, Stream.REFLECTION).uniform(0.0, 2.0 * np.pi)
    distance = plane.distance_m - 0.5 * setup.tracer.diameter_m
    if setup.simulation.scene == "bed":
        distance -= setup.simulation.bed_depth_m
    return Reflector(plane.normal, distance, complex(setup.simulation.size("reflection") * np.exp(1j * phase)))


def reflectors_of(setup: Setup) -> tuple[Reflector, ...]:
    """Return all reflectors of the scene: the bottom, where it reflects at all."""
    return (bottom_reflector(setup),) if setup.simulation.size("reflection") > 0.0 else ()


def mirrored(antenna: Antenna, reflector: Reflector) -> Antenna:
    """Return the image of an antenna: place and lobe mirrored.

    Raises
    ------
    SetupError
        The antenna stands behind the reflector.
    """
    if antenna.place_m @ reflector.normal <= reflector.distance_m:
        place = ", ".join(f"{part:.3g}" for part in antenna.place_m)
        raise SetupError(
            f"An antenna at ({place}) m stands below the bottom that reflects in the simulation",
            remedy="Correct the antenna's tilt and distance or the floor, or set simulation.reflection = 0.",
        )
    return replace(
        antenna,
        place_m=mirror(antenna.place_m, reflector.normal, reflector.distance_m),
        axis=mirror(antenna.axis, reflector.normal, 0.0),
        coefficient=reflector.coefficient,
    )


def make_waves(setup: Setup, antennas: Antennas) -> Waves:
    """Return the waves of a setup, reflections included; amplitude 1 at the release.

    Raises
    ------
    SetupError
        An antenna stands behind a reflector.
    """
    lobe = Lobe.of_beamwidth(setup.simulation.beamwidth_deg)
    reflectors = reflectors_of(setup)

    def with_images(place_m: FloatArray) -> tuple[Antenna, ...]:
        antenna = aimed_antenna(place_m, lobe)
        return (antenna, *(mirrored(antenna, reflector) for reflector in reflectors))

    return Waves(
        with_images(antennas.transmitter_m),
        tuple(with_images(place) for place in antennas.receivers_m),
        setup.radar.wavelength_m,
        np.array(setup.tracer.release_position_m),
    )
