"""A fall that ends without a rebound: in what stops the sphere, the wave may be slower than in air.

Method 5, One fall into a bed.
"""

import numpy as np

from radargui.model.result import Bounces, Track
from radargui.restitution.settings import CHECKS


def braked_without_rebound(bounces: Bounces, track: Track) -> list[str]:
    """Return a sentence where the sphere falls freely and is then stopped on some way, not by an impact.

    A path of the length s in a medium of refractive index n shows as n s: below the surface of grains the track is too
    deep by (n - 1) times the depth. No setup states a medium.

    Parameters
    ----------
    bounces
        With the first fall, which ends where the motion no longer falls freely.
    track
        Position of the sphere's centre.
    """
    fall = bounces.free_fall
    if fall is None or bounces.impacts or bounces.normal is None:
        return []
    after = track.valid & (track.time_s >= fall.last_time_s)
    if not after.any():
        return []
    height = np.asarray(bounces.normal) @ track.position_m[:, after]
    way_m = float(height[0] - height.min())
    if way_m < CHECKS.least_braked_m:
        return []
    sentence = (
        f"the fall ends without a rebound, {1e3 * way_m:.0f} mm deeper: where grains or a liquid stop the sphere, the "
        "wave is slower than in air, and below their surface the track is too deep by a share n - 1 (foam beads up to "
        "2 %), which no uncertainty holds"
    )
    return [sentence]
