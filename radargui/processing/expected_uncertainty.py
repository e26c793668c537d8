"""What a position will be uncertain by, before anything is recorded: the budget of a result, of places alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.model.result import Bounces, PathLengths, Segment
from radargui.model.setup import Setup
from radargui.model.uncertainty_budget import UncertaintyBudget
from radargui.physics.path_length import HALF_FIELD_M, MIN_RECEIVERS, path_lengths, place_antennas, range_factor
from radargui.processing.measured_motion import locate
from radargui.processing.uncertainty_budget import changes_of_track, with_budget
from radargui.restitution.bounces import FlownTrack

POINTS = 25
"""Of a map along each edge: a place every 12.5 mm, between which u changes by a twentieth."""


def expected_uncertainty(
    position_m: FloatArray, setup: Setup, snr_db: float
) -> tuple[FloatArray, UncertaintyBudget] | None:
    """Return the combined standard uncertainty of places where the sphere may be, and their budget.

    The budget's own rules (method 6) on the exact paths to these places. Noise is that of one sample, u(phase) =
    sigma / A with SNR = 10 log10(A^2 / (2 sigma^2)) at the release, A falling with the ways there and back; what a
    correction leaves, and walls, are not in it.

    Parameters
    ----------
    position_m
        Shape (3, n).
    setup
        Antennas, release, sphere, wave, and what they are uncertain by.
    snr_db
        Of a sample at the release.

    Returns
    -------
    tuple or None
        u of x, y, z in metres, shape (3, n), NaN where no place is determined; None with fewer than three receivers.
    """
    antennas, release = place_antennas(setup), np.array(setup.tracer.release_position_m)
    if antennas.n_receivers < MIN_RECEIVERS:
        return None
    change_m = path_lengths(position_m, antennas) - path_lengths(release[:, None], antennas)
    u_rad = 10.0 ** (-snr_db / 20.0) / np.sqrt(2.0) / range_factor(position_m, antennas, release)
    per_rad, n = setup.radar.wavelength_m / (2.0 * np.pi), position_m.shape[1]
    # a second apart: none is averaged with its neighbour
    paths = PathLengths(
        np.arange(n, dtype=np.float64), change_m / per_rad, change_m, per_rad * u_rad, np.isfinite(change_m)
    )
    track, whole = locate(paths, setup), Segment(0, n, 0, 0)
    if track is None:
        return None
    changes = changes_of_track(paths, FlownTrack(Bounces()), setup, whole)
    track, _, budget = with_budget(track, Bounces(), changes, whole, setup)
    return (track.u_position_m if track.u_combined_m is None else track.u_combined_m), budget


@dataclass(frozen=True, slots=True, eq=False)
class UncertaintyMap:
    """Two planes through the field of view.

    Attributes
    ----------
    planes_mm
        Root mean square of u over x, y and z, shape (2, n, n): from the side (x, z) and from above (x, y).
    release_mm, largest_share
        At the release, and what it comes from most.
    """

    planes_mm: FloatArray
    release_mm: float
    largest_share: str


def map_of(setup: Setup, snr_db: float) -> UncertaintyMap | None:
    """Return the map of a setup; None where fewer than three receivers tell no place."""
    edge = np.linspace(-HALF_FIELD_M, HALF_FIELD_M, POINTS)
    places = np.zeros((3, 2, POINTS, POINTS))
    # across x in both planes; upwards z from the side, y from above
    places[0], places[2, 0], places[1, 1] = edge[:, None], edge, edge
    release = np.array(setup.tracer.release_position_m)[:, None]
    # two places to tell the release's own budget: one alone has no spacing
    at_release = expected_uncertainty(np.repeat(release, 2, axis=1), setup, snr_db)
    found = expected_uncertainty(places.reshape(3, -1), setup, snr_db)
    if found is None or at_release is None:
        return None
    u_mm = 1e3 * np.sqrt((found[0] ** 2).mean(axis=0)).reshape(2, POINTS, POINTS)
    line = at_release[1].position_m
    shares = {"noise": line.statistical, "antennas, release and wave": line.calibration, "the sphere": line.sphere}
    return UncertaintyMap(u_mm, 1e3 * (line.combined or np.nan), max(shares, key=lambda one: shares[one] or 0.0))
