"""Reflectors: the container's bottom and walls, and the antennas seen in them."""

from dataclasses import dataclass, replace

import numpy as np

from radargui.geometry.antennas import Antennas
from radargui.geometry.reflectors import mirror
from radargui.model.arrays import FloatArray
from radargui.model.errors import SetupError
from radargui.model.polarization import received_direction, transmitted_direction
from radargui.model.scattering import conducting_sphere
from radargui.model.setup import Setup
from radargui.sources.simulated.floor import contact_plane
from radargui.sources.simulated.seeds import Draw, generator
from radargui.sources.simulated.trajectory import azimuth_direction
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
        Complex reflection coefficient; of a wall, its magnitude.
    wall
        Number of the wall from 0; None for the bottom.
    """

    normal: FloatArray
    distance_m: float
    coefficient: complex
    wall: int | None = None

    def height_m(self, place_m: FloatArray) -> FloatArray:
        """Return how far places (3, ...) lie in front of it, shape (...)."""
        return np.tensordot(self.normal, place_m, axes=1) - self.distance_m


def bottom_reflector(setup: Setup) -> Reflector:
    """Return the container's bottom: one radius of the sphere below its centre at the impact.

    The coefficient's magnitude is the size of `reflection`, its phase is drawn from the seed.

    Raises
    ------
    SetupError
        There is no floor below the release.
    """
    plane = contact_plane(setup)
    phase = generator(setup.simulation.seed, Draw.REFLECTION).uniform(0.0, 2.0 * np.pi)
    distance = plane.distance_m - 0.5 * setup.tracer.diameter_m
    if setup.simulation.scene == "bed":
        distance -= setup.simulation.bed_depth_m
    return Reflector(plane.normal, distance, complex(setup.simulation.size("reflection") * np.exp(1j * phase)))


def wall_reflectors(setup: Setup) -> tuple[Reflector, ...]:
    """Return the upright walls round the z axis, where they reflect at all."""
    simulation = setup.simulation
    if simulation.wall_reflection == 0.0:
        return ()
    return tuple(
        Reflector(-azimuth_direction(azimuth_deg), -distance_m, simulation.wall_reflection, wall)
        for wall, (distance_m, azimuth_deg) in enumerate(
            zip(simulation.wall_distance_m, simulation.wall_azimuth_deg, strict=True)
        )
    )


def reflectors_of(setup: Setup) -> tuple[Reflector, ...]:
    """Return all reflectors of the scene: the bottom and the walls, where they reflect at all."""
    bottom = (bottom_reflector(setup),) if setup.simulation.size("reflection") > 0.0 else ()
    return (*bottom, *wall_reflectors(setup))


def mirrored(antenna: Antenna, reflector: Reflector, coefficient: complex) -> Antenna:
    """Return the image of an antenna: place, lobe and field mirrored."""
    return replace(
        antenna,
        place_m=mirror(antenna.place_m, reflector.normal, reflector.distance_m),
        axis=mirror(antenna.axis, reflector.normal, 0.0),
        field=None if antenna.field is None else mirror(antenna.field, reflector.normal, 0.0),
        coefficient=coefficient,
    )


def image_in_bottom(antenna: Antenna, bottom: Reflector) -> Antenna:
    """Return the image of an antenna in the container's bottom: one coefficient for all antennas.

    Raises
    ------
    SetupError
        The antenna stands behind the reflector.
    """
    if bottom.height_m(antenna.place_m) <= 0.0:
        place = ", ".join(f"{part:.3g}" for part in antenna.place_m)
        raise SetupError(
            f"An antenna at ({place}) m stands below the bottom that reflects in the simulation",
            remedy="Correct the antenna's tilt and distance or the floor, or set simulation.reflection = 0.",
        )
    return mirrored(antenna, bottom, bottom.coefficient)


def image_in_wall(antenna: Antenna, wall: Reflector, phase_rad: float, reference_m: FloatArray) -> Antenna | None:
    """Return the image of an antenna in a wall, or None where the antenna stands beyond the wall.

    Its coefficient makes up for the lobes at the reference, so that there the image over the antenna itself is
    coefficient r / r', as the direct path's 1 / r and the mirrored path's 1 / r' have it.
    """
    if wall.height_m(antenna.place_m) <= 0.0:
        return None
    image = mirrored(antenna, wall, 1.0)
    place = reference_m[:, None]
    lobes = float(antenna.gain(place)[0] / image.gain(place)[0])
    return replace(image, coefficient=complex(wall.coefficient * lobes * np.exp(1j * phase_rad)))


def make_waves(setup: Setup, antennas: Antennas) -> Waves:
    """Return the waves of a setup, reflections included; amplitude 1 at the release.

    Every antenna is seen once in every reflector. What goes over two reflectors on its way to the tracer is left out,
    of the order of the product of their coefficients.

    Raises
    ------
    SetupError
        An antenna stands below the bottom.
    """
    lobe = Lobe.of_beamwidth(setup.simulation.beamwidth_deg)
    reference = np.array(setup.tracer.release_position_m)
    reflectors = reflectors_of(setup)

    metal = setup.simulation.is_metal(polarized=setup.transmitter.polarization_deg is not None)
    fields: tuple[FloatArray | None, ...] = (None,) * (1 + antennas.n_receivers)
    if metal:
        got = [received_direction(one.angle_deg, one.horizontal, one.vertical) for one in setup.received_fields()]
        fields = (transmitted_direction(setup.transmitter.polarization_deg or 0.0), *got)

    def with_images(number: int, place_m: FloatArray) -> tuple[Antenna, ...]:
        antenna = aimed_antenna(place_m, lobe, fields[number])
        images: list[Antenna | None] = []
        for reflector in reflectors:
            if reflector.wall is None:
                images.append(image_in_bottom(antenna, reflector))
            else:
                draw = generator(setup.simulation.seed, Draw.WALL, reflector.wall, number)
                images.append(image_in_wall(antenna, reflector, draw.uniform(0.0, 2.0 * np.pi), reference))
        return (antenna, *(image for image in images if image is not None))

    return Waves(
        with_images(0, antennas.transmitter_m),
        tuple(with_images(number, place) for number, place in enumerate(antennas.receivers_m, start=1)),
        setup.radar.wavelength_m,
        reference,
        conducting_sphere(0.5 * setup.tracer.diameter_m, setup.radar.wavelength_m) if metal else None,
    )
