"""The radar of the setup file: transmitter, receivers, tracer, floor, and where on Earth they stand."""

from __future__ import annotations

import math
from typing import Annotated, Literal, NamedTuple

import numpy as np
from pydantic import BeforeValidator, Field, PrivateAttr, WithJsonSchema, field_validator, model_validator

from radargui.model.section import Coordinate, ExactWhole, Real, Section, Vector

SPEED_OF_LIGHT_M_S = 299_792_458.0  # exact: it defines the metre (SI)
MAX_RECEIVERS = 4
"""Three tell a place; a fourth tells whether they agree."""


class Radar(Section):
    """Transmitted wave, the air it passes, and the sign of the phase.

    Attributes
    ----------
    frequency_hz, u_frequency_hz
        Of the transmitted wave.
    refractive_index
        n of the air, wavelength = c / (n f0): 1.00032 in a laboratory. Left out: that of `[air]`, else 1, as 0.1 had it
        (decision record 21).
    phase_sign
        -1 where Q is inverted: moving the tracer away must raise every path length.
    """

    frequency_hz: Annotated[Real, Field(ge=1e8, le=1e12)] = 10.0e9
    u_frequency_hz: Annotated[Real, Field(ge=0.0, le=1e9)] | None = None
    refractive_index: Annotated[Real, Field(ge=1.0, le=1.01)] | None = None
    phase_sign: Annotated[Literal[-1, 1], ExactWhole] = 1

    # what the setup's [air] makes it, for whoever has the radar alone; no key of the file
    _index_of_air: float = PrivateAttr(default=1.0)

    def in_air(self, index: float) -> Radar:
        """Return the radar in air of a refractive index, which counts where none is stated."""
        radar = self.model_copy()
        radar._index_of_air = index  # noqa: SLF001  of its own copy
        return radar

    @property
    def index(self) -> float:
        """Refractive index that counts: the one stated, else that of the air, else 1."""
        return self.refractive_index or self._index_of_air

    @property
    def wavelength_m(self) -> float:
        """Wavelength c / (n f0)."""
        # air shortens the wave by 3e-4: counted as vacuum every length and g come out as much too large
        return SPEED_OF_LIGHT_M_S / (self.index * self.frequency_hz)


Distance = Annotated[Real, Field(gt=0.0, le=100.0)]
Uncertainty = Annotated[Real, Field(ge=0.0, le=1.0)]
Behind = Annotated[Real, Field(ge=-0.5, le=0.5)]
Azimuth = Annotated[Real, Field(ge=-360.0, le=360.0)]
AngleUncertainty = Annotated[Real, Field(ge=0.0, le=45.0)]


def _has_its_phase_centre(antenna: Transmitter | Receiver) -> None:
    if antenna.u_phase_centre_m is not None and antenna.phase_centre_m is None:
        given = f"u_phase_centre_m = {antenna.u_phase_centre_m:g}"
        raise ValueError(f"{given}, allowed: together with phase_centre_m")
    # in front of the aperture by less than the antenna is away
    if antenna.distance_m is not None and antenna.distance_m + (antenna.phase_centre_m or 0.0) <= 0.0:
        given = f"phase_centre_m = {antenna.phase_centre_m:g} with distance_m = {antenna.distance_m:g}"
        raise ValueError(f"{given}, allowed: a phase centre on the antenna's side of the centre")


class Transmitter(Section):
    """Transmitter on the +z axis, pointing to -z, or where a calibration found it.

    Attributes
    ----------
    distance_m, u_distance_m
        From the centre of the field of view.
    position_m
        x, y, z instead of `distance_m`, where it stands off the axis; `u_distance_m` holds along its direction.
    phase_centre_m, u_phase_centre_m
        How far behind the point that `distance_m` is measured to, away from the centre, its waves come from: a horn's
        come from behind its aperture. `position_m` is that of the phase centre itself.
    u_x_m, u_y_m
        How far it may stand beside that place.
    polarization_deg, u_polarization_deg
        Direction of the electric field, from the x axis towards the y axis; left out: the sphere counts as a point.
    """

    distance_m: Distance | None = None
    u_distance_m: Uncertainty | None = None
    phase_centre_m: Behind | None = None
    u_phase_centre_m: Uncertainty | None = None
    u_x_m: Uncertainty | None = None
    u_y_m: Uncertainty | None = None
    position_m: Vector | None = None
    polarization_deg: Azimuth | None = None
    u_polarization_deg: AngleUncertainty | None = None

    @model_validator(mode="after")
    def _stands_at_one_place(self) -> Transmitter:
        if (self.distance_m is None) == (self.position_m is None):
            fault = "is missing" if self.position_m is None else f"= {self.distance_m:g} beside position_m"
            raise ValueError(f"distance_m {fault}, allowed: a number above 0 to 100, or position_m instead")
        # from the centre itself there is no direction, and 1 / r has no value
        if self.position_m is not None and not any(self.position_m):
            raise ValueError("position_m = [0, 0, 0], allowed: any place but the centre")
        if self.position_m is not None and self.phase_centre_m is not None:
            given = f"phase_centre_m = {self.phase_centre_m:g} beside position_m"
            raise ValueError(f"{given}, allowed: with distance_m; position_m is that of the phase centre")
        _has_its_phase_centre(self)
        return self

    @property
    def place_m(self) -> Vector:
        """Where its phase centre stands."""
        # on the z axis unless a calibration found it beside
        return self.position_m or (0.0, 0.0, (self.distance_m or 0.0) + (self.phase_centre_m or 0.0))


