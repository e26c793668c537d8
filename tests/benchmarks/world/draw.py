"""Draws scenes of the laboratory from a seed; any value can be held instead of drawn, the others stay as they were."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from benchmarks.world.antenna import Antenna, receiver, transmitter
from benchmarks.world.antenna_values import AntennaValues, signal_share
from benchmarks.world.bed import Bed
from benchmarks.world.course import UP, Course
from benchmarks.world.draw_course import COURSES, course_of, placed
from benchmarks.world.draw_grain import EXPERIMENTS, experiment_of
from benchmarks.world.drawn_drop import draw_mixers
from benchmarks.world.draws import Draws
from benchmarks.world.drop import Body, Drop, Floor, fall
from benchmarks.world.mirror import Conductor, Dielectric, Mirror, permittivity_of
from benchmarks.world.receiver_chain import Converter, Noise
from benchmarks.world.room import Room
from benchmarks.world.scene import Scene
from benchmarks.world.sphere import Sphere
from benchmarks.world.stated import Stated, TrueValues, setup_of
from numpy.typing import NDArray

Array = NDArray[np.float64]

FREQUENCY_HZ = 10.0e9
N_RECEIVERS = 3
WEAKEST = 0.2
"""A receiver's polarisation is drawn again where it gets less than this share of the strongest signal."""
SIDE_LOBE = 0.1
"""Minus 20 dB, as of a small horn: what walls get of an antenna that looks elsewhere."""
OPTIONS = (
    "snr_db", "rate_hz", "skew_s", "skew_in_file", "height_m", "e", "scatter", "radius_m", "density_kg_m3",
    "gravity_m_s2", "floor", "surface", "walls", "wall", "wall_distance_m", "corners", "crosstalk", "lively",
    "kick_m_s", "tilt_deg", "depth_m", "flicker", "drift", "amplitude_v", "lobes", "coupled", "rest",
    "motion", "mode", "size_m", "speed_m_s", "lean_deg", "stops", "start_m", "gap_m", "tremor_m",
    "index", "film", "shake_hz", "shake_g", "side", "step_m", "bounces", "nearer", "contact_s",
)  # fmt: skip
"""Values to hold:
`floor`: share of the field that comes back; `wall`: the same at the centre, lobes counted; `walls`: how many;
`surface`: of the floor, conductor or dielectric; `corners`: whether waves go over wall and floor; `coupled`: whether
the floor sends back what the sphere sends it; `lively`: whether impacts kick and the floor leans; `depth_m`: caught
within this depth, no rebound (None: it bounces); `lobes`: whether antennas have any; `rest`: s before it leaves;
`nearer`: times as far away as drawn all antennas are; `contact_s`: how long an impact of a drop lasts; others as their
units say.
Of motions other than drops alone: `mode` of the motion; `size_m` (`draw_course.SIZES_M`); `speed_m_s`: the greatest, of
circle, hand, stage, and the push into a box; `lean_deg` of a circle's plane, a board, a stage; `stops`: whether circle
or board end before the record; `start_m`: three coordinates; `gap_m`: from the lowest place down to the floor, where it
falls on none.
Of experiments: a bed's refractive `index` and what a `film` on it sends back; a plate's frequency `shake_hz` and peak
acceleration `shake_g` (over g); what a box's wall (`side`) sends back; the height of an edge (`step_m`) and the
`bounces` before it."""
MOTIONS = ("drop", *COURSES, *EXPERIMENTS)
_RATES_HZ = (2000.0, 5000.0, 10000.0, 20000.0, 33333.0)
NEAREST_WALL_M = 0.06
"""A wall is no nearer to where a sphere goes that moves by a course: as near as to the drops."""


