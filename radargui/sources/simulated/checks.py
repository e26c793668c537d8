"""Checks that a simulated scene can exist: the sphere stays clear of antennas and reflectors."""

from __future__ import annotations

import numpy as np

from radargui.geometry.antennas import Antennas
from radargui.model.errors import SetupError
from radargui.model.setup import Setup
from radargui.sources.simulated.arrays import dot
from radargui.sources.simulated.reflection import Reflector
from radargui.sources.simulated.scene import Scene

_N_PLACES = 2001
_CLEARANCE_M = 0.02


def check_clearance(setup: Setup, scene: Scene, antennas: Antennas, reflectors: tuple[Reflector, ...]) -> None:
    """Check the whole way of the sphere.

    Raises
    ------
    SetupError
        It comes within 2 cm of an antenna, or passes a reflector.
    """
    times = setup.simulation.rest_s + np.linspace(0.0, scene.trajectory.duration_s, _N_PLACES)
    position = scene.position_m(times)
    names = ["transmitter", *(f"receiver {number}" for number in range(1, antennas.n_receivers + 1))]
    for name, place in zip(names, [antennas.transmitter_m, *antennas.receivers_m], strict=True):
        away = position - place[:, None]
        if float(dot(away, away).min()) < (_CLEARANCE_M + 0.5 * setup.tracer.diameter_m) ** 2:
            raise SetupError(
                f"The simulated sphere would hit the {name}",
                remedy="Check the antennas' distances, tracer.release_position_m and the sizes in [simulation].",
            )
    for reflector in reflectors:
        if float(reflector.height_m(position).min()) >= 0.0:
            continue
        if reflector.wall is not None:
            raise SetupError(
                f"The simulated sphere would pass through wall {reflector.wall + 1}",
                remedy="Raise simulation.wall_distance_m, make the motion smaller, or set "
                "simulation.wall_reflection = 0.",
            )
        raise SetupError(
            "The simulated sphere would pass through the bottom that reflects",
            remedy="Lower the floor (floor.height_m or simulation.drop_height_m), make the motion smaller, or set "
            "simulation.reflection = 0.",
        )
