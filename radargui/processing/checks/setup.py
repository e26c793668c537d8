"""What speaks against the setup: values that no laboratory has, what was left out or edited, a floor elsewhere."""

import math
from collections.abc import Sequence

import numpy as np

from radargui.model.calibrated_setup import edited_since
from radargui.model.finding import Finding, warn
from radargui.model.result import Track
from radargui.model.setup import Setup
from radargui.physics.path_length import MIN_RECEIVERS
from radargui.processing.checks.evidence import Evidence

_FARTHEST_M = 10.0
"""From an antenna to the field of view of some 0.3 m: from farther no sphere of some mm is seen, and a laboratory's
0.5 to 1 m told in centimetres, millimetres or inches lie there."""
_MIN_TILT_DEG = 2.0
"""A laboratory's 30 to 60 degrees are 0.5 to 1.05 in radians; receivers that all stand so close to the z axis tell no
place."""
_THINNEST_AIR = 1.0001
"""n of dry air at 5000 m and 40 degrees C is 1.00013 (ITU-R P.453)."""
SIGMAS = 3.0
"""How far from what is stated, or possible, a measured value has to be, in the u of both."""
_U_FLOOR_M = 3e-3
"""Of a floor's height measured by tape, as of antennas: the setup has no u for it."""


def release_assumed(setup: Setup) -> Finding | None:
    """The release position is left out: only changes of path are measured, and the track is laid there."""
    tracer = setup.tracer
    if setup.n_receivers < MIN_RECEIVERS or "release_position_m" in tracer.model_fields_set:
        return None
    return warn("release_assumed", place_m=tuple(tracer.release_position_m))


def is_misplaced(setup: Setup) -> bool:
    """Whether antennas stand where none does: flights bend by them, and would name any place for it."""
    return antenna_far(setup) is not None or angles_in_radians(setup) is not None


def antenna_far(setup: Setup) -> Finding | None:
    """An antenna stands farther off than any."""
    antennas = {"transmitter": setup.transmitter.distance_m}
    antennas |= {f"receiver[{n}]": one.distance_m for n, one in enumerate(setup.receiver, 1)}
    far = [name for name, distance_m in antennas.items() if distance_m is not None and distance_m > _FARTHEST_M]
    return warn("antenna_far", antenna=far[0], distance_m=antennas[far[0]]) if far else None


def angles_in_radians(setup: Setup) -> Finding | None:
    """All receivers stand next to the z axis: their angles look like radians."""
    tilts = [one.tilt_deg for one in setup.receiver]
    if len(tilts) < 2 or not 0.0 < max(tilts) < _MIN_TILT_DEG:
        return None
    return warn("angles_in_radians", tilts=tuple(tilts), tilt=tilts[0], tilt_deg=math.degrees(tilts[0]))


def index_of_vacuum(setup: Setup) -> Finding | None:
    """The air is stated to be none."""
    index = setup.radar.refractive_index
    # left out it is uncertain by what air has
    if index is None or index >= _THINNEST_AIR:
        return None
    return warn("index_of_vacuum", index=index)


def floor_upside_down(setup: Setup) -> Finding | None:
    """The floor's normal points into it."""
    return None if setup.floor.normal[2] >= 0.0 else warn("floor_upside_down")


def floor_above_release(setup: Setup) -> Finding | None:
    """The sphere is let go below the floor."""
    floor_m, release_m = setup.floor.height_m, setup.tracer.release_position_m[2]
    # a release that was left out is told already
    if floor_m is None or floor_m < release_m or "release_position_m" not in setup.tracer.model_fields_set:
        return None
    return warn("floor_above_release", floor_m=floor_m, release_m=release_m)


OF_SETUP = (
    release_assumed,
    antenna_far,
    angles_in_radians,
    index_of_vacuum,
    floor_upside_down,
    floor_above_release,
    edited_since,
)
"""What the setup alone says, in order."""


def skew_too_long(evidence: Evidence) -> Finding | None:
    """Delays between channels have no room in a sample."""
    delay_s, rate_hz = evidence.part.whole.delay_s, evidence.recording.digitisation.sample_rate_hz
    if evidence.part.has_room:
        return None
    return warn("skew_too_long", n_channels=delay_s.size, delay_s=float(delay_s[1]), sample_s=1.0 / rate_hz)


def floor_elsewhere(evidence: Evidence) -> Finding | None:
    """The sphere met the floor elsewhere than it is stated, by more than both are known to."""
    stated_m, normal = evidence.setup.floor.height_m, evidence.setup.floor.normal
    track = evidence.exact_track
    if stated_m is None or track is None:
        return None
    met = _touch_m(track, [one.time_s for one in evidence.bounces.impacts if one.valid], normal, stated_m)
    if met is None:
        return None
    height_m, u_m = met
    if not abs(height_m - stated_m) > SIGMAS * math.hypot(u_m, _U_FLOOR_M):
        return None
    x, y, _ = normal
    return warn("floor_elsewhere", height_m=height_m, stated_m=stated_m, is_tilted=not x == y == 0.0)


def _touch_m(
    track: Track, times_s: Sequence[float], normal: tuple[float, float, float], stated_m: float
) -> tuple[float, float] | None:
    """Return the height on the z axis of the floor touched at some instants, and its u; None without any.

    Of several floors, a plate and the table below it, the one next to what the setup says: that it speaks of one of
    them is no contradiction.
    """
    if not times_s or normal[2] <= 0.0:
        return None
    # the next sample is less than a millimetre away: a tape tells no less
    place = np.minimum(np.searchsorted(track.time_s, times_s), track.time_s.size - 1)
    place = place[track.valid[place] & np.isfinite(track.position_m[:, place]).all(axis=0)]
    if not place.size:
        return None
    u_m = track.u_position_m if track.u_combined_m is None else track.u_combined_m
    # a plane that leans is met higher or lower away from the axis
    height_m = np.asarray(normal) @ track.position_m[:, place] / normal[2]
    nearest = int(np.argmin(np.abs(height_m - stated_m)))
    return float(height_m[nearest]), float(u_m[2, place[nearest]])
