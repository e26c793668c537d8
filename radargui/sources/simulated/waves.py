"""Simulate spherical waves from transmitter to tracer to receiver, and their images in floor and walls."""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass, replace

import numpy as np

from radargui.model import scattering
from radargui.model.arrays import ComplexArray, FloatArray
from radargui.model.errors import SetupError, worded
from radargui.model.radar import Walls
from radargui.model.setup import Setup
from radargui.physics.edges import Rectangle, StatedEdges
from radargui.physics.path_length import Antennas, mirror
from radargui.physics.plate import Plate
from radargui.physics.scattering import wall_factor
from radargui.sources.simulated.exchange import Exchange, ExchangeTable
from radargui.sources.simulated.noise import Draw, generator
from radargui.sources.simulated.scene import Plane, azimuth_direction, contact_plane


def dot(first: FloatArray, second: FloatArray) -> FloatArray:
    """Return the dot products of vectors along axis 0, shape (3, n) each (or (3, 1))."""
    return np.asarray(first[0] * second[0] + first[1] * second[1] + first[2] * second[2])


def phasor(phase_rad: FloatArray, amplitude: FloatArray | float = 1.0) -> ComplexArray:
    """Return amplitude exp(j phase), shape (n,); real sine and cosine are much faster than the complex exponential."""
    out = np.empty(phase_rad.shape, dtype=np.complex128)
    np.multiply(np.cos(phase_rad), amplitude, out=out.real)
    np.multiply(np.sin(phase_rad), amplitude, out=out.imag)
    return out


SIDE_LOBE = 0.1
"""Field far off the axis against that on it: -20 dB. Chosen by hand."""
_HALF_POWER = np.sqrt(0.5)  # as an amplitude


@dataclass(frozen=True, slots=True)
class Lobe:
    """Pattern of an antenna, as amplitude against the angle from its axis.

    gain = s + (1 - s) exp(-k sin^2(angle / 2)): for small angles a Gaussian, half power (amplitude 0.71) at half
    the beam width, and never below s = 0.1 (-20 dB, where a real horn's side lobes begin), so that a sphere that
    leaves the main lobe is heard weakly instead of not at all.
    """

    falloff: float

    @classmethod
    def of_beamwidth(cls, beamwidth_deg: float) -> Lobe:
        """Return the lobe with this full width at half power."""
        level = np.log((1.0 - SIDE_LOBE) / (_HALF_POWER - SIDE_LOBE))
        return cls(float(level / np.sin(np.radians(beamwidth_deg) / 4.0) ** 2))

    def gain(self, cosine: FloatArray) -> FloatArray:
        """Return the amplitude gain at the cosine of an angle: sin^2(angle / 2) = (1 - cosine) / 2."""
        return np.asarray(SIDE_LOBE + (1.0 - SIDE_LOBE) * np.exp(0.5 * self.falloff * (cosine - 1.0)))


@dataclass(frozen=True, slots=True)
class Antenna:
    """An antenna, real or mirrored.

    Attributes
    ----------
    place_m
        Shape (3,).
    axis
        Unit vector of its lobe, shape (3,).
    lobe
        Its pattern.
    coefficient
        1 for the real one, the reflection coefficient for a mirrored one: beside the direct path the mirrored one of
        length r' has the amplitude |coefficient| (r / r') (ratio of the lobes' gains).
    field
        Direction of the electric field that it sends or answers to, shape (3,); mirrored like a vector, the change of
        sign stays in `coefficient`. Only a sphere with a size asks for it.
    walls
        Of a container in its rays; None of an image.
    mirror
        Of an image in the bottom: the bottom.
    """

    place_m: FloatArray
    axis: FloatArray
    lobe: Lobe
    coefficient: complex = 1.0
    field: FloatArray | None = None
    walls: Walls | None = None
    mirror: Reflector | None = None

    @property
    def fields(self) -> tuple[FloatArray, ...]:
        """Directions of the fields (3,) that `over_plate` gives shares of: its own, over a dielectric the normal."""
        if self.field is None:
            return ()
        if self.mirror is None or self.mirror.plate is None or self.mirror.plate.index is None:
            return (self.field,)
        return self.field, self.mirror.normal

    def gain(self, position_m: FloatArray) -> FloatArray:
        """Return the gain of its lobe towards positions (3, n), shape (n,)."""
        away = position_m - self.place_m[:, None]
        return self.lobe.gain(dot(self.axis[:, None], away) / np.sqrt(dot(away, away)))

    def wave(self, position_m: FloatArray, wavelength_m: float) -> ComplexArray:
        """Return coefficient gain exp(j 2 pi r / wavelength) / r at positions (3, n), shape (n,)."""
        away = position_m - self.place_m[:, None]
        distance = np.sqrt(dot(away, away))
        # a spherical wave: its field falls as 1 / r
        amplitude = self.lobe.gain(dot(self.axis[:, None], away) / distance) / distance
        wavenumber = 2.0 * np.pi / wavelength_m
        wave = phasor(wavenumber * distance, amplitude)
        if self.walls is not None:
            wave = wave * wall_factor(position_m, self.place_m, self.walls, wavenumber)
        if self.mirror is not None and self.mirror.edges is not None:
            wave = wave * self.mirror.within_edges(position_m, self.place_m, self.field, wavenumber)
        return wave if self.coefficient == 1.0 else self.coefficient * wave

    def over_plate(
        self, position_m: FloatArray, wavelength_m: float
    ) -> tuple[ComplexArray | float, tuple[ComplexArray | float, ...]]:
        """Return by what a point at positions (3, n) is lit, and the share of each of `fields`.

        Of all but the image in a plate that is 1.
        """
        if self.mirror is None or self.mirror.plate is None:
            return 1.0, () if self.field is None else (1.0,)
        plate, normal = self.mirror.plate, self.mirror.normal
        wavenumber = 2.0 * np.pi / wavelength_m
        direction = scattering.unit_vectors(position_m - self.place_m[:, None])
        if self.field is None:
            # a point tells no polarisations apart
            electric, magnetic = plate.coefficients(np.abs(normal @ direction), wavenumber)
            return 0.5 * (electric + magnetic), ()
        share, of_normal = plate.parts(direction, normal, self.field[None], wavenumber)
        straight = plate.straight_down(wavenumber)
        return 1.0, (straight * share, straight * of_normal[0])[: len(self.fields)]


