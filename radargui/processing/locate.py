"""The track from path lengths, by the chosen geometry."""

from __future__ import annotations

import numpy as np

from radargui.geometry.antennas import Antennas
from radargui.geometry.bistatic import locate_exact, position_uncertainty
from radargui.geometry.plane_wave import locate_plane
from radargui.model.arrays import FloatArray
from radargui.model.path import PathLengths
from radargui.model.track import Track

LEAST_RECEIVERS = 3


def locate(paths: PathLengths, antennas: Antennas, release_position_m: FloatArray, geometry: str) -> Track | None:
    """Return the positions of the sphere's centre.

    Parameters
    ----------
    paths
        Change of path length of every receiver.
    antennas
        As many receivers.
    release_position_m
        Where the sphere hangs at rest, shape (3,).
    geometry
        exact (bistatic) or plane (far field).

    Returns
    -------
    Track or None
        None with fewer than three receivers.
    """
    if antennas.n_receivers < LEAST_RECEIVERS:
        return None
    change = np.where(paths.valid, paths.change_m, np.nan)
    if geometry == "plane":
        position = locate_plane(change, antennas, release_position_m)
    else:
        position = locate_exact(change, antennas, release_position_m)
    u = position_uncertainty(position, paths.u_m, antennas)
    return Track(paths.time_s, position, u, np.asarray(np.isfinite(position).all(axis=0)), geometry)
