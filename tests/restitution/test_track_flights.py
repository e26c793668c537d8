"""Flights of a track: where they begin and end, where they meet, and the velocities at their ends."""

from __future__ import annotations

import numpy as np
import pytest
from support.drops import Drop

from radargui.model.gravity import NOMINAL_GRAVITY_M_S2 as G_M_S2
from radargui.restitution.settings import TRACKS
from radargui.restitution.track_flights import (
    Heights,
    find_flights,
    fit_track_flights,
    impact_sides,
    impact_velocities,
)


def test_flights_keep_clear_of_impacts_and_end_where_the_sphere_is_back() -> None:
    first, second, last = find_flights(0.0, 2.0, np.array([0.3, 0.5]), 0.981, G_M_S2)
    assert first == pytest.approx((TRACKS.start_clearance_s, 0.3 - TRACKS.clearance_s))
    assert second == pytest.approx((0.3 + TRACKS.clearance_s, 0.5 - TRACKS.clearance_s))
    assert last[1] == pytest.approx(0.5 + 0.2 - TRACKS.clearance_s)
    assert np.isnan(find_flights(0.0, 2.0, np.array([0.3, 0.31]), 0.981, G_M_S2)[1]).all(), "12 ms are the least"


def test_parabolas_meet_at_the_impacts_although_these_were_seen_a_millisecond_off() -> None:
    drop = Drop(height_m=0.2, e=0.8)
    heights = Heights(drop.time_s, drop.height(drop.time_s))
    seen = drop.impact_s[:3] + np.array([1e-3, -1e-3, 1e-3])
    flights = find_flights(drop.rest_s, float(drop.impact_s[3]), seen, 0.0, G_M_S2)
    fitted = fit_track_flights(heights, flights)
    assert fitted is not None
    assert fitted.meet(seen)[:2] == pytest.approx(drop.impact_s[:2], abs=1e-9)
    assert heights.rising_speed(float(drop.impact_s[0]), G_M_S2) == pytest.approx(
        0.8 * np.sqrt(2 * 9.81 * 0.2), rel=1e-6
    )


@pytest.mark.parametrize("rate_hz", [2000.0, 8000.0, 33333.0])
def test_what_a_stretch_tells_is_a_matter_of_its_duration_at_any_rate(rate_hz: float) -> None:
    time_s = np.arange(round(0.2 * rate_hz)) / rate_hz
    # known are 3 ms of a flight of 50 ms, then 6 ms of another
    known = ((time_s > 0.02) & (time_s < 0.023)) | ((time_s > 0.12) & (time_s < 0.126))
    heights = Heights(time_s[known], -4.905 * time_s[known] ** 2)
    fitted = fit_track_flights(heights, np.array([[0.01, 0.06], [0.1, 0.15]]))
    assert fitted is not None
    assert list(fitted.place) == [1]
    # and 25 ms beside an impact bear a line, 3 ms do not
    beside = time_s[(time_s < 0.035) | (time_s > 0.0955)]
    side, impact, _ = impact_sides(beside, np.array([0.04, 0.1]))
    assert list(zip(side.tolist(), impact.tolist(), strict=True)) == [(0, 0), (1, 1)]


def test_a_flight_that_is_no_parabola_is_left_out() -> None:
    drop = Drop(height_m=0.2, e=0.8)
    height = drop.height(drop.time_s)
    missed = (drop.time_s > drop.impact_s[1] + 0.05) & (drop.time_s < drop.impact_s[2])
    flights = find_flights(drop.rest_s, float(drop.impact_s[4]), drop.impact_s[:4], 0.0, G_M_S2)
    fitted = fit_track_flights(Heights(drop.time_s, np.where(missed, height + 0.015, height)), flights)
    assert fitted is not None
    assert 2 not in fitted.place
    assert {0, 1, 3} <= set(fitted.place)
    assert fitted.parabolas.g_m_s2 == pytest.approx(9.81, rel=1e-6)


def test_velocities_at_an_impact_and_their_uncertainty_are_those_of_the_lines() -> None:
    drop = Drop(height_m=0.2, e=0.8)
    speed = np.sqrt(2 * 9.81 * 0.2)
    away = []
    for seed in range(60):
        noise = 20e-6 * np.random.default_rng(seed).standard_normal((3, drop.time_s.size))
        place = np.stack([0.1 * drop.time_s, -0.05 * drop.time_s, drop.height(drop.time_s)]) + noise
        at = impact_velocities(drop.time_s, place, drop.impact_s[:1], G_M_S2)
        assert at.before_m_s[0] == pytest.approx([0.1, -0.05, -speed], abs=5e-3)
        assert at.after_m_s[0] == pytest.approx([0.1, -0.05, 0.8 * speed], abs=5e-3)
        away.append((at.after_m_s - at.before_m_s)[0, 0] / at.u_side_m_s[0])
    assert 0.6 < np.std(away) < 1.2
    unknown = impact_velocities(drop.time_s[:100], place[:, :100], drop.impact_s[:1], G_M_S2)
    assert np.isnan(unknown.u_side_m_s).all()
