"""Channels scaled to about one amplitude, a front end that is far from a perfect one taken off first."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from radargui.estimation.signals import (
    ScaledSignals,
    composed,
    remaining,
    scaled_signals,
)
from radargui.model.errors import ProcessingError
from radargui.model.front_end import FrontEnd, noise_across, point_of

TIME_S = 2.0 + np.arange(1000) / 1000.0
AMPLITUDES_V, GAIN = np.array([0.5, 2.0, 1.0]), np.array([1.0, 1.1, 0.9])
NOISE_V = np.array([1.0, 2.0, 3.0, 4.0, 5.0, 6.0]) * 1e-3


def conditioned(**other: Any) -> Any:
    """Return three receivers that go round ten times."""
    phase = 20.0 * np.pi * np.arange(1000) / 1000.0
    volts = np.concatenate(
        [[a * np.cos(phase), a * g * np.sin(phase)] for a, g in zip(AMPLITUDES_V, GAIN, strict=True)]
    )
    given: dict[str, Any] = {
        "doppler": (0, 1, 2),
        "volts": volts,
        "noise_v": NOISE_V,
        "delay_s": np.arange(6) * 1e-4,
        "usable": np.ones((3, 1000), bool),
        "valid": np.ones((3, 1000), bool),
        "unusable_share": np.zeros(3),
        "n_receivers": 3,
        "time_s": TIME_S,
        "phase_sign": -1,
        "sample_rate_hz": 1000.0,
        "rest_end_s": 2.1,
        "onset_s": 2.2,
        "size": 5,
        "at_one_time_v": volts,
    }
    return SimpleNamespace(**(given | other))


def scaled(front_ends: dict[Any, FrontEnd] | None = None, **other: Any) -> ScaledSignals:
    """Return the signals scaled where Doppler signals say this of the front ends, by receiver."""
    return scaled_signals(conditioned(**other), (front_ends or {}).get)


def test_a_pair_shares_the_scale_of_its_mean_amplitude_and_noise_goes_with_it() -> None:
    found = scaled()
    scale = AMPLITUDES_V * (1.0 + GAIN) / 2.0
    assert found.scale_v == pytest.approx(scale)
    assert found.value == pytest.approx(conditioned().volts / np.repeat(scale, 2)[:, None])
    assert found.sigma == pytest.approx(NOISE_V / np.repeat(scale, 2))
    assert found.delay_s.tolist() == conditioned().delay_s.tolist()
    # the channel before in the unit of each, Q of the wrong sign; before the first comes the last
    unit = np.repeat(scale, 2) * np.tile([1.0, -1.0], 3)
    assert found.before is not None
    assert found.before.tolist() == pytest.approx([unit[k - 1] / unit[k] for k in range(6)])
    # a sample is the mean of five values
    assert found.spread_s == pytest.approx(np.std(np.arange(5) / 5000.0))


def test_a_far_front_end_is_taken_off_its_own_receiver_and_put_back_at_the_end() -> None:
    mixer = FrontEnd(1.5, 0.01, 10.0, 0.1)
    found = scaled({1: mixer, 2: FrontEnd(1.1, 0.01, 2.0, 0.1)})
    plain = conditioned().volts
    taken = np.array(point_of(plain[2], plain[3], 1.5, np.radians(10.0)))
    scale = np.sqrt(2.0) * 0.5 * (taken[0].std() + taken[1].std())
    assert found.scale_v[1] == pytest.approx(scale)
    assert found.value[2:4] == pytest.approx(taken / scale)
    assert found.sigma[2:4] == pytest.approx(
        np.array([NOISE_V[2], noise_across(NOISE_V[2], NOISE_V[3], 1.5, float(np.radians(10.0)))]) / scale
    )
    # brought to one time, its channels have no delay any more; what comes before a first sample is not used
    assert found.delay_s == pytest.approx([0.0, 1e-4, 0.0, 0.0, 4e-4, 5e-4])
    assert found.mixers == (None, mixer, None)
    assert not found.usable[0]
    assert found.usable[1:].all()
    # what channels keep of each other was mixed with it
    assert found.before is None
    near = tuple(FrontEnd(1.02, 0.001, 0.5, 0.01) for _ in range(3))
    first, second, third = composed(near, found)
    assert (first, third) == (near[0], near[2])
    assert second == near[1].after(mixer)
    left = remaining((near[0], second, near[2]), found)
    assert (left[0], left[2]) == (near[0], near[2])
    assert left[1].gain_ratio == pytest.approx(1.02, rel=1e-6)
    assert left[1].quadrature_error_deg == pytest.approx(0.5, abs=1e-6)


def test_channels_that_never_change_are_refused() -> None:
    still = conditioned().volts
    still[2:4] = 0.125
    with pytest.raises(ProcessingError, match="never change"):
        scaled(volts=still)
