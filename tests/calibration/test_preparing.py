"""What is measured of a recording before any fit: the phase of a known motion, the impacts of a fall."""

from __future__ import annotations

import numpy as np

from radargui.calibration.preparing import against, impacts_of_most
from radargui.model.gravity import NOMINAL_GRAVITY_M_S2

TURN = 2.0 * np.pi


def test_no_fringe_is_lost_where_a_lobe_is_smaller_than_what_a_floor_moves_the_circle_by() -> None:
    time = np.arange(0.0, 4.0, 0.002)
    phase = 60.0 * np.cos(TURN * time / 2.0)
    amplitude = 0.55 + 0.45 * np.cos(TURN * (time - 0.3) / 2.0)
    centre = 0.2 * np.exp(1j * TURN * time / 2.0)
    value = 0.4 - 0.3j + centre + amplitude * np.exp(1j * phase)
    foretold = phase + 1.5 * np.sin(TURN * time / 3.0)
    error = against(foretold, np.array([value.real, value.imag]))[1] - phase
    error -= np.median(error)
    assert np.median(np.abs(error)) < 0.3
    # half a turn where the circle is smaller than the centre's way, never one that stays
    assert np.abs(error).max() < 1.1 * np.pi
    assert abs(error[-50:].mean() - error[:50].mean()) < 0.6


def test_the_phase_of_a_clean_circle_is_measured_within_a_hundredth_of_a_turn_at_rest_too() -> None:
    time = np.arange(0.0, 3.0, 0.002)
    phase = 0.4 + 30.0 * np.sin(np.clip(time - 0.5, 0.0, 2.0)) ** 2
    value = 0.1j + np.exp(1j * phase)
    error = against(phase + 0.4 * np.sin(time), np.array([value.real, value.imag]))[1] - phase
    assert np.ptp(error) < 2.0 * 0.01 * TURN


def test_an_impact_is_found_though_one_receiver_loses_a_fringe_as_the_sphere_hits() -> None:
    rate_hz = 5000.0
    time = np.arange(0.0, 0.9, 1.0 / rate_hz)
    since = np.clip(time - 0.3, 0.0, None)
    fall_s, rise_s = 0.2, time - 0.5
    height = np.where(time < 0.5, -4.905 * since**2, -4.905 * fall_s**2 + 1.5 * rise_s - 4.905 * rise_s**2)
    rng = np.random.default_rng(3)
    paths = np.outer([-1.9, -1.8, -1.85], height) + rng.normal(0.0, 2e-5, (3, time.size))
    paths[2] -= 0.03 * (np.abs(time - 0.5) < 0.003)
    found = impacts_of_most(time, paths, 0.3, rate_hz, NOMINAL_GRAVITY_M_S2)
    first = found[0]
    assert abs(first - 0.5) < 0.001
    # below the antennas or above them
    assert np.allclose(impacts_of_most(time, -paths, 0.3, rate_hz, NOMINAL_GRAVITY_M_S2), found)
