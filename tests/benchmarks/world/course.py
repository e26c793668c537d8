"""A motion from its start place, wherever that is put: closed forms of an arm and of straight ways."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from benchmarks.world.bed import Grains
from benchmarks.world.drop import Impact
from benchmarks.world.profile import Array, Profile

UP = np.array([0.0, 0.0, 1.0])
_LOOKED_AT = 2000


@dataclass(frozen=True)
class Course:
    """Where the sphere goes, counted from where it rests and from when it leaves.

    What holds it (arm, thread, hand, stage) reflects nothing.

    Attributes
    ----------
    offset_m
        Displacements (3, n) at times (n,) in s since it left; 0 before.
    lasts_s
        From leaving to the end of the record.
    impacts
        In time order, since it left.
    falls
        Whether it flies freely somewhere.
    touch_m, normal
        A displacement at which the sphere touches the floor, and the floor's normal, where the course says so: both or
        the place alone; without a place the floor is somewhere below.
    facts
        What was drawn, for the printed line.
    spread_m
        How far sideways from the axis it begins at the most; None: anywhere.
    sides
        Upright walls that it meets: unit vector towards the sphere, where their surface is (a displacement), and the
        share of the field they send back.
    grains
        What it sinks into.
    breaks_s
        Where the velocity may jump, since it left.
    """

    offset_m: Callable[[Array], Array]
    lasts_s: float
    impacts: tuple[Impact, ...] = ()
    falls: bool = False
    touch_m: Array | None = None
    normal: Array | None = None
    facts: dict[str, object] = field(default_factory=dict)
    spread_m: float | None = None
    sides: tuple[tuple[Array, Array, float], ...] = ()
    grains: Grains | None = None
    breaks_s: tuple[float, ...] = ()

    def places_m(self) -> Array:
        """Return displacements over the whole course, shape (3, 2000)."""
        return self.offset_m(np.linspace(0.0, self.lasts_s, _LOOKED_AT))


def along(direction: Array, profile: Profile) -> Callable[[Array], Array]:
    """Return displacements along a unit vector (3,) by the profile of the speed."""
    return lambda time_s: np.outer(direction, profile.way(time_s))


def circle(profile: Profile, radius_m: float, normal: Array, begin_rad: float) -> Callable[[Array], Array]:
    """Return displacements of the end of an arm that turns about a normal (3,) by the profile of the angular speed."""
    across = np.cross(normal, np.eye(3)[np.abs(normal).argmin()])
    across /= np.linalg.norm(across)
    beside = np.cross(normal, across)

    def offset_m(time_s: Array) -> Array:
        angle = begin_rad + profile.way(time_s)
        around = np.outer(across, np.cos(angle) - np.cos(begin_rad))
        return radius_m * (around + np.outer(beside, np.sin(angle) - np.sin(begin_rad)))

    return offset_m


def downhill(slope_rad: float, azimuth_rad: float) -> tuple[Array, Array]:
    """Return the unit vectors down a board that leans, and away from it."""
    level = np.array([np.cos(azimuth_rad), np.sin(azimuth_rad), 0.0])
    down = np.cos(slope_rad) * level - np.sin(slope_rad) * UP
    return down, np.sin(slope_rad) * level + np.cos(slope_rad) * UP
