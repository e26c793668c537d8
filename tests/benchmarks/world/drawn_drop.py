"""Draws the drop of an ordinary laboratory: antennas, sphere, floor, walls, board, front end, and how it falls."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from benchmarks.world.antenna import Antenna, receiver, transmitter
from benchmarks.world.antenna_values import AntennaValues, signal_share
from benchmarks.world.draws import Draws
from benchmarks.world.drop import Body, Drop, Floor, fall
from benchmarks.world.effects import NOTHING, SPHERES, Effects
from benchmarks.world.mirror import Conductor, Mirror
from benchmarks.world.receiver_chain import Converter, Mixer, Noise
from benchmarks.world.room import Room
from benchmarks.world.scene import World
from benchmarks.world.sphere import Sphere
from benchmarks.world.told import Tables, Uncertainties
from numpy.typing import NDArray

Array = NDArray[np.float64]

FREQUENCY_HZ, REFRACTIVE_INDEX = 10.0e9, 1.00032
WAVENUMBER_RAD_M = 2.0 * np.pi * REFRACTIVE_INDEX * FREQUENCY_HZ / 299_792_458.0
N_RECEIVERS = 3
RANGE_V = 5.0
RATES_HZ = (5000.0, 10000.0, 20000.0, 33333.0, 50000.0, 100000.0)
WEAKEST = 0.2
"""A receiver's polarisation is drawn again where it gets less than this share of the strongest signal."""
SIDE_LOBE = 0.1
"""Minus 20 dB, as of a small horn: what walls get of an antenna that looks elsewhere."""
DIMMEST = 0.4
"""Antennas are chosen for their field of view: nowhere in the drop the field is less than this share of the axis."""
WEAK_DB = 24.0
HIGHER_M = 0.02
"""No sphere rises so far above its release."""
_OF_WALLS = ("wall", "wall_distance_m")
LONGEST_S, LIES_S, SHORTEST_S = 0.9, 0.15, 0.35
"""A record ends so long after the release, or so long after the last bounce if that is sooner; not before the third."""
OPTIONS = (
    "exact", "told", "diameter_m", "density_kg_m3", "density_told", "gravity_m_s2", "site", "height_m", "release_m",
    "e", "scatter", "kick_m_s", "tilt_deg", "snr_db", "rate_hz", "multiplexed", "skew_s", "skew_in_file", "crosstalk",
    "amplitude_v", "floor", "walls", "wall", "wall_distance_m", "rest_s", "u_angle_deg", "u_distance_m",
    "u_polarization_deg", "u_release_m", "release_scatter", "lateral_m_s", "friction", "drift",
)  # fmt: skip
"""Values to hold, units in their names; `exact`: the setup is the truth; `told`: polarisations are stated; `floor`:
|R|, 0 of none; `walls`: how many; `wall`: share of the field that one sends back to the centre, the lobes counted;
`site`, `density_told`: whether the setup states g and the sphere's density; `release_scatter`: over `u_release_m`.
Only where held: `lateral_m_s`, with which the sphere is let go in a drawn direction, Coulomb's `friction`, and `drift`
of the offsets over the record, in amplitudes."""


@dataclass(frozen=True)
class DrawnDrop:
    """A drop before anything is said of it.

    Attributes
    ----------
    world
        What is true.
    true
        The tables of a setup that is the truth, the transmitter's x_m and y_m beside.
    effects, share
        What else is there, and |R| of the floor.
    causes, facts
        As of the scene.
    """

    world: World
    true: Tables
    effects: Effects
    share: float
    causes: frozenset[str]
    facts: dict[str, Any]


