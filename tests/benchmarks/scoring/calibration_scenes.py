"""Recordings to calibrate with: drops of one laboratory from several places, circles, and a setup that is off."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from benchmarks.world.draw import draw
from benchmarks.world.drop import Array, Drop, Floor, fall
from benchmarks.world.scene import Record, Scene, make_record

from radargui.calibration.known_path import Trajectory, read_known
from radargui.calibration.rough_fit import KnownRecording
from radargui.model.radar import Floor as StatedFloor, Site
from radargui.model.setup import Setup

PLACES = ((0.0, 0.0, 0.12), (0.08, 0.02, 0.10), (-0.03, 0.09, 0.14))
HEIGHT_M = 0.22
U_CIRCLE_M = 5e-5
"""Of the circle's place as a whole, as its path file states it; its true place is exact."""
NEAREST_WALL_M = 0.2
"""A turntable needs its room: a wall that is drawn nearer stands here."""
OFF_DEG, OFF_M, OFF_RELEASE_M = 3.0, 0.02, 0.002
"""Seeded errors of the setup, even between plus and minus these; their deviation is this over the root of three."""


@dataclass(frozen=True)
class Laboratory:
    """One laboratory: what is true and what its setup says.

    Attributes
    ----------
    scene
        As drawn.
    setup
        Off by the seeded errors, which it states as its u.
    places_m
        Where the sphere hangs as the setup says, one of `PLACES` each.
    """

    scene: Scene
    setup: Setup
    places_m: tuple[tuple[float, float, float], ...]

    @property
    def floor_m(self) -> float:
        """Where the sphere's centre touches the floor."""
        return self.scene.setup.tracer.release_position_m[2] - HEIGHT_M


def laboratory(seed: int, **held: object) -> Laboratory:
    """Return the laboratory of a seed: mismatch, noise, a floor, and in half of them a wall."""
    scene = draw(seed, "exact", lively=False, height_m=HEIGHT_M, **held)
    wall = scene.room.mirrors[1:]
    if wall and "wall_distance_m" not in held and -wall[0].offset_m < NEAREST_WALL_M:
        scene = draw(seed, "exact", lively=False, height_m=HEIGHT_M, **(held | {"wall_distance_m": NEAREST_WALL_M}))
    rng, third = np.random.default_rng([seed, 31]), 3.0**-0.5

    def off(value: float, by: float) -> float:
        return value + float(rng.uniform(-by, by))

    true = scene.setup
    sender = {"distance_m": off(true.transmitter.distance_m or 0.0, OFF_M), "u_distance_m": OFF_M * third}
    receivers = tuple(
        one.model_copy(
            update={
                "tilt_deg": off(one.tilt_deg, OFF_DEG),
                "azimuth_deg": off(one.azimuth_deg, OFF_DEG),
                "distance_m": off(one.distance_m, OFF_M),
                "u_tilt_deg": OFF_DEG * third,
                "u_azimuth_deg": OFF_DEG * third,
                "u_distance_m": OFF_M * third,
            }
        )
        for one in true.receiver
    )
    places = tuple(tuple(off(x, OFF_RELEASE_M) for x in place) for place in PLACES)
    setup = true.model_copy(
        update={
            "transmitter": true.transmitter.model_copy(update=sender),
            "receiver": receivers,
            "tracer": true.tracer.model_copy(
                update={"release_position_m": places[0], "u_release_m": OFF_RELEASE_M * third}
            ),
            "floor": StatedFloor(height_m=off(true.tracer.release_position_m[2] - HEIGHT_M, OFF_RELEASE_M)),
            "site": Site(g_m_s2=scene.body.gravity_m_s2, u_g_m_s2=1e-4),
        }
    )
    return Laboratory(scene, setup, places)  # type: ignore[arg-type]


def dropped(lab: Laboratory, number: int, place: int) -> Record:
    """Return a drop from one of the places onto the floor that all have in common."""
    floor = Floor(np.array([0.0, 0.0, 1.0]), np.array([0.0, 0.0, lab.floor_m]), 0.8, kick_m_s=0.01)
    rng = np.random.default_rng([lab.scene.seed, number, 5])
    drop = fall(rng, lab.scene.body, floor, np.array(PLACES[place]), start_s=0.3, duration_s=1.2)
    return _recorded(lab, drop, f"drop-{number}", 100 + number)


def circled(lab: Laboratory, folder: Path, *, centre_m: Array, radius_m: float = 0.10) -> tuple[Record, Trajectory]:
    """Return a circle that leans, off the axis, and what a table of places on the recording's clock says of it."""
    lean, turns, ramp_s, period_s, start_s = np.radians(65.0), 2.0, 0.5, 2.0, 0.5
    across, along = np.array([0.0, 1.0, 0.0]), np.array([np.cos(lean), 0.0, np.sin(lean)])
    lasts = turns * period_s + ramp_s

    def position(time: Array) -> Array:
        t = np.clip(time - start_s, 0.0, lasts)
        share = np.minimum(t, ramp_s) / ramp_s, np.maximum(t - (lasts - ramp_s), 0.0) / ramp_s
        # the rate rises and falls as 3 s^2 - 2 s^3, whose integral is s^3 - s^4 / 2
        rise, slow = (ramp_s * (s**3 - 0.5 * s**4) for s in share)
        even = np.clip(t - ramp_s, 0.0, lasts - 2.0 * ramp_s)
        angle = 2.0 * np.pi / period_s * (rise + even + np.maximum(t - (lasts - ramp_s), 0.0) - slow)
        return np.asarray(
            centre_m[:, None] + radius_m * (along[:, None] * np.cos(angle) + across[:, None] * np.sin(angle))
        )

    record = _recorded(lab, Drop(position, start_s, start_s + lasts + 0.3, ()), "circle", 1)
    times = np.arange(0.0, start_s + lasts + 0.3, 0.005)
    path = folder / f"circle-{lab.scene.seed}.csv"
    table = np.column_stack([times, *position(times)])
    np.savetxt(path, table, delimiter=",", header="time_s,x_m,y_m,z_m", comments="", fmt="%.9f")
    stated = path.with_suffix(".toml")
    stated.write_text(f'kind = "table"\nfile = "{path.name}"\nu_position_m = {U_CIRCLE_M}\n')
    return record, read_known(stated, "shared")


def _recorded(lab: Laboratory, drop: Drop, name: str, number: int) -> Record:
    return make_record(replace(lab.scene, drop=drop, name=name, seed=1000 * lab.scene.seed + number))


def known(record: Record, trajectory: Trajectory | None, release_m: tuple[float, float, float]) -> KnownRecording:
    """Return a record as the calibration reads it."""
    return KnownRecording(record.recording, record.scene.name, "", trajectory, release_m)


def truth(lab: Laboratory, name: str) -> float | None:
    """Return the true value of an antenna's unknown; None of what is none."""
    true, parts = lab.scene.setup, name.split(".")
    if parts[0] == "receiver":
        return float(getattr(true.receiver[int(parts[1]) - 1], parts[2]))
    return true.transmitter.distance_m if name == "transmitter.distance_m" else None
