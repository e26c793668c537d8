"""Flights of a track: where they begin and end, and about what they are."""

from __future__ import annotations

import numpy as np
import pytest
from support.drops import Drop
from support.flown import track_of

from radargui.model.gravity import NOMINAL_GRAVITY_M_S2 as G_M_S2
from radargui.restitution.settings import TRACKS
from radargui.restitution.track_flights import TrackFlights, find_flights, find_track_flights, impact_sides


def test_flights_keep_clear_of_impacts_and_end_where_the_sphere_is_back() -> None:
    first, second, last = find_flights(0.0, 2.0, np.array([0.3, 0.5]), 0.981, G_M_S2)
    assert first == pytest.approx((TRACKS.start_clearance_s, 0.3 - TRACKS.clearance_s))
    assert second == pytest.approx((0.3 + TRACKS.clearance_s, 0.5 - TRACKS.clearance_s))
    assert last[1] == pytest.approx(0.5 + 0.2 - TRACKS.clearance_s)
    assert np.isnan(find_flights(0.0, 2.0, np.array([0.3, 0.31]), 0.981, G_M_S2)[1]).all(), "12 ms are the least"


def test_flights_begin_about_where_and_as_fast_as_they_do() -> None:
    drop = Drop(height_m=0.2, e=0.8)
    flights = find_track_flights(*track_of(drop, 1e-5), drop.rate_hz, G_M_S2)
    assert isinstance(flights, TrackFlights)
    assert flights.impact_s[:3] == pytest.approx(drop.impact_s[:3], abs=1e-3)
    assert flights.are_known[:4].all()
    assert flights.velocity_m_s[1, 2] == pytest.approx(0.8 * np.sqrt(2 * 9.81 * 0.2), rel=0.01)
    assert flights.start_m[1] == pytest.approx(np.zeros(3), abs=2e-3)


def test_what_falls_with_another_g_is_told_with_it_and_is_no_flight() -> None:
    track, segment = track_of(Drop(height_m=0.2, e=0.8, rate_hz=5000.0), 1e-6)
    assert find_track_flights(track, segment, 5000.0, 7.0) == pytest.approx(9.81, rel=0.01)


@pytest.mark.parametrize("rate_hz", [2000.0, 8000.0, 33333.0])
def test_what_a_stretch_tells_is_a_matter_of_its_duration_at_any_rate(rate_hz: float) -> None:
    time_s = np.arange(round(0.2 * rate_hz)) / rate_hz
    # 25 ms beside an impact bear a line, 3 ms do not
    beside = time_s[(time_s < 0.035) | (time_s > 0.0955)]
    side, impact, _ = impact_sides(beside, np.array([0.04, 0.1]))
    assert list(zip(side.tolist(), impact.tolist(), strict=True)) == [(0, 0), (1, 1)]