def draw_drop(value: Draws, u: Uncertainties, name: str, number: int, effects: Effects = NOTHING) -> DrawnDrop:
    """Return drop `number` of a session: laboratory and sphere are those of all its drops."""
    diameter_m = value.between("diameter_m", 0.005, 0.016)
    body = Body(
        diameter_m / 2.0,
        float(value("density_kg_m3", lambda r: r.choice([7850.0, 7850.0, 7850.0, 2700.0, 1100.0]))),
        value.between("gravity_m_s2", 9.785, 9.825),
    )
    height_m = value.between("height_m", 0.06, 0.40)
    nominal = np.asarray(value("release_m", lambda r: _release_m(r, height_m)), dtype=np.float64)
    floor = _floor(value, nominal - [0.0, 0.0, height_m])
    index = None
    if effects.material:
        index = SPHERES[effects.material].index
        body = replace(body, density_kg_m3=SPHERES[effects.material].density_kg_m3)
    sphere = Sphere(body.radius_m, WAVENUMBER_RAD_M, index)
    values, beside_m = draw_antenna_values(value, sphere), u.distance_m * value.rng("beside").standard_normal(2)
    antennas = _antennas(value, effects, values, beside_m, nominal, floor.touch_m)
    share = value.log_between("floor", 0.02, 0.66) if effects.floor is None else effects.floor
    mirrors = _mirrors(value, effects, antennas, floor, body.radius_m, share)
    room = effects.furnished(Room(antennas, sphere, mirrors), nominal, height_m + HIGHER_M)
    converter = draw_converter(value)
    snr_db = value.between("snr_db", 20.0, 45.0)
    each = value.drop(number)
    release = nominal + u.release_scatter_m * each.rng("release scatter").standard_normal(3)
    phase_sign = int(value.rng("wiring").choice([-1, 1]))
    world = World(
        name=name,
        key=each.key,
        room=room,
        body=body,
        drop=_fall(each, body, floor, release, height_m),
        mixers=effects.mixers(draw_mixers(value)),
        noise=Noise(10.0 ** (-snr_db / 20.0) / np.sqrt(2.0), drift=value("drift", lambda _: 0.0)),
        converter=converter,
        phase_sign=phase_sign,
        phases_rad=tuple(value.rng("phases").uniform(0.0, 2.0 * np.pi, N_RECEIVERS)),
        snr_db=snr_db,
        skew_in_file=value.happens("skew_in_file", 0.67),
    )
    facts = {
        "diameter_m": diameter_m, "density_kg_m3": body.density_kg_m3, "gravity_m_s2": body.gravity_m_s2,
        "height_m": height_m, "release_m": release.tolist(), "floor_m": float(floor.touch_m[2]),
        "e": floor.restitution, "kick_m_s": floor.kick_m_s, "tilt_deg": float(np.degrees(np.arccos(floor.normal[2]))),
        "floor": share, "walls": len(mirrors) - bool(share),
        "snr_db": snr_db, "rate_hz": converter.rate_hz, "skew_s": converter.skew_s, "crosstalk": converter.crosstalk,
    }  # fmt: skip
    causes = {
        "floor": share > 0.0, "walls": facts["walls"] > 0, "tilt": facts["tilt_deg"] > 0.0,
        "crosstalk": converter.crosstalk > 0.0, "signal": snr_db < WEAK_DB,
    }  # fmt: skip
    return DrawnDrop(
        world,
        _true_tables(value, values, beside_m, nominal, body, converter, phase_sign),
        effects,
        share,
        frozenset(one for one, there in causes.items() if there),
        facts,
    )


def _release_m(rng: np.random.Generator, height_m: float) -> Array:
    """Return a place such that the centre of the field of view lies in the drop, near its middle."""
    return np.append(rng.uniform(-0.02, 0.02, 2), height_m / 2.0 + rng.uniform(-0.02, 0.04))


def _true_tables(
    value: Draws, antennas: tuple[AntennaValues, ...], beside_m: Array, release_m: Array, body: Body,
    converter: Converter, phase_sign: int,
) -> Tables:  # fmt: skip
    sender, *receivers = antennas
    has_polarizations = value.happens("told", 0.7)

    def field_of(one: AntennaValues) -> dict[str, float]:
        return {"polarization_deg": one.polarization_deg} if has_polarizations else {}

    tracer: Tables = {"diameter_m": 2.0 * body.radius_m, "release_position_m": release_m.tolist()}
    if value.happens("density_told", 0.8):
        tracer["density_kg_m3"] = body.density_kg_m3
    return {
        "schema": 1,
        "radar": {"frequency_hz": FREQUENCY_HZ, "refractive_index": REFRACTIVE_INDEX, "phase_sign": phase_sign},
        "transmitter": {
            "distance_m": sender.distance_m, "x_m": float(beside_m[0]), "y_m": float(beside_m[1]), **field_of(sender),
        },
        "receiver": [
            {
                "tilt_deg": one.tilt_deg, "azimuth_deg": one.azimuth_deg, "distance_m": one.distance_m,
                **field_of(one),
            }
            for one in receivers
        ],
        "tracer": tracer,
        "daq": {"rate_hz": converter.rate_hz, "channel_skew_s": converter.skew_s, "range_v": converter.range_v},
        **({"site": {"g_m_s2": body.gravity_m_s2}} if value.happens("site", 0.5) else {}),
    }  # fmt: skip


