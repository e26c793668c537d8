"""Mains pick-up: tells a tracer at rest under a hum from a tracer that moves."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from radargui.model.arrays import FloatArray

MAINS_HZ = (50.0, 60.0)
HARMONICS = 5


def without_mains(volts: FloatArray, sample_rate_hz: float, frequency_hz: float, *, line: bool = True) -> FloatArray:
    """Return the voltages less a straight line and the least-squares sinusoids at the mains and its harmonics.

    Parameters
    ----------
    volts
        Shape (n_channels, n_samples).
    sample_rate_hz
        Rate of each channel.
    frequency_hz
        Frequency of the mains.
    line
        Whether the straight line is taken off too.
    """
    time = np.arange(volts.shape[1]) / sample_rate_hz
    orders = [order for order in range(1, HARMONICS + 1) if order * frequency_hz < 0.45 * sample_rate_hz]
    basis = np.concatenate([np.stack([np.ones_like(time), time]), harmonics(time, frequency_hz, orders)]).T
    coefficients, *_ = np.linalg.lstsq(basis, volts.T, rcond=None)
    first = 0 if line else 2
    return np.asarray(volts - (basis[:, first:] @ coefficients[first:]).T)


def harmonics(time_s: FloatArray, frequency_hz: float, orders: Sequence[int]) -> FloatArray:
    """Return cosine and sine by turns of each order of the mains at times, shape (2 n_orders, n)."""
    angle = 2.0 * np.pi * frequency_hz * np.asarray(orders, dtype=np.float64)[:, None] * time_s
    return np.stack([np.cos(angle), np.sin(angle)], axis=1).reshape(-1, time_s.size)