def draw(seed: int, stated: Stated = "exact", *, name: str = "laboratory", **held: Any) -> Scene:
    """Return the scene of a seed.

    Parameters
    ----------
    seed
        Same seed, same world, whatever is stated of it.
    stated
        What the setup says: all exact, the same without polarisations, or values off by the u that stand beside them.
    name
        The scene's name is this and the seed.
    held
        Values of `OPTIONS` to hold instead of drawing.
    """
    value = Draws((seed,), held, OPTIONS)
    motion = value("motion", lambda _: "drop")
    if motion not in MOTIONS:
        raise ValueError(f"no such motion: {motion}; there are {', '.join(MOTIONS)}")
    radius_m = value("radius_m", lambda r: r.uniform(0.0025, 0.008))
    rate_hz = float(value("rate_hz", lambda r: r.choice(_RATES_HZ[:3] if motion == "twice" else _RATES_HZ)))
    scan_s = 1.0 / (2 * N_RECEIVERS * rate_hz)
    skew_s = float(value("skew_s", lambda r: r.choice([0.0, 5e-6, min(15e-6, scan_s), scan_s])))
    snr_db = value("snr_db", lambda r: r.uniform(20.0, 45.0))
    tilt_deg = value("tilt_deg", lambda r: r.uniform(0.0, 1.0) if _lively(value) else 0.0)
    tilt, slope = np.radians(tilt_deg), value.rng("slope").uniform(0.0, 2.0 * np.pi)
    normal = np.array([np.sin(tilt) * np.cos(slope), np.sin(tilt) * np.sin(slope), np.cos(tilt)])
    body = Body(
        radius_m,
        value("density_kg_m3", lambda r: r.choice([7850.0, 7850.0, 7850.0, 2700.0])),
        value("gravity_m_s2", lambda r: r.uniform(9.785, 9.825)),
    )
    path = _dropped(value, body, normal) if motion == "drop" else _moved(value, motion, body, normal)
    true = TrueValues(
        _antenna_values(value, Sphere(radius_m, 2.0 * np.pi * FREQUENCY_HZ / 299_792_458.0)),
        path.start_m,
        2.0 * radius_m,
        body.density_kg_m3,
        path.normal,
        FREQUENCY_HZ,
        rate_hz,
        skew_s,
        5.0,
        int(value.rng("wiring").choice([-1, 1])),
        floor_is_known=motion in ("incline", "box"),
    )
    antennas = _antennas(value, true.antennas)
    sphere = Sphere(radius_m, true.wavenumber_rad_m)
    mirrors, corners = _mirrors(value, antennas, path)
    coupled = mirrors[:1] if value("coupled", lambda _: False) else ()
    crosstalk = value("crosstalk", lambda r: r.uniform(0.002, 0.01) if r.random() < 1 / 3 else 0.0)
    noise = Noise(
        10.0 ** (-snr_db / 20.0) / np.sqrt(2.0), value("flicker", lambda _: 0.0), value("drift", lambda _: 0.0)
    )
    return Scene(
        name=f"{name}-{seed}",
        key=(seed,),
        seed=seed,
        stated=stated,
        setup=setup_of(true, stated, value.rng("stated")),
        room=Room(antennas, sphere, mirrors, corners, coupled, path.bed),
        body=body,
        drop=path.drop,
        mixers=draw_mixers(value),
        noise=noise,
        converter=Converter(rate_hz, skew_s, crosstalk, true.range_v),
        phase_sign=true.phase_sign,
        phases_rad=tuple(value.rng("phases").uniform(0.0, 2.0 * np.pi, N_RECEIVERS)),
        snr_db=snr_db,
        skew_in_file=value("skew_in_file", lambda r: bool(r.random() < 0.67)),
        facts={
            "d": f"{2e3 * radius_m:.1f}mm",
            "walls": len(mirrors) - bool(value("floor", lambda _: 1.0)),
            "kappa": round(crosstalk, 4),
            "tilt": round(tilt_deg, 2),
            **path.facts,
        },
        motion=motion,
        falls=path.falls,
    )