def draw_antenna_values(value: Draws, sphere: Sphere) -> tuple[AntennaValues, ...]:
    """Return an arrangement drawn anew: the transmitter, then receivers all around; none is nearly blind."""
    rng = value.rng("antennas")
    spread = 360.0 / N_RECEIVERS * np.arange(N_RECEIVERS) + rng.uniform(-15.0, 15.0, N_RECEIVERS)
    sender = AntennaValues(0.0, 0.0, rng.uniform(0.5, 1.0), rng.uniform(0.0, 180.0))
    receivers = []
    for azimuth in (rng.uniform(0.0, 360.0) + spread) % 360.0:
        one = AntennaValues(rng.uniform(30.0, 50.0), float(azimuth), rng.uniform(0.5, 1.0), rng.uniform(0.0, 180.0))
        while signal_share(sender, one, sphere) < WEAKEST:
            one = replace(one, polarization_deg=rng.uniform(0.0, 180.0))
        receivers.append(one)
    return (sender, *receivers)


def _antennas(
    value: Draws, effects: Effects, values: tuple[AntennaValues, ...], beside_m: Array, *ends_m: Array
) -> tuple[Antenna, ...]:
    """Return the antennas with their lobes, none too narrow for the drop between its ends."""
    drawn = value.rng("lobes").uniform(4.0, 16.0, len(values))
    sender, *receivers = values
    above = transmitter(sender.distance_m, sender.polarization_deg, 0.0)
    plain = (
        replace(above, position_m=above.position_m + np.append(beside_m, 0.0)),
        *(receiver(one.tilt_deg, one.azimuth_deg, one.distance_m, one.polarization_deg, 0.0) for one in receivers),
    )
    widest = []
    for one in plain:
        away = np.array(ends_m).T - one.position_m[:, None]
        widest.append(float((one.axis @ away / np.linalg.norm(away, axis=0)).min()))
    lobed = tuple(
        replace(one, lobe=min(lobe, np.log(DIMMEST) / np.log(cosine)), side_lobe=SIDE_LOBE)
        for one, lobe, cosine in zip(plain, drawn, widest, strict=True)
    )
    return effects.antennas(lobed, [one.distance_m for one in values], widest, WAVENUMBER_RAD_M)


def _floor(value: Draws, touch_m: Array) -> Floor:
    tilt, slope = np.radians(value.between("tilt_deg", 0.0, 0.8)), value.rng("slope").uniform(0.0, 2.0 * np.pi)
    normal = np.array([np.sin(tilt) * np.cos(slope), np.sin(tilt) * np.sin(slope), np.cos(tilt)])
    return Floor(
        normal,
        touch_m,
        value.between("e", 0.2, 0.95),
        float(value("scatter", lambda _: 0.01)),
        value.between("kick_m_s", 0.0, 0.03),
        friction=value("friction", lambda _: None),
    )


def _fall(each: Draws, body: Body, floor: Floor, release_m: Array, height_m: float) -> Drop:
    """Return the fall and as much of the bounces as a record is long."""
    start_s = each.between("rest_s", 0.2, 0.35)
    falls_s = np.sqrt(2.0 * height_m / body.acceleration_m_s2)
    e = floor.restitution
    lasts_s = np.clip(falls_s * (1.0 + e) / (1.0 - e) + LIES_S, SHORTEST_S, LONGEST_S)
    angle, speed = each.rng("lateral").uniform(0.0, 2.0 * np.pi), float(each("lateral_m_s", lambda _: 0.0))
    pushed = speed * np.array([np.cos(angle), np.sin(angle), 0.0]) if speed else None
    span = {"start_s": start_s, "duration_s": start_s + float(lasts_s)}
    return fall(each.rng("impacts"), body, floor, release_m, **span, velocity_m_s=pushed)


