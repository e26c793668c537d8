"""The track from path lengths, by the chosen geometry (method 3)."""

from dataclasses import replace

import numpy as np

from radargui.geometry.bistatic import locate_exact, position_uncertainty
from radargui.geometry.path_length import LEAST_RECEIVERS, locate_plane, place_antennas
from radargui.geometry.scattering import path_delay
from radargui.model.arrays import FloatArray
from radargui.model.result import PathLengths, Track
from radargui.model.setup import Setup


def locate_body(paths: PathLengths, setup: Setup) -> tuple[PathLengths, Track | None]:
    """Return the paths to the sphere's centre, and the track, from paths as their phase was measured.

    Where the setup gives the polarisation, the phase that the sphere scatters with is taken off the direct path, and
    what a container's walls delay, in one step: it changes by a thousandth of what the place does. What it does to
    mirrored paths stays.
    """
    track, delay = locate(paths, setup), path_delay(setup)
    if track is None or delay is None:
        return paths, track
    # where not all receivers know their path the place is unknown, and so is the delay
    change_m = paths.change_m - np.nan_to_num(delay.at(track.position_m))
    paths = replace(paths, change_m=change_m)
    return paths, locate(paths, setup)


def locate(paths: PathLengths, setup: Setup) -> Track | None:
    """Return the positions of the sphere's centre.

    Parameters
    ----------
    paths
        Change of path length of every receiver.
    setup
        Antennas of as many receivers, where the sphere hangs at rest, and the geometry: exact (bistatic) or plane (far
        field).

    Returns
    -------
    Track or None
        None with fewer than three receivers.
    """
    if setup.n_receivers < LEAST_RECEIVERS:
        return None
    # an invalid path would pull the place without a sign of it
    position = place_at(np.where(paths.valid, paths.change_m, np.nan), setup)
    # linear propagation of u(L_i) through the inverse of the rows dL_i/dp (GUM 5.1.2)
    u = position_uncertainty(position, paths.u_m, place_antennas(setup))
    return Track(paths.time_s, position, u, np.asarray(np.isfinite(position).all(axis=0)), setup.processing.geometry)


def place_at(change_m: FloatArray, setup: Setup) -> FloatArray:
    """Return the places (3, n) at changes of the paths (n_receivers, n); NaN for NaN, setup as above."""
    solve = locate_plane if setup.processing.geometry == "plane" else locate_exact
    # changes of path count from the release: there the antennas' geometry fixes L itself
    return solve(change_m, place_antennas(setup), np.array(setup.tracer.release_position_m))