@dataclass(frozen=True)
class _Path:
    """A motion at its place in the room, and the floor below it.

    `bottom_m`: a place (3,) that the floor's surface is not above; `reach_m`: places (3, n) that no wall may come near
    but `sides`, each with its normal, its offset along that and the share of the field it sends back to the centre.
    """

    drop: Drop
    start_m: Array
    bottom_m: Array
    normal: Array
    falls: bool
    facts: dict[str, object]
    reach_m: Array | None = None
    sides: tuple[tuple[Array, float, float], ...] = ()
    bed: Bed | None = None


def _floor(value: Draws, normal: Array, touch_m: Array) -> Floor:
    return Floor(
        normal,
        touch_m,
        value("e", lambda r: r.uniform(0.4, 0.92)),
        value("scatter", lambda _: 0.01),
        value("kick_m_s", lambda _: 0.03 if _lively(value) else 0.0),
        value("contact_s", lambda _: 0.0),
    )


def _lively(value: Draws) -> bool:
    return bool(value("lively", lambda r: r.random() < 1 / 3))


def _dropped(value: Draws, body: Body, normal: Array) -> _Path:
    release = value.rng("release").uniform([-0.02, -0.02, 0.08], [0.02, 0.02, 0.14])
    height_m = min(value("height_m", lambda r: r.uniform(0.06, 0.30)), release[2] + 0.16)
    floor = _floor(value, normal, release - [0.0, 0.0, height_m])
    start_s = _rest_s(value)
    depth_m = value("depth_m", lambda _: None)
    drop = fall(
        value.rng("impacts"), body, floor, release, start_s=start_s, duration_s=start_s + 0.9, caught_within_m=depth_m
    )
    bottom = floor.touch_m - (body.radius_m + (depth_m or 0.0)) * normal
    return _Path(drop, release, bottom, normal, falls=True, facts={"kicks": floor.kick_m_s})


def _rest_s(value: Draws) -> float:
    return float(value("rest", lambda r: r.uniform(0.2, 0.4)))


def _moved(value: Draws, motion: str, body: Body, normal: Array) -> _Path:
    made = experiment_of if motion in EXPERIMENTS else course_of
    course = made(value, motion, body, _floor(value, normal, np.zeros(3)))
    drop, start = placed(value, course, _rest_s(value))
    reach = start[:, None] + course.places_m()
    if course.normal is not None:
        normal = course.normal
    if course.touch_m is None:
        touch = reach[:, int(np.argmin(normal @ reach))] - value("gap_m", lambda r: r.uniform(0.01, 0.2)) * normal
    else:
        touch = start + course.touch_m
    facts = {"motion": motion, **course.facts, "start": np.round(start, 3).tolist()}
    sides = tuple((n, float(n @ (start + place)), share) for n, place, share in course.sides)
    return _Path(
        drop, start, touch - body.radius_m * normal, normal, course.falls, facts, reach, sides, _bed(course, start)
    )


def _bed(course: Course, start_m: Array) -> Bed | None:
    """Return the grains at their place; what the wave meets there is the index's step, or a film."""
    if course.grains is None:
        return None
    grains = replace(course.grains, surface_z_m=float(start_m[2]) + course.grains.surface_z_m)
    if not grains.film:
        return Bed(grains, Dielectric(UP, grains.surface_z_m, complex(grains.index**2)))
    return Bed(grains, Conductor(UP, grains.surface_z_m, grains.film * np.ones(N_RECEIVERS + 1, complex)))


def _antenna_values(value: Draws, sphere: Sphere) -> tuple[AntennaValues, ...]:
    rng = value.rng("antennas")
    azimuths = 90.0 + 360.0 / N_RECEIVERS * np.arange(N_RECEIVERS) + rng.uniform(-15.0, 15.0, N_RECEIVERS)
    nearer = float(value("nearer", lambda _: 1.0))
    sender = AntennaValues(0.0, 0.0, nearer * rng.uniform(0.6, 0.8), rng.uniform(0.0, 180.0))
    receivers = []
    for azimuth in azimuths % 360.0:
        tilt, distance = rng.uniform(32.0, 50.0), nearer * rng.uniform(0.6, 0.8)
        one = AntennaValues(tilt, azimuth, distance, rng.uniform(0.0, 180.0))
        while signal_share(sender, one, sphere) < WEAKEST:
            one = replace(one, polarization_deg=rng.uniform(0.0, 180.0))
        receivers.append(one)
    return (sender, *receivers)