class Receiver(Section):
    """One receiver at distance * (sin tilt cos azimuth, sin tilt sin azimuth, cos tilt).

    Attributes
    ----------
    tilt_deg, u_tilt_deg
        From the z axis.
    azimuth_deg, u_azimuth_deg
        From the x axis towards the y axis.
    distance_m, u_distance_m
        From the centre of the field of view.
    phase_centre_m, u_phase_centre_m
        How far behind that point its phase centre lies, as of the transmitter.
    polarization_deg, u_polarization_deg
        It answers to the field along cos(p) h + sin(p) v: u from the centre to the antenna, h = unit(z x u), v = u x h
        (at tilt 0 or 180 h = (-sin azimuth, cos azimuth, 0)); left out: turned for the strongest signal from there.
    """

    tilt_deg: Annotated[Real, Field(ge=0.0, le=180.0)]
    azimuth_deg: Azimuth
    distance_m: Distance
    polarization_deg: Azimuth | None = None
    u_tilt_deg: AngleUncertainty | None = None
    u_azimuth_deg: AngleUncertainty | None = None
    u_distance_m: Uncertainty | None = None
    phase_centre_m: Behind | None = None
    u_phase_centre_m: Uncertainty | None = None
    u_polarization_deg: AngleUncertainty | None = None

    @model_validator(mode="after")
    def _stands_at_one_place(self) -> Receiver:
        _has_its_phase_centre(self)
        return self

    @property
    def reach_m(self) -> float:
        """Distance of its phase centre from the centre of the field of view."""
        return self.distance_m + (self.phase_centre_m or 0.0)


PLASTICS = {"PTFE": 1.45, "PE": 1.52, "PMMA": 1.61}
"""Refractive indices at 10 GHz."""


class Tracer(Section):
    """The sphere and the place where its centre hangs before it falls.

    Attributes
    ----------
    diameter_m, u_diameter_m
        Of the sphere.
    material, refractive_index, u_refractive_index
        What it scatters as: metal, or a plastic, by name or by its refractive index at the radar's frequency (PTFE
        1.45, PE 1.52, PMMA 1.61).
    holder_distance_m
        From the sphere's centre at rest to that of a magnet, nozzle or needle that holds it: the echo at rest then has
        an unknown part by it, and places come from the fall alone. Left out: nothing near reflects.
    density_kg_m3
        Of the sphere, for its buoyancy in air; left out: none is counted. Steel 7800, polystyrene 1050.
    release_position_m, u_release_m
        Centre of the sphere while it hangs: everything counts from there. u is that of each coordinate.
    u_release_scatter_m
        By how much each drop is hung about it, of each coordinate; `u_release_m` is then common to the drops of a
        session. Left out: 0.2 mm of `u_release_m`, or all of it where that is less.
    """

    diameter_m: Annotated[Real, Field(gt=0.0, le=0.5)] = 0.010
    u_diameter_m: Annotated[Real, Field(ge=0.0, le=0.1)] | None = None
    material: Literal["metal", "PTFE", "PE", "PMMA"] = "metal"
    refractive_index: Annotated[Real, Field(gt=1.0, le=10.0)] | None = None
    u_refractive_index: Annotated[Real, Field(ge=0.0, le=1.0)] | None = None
    holder_distance_m: Annotated[Real, Field(gt=0.0, le=0.1)] | None = None
    density_kg_m3: Annotated[Real, Field(ge=10.0, le=25000.0)] | None = None
    release_position_m: Vector = (0.0, 0.0, 0.12)
    u_release_m: Uncertainty | None = None
    u_release_scatter_m: Uncertainty | None = None

    @model_validator(mode="after")
    def _is_of_one_material(self) -> Tracer:
        if self.material in PLASTICS and self.refractive_index is not None:
            given = f'material = "{self.material}" beside refractive_index = {self.refractive_index:g}'
            raise ValueError(f"{given}, allowed: one of them")
        if self.u_refractive_index is not None and self.index is None:
            given = f"u_refractive_index = {self.u_refractive_index:g}"
            raise ValueError(f"{given}, allowed: of a sphere that is not of metal")
        return self

    @property
    def index(self) -> float | None:
        """Refractive index of the sphere; None of metal."""
        return self.refractive_index or PLASTICS.get(self.material)


