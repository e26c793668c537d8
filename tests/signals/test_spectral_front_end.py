"""Front end from the lines of I and Q: found for mixers, none for what turns no one way."""

from __future__ import annotations

import numpy as np
import pytest

from radargui.model.front_end import FrontEnd, channels_of
from radargui.signals.doppler import ALONE, measure_doppler
from radargui.signals.spectral_front_end import front_end_of

RATE_HZ, NOISE_V = 20000.0, 0.01
PHASE = 2 * np.pi * 240.0 * np.arange(40000) / RATE_HZ


def found(pair: np.ndarray) -> FrontEnd | None:
    noisy = pair + NOISE_V * np.random.default_rng(3).normal(size=pair.shape)
    return front_end_of(measure_doppler(noisy, RATE_HZ, np.full(2, NOISE_V), ALONE))


@pytest.mark.parametrize(("gain", "angle_deg"), [(1.0, 0.0), (0.6, 35.0), (1.6, -35.0)])
def test_a_cheap_mixer_is_measured_whatever_its_offset(gain: float, angle_deg: float) -> None:
    z = np.exp(1j * PHASE)
    front_end = found(channels_of(z, z, gain, np.radians(angle_deg)) + np.array([[0.7], [-2.0]]))
    assert front_end is not None
    assert abs(front_end.gain_ratio - gain) < 2.0 * front_end.u_gain_ratio
    assert abs(front_end.quadrature_error_deg - angle_deg) < 2.0 * front_end.u_quadrature_error_deg
    assert front_end.u_quadrature_error_deg < 0.5


@pytest.mark.parametrize(("gain", "angle_deg"), [(1.0, 80.0), (0.2, 0.0), (4.0, 10.0)])
def test_what_no_mixer_makes_is_no_front_end(gain: float, angle_deg: float) -> None:
    z = np.exp(1j * PHASE)
    assert found(channels_of(z, z, gain, np.radians(angle_deg))) is None