def _antennas(value: Draws, values: tuple[AntennaValues, ...]) -> tuple[Antenna, ...]:
    """Return the antennas; their lobes fall to a half of the field at 17 to 34 degrees from the axis."""
    drawn = value.rng("lobes").uniform(4.0, 16.0, len(values))
    has_lobes = value("lobes", lambda _: True)
    sender, *receivers = values
    plain = (
        transmitter(sender.distance_m, sender.polarization_deg, 0.0),
        *(receiver(one.tilt_deg, one.azimuth_deg, one.distance_m, one.polarization_deg, 0.0) for one in receivers),
    )
    if not has_lobes:
        return plain
    return tuple(replace(one, lobe=lobe, side_lobe=SIDE_LOBE) for one, lobe in zip(plain, drawn, strict=True))


def _mirrors(
    value: Draws, antennas: tuple[Antenna, ...], path: _Path
) -> tuple[tuple[Mirror, ...], tuple[tuple[Mirror, Mirror], ...]]:
    """Return the floor below the lowest place and the walls around, and the corners between them."""
    share = value("floor", lambda r: r.uniform(0.1, 0.3))
    rng = value.rng("floor surface")
    normal = path.normal
    offset = float(normal @ path.bottom_m) - rng.uniform(0.0, 0.015)
    floors: tuple[Mirror, ...] = ()
    if share and value("surface", lambda _: "conductor") == "dielectric":
        floors = (Dielectric(normal, offset, complex(permittivity_of(share))),)
    elif share:
        floors = (Conductor(normal, offset, _uneven(rng, share)),)
    walls = []
    for number in range(value("walls", lambda r: int(r.random() < 0.5))):
        rng = value.rng(f"wall {number}")
        size = value("wall", lambda _, rng=rng: rng.uniform(0.02, 0.04))
        distance = value("wall_distance_m", lambda _, rng=rng: np.exp(rng.uniform(np.log(0.08), np.log(1.0))))
        azimuth = rng.uniform(0.0, 2.0 * np.pi)
        lean = np.radians(rng.normal(0.0, 0.5))
        inward = np.array([-np.cos(lean) * np.cos(azimuth), -np.cos(lean) * np.sin(azimuth), np.sin(lean)])
        if path.reach_m is not None:
            distance = max(distance, float((-inward @ path.reach_m).max()) + NEAREST_WALL_M)
        wall = Conductor(inward, -distance)
        walls.append(replace(wall, reflection=_uneven(rng, size) / _lobes_by(wall, antennas)))
    for number, (inward, along, size) in enumerate(path.sides):
        wall = Conductor(inward, along)
        reflection = _uneven(value.rng(f"side {number}"), size) / _lobes_by(wall, antennas)
        walls.extend([replace(wall, reflection=reflection)] if size else [])
    corners = [(wall, ground) for wall in walls for ground in floors] if value("corners", lambda _: False) else []
    return (*floors, *walls), tuple(corners)


def _lobes_by(mirror: Mirror, antennas: tuple[Antenna, ...]) -> Array:
    """Return how much weaker each antenna sends towards its image of the centre than on its axis."""
    images = [mirror.image(one.position_m) for one in antennas]
    directions = [mirror.mirrored(-image / np.linalg.norm(image)) for image in images]
    return np.array([one.strength(d[:, None])[0] for one, d in zip(antennas, directions, strict=True)])


def _uneven(rng: np.random.Generator, share: float) -> NDArray[np.complex128]:
    """Return the reflection for each antenna: one surface, seen at another spot and angle by each."""
    count = N_RECEIVERS + 1
    phase = rng.uniform(0.0, 2.0 * np.pi) + rng.normal(0.0, 0.3, count)
    return share * rng.uniform(0.8, 1.2, count) * np.exp(1j * phase)