PLATES = {"glass": 2.545 + 0.005j, "acrylic": 1.61 + 0.01j, "granite": 2.445 + 0.01j}
"""Refractive indices at 10 GHz, the imaginary part their loss."""
AIR, METAL = "air", "metal"
Index = Annotated[Real, Field(gt=1.0, le=10.0)]


def _backing(value: object) -> object:
    if value in (AIR, METAL):
        return value
    try:
        # typed into a field it is a text
        index = float(value) if isinstance(value, str | int | float) and not isinstance(value, bool) else math.nan
    except ValueError:
        index = math.nan
    if not 1.0 <= index <= 10.0:
        raise ValueError(f"allowed: {_BACKINGS}")
    return index


_BACKINGS = "air, metal, or a refractive index from 1 to 10"
Backing = Annotated[
    str | float,
    BeforeValidator(_backing),
    WithJsonSchema({"anyOf": [{"type": "string", "description": _BACKINGS}, {"type": "number"}]}),
]


class Floor(Section):
    """Where the sphere's centre is when it touches, the direction away from the floor, and what the floor reflects.

    Attributes
    ----------
    height_m
        z of the sphere's centre when it touches; left out: found from the impacts.
    normal
        Direction away from the floor, of any length; left out: level, and found from the impacts where they tell.
    u_tilt_deg
        Of the normal, in each of two directions.
    reflection, u_reflection
        |R| straight down, of the field, where it is known: 1 of metal; u 0.05 where it is left out. Its phase stays
        unknown: nobody says what lies how far below. Left out, and no material given: found.
    material, refractive_index
        Instead: of what the plate is that the sphere falls on, by name or by its refractive index at the radar's
        frequency (glass 2.55, granite 2.45, acrylic 1.61). R then follows for the angle and the polarisation of each
        path, its phase too; `u_reflection` may stand beside it. With `tracer.density_kg_m3` a material also says how
        long an impact lasts, which u of e holds.
    thickness_m
        Of the plate; of steel it does not matter.
    backing
        What the plate lies on: air, metal, or the refractive index of something thick (wood 1.5). It decides: acrylic
        of 10 mm reflects 0.12 in the air and 0.96 on metal.
    size_m, u_size_m
        Both sides of a plate that ends within 30 cm of the drop, where its edge shows; left out: it goes on.
    azimuth_deg, u_azimuth_deg
        Of its first side, from x towards y.
    middle_m, u_middle_m
        x and y of its middle; left out: below the release.
    """

    height_m: Coordinate | None = None
    normal: Vector = (0.0, 0.0, 1.0)
    u_tilt_deg: AngleUncertainty | None = None
    reflection: Annotated[Real, Field(gt=0.0, le=1.0)] | None = None
    u_reflection: Uncertainty | None = None
    material: Literal["steel", "glass", "acrylic", "granite"] | None = None
    refractive_index: Index | None = None
    thickness_m: Annotated[Real, Field(gt=0.0, le=1.0)] | None = None
    backing: Backing | None = None
    size_m: tuple[Distance, Distance] | None = None
    u_size_m: Uncertainty | None = None
    azimuth_deg: Azimuth = 0.0
    u_azimuth_deg: AngleUncertainty | None = None
    middle_m: tuple[Coordinate, Coordinate] | None = None
    u_middle_m: Uncertainty | None = None

    @model_validator(mode="after")
    def _says_in_one_way_what_it_reflects(self) -> Floor:
        ways = [name for name in ("reflection", "material", "refractive_index") if getattr(self, name) is not None]
        if len(ways) > 1:
            raise ValueError(f"{self._given(ways[1])} beside {self._given(ways[0])}, allowed: one of them")
        if self.u_reflection is not None and not ways:
            raise ValueError(f"{self._given('u_reflection')}, allowed: together with reflection or material")
        of_plate = ("thickness_m", "backing")
        alone = next((name for name in of_plate if getattr(self, name) is not None), None)
        if alone and (not ways or ways[0] == "reflection"):
            raise ValueError(f"{self._given(alone)}, allowed: together with material or refractive_index")
        if ways and ways[0] != "reflection" and self.material != "steel" and self.thickness_m is None:
            raise ValueError(f"thickness_m left out, allowed: above 0 to 1 beside {self._given(ways[0])}")
        of_edges = ("u_size_m", "azimuth_deg", "u_azimuth_deg", "middle_m", "u_middle_m")
        alone = next((name for name in of_edges if getattr(self, name) != type(self).model_fields[name].default), None)
        if alone and self.size_m is None:
            raise ValueError(f"size_m left out, allowed: both sides of the plate beside {alone}")
        return self

    def _given(self, name: str) -> str:
        value = getattr(self, name)
        return f'{name} = "{value}"' if isinstance(value, str) else f"{name} = {value:g}"

    @property
    def is_stated(self) -> bool:
        """Whether it says what it reflects."""
        return any(one is not None for one in (self.reflection, self.material, self.refractive_index))

    @field_validator("normal")
    @classmethod
    def _has_a_direction(cls, normal: Vector) -> Vector:
        length = float(np.linalg.norm(normal))
        if length < 1e-6:
            raise ValueError("allowed: any direction, not the zero vector")
        return (normal[0] / length, normal[1] / length, normal[2] / length)