def _mirrors(
    value: Draws, effects: Effects, antennas: tuple[Antenna, ...], floor: Floor, radius_m: float, share: float
) -> tuple[Mirror, ...]:
    """Return the floor, on whose surface the sphere rests, and the walls around.

    The floor is one surface that each antenna sees at another spot: five percent and 0.1 rad apart.
    """
    rng = value.rng("floor surface")
    uneven = np.exp(0.05 * rng.standard_normal(N_RECEIVERS + 1) + 0.1j * rng.standard_normal(N_RECEIVERS + 1))
    mirrors = [effects.surface(share, uneven, floor, radius_m, WAVENUMBER_RAD_M)] if share else []
    for number in range(int(value("walls", lambda r: r.random() < 0.35))):
        mirrors.append(_wall(value, antennas, number))
    return tuple(mirrors)


def _wall(value: Draws, antennas: tuple[Antenna, ...], number: int) -> Mirror:
    """Return an upright wall at any distance; its share counts the lobes, each antenna sees another spot of it."""
    rng = value.rng(f"wall {number}")
    drawn = np.exp(rng.uniform(np.log([0.01, 0.08]), np.log([0.08, 1.0])))
    share, distance_m = (float(value(name, lambda _, one=one: one)) for name, one in zip(_OF_WALLS, drawn, strict=True))
    azimuth, lean = rng.uniform(0.0, 2.0 * np.pi), np.radians(rng.normal(0.0, 0.5))
    inward = np.array([-np.cos(lean) * np.cos(azimuth), -np.cos(lean) * np.sin(azimuth), np.sin(lean)])
    wall = Conductor(inward, -distance_m)
    phase = rng.uniform(0.0, 2.0 * np.pi) + rng.normal(0.0, 0.3, N_RECEIVERS + 1)
    uneven = rng.uniform(0.8, 1.2, N_RECEIVERS + 1) * np.exp(1j * phase)
    return replace(wall, reflection=share * uneven / lobes_by(wall, antennas))


def lobes_by(mirror: Mirror, antennas: tuple[Antenna, ...]) -> Array:
    """Return how much weaker each antenna sends towards its image of the centre than on its axis."""
    images = [mirror.image(one.position_m) for one in antennas]
    directions = [mirror.mirrored(-image / np.linalg.norm(image)) for image in images]
    return np.array([one.strength(d[:, None])[0] for one, d in zip(antennas, directions, strict=True)])


def draw_converter(value: Draws) -> Converter:
    """Return a board that samples simultaneously, or a multiplexer: 5 or 15 us, or spread over the whole scan."""
    rate_hz = float(value("rate_hz", lambda r: r.choice(RATES_HZ)))
    scan_s = 1.0 / (2 * N_RECEIVERS * rate_hz)
    is_multiplexed = value.happens("multiplexed", 0.6)
    skew_s = float(value("skew_s", lambda r: r.choice([min(5e-6, scan_s), min(15e-6, scan_s), scan_s])))
    crosstalk = value("crosstalk", lambda r: r.uniform(0.002, 0.01) if r.random() < 0.5 else 0.0)
    return Converter(rate_hz, skew_s, crosstalk, RANGE_V) if is_multiplexed else Converter(rate_hz, 0.0, 0.0, RANGE_V)


def draw_mixers(value: Draws) -> tuple[Mixer, ...]:
    """Return the mixers: gain ratio to 15 %, quadrature to 10 degrees, offsets to half of the echo."""
    rng = value.rng("mixers")
    amplitude_v = value("amplitude_v", lambda r: r.choice([0.05, 0.5, 1.0, 1.5]))
    return tuple(
        Mixer(
            amplitude_v * rng.uniform(0.8, 1.2),
            rng.uniform(0.85, 1.15),
            np.radians(rng.uniform(-10.0, 10.0)),
            (rng.uniform(-0.5, 0.5), rng.uniform(-0.5, 0.5)),
        )
        for _ in range(N_RECEIVERS)
    )
