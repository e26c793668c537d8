"""Noise, bins, maps and onset: the stages that adaptive and joint share."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from radargui.estimation.forward.position_map import make_basis
from radargui.estimation.motion_estimate import channel_qualities
from radargui.estimation.signals import ScaledSignals
from radargui.model.front_end import FrontEnd


def signals_of(value: np.ndarray, rate: float) -> ScaledSignals:
    n = value.shape[1]
    return ScaledSignals(
        np.arange(n) / rate,
        value,
        np.ones(n, bool),
        np.ones((value.shape[0] // 2, n), bool),
        np.zeros(value.shape[0] // 2),
        np.full(value.shape[0], 0.01),
        np.ones(value.shape[0] // 2),
        np.zeros(value.shape[0]),
        (None,) * (value.shape[0] // 2),
        None,
        rate,
        0.0,
        0.0,
    )


def test_a_map_follows_a_smooth_function_of_position() -> None:
    z = np.linspace(0.0, 0.25, 800)
    place = np.stack([0.01 * np.sin(20 * z), 0 * z, z])
    basis = make_basis(place, 0.1)
    wanted = 0.2 * np.cos(2 * np.pi * z / 0.3) + z**2
    functions = basis(place)
    found = functions @ np.linalg.lstsq(functions, wanted, rcond=1e-10)[0]
    assert np.abs(found - wanted).max() < 2e-4


def test_the_noise_of_a_receiver_is_told_in_its_amplitude_and_its_quality_is_that_of_the_motion() -> None:
    n, amplitude = 2000, np.array([2.0, 0.5])
    phase = np.stack([np.linspace(0.0, 60.0, n)] * 2)
    signals = replace(signals_of(np.zeros((4, n)), 1000.0), unusable_share=np.array([0.0, 0.02]))
    moving = np.arange(n) >= 200
    valid = np.ones((2, n), dtype=np.bool_)
    valid[1, 200:290] = False
    # what is off the circle before the motion does not count
    i, q = np.where(moving, np.cos(phase), 3.0), np.where(moving, np.sin(phase), 3.0)
    ends = (FrontEnd(1.1, 0.01, 2.0, 0.1), FrontEnd(0.9, 0.02, -3.0, 0.2))
    one, other = channel_qualities(
        signals, moving, (i, q), valid, phase, amplitude, np.array([0.3, 0.3]), np.array([1.0, 1.0]), ends
    )
    # 10 log10(A^2 / 2 sigma^2), sigma 0.01
    assert one.snr_db == pytest.approx(10.0 * np.log10(2.0**2 / 2e-4))
    assert other.snr_db == pytest.approx(10.0 * np.log10(0.5**2 / 2e-4))
    assert (one.name, other.name) == ("1", "2")
    assert (one.gain_ratio, one.u_gain_ratio, other.quadrature_error_deg, other.u_quadrature_error_deg) == (
        1.1,
        0.01,
        -3.0,
        0.2,
    )
    assert one.circularity == pytest.approx(0.0, abs=1e-9)
    assert (one.fraction_valid, other.fraction_valid) == (1.0, 0.95)
    assert (one.fraction_clipped, other.fraction_clipped) == (0.0, 0.02)
    # the same noise of a bin, in amplitudes: 15 % and 60 %
    assert (one.verdict, other.verdict) == ("good", "rejected")
    assert other.reason.startswith("noise of 60 % of the amplitude")