N_WAYS = 2
"""Between an antenna and the sphere that counts for the exchange: the direct one, and that over the floor."""


class SceneWaves:
    """Complex signal of each receiver for a tracer anywhere, before mixer and converter.

    Z_i = a (sum of waves of the transmitter and its images) (sum of waves of receiver i and its images): by image
    theory the product holds the direct path, one reflection on either leg, and one on both (coefficient squared). A
    metal sphere gives each of these pairs a factor of its own, f = e_b . E(image a -> sphere -> image b) (Mie). What it
    exchanges with a floor that the setup states adds to f, on the direct ways and those over the floor.

    Parameters
    ----------
    transmitters
        The transmitter and its images.
    receivers
        For each receiver: itself and its images.
    wavelength_m
        Wavelength.
    reference_m
        Where the direct path has the amplitude 1, shape (3,).
    sphere
        The sphere; None: a point, f = 1.
    exchange
        Between sphere and floor; None: nothing.
    """

    def __init__(
        self,
        transmitters: tuple[Antenna, ...],
        receivers: tuple[tuple[Antenna, ...], ...],
        wavelength_m: float,
        reference_m: FloatArray,
        sphere: scattering.MieSphere | None = None,
        exchange: Exchange | None = None,
    ) -> None:
        self._transmitters = transmitters
        self._receivers = receivers
        self._wavelength_m = wavelength_m
        self._sphere = sphere
        self.exchange: Exchange | ExchangeTable | None = None
        place = reference_m[:, None]
        direct, n = [transmitters[0].wave(place, wavelength_m)], len(receivers)
        # the direct path alone is amplitude 1 at the reference: reflections are a ripple about it
        self._scale = [1.0] * n
        self._scale = [float(1.0 / abs(self.received(number, place, direct, 1)[0])) for number in range(n)]
        self.exchange = exchange

    def along(self, place_m: FloatArray) -> SceneWaves:
        """Return them for a sphere that stays among places (3, n): what it exchanges with the floor is looked up."""
        if not isinstance(self.exchange, Exchange):
            return self
        out = copy(self)
        out.exchange = ExchangeTable(self.exchange, place_m)
        return out

    def at_tracer(self, position_m: FloatArray) -> list[ComplexArray]:
        """Return the waves of the transmitter and of its images at positions (3, n), shape (n,) each."""
        return [antenna.wave(position_m, self._wavelength_m) for antenna in self._transmitters]

    def received(
        self, receiver: int, position_m: FloatArray, at_tracer: list[ComplexArray], n_images: int | None = None
    ) -> ComplexArray:
        """Return the signal of a receiver, shape (n,), from the waves at the tracer; amplitude 1 at the reference.

        Of all pairs of images, of the transmitter's those whose waves are given, of the receiver's the first
        `n_images`, itself among them; None: all.
        """
        total: ComplexArray | float = 0.0
        sources = [
            (source, one, *source.over_plate(position_m, self._wavelength_m))
            for source, one in zip(self._transmitters, at_tracer, strict=False)
        ]
        exchanged = None if self.exchange is None else self.exchange.received(receiver, position_m)
        for way_out, antenna in enumerate(self._receivers[receiver][:n_images]):
            wave = antenna.wave(position_m, self._wavelength_m)
            lit, answers = antenna.over_plate(position_m, self._wavelength_m)
            # a point scatters alike in all directions: one factor for all pairs of images
            if self._sphere is None or not answers:
                sent = sum(one * by for _, one, by, _ in sources)
                total = total + sent * lit * wave
                continue
            field: ComplexArray | float = 0.0
            for source, one, _, shares in sources:
                for share, own in zip(shares, source.fields, strict=True):
                    ends = source.place_m, own, antenna.place_m
                    field = field + one * share * scattering.scattered_field(self._sphere, position_m, *ends)
            got = sum(share * (own @ field) for share, own in zip(answers, antenna.fields, strict=True))
            # what goes to and fro and then over a wall is left out
            if exchanged is not None and way_out < N_WAYS:
                for (_, one, _, shares), returned in zip(sources, exchanged[:, way_out], strict=False):
                    for share, fields in zip(shares, returned, strict=False):
                        got = got + one * share * sum(by * own for by, own in zip(answers, fields, strict=False))
            total = total + got * wave
        return np.asarray(self._scale[receiver] * total)


