"""Channels that stand still while their receiver's other one goes round."""

from __future__ import annotations

import numpy as np
import pytest

from radargui.signals.faults import open_channels

RATE_HZ = 5000.0
TIME = np.arange(5000) / RATE_HZ
NOISE_V = 0.05


def falling(quadrature_error: float = 0.0, gain: float = 1.0, noise_v: float = NOISE_V) -> np.ndarray:
    """Two receivers that see a fall from 0.3 s to 0.7 s, then rest; offsets beside."""
    phase = 2.0 * np.pi * 400.0 * np.clip(TIME - 0.3, 0.0, 0.4) ** 2
    pairs = [
        row
        for shift in (0.4, 2.0)
        for row in (0.3 + np.cos(phase + shift), gain * np.sin(phase + shift + quadrature_error) - 0.2)
    ]
    return np.array(pairs) + noise_v * np.random.default_rng(7).standard_normal((4, TIME.size))


def found(volts: np.ndarray) -> np.ndarray:
    return open_channels(volts, np.full(4, NOISE_V), RATE_HZ, slice(1500, 3500))


@pytest.mark.parametrize(("quadrature_error", "gain"), [(0.0, 1.0), (0.5, 1.0), (-0.5, 0.3)])
def test_channels_of_an_echo_are_never_open(quadrature_error: float, gain: float) -> None:
    assert not found(falling(quadrature_error, gain)).any()


@pytest.mark.parametrize("channel", [0, 3])
@pytest.mark.parametrize(("begin_s", "end_s"), [(0.5, 0.6), (0.55, 1.0)])
def test_a_channel_that_opens_is_told_from_there_to_where_it_closes(channel: int, begin_s: float, end_s: float) -> None:
    volts = falling()
    inside = (begin_s <= TIME) & (end_s > TIME)
    # open inputs pick up a little hum
    volts[channel, inside] = 0.02 * np.sin(2.0 * np.pi * 50.0 * TIME[inside])
    opened = found(volts)
    assert not np.delete(opened, channel, axis=0).any()
    assert opened[channel, inside].all()
    outside = ~inside & ((begin_s - 0.03 > TIME) | (end_s + 0.03 < TIME))
    assert not opened[channel, outside].any()


def test_both_at_rest_are_no_open_contact() -> None:
    volts = falling()
    volts[:2] = NOISE_V * np.random.default_rng(8).standard_normal((2, TIME.size))
    assert not found(volts).any()
