"""What else laboratories have, drawn for a drop: floors that reflect strongly, horns, harmonics, foam, holders, plates.

Half of the laboratories state it in the setup, as far as there are keys.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from benchmarks.world.antenna import Antenna
from benchmarks.world.container import Container
from benchmarks.world.draws import Draws
from benchmarks.world.drop import Floor
from benchmarks.world.exchange import Exchange
from benchmarks.world.horn import Horn
from benchmarks.world.mirror import Conductor, Dielectric, Mirror, Plate, Slab
from benchmarks.world.receiver_chain import Mixer
from benchmarks.world.room import Holder, Room
from benchmarks.world.sphere import Sphere
from benchmarks.world.told import Tables
from numpy.typing import NDArray

Array = NDArray[np.float64]

EFFECT_OPTIONS = (
    "exchange", "horns", "harmonics", "harmonics_db", "container", "holder", "holder_m", "dielectric", "plate",
    "plate_m", "effects_told",
)  # fmt: skip
"""Whether each is there; `harmonics_db`: the stronger one of each mixer; `holder_m`: from the sphere at rest;
`plate_m`: edge of the plate; `dielectric`: name of the sphere's material, or an empty one; `effects_told`: the setup
states it."""


@dataclass(frozen=True)
class Material:
    """Refractive index, density of a sphere of it and thickness of a floor of it."""

    index: complex
    density_kg_m3: float = 0.0
    thickness_m: float = 0.0


SPHERES = {
    "PTFE": Material(1.45, 2200.0),
    "PE": Material(1.52, 950.0),
    "PMMA": Material(1.61, 1190.0),
    "glass": Material(2.5, 2500.0),
}
FLOORS = {
    0.12: ("acrylic", Material(1.61 + 0.01j, thickness_m=0.01)),
    0.29: ("granite", Material(2.445 + 0.01j, thickness_m=0.03)),
    0.66: ("glass", Material(2.545 + 0.005j, thickness_m=0.01)),
    0.72: ("glass", Material(2.545 + 0.005j, thickness_m=0.02)),
}
"""Plates in free air by |R| straight down; indices such that |R| is right at 40 degrees too."""
STEEL = 0.95
U_REFLECTION, U_INDEX, U_PHASE_CENTRE_M = 0.05, 0.01, 0.005
U_SIZE_M, U_AZIMUTH_DEG, U_MIDDLE_M = 1e-3, 2.0, 3e-3
CLEAR_M = 5e-4
"""At least between sphere and holder."""
STEADY = 0.2
"""A steel plate differs so much from antenna to antenna, over a floor of anything."""


@dataclass(frozen=True)
class Effects:
    """What is there beside what an estimate can model; nothing by default.

    Attributes
    ----------
    floor
        |R| straight down, the key of `FLOORS` where it is one; None: drawn with the drop.
    exchange
        Whether sphere and floor send waves to and fro.
    flare_m
        Of horns near by; None: spherical waves.
    harmonics
        Of each receiver's mixer.
    container
        Around the drop, its rim counted from the release; None: there is none.
    holder_m
        Where a metal holder stands from the release, shape (3,), and its radius.
    material
        Of a dielectric sphere.
    plate
        Half edges of the floor's plate, azimuth and place of its middle beside the drop.
    is_told
        Whether the setup states what it can.
    """

    floor: float | None = None
    exchange: bool = False
    flare_m: float | None = None
    harmonics: tuple[tuple[complex, complex], ...] = ()
    container: Container | None = None
    holder_m: tuple[Array, float] | None = None
    material: str = ""
    plate: tuple[tuple[float, float], float, Array] | None = None
    is_told: bool = False

    @property
    def causes(self) -> frozenset[str]:
        """What a finding may blame: even where it is told, the setup says it no better than its keys do."""
        there = {
            "horns": self.flare_m is not None, "harmonics": bool(self.harmonics),
            "container": self.container is not None, "holder": self.holder_m is not None,
            "sphere": bool(self.material), "plate": self.plate is not None,
            "antennas": self.flare_m is not None and not self.is_told,
        }  # fmt: skip
        return frozenset(one for one, is_there in there.items() if is_there)

    @property
    def facts(self) -> dict[str, Any]:
        """What was drawn, by name; nothing of what is not there."""
        facts: dict[str, Any] = {
            "exchange": self.exchange, "flare_m": self.flare_m,
            "harmonics_db": [[float(20.0 * np.log10(abs(one))) for one in pair] for pair in self.harmonics],
            "container": None if self.container is None else vars(self.container),
            "holder_m": None if self.holder_m is None else float(np.linalg.norm(self.holder_m[0])),
            "material": self.material, "plate_m": None if self.plate is None else [2.0 * one for one in self.plate[0]],
        }  # fmt: skip
        found = {name: one for name, one in facts.items() if one}
        return {**found, "effects_told": self.is_told} if found else {}

    def surface(self, share: float, uneven: NDArray[np.complex128], floor: Floor, radius_m: float, k: float) -> Mirror:
        """Return the floor's surface, on which the sphere rests; each antenna sees another spot of what is no plate."""
        offset_m = float(floor.normal @ floor.touch_m) - radius_m
        if self.floor in FLOORS:
            material = FLOORS[self.floor][1]
            mirror: Mirror = Slab(
                floor.normal, offset_m, material.index**2, thickness_m=material.thickness_m, wavenumber_rad_m=k
            )
        else:
            mirror = Conductor(floor.normal, offset_m, share * (uneven**STEADY if self.floor == STEEL else uneven))
        if self.plate is None:
            return mirror
        half_m, azimuth, beside_m = self.plate
        along = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
        along -= floor.normal * (floor.normal @ along)
        along /= np.linalg.norm(along)
        axes = np.array([along, np.cross(floor.normal, along)])
        centre = floor.touch_m - radius_m * floor.normal + beside_m @ axes
        return replace(mirror, plate=Plate(centre, axes, half_m))

    def antennas(
        self, plain: tuple[Antenna, ...], distances_m: list[float], widest: list[float], k: float
    ) -> tuple[Antenna, ...]:
        """Return horns near by instead of spherical waves.

        Their apertures are such that the drop, whose ends lie at angles of the cosines `widest`, is in their beams.
        """
        if self.flare_m is None:
            return plain
        out = []
        for one, distance_m, cosine in zip(plain, distances_m, widest, strict=True):
            sine = np.sqrt(1.0 - cosine**2)
            # cos(pi rho / 2 a) falls to 0.4 of the axis at K a sin = 2.7
            radius_m = float(np.clip(2.7 / (k * sine), 0.025, 0.05))
            out.append(replace(one, horn=Horn(radius_m, self.flare_m, k, distance_m)))
        return tuple(out)

    def furnished(self, room: Room, release_m: Array, highest_m: float) -> Room:
        """Return the room with exchange, holder and container."""
        if self.exchange and room.mirrors:
            floor = room.mirrors[0]
            layers = floor.over_conductor if isinstance(floor, Dielectric) else None
            exchange = Exchange(
                room.sphere.radius_m, room.sphere.series(), floor.straight_down(), room.sphere.wavenumber_rad_m,
                highest_m, layers=layers,
            )  # fmt: skip
            room = replace(room, exchange=exchange)
        if self.holder_m is not None:
            away, radius_m = self.holder_m
            # a large sphere hangs below it, not in it
            nearest_m = room.sphere.radius_m + radius_m + CLEAR_M
            away = away * max(1.0, nearest_m / float(np.linalg.norm(away)))
            room = replace(room, holder=Holder(release_m + away, Sphere(radius_m, room.sphere.wavenumber_rad_m)))
        if self.container is None:
            return room
        rim_z_m = float(release_m[2] + self.container.rim_z_m)
        return replace(room, container=replace(self.container, rim_z_m=rim_z_m))

    def mixers(self, plain: tuple[Mixer, ...]) -> tuple[Mixer, ...]:
        """Return the mixers with their harmonics."""
        if not self.harmonics:
            return plain
        return tuple(replace(one, harmonics=pair) for one, pair in zip(plain, self.harmonics, strict=True))

    def state(self, setup: Tables, room: Room, share: float, value: Draws, *, is_exact: bool) -> Tables:
        """Return the setup with what it can state of the effects; distances to the aperture where horns are near."""
        rng = value.rng("effects stated")
        off = 0.0 if is_exact else 1.0
        reflection, index_off, behind_off = off * rng.standard_normal((3, 8))
        if self.flare_m is not None:
            for number, table in enumerate([setup["transmitter"], *setup["receiver"]]):
                horn = room.antennas[number].horn
                assert horn is not None
                table["distance_m"] -= horn.behind_m
                if self.is_told:
                    table["phase_centre_m"] = max(horn.behind_m + U_PHASE_CENTRE_M * float(behind_off[number]), 0.0)
                    table["u_phase_centre_m"] = off * U_PHASE_CENTRE_M
        if not self.is_told:
            return setup
        floor, tracer = setup.setdefault("floor", {}), setup["tracer"]
        if self.floor in FLOORS:
            name, material = FLOORS[self.floor]
            floor |= {"material": name, "thickness_m": material.thickness_m, "backing": "air"}
        elif share:
            stated = share * (1.0 + U_REFLECTION * reflection[0])
            floor |= {"reflection": float(min(stated, 1.0)), "u_reflection": share * U_REFLECTION}
        if self.plate is not None:
            floor |= self._edges(room.mirrors[0], off * value.rng("edges stated").standard_normal(5))
        if self.container is not None and room.container is not None:
            setup["container"] = {
                "wall_m": self.container.wall_m, "refractive_index": self.container.index,
                "height_m": room.container.rim_z_m, "inner_m": list(self.container.inner_m),
            }  # fmt: skip
        if self.holder_m is not None:
            tracer["holder_distance_m"] = float(np.linalg.norm(self.holder_m[0]))
        if self.material:
            index = SPHERES[self.material].index.real
            tracer |= {"refractive_index": index + U_INDEX * float(index_off[0]), "u_refractive_index": off * U_INDEX}
        return setup

    @staticmethod
    def _edges(floor: Mirror, off: Array) -> Tables:
        """Return what the setup says of where the floor's plate ends, off by numbers (5,) of its uncertainties."""
        assert floor.plate is not None
        along, half_m, middle_m = floor.plate.axes[0], np.array(floor.plate.half_m), floor.plate.centre_m[:2]
        azimuth_deg = np.degrees(np.arctan2(along[1], along[0])) + U_AZIMUTH_DEG * off[2]
        told = {
            "size_m": (2.0 * half_m + U_SIZE_M * off[:2]).tolist(), "azimuth_deg": float(azimuth_deg),
            "middle_m": (middle_m + U_MIDDLE_M * off[3:]).tolist(),
        }  # fmt: skip
        share = float(bool(off.any()))
        u = {"u_size_m": U_SIZE_M, "u_azimuth_deg": U_AZIMUTH_DEG, "u_middle_m": U_MIDDLE_M}
        return {**told, **{name: share * each for name, each in u.items()}}


