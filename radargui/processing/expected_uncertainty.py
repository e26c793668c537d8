"""What a position will be uncertain by, before anything is recorded: the budget of a result, of places alone."""

from __future__ import annotations

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.model.result import Bounces, PathLengths, Segment
from radargui.model.setup import Setup
from radargui.model.uncertainty_budget import UncertaintyBudget
from radargui.physics.path_length import MIN_RECEIVERS, path_lengths, place_antennas, range_factor
from radargui.processing.measured_motion import locate
from radargui.processing.uncertainty_budget import changes_of_track, with_budget
from radargui.restitution.bounces import FlownTrack


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
