"""The phase of a known motion, measured against the one that the setup makes of it."""

from __future__ import annotations

import numpy as np

from radargui.calibration.preparing import against

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
