"""Activity: 1 where only noise is, high around what moves, centred on it."""

from __future__ import annotations

import numpy as np
import pytest

from radargui.conditioning.averager import block_means
from radargui.conditioning.segment import activity, block_size, window_blocks

RATE = 20000.0
SIZE = block_size(RATE)


def level_of(volts: np.ndarray) -> np.ndarray:
    """Return the activity of voltages with a white noise of 10 mV."""
    return activity(block_means(volts, SIZE), RATE / SIZE, np.full(6, 0.01 / np.sqrt(SIZE)))


def test_white_noise_alone_has_an_activity_of_about_1() -> None:
    volts = np.random.default_rng(0).normal(0.0, 0.01, (6, 40000))
    level = level_of(volts)
    assert level.size == 40000 // SIZE
    assert level.mean() == pytest.approx(1.0, abs=0.05)
    assert level.max() < 2.0


def test_the_window_is_centred_on_the_block() -> None:
    volts = np.random.default_rng(0).normal(0.0, 0.01, (6, 40000))
    volts[:, 20000:20010] += 1.0
    raised = np.flatnonzero(level_of(volts) > 8.0)
    assert raised.size == window_blocks(RATE / SIZE)
    assert abs(raised.mean() - 20000 / SIZE) <= 1.0
