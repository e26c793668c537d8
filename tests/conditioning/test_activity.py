"""Activity: 1 where only noise is, high around what moves, centred on it."""

from __future__ import annotations

import numpy as np
import pytest

from radargui.conditioning.noise import activity, block_size, window_blocks

RATE = 20000.0


def test_white_noise_alone_has_an_activity_of_about_1() -> None:
    volts = np.random.default_rng(0).normal(0.0, 0.01, (6, 40000))
    level = activity(volts, RATE, np.full(6, 0.01))
    assert level.size == 40000 // block_size(RATE)
    assert level.mean() == pytest.approx(1.0, abs=0.05)
    assert level.max() < 2.0


def test_the_window_is_centred_on_the_block() -> None:
    volts = np.random.default_rng(0).normal(0.0, 0.01, (6, 40000))
    volts[:, 20000:20010] += 1.0
    size, window = block_size(RATE), window_blocks(RATE)
    raised = np.flatnonzero(activity(volts, RATE, np.full(6, 0.01)) > 8.0)
    assert raised.size == window
    assert abs(raised.mean() - 20000 / size) <= 1.0
