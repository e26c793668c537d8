"""The antennas' share of the uncertainty where a calibration gives their covariance, and the check by one drop."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.calibrations import antenna_names, calibration_of, u_of
from support.changed import changed
from support.small_setups import quick_setup

from radargui.model.arrays import FloatArray
from radargui.model.assumed import uncertain_inputs
from radargui.model.calibrated_setup import calibrated
from radargui.model.result import Bounces, PathLengths, Segment, Track
from radargui.model.setup import Setup, moved
from radargui.physics.path_length import path_lengths, place_antennas
from radargui.processing.measured_motion import locate
from radargui.processing.uncertainty_budget import changes_of_track, with_budget
from radargui.restitution.bounces import FlownTrack

DRAWS = 2000


def certain_setup() -> Setup:
    """Return a setup in which nothing but the antennas is uncertain."""
    exact = {"frequency_hz": 1e10, "u_frequency_hz": 0.0, "refractive_index": 1.0003}
    setup = changed(quick_setup(), radar=exact, tracer={"u_release_m": 0.0, "u_diameter_m": 0.0})
    fields = {"polarization_deg": 0.0, "u_polarization_deg": 0.0}
    receivers = [one.model_copy(update={"u_polarization_deg": 0.0}) for one in setup.receiver]
    sender = setup.transmitter.model_copy(update={**fields, "u_x_m": 0.0, "u_y_m": 0.0})
    return setup.model_copy(update={"receiver": tuple(receivers), "transmitter": sender})


def correlated(setup: Setup) -> FloatArray:
    """Return a covariance with a common scale of all distances and tilts that lean together."""
    names = antenna_names(setup)
    r = np.eye(len(names))
    for key in ("distance_m", "tilt_deg"):
        same = np.array([name.endswith(key) for name in names])
        r[np.ix_(same, same)] = 0.98
    np.fill_diagonal(r, 1.0)
    u = u_of(names)
    return r * np.outer(u, u)


def fallen(setup: Setup) -> tuple[PathLengths, Track, Segment]:
    """Return exact changes of path over a fall from the release, and its track."""
    time_s = np.linspace(0.0, 0.2, 401)
    place = np.array(setup.tracer.release_position_m)[:, None] - np.array([[0.1], [-0.05], [0.0]]) * time_s
    place[2] -= 4.9 * time_s**2
    lengths = path_lengths(place, place_antennas(setup))
    nothing = np.zeros_like(lengths)
    paths = PathLengths(time_s, nothing, lengths - lengths[:, :1], nothing, np.ones(time_s.size, dtype=bool))
    track = locate(paths, setup)
    assert track is not None
    return paths, track, Segment(0, time_s.size, 0, 0)


def share_of(setup: Setup) -> float:
    paths, track, segment = fallen(setup)
    changes = changes_of_track(paths, FlownTrack(Bounces()), setup, segment)
    share = with_budget(track, Bounces(), changes, segment, setup)[2].position_m.calibration
    assert share is not None
    return share


def by_draws(setup: Setup, covariance: FloatArray) -> float:
    """Return the rms over draws of the antennas of the shift of the track, located with each."""
    paths, track, _ = fallen(setup)
    few = slice(None, None, 25)
    thin = replace(
        paths, **{key: getattr(paths, key)[..., few] for key in ("time_s", "phase_rad", "change_m", "u_m", "valid")}
    )
    rng, total = np.random.default_rng(5), 0.0
    keys = [one.replace("receiver.", "receiver[", 1).replace(".", "].", 1) for one in antenna_names(setup)[:-1]]
    for x in rng.multivariate_normal(np.zeros(len(covariance)), covariance, DRAWS):
        other = setup
        for key, by in zip([*keys, "transmitter.distance_m"], x, strict=True):
            other = moved(other, key, float(by))
        there = locate(thin, other)
        assert there is not None
        total += float(np.mean((there.position_m - track.position_m[:, few]) ** 2))
    return float(np.sqrt(total / DRAWS))


def test_the_directions_of_a_covariance_are_all_of_it() -> None:
    setup = certain_setup()
    covariance = correlated(setup)
    setup = calibrated(setup, calibration_of(setup, covariance=covariance), Path("c.json"))
    directions = [one.together for one in uncertain_inputs(setup) if one.together]
    again = sum(np.outer(d, d) for d in (np.array([by for _, by in one]) for one in directions))
    assert again == pytest.approx(covariance, abs=1e-12)


@pytest.mark.slow
def test_correlated_antennas_leave_the_share_that_draws_of_them_do() -> None:
    setup = certain_setup()
    covariance = correlated(setup)
    independent = np.diag(np.diag(covariance))
    shares = {}
    for name, own in (("together", covariance), ("alone", independent)):
        shares[name] = share_of(calibrated(setup, calibration_of(setup, covariance=own), Path("c.json")))
        # of an rms that one direction may rule: 1 / sqrt(2 n), thrice
        assert shares[name] == pytest.approx(by_draws(setup, own), rel=3.0 / np.sqrt(2.0 * DRAWS)), name
    # without the file the same u stand in the setup, each by itself
    plain = calibrated(setup, calibration_of(setup, covariance=covariance), Path("c.json"))
    plain = plain.model_copy(update={"calibration": setup.calibration})
    assert share_of(plain) == pytest.approx(shares["alone"], rel=1e-6)
    assert shares["together"] < 0.5 * shares["alone"]
