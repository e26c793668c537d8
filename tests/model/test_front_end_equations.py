"""The front end's equations against each other and against finite differences."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, strategies as st

from radargui.model.front_end import (
    FrontEnd,
    channel_factors,
    channels_of,
    noise_across,
    point_of,
    slopes_of_point,
    with_phase_sign,
)

angles = st.floats(-1.2, 1.2)
gains = st.floats(0.3, 3.0)


@given(gains, angles)
def test_the_point_of_the_channels_of_a_signal_is_the_signal(gain: float, eps: float) -> None:
    z = np.exp(1j * np.linspace(0.0, 7.0, 50)) * np.linspace(0.5, 2.0, 50)
    x, y = point_of(*channels_of(z, z, gain, eps), gain, eps)
    np.testing.assert_allclose(x + 1j * y, z, atol=1e-12)


def test_spectra_of_the_channels_give_the_spectra_of_the_point() -> None:
    z = np.exp(1j * np.linspace(0.0, 7.0, 50))
    channels = channels_of(z, z, 1.3, 0.2)
    x, y = point_of(*np.fft.rfft(channels), 1.3, 0.2)
    np.testing.assert_allclose([x, y], np.fft.rfft([z.real, z.imag]), atol=1e-12)


def test_the_sign_negates_q_alone_and_takes_itself_back() -> None:
    volts = np.arange(12.0).reshape(4, 3)
    turned = with_phase_sign(volts, -1)
    np.testing.assert_array_equal(turned, [volts[0], -volts[1], volts[2], -volts[3]])
    np.testing.assert_array_equal(with_phase_sign(turned, -1), volts)
    assert with_phase_sign(volts, 1) is volts


def test_q_lags_by_the_quadrature_error_and_is_larger_by_the_gain() -> None:
    phase = np.linspace(0.0, 6.0, 30)
    i, q = channels_of(np.exp(1j * phase), np.exp(1j * phase), 1.3, 0.2)
    np.testing.assert_allclose(i, np.cos(phase))
    np.testing.assert_allclose(q, 1.3 * np.sin(phase + 0.2))


@given(gains, angles, gains, angles)
def test_taking_constants_off_and_putting_them_back_changes_nothing(
    gain: float, eps: float, first_gain: float, first_eps: float
) -> None:
    whole = FrontEnd(gain, 0.01 * gain, float(np.degrees(eps)), 0.1)
    first = FrontEnd(first_gain, 0.0, float(np.degrees(first_eps)), 0.0)
    again = whole.less(first).after(first)
    assert again.gain_ratio == pytest.approx(gain)
    assert again.u_gain_ratio == pytest.approx(whole.u_gain_ratio)
    assert again.quadrature_error_deg == pytest.approx(whole.quadrature_error_deg, abs=1e-9)


def test_channels_whose_front_end_is_taken_off_in_two_steps_are_those_of_the_signal() -> None:
    z = np.exp(1j * np.linspace(0.0, 6.0, 30))
    first, whole = FrontEnd(0.9, 0.0, 12.0, 0.0), FrontEnd(1.3, 0.0, -5.0, 0.0)
    left = whole.less(first)
    x, y = point_of(*channels_of(z, z, 1.3, np.radians(-5.0)), 0.9, np.radians(12.0))
    x, y = point_of(x, y, left.gain_ratio, np.radians(left.quadrature_error_deg))
    np.testing.assert_allclose(x + 1j * y, z, atol=1e-12)


@given(gains, angles)
def test_the_channels_are_the_real_parts_of_their_factors_times_the_signal(gain: float, eps: float) -> None:
    z = np.exp(1j * np.linspace(0.0, 7.0, 50)) * np.linspace(0.5, 2.0, 50)
    h = channel_factors(np.array([gain, 1.0]), np.array([eps, 0.0]))
    assert h.shape == (2, 2)
    np.testing.assert_allclose((h[0][:, None] * z).real, channels_of(z, z, gain, eps), atol=1e-12)
    up, down = (channels_of(z, z, gain, eps + step)[1] for step in (1e-6, -1e-6))
    np.testing.assert_allclose(-(h[0, 1] * z).imag, (up - down) / 2e-6, atol=1e-8)
    np.testing.assert_allclose(h[1], [1.0, -1j], atol=1e-15)


def test_the_noise_across_is_that_of_points_of_noise() -> None:
    noise = np.random.default_rng(4).standard_normal((2, 100000)) * np.array([[0.02], [0.05]])
    across = noise_across(np.array(0.02), np.array(0.05), 1.4, 0.5)
    assert point_of(*noise, 1.4, 0.5)[1].std() == pytest.approx(float(across), rel=0.01)
    # in a perfect mixer each channel has its own
    assert float(noise_across(np.array(0.02), np.array(0.05), 1.0, 0.0)) == pytest.approx(0.05)


@given(gains, angles)
def test_the_slopes_of_a_point_are_finite_differences(gain: float, eps: float) -> None:
    z = np.exp(1j * np.linspace(0.0, 7.0, 50)) * np.linspace(0.5, 2.0, 50)
    i, q = channels_of(z, z, gain, eps)
    found = slopes_of_point(z.real, z.imag, gain, eps)
    step = 1e-6

    def slope(up: np.ndarray, down: np.ndarray) -> np.ndarray:
        return (up[1] - down[1]) / (2.0 * step)

    wanted = (
        slope(point_of(i - step, q, gain, eps), point_of(i + step, q, gain, eps)),
        slope(point_of(i, q - step, gain, eps), point_of(i, q + step, gain, eps)),
        slope(point_of(i, q, gain * np.exp(step), eps), point_of(i, q, gain * np.exp(-step), eps)),
        slope(point_of(i, q, gain, eps + step), point_of(i, q, gain, eps - step)),
    )
    for own, by_steps in zip(found, wanted, strict=True):
        np.testing.assert_allclose(np.broadcast_to(own, 50), by_steps, rtol=1e-6, atol=1e-7)
