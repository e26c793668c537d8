"""What the bounces that are not followed leave open of the speeds at impacts."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from radargui.estimation.posterior.free_motion import FreeMotion
from radargui.estimation.posterior.unfollowed import lands_after_s, unfollowed_m_s

G = 9.81
E = 0.65


def cascade() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Five impacts, the last with a flight of 25 ms after it; of e = 0.65."""
    after = 0.122 / E ** np.arange(4, -1, -1)
    time = np.concatenate([[0.5], 0.5 + np.cumsum(2.0 * after[:-1] / G)])
    return time, after / E, after


def test_the_end_of_a_cascade_leaves_the_last_rebound_open_and_no_other() -> None:
    time, before, after = cascade()
    by_flights = np.ones(5, dtype=np.bool_)
    none, left = unfollowed_m_s(time, before, after, by_flights, G, 3.0)
    assert not none.any()
    assert not left[:-1].any()
    # a bounce of 0.3 mm, anywhere in it, over a flight of 25 ms
    assert left[-1] == pytest.approx((E * 0.122) ** 2 / (2.0 * G) / np.sqrt(12.0) / (2.0 * 0.122 / G))
    # of 12 ms not even the flight itself is followed: an e of 0.72 +- 0.04 for 0.56 (42 dB) is not valid now
    left = unfollowed_m_s(time, before, 0.5 * after, by_flights, G, 3.0)[1][-1]
    assert left == pytest.approx(0.061 / (4.0 * np.sqrt(12.0)))
    # a record that ends within the flight has no bounce after it, and one of 40 ms is followed
    assert not unfollowed_m_s(time, before, after, by_flights, G, time[-1] + 0.02)[1].any()
    assert not unfollowed_m_s(time, before, 2.0 * after, by_flights, G, 3.0)[1].any()


def test_a_bounce_that_is_not_followed_is_no_faster_than_the_one_before_it() -> None:
    time, _, after = cascade()
    # speeds of which noise makes more than there was: the next bounce is as high as this one at the most
    faster = 0.9 * after
    left = unfollowed_m_s(time, faster, after, np.ones(5, dtype=np.bool_), G, 3.0)[1][-1]
    assert left == pytest.approx(0.122**2 / (2.0 * G) / np.sqrt(12.0) / (2.0 * 0.122 / G))


@pytest.mark.parametrize(("rests_m", "end_s", "lands"), [(0.0, 1.0, True), (6e-4, 1.0, False), (0.0, 0.54, False)])
def test_a_motion_lands_where_it_turns_near_the_floor(rests_m: float, end_s: float, lands: bool) -> None:
    speed, impact_s = 0.131, 0.5
    flight_s = 2.0 * speed / 9.80665

    def position_m(time_s: np.ndarray) -> np.ndarray:
        away = time_s - impact_s
        up = speed * away - 9.80665 / 2.0 * away**2
        again = 0.02 * (away - flight_s)
        height = np.where(
            away < flight_s, np.maximum(up, np.where(away > flight_s / 2.0, rests_m, 0.0)), again + rests_m
        )
        return np.stack([0.0 * height, 0.0 * height, height])

    free: FreeMotion | Any = SimpleNamespace(gravity_m_s2=9.81, position_m=position_m, edge_s=np.array([0.0, end_s]))
    found = lands_after_s(free, np.array([0.0, 0.0, 1.0]), impact_s, 0.170)
    if lands:
        assert found == pytest.approx(impact_s + flight_s, abs=5e-4)
    else:
        assert np.isnan(found)
