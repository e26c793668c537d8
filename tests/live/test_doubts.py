"""What speaks against a track while it is followed: which receivers fall upwards."""

from __future__ import annotations

import numpy as np
import pytest

from radargui.live.processor import FallWatch
from radargui.model.arrays import FloatArray
from radargui.model.setup import read_setup
from radargui.physics.path_length import path_gradient, place_antennas
from radargui.system.resources import default_setup_path


def told_live(rises: tuple[float, ...], n_s: float = 0.2) -> set[int]:
    """Return the receivers told of by a track whose paths grow so many times as they would in a fall."""
    setup, rate_hz = read_setup(default_setup_path()), 4000.0
    time_s = np.arange(round(n_s * rate_hz)) / rate_hz
    release = np.array(setup.tracer.release_position_m)[:, None]
    along = -path_gradient(release, place_antennas(setup))[:, 2]
    change: FloatArray = np.array(rises)[:, None] * along * 0.5 * 9.81 * time_s**2
    watch = FallWatch(setup, rate_hz)
    return {one for part in np.array_split(change, 5, axis=1) for one in watch.push(part)}


@pytest.mark.parametrize(
    ("rises", "told"),
    [((1, 1, 1), set()), ((1, -1, 1), {1}), ((-1, -1, -1), {0, 1, 2}), ((0.3, -0.3, 0.3), set())],
)
def test_a_live_track_is_judged_by_the_same_rule(rises: tuple[float, ...], told: set[int]) -> None:
    assert told_live(rises) == told


def test_a_live_fall_of_less_than_a_tenth_of_a_second_says_nothing() -> None:
    assert told_live((1, -1, 1), 0.09) == set()
