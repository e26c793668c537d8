"""The live correction learns hardware constants and maps of the path length while the signal comes."""

from __future__ import annotations

import numpy as np
import pytest

from radargui.live.map_filter import MapFilter
from radargui.model.arrays import FloatArray

RAD_PER_M = 2.0 * np.pi / 0.03


def there_and_back(n: int = 9000) -> FloatArray:
    """Return path lengths: 0.4 m out and back, with a rest before."""
    t = np.linspace(0.0, 1.0, n)
    return np.concatenate([np.zeros(400), 0.2 * (1.0 - np.cos(2.0 * np.pi * t))])


def volts(length_m: FloatArray, noise: float = 0.003) -> FloatArray:
    phase = RAD_PER_M * length_m + 0.7
    offset_i, offset_q = 0.5 + 0.06 * np.sin(9.0 * length_m), -0.3 + 0.06 * np.cos(7.0 * length_m)
    amplitude = 1.4 * (1.0 - 0.3 * length_m)
    pair = np.stack([offset_i + amplitude * np.cos(phase), offset_q + 1.1 * amplitude * np.sin(phase + 0.05)])
    return np.asarray(pair + np.random.default_rng(0).normal(0.0, noise, pair.shape))


def test_constants_and_maps_are_found_and_the_path_is_true() -> None:
    length = there_and_back()
    pair = volts(length)
    follower = MapFilter(RAD_PER_M)
    follower.rest(pair[:, :400].mean(axis=1), 0.003)
    begin = 500
    while not follower.start(pair[:, 400:begin]):
        begin += 100
    assert length[begin] < 0.09
    assert follower.gain_ratio == pytest.approx(1.1, abs=0.05)
    change = [follower.follow(pair[:, 400:begin], learn=False)[1]]
    change += [follower.follow(pair[:, k : k + 80])[1] for k in range(begin, pair.shape[1], 80)]
    error = np.concatenate(change) - length[400:]
    assert np.sqrt(np.mean(error**2)) < 0.1e-3
    assert follower.gain_ratio == pytest.approx(1.1, abs=0.01)
    assert follower.quadrature_error_rad == pytest.approx(0.05, abs=0.01)


def test_nothing_begins_before_one_and_a_half_fringes() -> None:
    pair = volts(there_and_back())
    follower = MapFilter(RAD_PER_M)
    assert not follower.start(pair[:, :5])
    assert not follower.start(pair[:, :1200])
    assert not follower.started
    assert np.isnan(follower.at_rest(pair[:, :10])).all()


def test_a_dead_input_never_begins() -> None:
    assert not MapFilter(RAD_PER_M).start(np.zeros((2, 4000)))


def test_without_a_rest_the_path_counts_from_the_first_sample() -> None:
    length = there_and_back()[2000:4000]
    follower = MapFilter(RAD_PER_M)
    follower.rest(None, None)
    pair = volts(length)
    assert follower.start(pair)
    _, change = follower.follow(pair, learn=False)
    assert change - change[0] == pytest.approx(length - length[0], abs=0.5e-3)


@pytest.mark.parametrize("block", [20, 160, 640])
def test_what_is_learned_does_not_hang_on_how_long_the_blocks_are(block: int) -> None:
    length = there_and_back(2000)
    # offsets that turn round in 0.23 m, as over a floor that reflects a third of the field
    turn = 2.0 * np.pi * length / 0.23
    pair = volts(length) + 0.4 * 1.4 * np.stack([np.cos(turn) - 1.0, np.sin(turn)])
    follower = MapFilter(RAD_PER_M)
    follower.rest(pair[:, :400].mean(axis=1), 0.003)
    begin = 500
    while not follower.start(pair[:, 400:begin]):
        begin += 100
    change = [follower.follow(pair[:, 400:begin], learn=False)[1]]
    change += [follower.follow(pair[:, k : k + block])[1] for k in range(begin, pair.shape[1], block)]
    error = np.concatenate(change) - length[400:]
    assert np.abs(error).max() < 5e-3, "a lost turn is 30 mm"
    assert follower.misfit < 0.2
