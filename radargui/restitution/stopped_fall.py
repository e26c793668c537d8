"""A fall that ends without an impact: in what stops the sphere, the wave may be slower than in air; or it gives way.

Method 5, One fall into a bed.
"""

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.model.finding import Finding, warn
from radargui.model.result import Bounces, FreeFall, Track
from radargui.restitution.settings import CHECKS


def braked_without_impact(bounces: Bounces, track: Track) -> Finding | None:
    """Return a finding where the sphere falls freely and is then stopped on some way, not by an impact.

    A path of the length s in a medium of refractive index n shows as n s: below the surface of grains the track is too
    deep by (n - 1) times the depth. No setup states a medium. What throws the sphere up again after some ms is no
    medium, but has no instant of impact either.

    Parameters
    ----------
    bounces
        With the first fall, which ends where the motion no longer falls freely.
    track
        Position of the sphere's centre.
    """
    fall = bounces.free_fall
    if fall is None or bounces.impacts or bounces.normal is None:
        return None
    after = track.valid & (track.time_s >= fall.last_time_s)
    if not after.any():
        return None
    height = np.asarray(bounces.normal) @ track.position_m[:, after]
    u_m = np.linalg.norm(np.asarray(bounces.normal)[:, None] * track.u_position_m[:, after], axis=0)
    free = _last_free(fall, track.time_s[after], height, u_m)
    lowest = free + int(np.argmin(height[free:]))
    way_m, back_m = float(height[free] - height[lowest]), float(height[lowest:].max() - height[lowest])
    if way_m < CHECKS.min_braked_m:
        return None
    if back_m > CHECKS.min_braked_m:
        return warn("fall_ends_softly", way_m=way_m, back_m=back_m)
    return warn("fall_without_rebound", way_m=way_m)


def _last_free(fall: FreeFall, time_s: FloatArray, height_m: FloatArray, u_m: FloatArray) -> int:
    """Return the last sample on the fall's parabola: the fit ends before that, to be sure."""
    since_s = time_s - fall.first_time_s
    a, b, c = fall.parabola
    above = height_m - (a + b * since_s + c * since_s**2)
    is_braked = above > CHECKS.min_above_m + CHECKS.coverage * u_m
    return max(int(np.argmax(is_braked)) - 1, 0)
