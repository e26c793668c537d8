"""Restitution and free fall from tracks whose truth is exact, and uncertainties that hold."""

from __future__ import annotations

import numpy as np
import pytest
from support.drops import Drop

from radargui.model.segment import Segment
from radargui.model.track import Track
from radargui.restitution.bounces import find_bounces
from radargui.restitution.parabola import correlation_length, fit_parabolas

UP = (0.0, 0.0, 1.0)


def track_of(drop: Drop, noise_m: float = 0.0, seed: int = 0) -> tuple[Track, Segment]:
    time = drop.time_s
    position = np.zeros((3, time.size))
    position[2] = drop.height(time)
    position += noise_m * np.random.default_rng(seed).normal(size=position.shape)
    segment = Segment(
        round(drop.rest_s * drop.rate_hz),
        round((drop.impact_s[-1] + 0.02) * drop.rate_hz),
        0,
        round((drop.rest_s - 0.02) * drop.rate_hz),
    )
    known = np.ones(time.size, dtype=bool)
    return Track(time, position, np.full_like(position, max(noise_m, 1e-9)), known, "exact"), segment


@pytest.mark.parametrize(("height", "e"), [(0.06, 0.9), (0.25, 0.8), (0.30, 0.5), (0.12, 0.92)])
def test_an_exact_track_gives_exact_coefficients(height: float, e: float) -> None:
    drop = Drop(height_m=height, e=e)
    track, segment = track_of(drop)
    bounces = find_bounces(track, segment, UP, drop.rate_hz)
    assert bounces.impacts[0].e == pytest.approx(e, abs=1e-9)
    assert bounces.impacts[0].speed_before_m_s == pytest.approx(np.sqrt(2 * 9.81 * height), rel=1e-9)
    assert bounces.impacts[0].time_s == pytest.approx(drop.impact_s[0], abs=1e-9)
    assert bounces.impacts[1].e == pytest.approx(e, abs=1e-9)
    assert bounces.free_fall is not None
    assert bounces.free_fall.g_m_s2 == pytest.approx(9.81, rel=1e-9)
    assert bounces.free_fall.drop_height_m == pytest.approx(height, abs=1e-9)
    assert bounces.free_fall.release_height_m == pytest.approx(height, abs=1e-9)


def test_uncertainties_hold_the_truth_as_often_as_they_should() -> None:
    drop = Drop(rate_hz=5000.0)
    e_pull, g_pull = [], []
    for seed in range(120):
        track, segment = track_of(drop, 30e-6, seed)
        bounces = find_bounces(track, segment, UP, drop.rate_hz)
        first, fall = bounces.impacts[0], bounces.free_fall
        assert fall is not None
        e_pull.append((first.e - 0.8) / first.u_e)
        g_pull.append((fall.g_m_s2 - 9.81) / fall.u_g_m_s2)
    for pull in (e_pull, g_pull):
        assert 0.75 < np.std(pull) < 1.3
        assert np.mean(np.abs(pull) < 2.0) > 0.9
        assert abs(np.mean(pull)) < 0.3


def test_a_tilted_floor_is_judged_along_its_normal() -> None:
    drop = Drop()
    track, segment = track_of(drop)
    normal = np.array([0.1, 0.0, 1.0])
    normal /= np.linalg.norm(normal)
    bounces = find_bounces(track, segment, (normal[0], normal[1], normal[2]), drop.rate_hz)
    assert bounces.impacts[0].e == pytest.approx(0.8, abs=1e-6)


def test_without_impacts_there_is_no_coefficient() -> None:
    time = np.arange(20000) / 10000.0
    position = np.stack([0.1 * np.cos(3 * time), 0.1 * np.sin(3 * time), np.zeros_like(time)])
    track = Track(time, position, np.ones_like(position), np.ones(time.size, dtype=bool), "exact")
    bounces = find_bounces(track, Segment(0, 20000, 0, 0), UP, 10000.0)
    assert bounces.impacts == ()
    assert bounces.free_fall is None


def test_an_impact_whose_flight_is_unknown_has_no_coefficient() -> None:
    drop = Drop()
    track, segment = track_of(drop)
    gone = (track.time_s > drop.impact_s[0] + 0.015) & (track.time_s < drop.impact_s[1] - 0.015)
    cut = Track(track.time_s, np.where(gone, np.nan, track.position_m), track.u_position_m, ~gone, "exact")
    impacts = find_bounces(cut, segment, UP, drop.rate_hz).impacts
    assert impacts[0].e == pytest.approx(0.8, abs=1e-3)


def test_waves_in_the_residual_widen_the_uncertainty() -> None:
    time = np.linspace(0, 0.2, 2000)
    fall = 0.2 - 0.5 * 9.81 * time**2
    white = fit_parabolas([(time, fall + np.random.default_rng(0).normal(0, 1e-4, 2000))])
    wavy = fit_parabolas([(time, fall + 1.4e-4 * np.sin(2 * np.pi * 40 * time))])
    assert wavy.u_g_m_s2 > 4 * white.u_g_m_s2


def test_white_residuals_have_the_correlation_length_of_one_sample() -> None:
    assert correlation_length(np.random.default_rng(0).normal(size=20000)) == pytest.approx(1.0, abs=0.15)
    assert correlation_length(np.repeat(np.random.default_rng(0).normal(size=2000), 10)) == pytest.approx(10, rel=0.2)
