"""Where the maps live: position from the phases, or the path lengths where receivers are too few."""

from __future__ import annotations

import numpy as np

from radargui.geometry.antennas import Antennas
from radargui.geometry.bistatic import locate_exact
from radargui.model.arrays import BoolArray, FloatArray


def map_places(change_m: FloatArray, antennas: Antennas, release_m: FloatArray, rest: BoolArray) -> FloatArray:
    """Return the coordinate of the maps: exact positions (3, n), or (L - L_rest) / 2 of one or two receivers.

    Parameters
    ----------
    change_m
        Shape (n_receivers, n).
    rest
        Where the tracer still rests: its place is the release position.
    """
    if antennas.n_receivers < 3:
        place = change_m / 2.0
        place[:, rest] = 0.0
        return place
    place = locate_exact(change_m, antennas, release_m)
    place[:, rest] = release_m[:, None]
    known = np.isfinite(place).all(axis=0)
    if not known.all():
        index = np.arange(known.size)
        place = np.array([np.interp(index, index[known], row[known]) for row in place])
    return place


def range_law(place: FloatArray, antennas: Antennas, release_m: FloatArray) -> FloatArray:
    """Return 1 / (r_tx r_rx) over its value at rest, shape (n_receivers, n); ones where position is unknown."""
    if antennas.n_receivers < 3:
        return np.ones((antennas.n_receivers, place.shape[1]))

    def product(p: FloatArray) -> FloatArray:
        to_receiver = np.linalg.norm(p[None] - antennas.receivers_m[:, :, None], axis=1)
        return np.asarray(to_receiver * np.linalg.norm(p - antennas.transmitter_m[:, None], axis=0))

    return np.asarray(product(release_m[:, None]) / product(place))