NOTHING = Effects()


def draw_effects(value: Draws) -> Effects:
    """Return the effects of a laboratory."""
    rng = value.rng("effects")
    count = 3
    top_db = value.between("harmonics_db", -65.0, -40.0)
    harmonics = 10.0 ** ((top_db + rng.uniform(-10.0, 0.0, (count, 2))) / 20.0)
    harmonics[np.arange(count), rng.integers(2, size=count)] = 10.0 ** (top_db / 20.0)
    pairs = harmonics * np.exp(2j * np.pi * rng.random((count, 2)))
    lean, azimuth = np.radians(rng.uniform(0.0, 45.0)), rng.uniform(0.0, 2.0 * np.pi)
    upward = np.array([np.sin(lean) * np.cos(azimuth), np.sin(lean) * np.sin(azimuth), np.cos(lean)])
    inner = rng.uniform(0.20, 0.36, 2)
    box = Container(
        (float(inner[0]), float(inner[1])), rng.uniform(0.02, 0.03), rng.uniform(1.01, 1.02), rng.uniform(0.1, 0.3)
    )
    holder = value.between("holder_m", 0.015, 0.030) * upward, rng.uniform(0.004, 0.006)
    edge_m = value.between("plate_m", 0.05, 0.15)
    plate = (edge_m / 2.0, edge_m / 2.0 * rng.uniform(0.7, 1.0)), rng.uniform(0.0, np.pi), rng.uniform(-0.01, 0.01, 2)
    flare_m = rng.uniform(0.13, 0.20)
    is_dielectric = rng.random() < 0.12
    name = str(rng.choice(list(SPHERES)))
    return Effects(
        floor=float(value("floor", _floor_share)),
        exchange=bool(value("exchange", lambda _: True)),
        flare_m=flare_m if value.happens("horns", 0.25) else None,
        harmonics=tuple((complex(one), complex(two)) for one, two in pairs) if value.happens("harmonics", 0.25) else (),
        container=box if value.happens("container", 0.12) else None,
        holder_m=holder if value.happens("holder", 0.12) else None,
        material=str(value("dielectric", lambda _: name if is_dielectric else "") or ""),
        plate=plate if value.happens("plate", 0.2) else None,
        is_told=value.happens("effects_told", 0.5),
    )


def _floor_share(rng: np.random.Generator) -> float:
    anything = float(np.exp(rng.uniform(np.log(0.02), np.log(0.66))))
    return (anything, *FLOORS, STEEL)[int(rng.integers(len(FLOORS) + 2))]