class Container(Section):
    """A box open above, round the drop: its upright walls along x and y stand in the rays to the receivers.

    Attributes
    ----------
    wall_m, refractive_index
        Thickness and refractive index of the walls: polystyrene foam 1.01 to 1.02, acrylic 1.61.
    height_m
        z of their upper edge.
    inner_m
        Inner lengths along x and y, the origin in the middle.
    """

    wall_m: Annotated[Real, Field(gt=0.0, le=0.2)] | None = None
    refractive_index: Annotated[Real, Field(ge=1.0, le=3.0)] | None = None
    height_m: Coordinate | None = None
    inner_m: tuple[Distance, Distance] | None = None

    @model_validator(mode="after")
    def _is_whole(self) -> Container:
        missing = [f"container.{name}" for name, value in self if value is None]
        if missing and len(missing) < len(type(self).model_fields):
            # the first is called by its table as every error is
            named = ", ".join(missing).removeprefix("container.")
            raise ValueError(f"{named} left out, allowed: all of a container or nothing")
        return self

    @property
    def walls(self) -> Walls | None:
        """What stands in the rays; None where nothing does."""
        if self.wall_m is None or self.refractive_index is None or self.height_m is None or self.inner_m is None:
            return None
        return Walls(self.wall_m, self.refractive_index, self.height_m, self.inner_m)


class Walls(NamedTuple):
    """The walls of a container, as `Container` states them."""

    wall_m: float
    refractive_index: float
    height_m: float
    inner_m: tuple[float, float]


class Site(Section):
    """The g that falls are expected with, and checked against: g itself, or latitude and height above the sea.

    Attributes
    ----------
    g_m_s2, u_g_m_s2
        Measured there, or from a gravity map, or what a drop tower or a counterweight leaves: falls are expected with
        it. u left out: 0.0005 m/s^2.
    latitude_deg, height_m
        Instead: normal gravity of WGS 84, known to 0.0005 m/s^2 (free-air anomalies).
    """

    g_m_s2: Annotated[Real, Field(ge=0.1, le=30.0)] | None = None
    u_g_m_s2: Annotated[Real, Field(ge=0.0, le=1.0)] | None = None
    latitude_deg: Annotated[Real, Field(ge=-90.0, le=90.0)] | None = None
    height_m: Annotated[Real, Field(ge=-500.0, le=10000.0)] | None = None

    @model_validator(mode="after")
    def _says_g_in_one_way(self) -> Site:
        names = [name for name, value in self if value is not None]
        if names and set(names) not in ({"g_m_s2"}, {"g_m_s2", "u_g_m_s2"}, {"latitude_deg", "height_m"}):
            given = " with ".join(f"{name} = {getattr(self, name):g}" for name in names)
            raise ValueError(f"{given}, allowed: g_m_s2 (and u_g_m_s2), or latitude_deg and height_m together")
        return self
