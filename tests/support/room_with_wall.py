"""A drop beside a wall, prepared for a calibration that does not know the wall yet."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from support.changed import changed
from support.simulated_recording import simulate_recording

from radargui.calibration.likelihood import World
from radargui.calibration.preparing import Prepared, prepare_fall
from radargui.calibration.unknowns import Unknown, antenna_unknowns, fall_unknowns, place_unknowns
from radargui.estimation.select.wall_grid import upright_planes
from radargui.model.setup import Setup, read_setup
from radargui.physics.mirrors import MirrorPlane
from radargui.system.resources import default_setup_path

RELEASE = "tracer.release_position_m"
UP = np.array([0.0, 0.0, 1.0])
WALL_M, WALL_DEG = 0.30, 40.0


@dataclass(frozen=True)
class RoomWithWall:
    """The drop, and all that its calibration shares."""

    setup: Setup
    unknowns: list[Unknown]
    world: World
    ready: Prepared


def room_with_wall(rate_hz: float) -> RoomWithWall:
    setup = changed(
        read_setup(default_setup_path()),
        daq={"rate_hz": rate_hz, "channel_skew_s": 0.0},
        simulation={
            "rest_s": 0.3, "settle_s": 0.1, "restitution": 0.3, "snr_db": 40.0, "reflection": 0.1, "drift": 0.0,
            "wall_reflection": 0.06, "wall_distance_m": [WALL_M], "wall_azimuth_deg": [WALL_DEG],
        },
    )  # fmt: skip
    recording, _ = simulate_recording(setup)
    place = tuple(setup.tracer.release_position_m)
    unknowns = [*antenna_unknowns(setup), *place_unknowns(setup, place, RELEASE), *fall_unknowns(setup)]
    return RoomWithWall(setup, unknowns, World(setup, tuple(unknowns)), prepare_fall(recording, setup, RELEASE))


def true_wall() -> list[MirrorPlane]:
    return upright_planes(np.zeros(3), UP, np.array([np.radians(WALL_DEG + 180.0)]), np.array([WALL_M]))