@dataclass(frozen=True, slots=True)
class Reflector(Plane):
    """A plane that reflects waves.

    Attributes
    ----------
    coefficient
        Complex reflection coefficient; of a wall, its magnitude; of a plate what its own coefficients are taken times.
    wall
        Number of the wall from 0; None for the bottom.
    plate
        What the bottom is, where the setup states it.
    edges
        Where the bottom ends; None: nowhere that counts.
    is_stated
        Whether the setup says what it reflects: then a sphere exchanges waves with it.
    """

    coefficient: complex
    wall: int | None = None
    plate: Plate | None = None
    edges: Rectangle | None = None
    is_stated: bool = False

    def within_edges(
        self, position_m: FloatArray, image_m: FloatArray, field: FloatArray | None, wavenumber: float
    ) -> ComplexArray | float:
        """Return what the wave of an image (3,) is over that over an endless bottom at positions (3, n), shape (n,).

        Along the bottom the image has the place and the field of its antenna.
        """
        if self.edges is None:
            return 1.0
        fields = None if field is None else field[None]
        ways = self.height_m(position_m), image_m[None], -self.height_m(image_m)[None, None], fields
        return np.asarray(self.edges.over(position_m, *ways, wavenumber).value()[0])

    def reflection(self, wavenumber: float) -> complex:
        """Return R straight down, as of a perfect conductor's image, which is 1."""
        return -self.coefficient * (1.0 if self.plate is None else self.plate.straight_down(wavenumber))


def bottom_reflector(setup: Setup) -> Reflector:
    """Return the container's bottom: one radius of the sphere below its centre at the impact.

    It is the plate that `[floor]` states, or its coefficient's magnitude is the reflection stated there, else the size
    of `reflection`, with a phase drawn from the seed; `simulation.reflection` goes before both.

    Raises
    ------
    SetupError
        There is no floor below the release.
    """
    plane = contact_plane(setup)
    phase = generator(setup.simulation.seed, Draw.REFLECTION).uniform(0.0, 2.0 * np.pi)
    # waves meet the bottom, the sphere its own radius above it
    distance = plane.distance_m - 0.5 * setup.tracer.diameter_m
    if setup.simulation.scene == "bed":
        # the grains of the simulation let waves through: what reflects lies below where the sphere comes to rest
        distance -= setup.simulation.bed_depth_m
    floor, is_own = setup.floor, setup.simulation.reflection is not None
    stated, edges = StatedEdges.of(setup), None
    if stated is not None:
        edges = Rectangle.of(stated.values, plane.normal, distance * plane.normal)
    plate = None if is_own else Plate.of(floor)
    size = setup.simulation.size("reflection") if is_own or floor.reflection is None else floor.reflection
    # of a plate the tangential field turns over
    coefficient = complex(size * np.exp(1j * phase)) if plate is None else -1.0 + 0j
    is_stated = not is_own and floor.is_stated
    return Reflector(plane.normal, distance, coefficient, plate=plate, edges=edges, is_stated=is_stated)


def reflectors_of(setup: Setup) -> tuple[Reflector, ...]:
    """Return all reflectors of the scene: the bottom and the upright walls round the z axis, where they reflect."""
    simulation = setup.simulation
    states = simulation.reflection is None and setup.floor.is_stated
    found = [bottom_reflector(setup)] if states or simulation.size("reflection") > 0.0 else []
    if simulation.wall_reflection != 0.0:
        walls = zip(simulation.wall_distance_m, simulation.wall_azimuth_deg, strict=True)
        for wall, (distance_m, azimuth_deg) in enumerate(walls):
            found.append(Reflector(-azimuth_direction(azimuth_deg), -distance_m, simulation.wall_reflection, wall))
    return tuple(found)


def image_of(antenna: Antenna, reflector: Reflector, phase_rad: float, reference_m: FloatArray) -> Antenna | None:
    """Return the image of an antenna, its place, lobe and field mirrored; None where it stands beyond a wall.

    In the bottom the coefficient is the reflector's, one for all antennas. In a wall, of this phase, it makes up for
    the lobes at the reference, so that there the image over the antenna itself is coefficient r / r', as the direct
    path's 1 / r and the mirrored path's 1 / r' have it.

    Raises
    ------
    SetupError
        The antenna stands below the bottom.
    """
    is_wall, normal = reflector.wall is not None, reflector.normal
    if reflector.height_m(antenna.place_m) <= 0.0:
        if is_wall:
            return None
        place = ", ".join(f"{part:.3g}" for part in antenna.place_m)
        raise worded(SetupError, "antenna_below_bottom", place=place)
    image = replace(
        antenna,
        place_m=mirror(antenna.place_m, normal, reflector.distance_m),
        axis=mirror(antenna.axis, normal, 0.0),
        field=None if antenna.field is None else mirror(antenna.field, normal, 0.0),
        coefficient=reflector.coefficient,
        walls=None,
        mirror=None if is_wall else reflector,
    )
    if not is_wall:
        return image
    # towards a wall an antenna has side lobes, towards the sphere its main one
    lobes = float(antenna.gain(reference_m[:, None])[0] / image.gain(reference_m[:, None])[0])
    return replace(image, coefficient=complex(reflector.coefficient * lobes * np.exp(1j * phase_rad)))


def make_waves(setup: Setup, antennas: Antennas) -> SceneWaves:
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
    # a point asks for no direction of the field
    fields: tuple[FloatArray | None, ...] = (None,) * (1 + antennas.n_receivers)
    if metal:
        received, sent_deg = setup.received_fields(), setup.transmitter.polarization_deg or 0.0
        got = [scattering.received_direction(one.angle_deg, one.horizontal, one.vertical) for one in received]
        fields = (scattering.transmitted_direction(sent_deg), *got)

    def with_images(number: int, place_m: FloatArray) -> tuple[Antenna, ...]:
        # it looks at the origin
        axis = -place_m / np.linalg.norm(place_m)
        antenna = Antenna(place_m, axis, lobe, field=fields[number], walls=setup.container.walls)
        images = []
        for reflector in reflectors:
            draw = generator(setup.simulation.seed, Draw.WALL, reflector.wall or 0, number)
            images.append(image_of(antenna, reflector, draw.uniform(0.0, 2.0 * np.pi), reference))
        return (antenna, *(image for image in images if image is not None))

    transmitters = with_images(0, antennas.transmitter_m)
    receivers = tuple(with_images(number, place) for number, place in enumerate(antennas.receivers_m, start=1))
    sphere = scattering.tracer_sphere(setup.tracer, setup.radar) if metal else None
    exchange = None
    if sphere is not None and reflectors and reflectors[0].is_stated:
        ends = [antennas_of[:N_WAYS] for antennas_of in (transmitters, *receivers)]
        exchange = _exchange_of(sphere, reflectors[0], ends)
    return SceneWaves(transmitters, receivers, setup.radar.wavelength_m, reference, sphere, exchange)


def _exchange_of(sphere: scattering.MieSphere, bottom: Reflector, ends: Sequence[tuple[Antenna, ...]]) -> Exchange:
    """Return what a sphere exchanges with the bottom, between antennas and their images in it, the transmitter's first.

    An antenna that has one field fewer than others sends none in its place.
    """
    n_fields = max(len(antenna.fields) for pair in ends for antenna in pair)
    fields = np.zeros((len(ends), N_WAYS, n_fields, 3))
    for row, pair in zip(fields, ends, strict=True):
        for own, antenna in zip(row, pair, strict=True):
            own[: len(antenna.fields)] = antenna.fields
    places = np.array([[antenna.place_m for antenna in pair] for pair in ends])
    reflection = bottom.reflection(2.0 * np.pi / sphere.wavelength_m)
    return Exchange(sphere, bottom, reflection, bottom.plate, places, fields)
