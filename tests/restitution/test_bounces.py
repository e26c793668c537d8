"""Restitution and free fall from tracks whose truth is exact, and uncertainties that hold."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from benchmarks.world.drop import Body, Floor, fall
from support.drops import Drop

from radargui.model.gravity import NOMINAL_GRAVITY_M_S2 as G_M_S2, drag_of_sphere
from radargui.model.result import Bounces, Segment, Track
from radargui.restitution.bounces import find_bounces
from radargui.restitution.cross_check import disagreements
from radargui.restitution.floor_normal import normal_of_impacts
from radargui.restitution.parabola import fit_parabolas
from radargui.restitution.settings import TRACKS
from radargui.restitution.stretches import Stretches
from radargui.restitution.track_flights import impact_velocities

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
    bounces = find_bounces(track, segment, UP, drop.rate_hz, G_M_S2)
    assert bounces.impacts[0].e == pytest.approx(e, abs=1e-9)
    assert bounces.impacts[0].speed_before_m_s == pytest.approx(np.sqrt(2 * 9.81 * height), rel=1e-9)
    assert bounces.impacts[0].time_s == pytest.approx(drop.impact_s[0], abs=1e-9)
    assert bounces.impacts[1].e == pytest.approx(e, abs=1e-9)
    assert bounces.free_fall is not None
    assert bounces.free_fall.g_m_s2 == pytest.approx(9.81, rel=1e-9)
    assert bounces.free_fall.drop_height_m == pytest.approx(height, abs=1e-9)
    assert bounces.free_fall.release_height_m == pytest.approx(height, abs=1e-9)


@pytest.mark.parametrize(("density_kg_m3", "seen"), [(7850.0, False), (1050.0, True)])
def test_a_sphere_of_plastic_is_told_by_its_flights_where_no_density_is_given(density_kg_m3: float, seen: bool) -> None:
    body = Body(radius_m=0.005, density_kg_m3=density_kg_m3, gravity_m_s2=9.81)
    floor = Floor(np.array(UP), np.array([0.0, 0.0, -0.13]), restitution=0.8, scatter=0.0)
    drop = fall(np.random.default_rng(1), body, floor, np.array([0.0, 0.0, 0.12]), start_s=0.3, duration_s=1.2)
    time = np.arange(6000) / 5000.0
    position = drop.position(time) + 5e-5 * np.random.default_rng(2).standard_normal((3, time.size))
    track = Track(time, position, np.full_like(position, 5e-5), np.ones(time.size, dtype=bool), "exact")
    segment, metal = Segment(1500, time.size, 0, 1450), drag_of_sphere(0.01, None)
    found = find_bounces(track, segment, UP, 5000.0, G_M_S2, drag=metal, is_drag_known=False)
    assert (found.braked_1_m is not None) is seen
    if found.braked_1_m is not None:
        assert found.braked_1_m == pytest.approx(drag_of_sphere(0.01, density_kg_m3).k_1_m, rel=0.15)
        assert found.braked_1_m > 1.5 * metal.k_1_m
    assert all(abs(one.e - 0.8) < 2.0 * one.u_e for one in found.impacts[:3])
    # who gives a density is believed
    assert find_bounces(track, segment, UP, 5000.0, G_M_S2, drag=metal).braked_1_m is None


def test_waves_as_long_as_a_rebound_are_in_the_uncertainty_of_e() -> None:
    drop = Drop(height_m=0.12, e=0.5)
    track, segment = track_of(drop)
    bent = replace(track, u_position_m=np.full_like(track.u_position_m, 2e-4))
    exact, uncertain = (find_bounces(one, segment, UP, drop.rate_hz, G_M_S2).impacts[0] for one in (track, bent))
    # the rebound rises e^2 = a quarter as high: 0.2 e u / h = 0.2 * 0.5 * 0.2 mm / 30 mm
    assert uncertain.u_e == pytest.approx(np.hypot(exact.u_e, 0.1 * 2e-4 / 0.03), rel=1e-3)
    assert uncertain.e == exact.e


@pytest.mark.parametrize("density_kg_m3", [7850.0, 1050.0])
def test_what_drag_does_to_parabolas_is_in_the_uncertainty_of_e_and_g(density_kg_m3: float) -> None:
    body = Body(radius_m=0.005, density_kg_m3=density_kg_m3, gravity_m_s2=9.81)
    floor = Floor(np.array(UP), np.array([0.0, 0.0, -0.13]), restitution=0.8, scatter=0.0)
    drop = fall(np.random.default_rng(1), body, floor, np.array([0.0, 0.0, 0.12]), start_s=0.3, duration_s=1.2)
    time = np.arange(6000) / 5000.0
    position = drop.position(time)
    track = Track(time, position, np.full_like(position, 1e-6), np.ones(time.size, dtype=bool), "exact")
    segment = Segment(1500, time.size, 0, 1450)
    bare = find_bounces(track, segment, UP, 5000.0, G_M_S2)
    told = find_bounces(track, segment, UP, 5000.0, G_M_S2, drag=drag_of_sphere(0.01, density_kg_m3))
    assert bare.free_fall is not None
    assert told.free_fall is not None
    g_missed = body.acceleration_m_s2 - bare.free_fall.g_m_s2
    assert np.hypot(bare.free_fall.u_g_m_s2, g_missed) == pytest.approx(told.free_fall.u_g_m_s2, rel=0.02)
    for one, same in zip(bare.impacts[:2], told.impacts[:2], strict=True):
        assert same.e == one.e < 0.8 - 10.0 * one.u_e, "drag matters, and without it nothing says so"
        assert np.hypot(one.u_e, 0.8 - one.e) == pytest.approx(same.u_e, rel=0.02)


def test_uncertainties_hold_the_truth_as_often_as_they_should() -> None:
    drop = Drop(rate_hz=2000.0, settle_s=0.1)
    e_pull, g_pull = [], []
    for seed in range(200):
        track, segment = track_of(drop, 30e-6, seed)
        bounces = find_bounces(track, segment, UP, drop.rate_hz, G_M_S2)
        first, fall = bounces.impacts[0], bounces.free_fall
        assert fall is not None
        e_pull.append((first.e - 0.8) / first.u_e)
        g_pull.append((fall.g_m_s2 - 9.81) / fall.u_g_m_s2)
    # two standard uncertainties promise 95 %; of 200 trials that is 0.95 +- 0.015
    for pull in (e_pull, g_pull):
        assert 0.85 < np.std(pull) < 1.15
        assert 0.92 < np.mean(np.abs(pull) < 2.0) < 0.995
        assert abs(np.mean(pull)) < 0.2


def test_a_tilted_floor_is_judged_along_its_normal() -> None:
    drop = Drop()
    track, segment = track_of(drop)
    normal = np.array([0.1, 0.0, 1.0])
    normal /= np.linalg.norm(normal)
    bounces = find_bounces(track, segment, (normal[0], normal[1], normal[2]), drop.rate_hz, G_M_S2)
    assert bounces.impacts[0].e == pytest.approx(0.8, abs=1e-6)
    assert bounces.free_fall is not None
    assert bounces.free_fall.g_m_s2 == pytest.approx(9.81, abs=1e-6), "g is vertical, whatever the floor"


def test_flight_time_and_height_give_the_same_coefficient() -> None:
    drop = Drop()
    track, segment = track_of(drop, 10e-6)
    impacts = find_bounces(track, segment, UP, drop.rate_hz, G_M_S2).impacts
    assert [impact.e_flight_time for impact in impacts[:4]] == pytest.approx([0.8] * 4, abs=1e-3)
    assert [impact.e_height for impact in impacts[:4]] == pytest.approx([0.8] * 4, abs=1e-3)
    assert np.isnan(impacts[-1].e_flight_time)
    assert disagreements(Bounces(impacts)) == []


def test_coefficients_that_disagree_are_told() -> None:
    drop = Drop()
    track, segment = track_of(drop)
    first = replace(find_bounces(track, segment, UP, drop.rate_hz, G_M_S2).impacts[0], e_flight_time=0.7)
    (finding,) = disagreements(Bounces((first,)))
    assert "0.7000 from the flight time" in finding.text
    assert disagreements(Bounces((replace(first, valid=False),))) == [], "what is not valid is not compared"
    slow = replace(first, speed_before_m_s=0.1, speed_after_m_s=0.08)
    assert disagreements(Bounces((slow,))) == [], "the impact after it may be below what is resolved"


@pytest.mark.parametrize("tilt_deg", [0.0, 0.2, 3.0])
def test_the_normal_of_a_tilted_floor_is_found_from_the_impacts(tilt_deg: float) -> None:
    normal = np.array([np.sin(np.radians(tilt_deg)), 0.0, np.cos(np.radians(tilt_deg))])
    rate, g = 20000.0, np.array([0.0, 0.0, -9.81])
    position, velocity, segments, start = np.array([0.0, 0.0, 0.25]), np.zeros(3), [], 0.0
    for _ in range(5):
        a, b, c = 0.5 * g @ normal, velocity @ normal, position @ normal
        duration = (-b - np.sqrt(b * b - 4 * a * c)) / (2 * a)
        segments.append((start, position, velocity))
        position = position + velocity * duration + 0.5 * g * duration**2
        velocity = velocity + g * duration
        velocity = velocity - (1 + 0.8) * (velocity @ normal) * normal
        position = position - (position @ normal) * normal
        start += duration
    time = np.arange(round(start * rate)) / rate
    which = np.searchsorted([segment[0] for segment in segments], time, side="right") - 1
    d = time - np.array([segment[0] for segment in segments])[which]
    track_m = (
        np.array([segment[1] for segment in segments])[which].T
        + np.array([segment[2] for segment in segments])[which].T * d
        + 0.5 * g[:, None] * d**2
    )
    track_m = track_m + np.random.default_rng(0).normal(0, 20e-6, track_m.shape)
    impacts = np.array([segment[0] for segment in segments[1:]])
    at = impact_velocities(time, track_m, impacts, G_M_S2)
    known = np.isfinite(at.u_side_m_s)
    floor = normal_of_impacts(at.before_m_s[known], at.after_m_s[known], at.u_side_m_s[known])
    between_deg = np.degrees(np.arccos(min(1.0, float(normal @ floor.normal))))
    assert between_deg < max(0.05, 3.0 * floor.u_tilt_deg)
    # four impacts that change the speed by 3 m/s, each with a kick that may be 1 cm/s: 0.1 degrees at best
    assert floor.u_tilt_deg < 0.15
    everywhere = np.ones(time.size, dtype=bool)
    track = Track(time, track_m, np.full_like(track_m, 20e-6), everywhere, "exact")
    found = find_bounces(track, Segment(0, time.size, 0, 0), None, rate, G_M_S2)
    assert found.u_tilt_deg is not None
    assert found.impacts[0].e == pytest.approx(0.8, abs=2e-3)
    assert (
        found.impacts[0].u_e
        >= find_bounces(track, Segment(0, time.size, 0, 0), found.normal, rate, G_M_S2).impacts[0].u_e
    )


def test_without_impacts_there_is_no_coefficient() -> None:
    time = np.arange(20000) / 10000.0
    position = np.stack([0.1 * np.cos(3 * time), 0.1 * np.sin(3 * time), np.zeros_like(time)])
    track = Track(time, position, np.ones_like(position), np.ones(time.size, dtype=bool), "exact")
    bounces = find_bounces(track, Segment(0, 20000, 0, 0), UP, 10000.0, G_M_S2)
    assert bounces.impacts == ()
    assert bounces.free_fall is None


def test_jerks_that_no_gravity_follows_are_no_bounces() -> None:
    time = np.arange(30000) / 10000.0
    position = np.stack([np.zeros_like(time), np.zeros_like(time), 0.05 * np.abs(np.sin(2 * np.pi * time))])
    position += np.random.default_rng(0).normal(0, 10e-6, position.shape)
    track = Track(time, position, np.ones_like(position), np.ones(time.size, dtype=bool), "exact")
    bounces = find_bounces(track, Segment(0, 30000, 0, 0), UP, 10000.0, G_M_S2)
    assert bounces.impacts == ()
    assert bounces.free_fall is None


def test_an_impact_whose_flight_is_unknown_has_no_coefficient() -> None:
    drop = Drop()
    track, segment = track_of(drop)
    gone = (track.time_s > drop.impact_s[0] + 0.015) & (track.time_s < drop.impact_s[1] - 0.015)
    cut = Track(track.time_s, np.where(gone, np.nan, track.position_m), track.u_position_m, ~gone, "exact")
    impacts = find_bounces(cut, segment, UP, drop.rate_hz, G_M_S2).impacts
    assert impacts[0].e == pytest.approx(0.8, abs=1e-3)


def test_a_flight_that_is_no_parabola_does_not_spoil_the_others() -> None:
    drop = Drop()
    track, segment = track_of(drop, 5e-6)
    share = np.clip((track.time_s - drop.impact_s[2]) / (drop.impact_s[3] - drop.impact_s[2]), 0.0, 1.0)
    bent = track.position_m + np.outer([0.0, 0.0, 3e-3], np.sin(4 * np.pi * share))
    bounces = find_bounces(replace(track, position_m=bent), segment, UP, drop.rate_hz, G_M_S2)
    assert [impact.valid for impact in bounces.impacts[:6]] == [True, True, False, False, True, True]
    assert [bounces.impacts[k].e for k in (0, 1, 4, 5)] == pytest.approx([0.8] * 4, abs=1e-5)


def test_a_coefficient_that_is_clearly_above_one_is_not_valid() -> None:
    drop = Drop()
    track, segment = track_of(drop, 5e-6)
    backwards = replace(track, position_m=track.position_m[:, ::-1].copy())
    n = track.time_s.size
    bounces = find_bounces(backwards, Segment(n - segment.last, n - segment.first, 0, 0), UP, drop.rate_hz, G_M_S2)
    assert [impact.e for impact in bounces.impacts[-5:]] == pytest.approx([1.25] * 5, abs=1e-3)
    assert not any(impact.valid for impact in bounces.impacts)


def test_a_coefficient_less_certain_than_a_tenth_is_not_valid() -> None:
    drop = Drop()
    track, segment = track_of(drop, 5e-6)
    waves = np.outer([0.0, 0.0, 6e-3], np.sin(2 * np.pi * 12 * track.time_s))
    impacts = find_bounces(
        replace(track, position_m=track.position_m + waves), segment, UP, drop.rate_hz, G_M_S2
    ).impacts
    assert [impact.valid for impact in impacts] == [impact.u_e < 0.1 for impact in impacts]
    assert {impact.valid for impact in impacts} == {True, False}


def test_waves_in_the_residual_widen_the_uncertainty() -> None:
    time = np.linspace(0, 0.2, 2000)
    fall = 0.2 - 0.5 * 9.81 * time**2
    flight = Stretches.between(time, np.array([0]), np.array([2000]))
    white = fit_parabolas(flight, fall + np.random.default_rng(0).normal(0, 1e-4, 2000))
    wavy = fit_parabolas(flight, fall + 1.4e-4 * np.sin(2 * np.pi * 40 * time))
    assert wavy.u_g_m_s2 > 4 * white.u_g_m_s2


def one_after_the_other(*curves: np.ndarray) -> tuple[Stretches, np.ndarray]:
    end = np.cumsum([curve.size for curve in curves])
    joined = np.concatenate(curves)
    return Stretches.between(np.arange(joined.size) * 1e-4, np.append(0, end[:-1]), end), joined


def test_only_what_waves_in_the_residual_hide_widens_the_variance() -> None:
    white = np.random.default_rng(0).normal(size=20000)
    waves = np.sin(2 * np.pi * 40 * np.linspace(0, 0.2, 2000))
    half = white[:2000] + np.sqrt(2.0) * waves
    stretches, residual = one_after_the_other(white, waves, half, np.zeros(20), white[:7])
    assert TRACKS.hidden_waves**2 == 4.0
    of_white, of_waves, of_half, *others = stretches.misfit_widenings(residual, TRACKS.hidden_waves)
    assert of_white == pytest.approx(1.0, abs=0.05)
    assert of_waves == pytest.approx(TRACKS.hidden_waves**2, rel=1e-3)
    assert of_half == pytest.approx(0.5 * (1.0 + 4.0), rel=0.1)
    assert others == [1.0, 1.0], "no residual at all, and too few of them, tell of no waves"


def test_white_residuals_have_the_correlation_length_of_one_sample() -> None:
    rng = np.random.default_rng(0)
    curves = rng.normal(size=20000), np.repeat(rng.normal(size=2000), 10), np.zeros(20), rng.normal(size=7)
    white, blocks, *others = np.asarray(Stretches.correlation_lengths(*one_after_the_other(*curves)))
    assert white == pytest.approx(1.0, abs=0.15)
    assert blocks == pytest.approx(10, rel=0.2)
    assert others == [1.0, 1.0], "no residual at all, and too few of them, tell of no correlation"


def test_the_correlation_length_of_each_stretch_is_the_sum_of_its_own_autocorrelation() -> None:
    rng = np.random.default_rng(1)
    curves = [np.convolve(rng.normal(size=count), np.ones(4), "valid") for count in (30, 33, 100, 250, 700, 703)]
    found = Stretches.correlation_lengths(*one_after_the_other(*curves))
    for own, curve in zip(found, curves, strict=True):
        away = curve - curve.mean()
        correlation = np.correlate(away, away, "full")[curve.size - 1 :] / (away @ away)
        end = next((k for k in range(curve.size // 2) if correlation[k] <= 0), curve.size // 2)
        assert own == pytest.approx(max(1.0, 1.0 + 2.0 * correlation[1:end].sum()), rel=1e-9)


def test_what_rides_a_plate_before_it_is_thrown_does_not_fall_freely() -> None:
    drop = Drop(height_m=0.2, e=0.8)
    track, segment = track_of(drop)
    position, first = track.position_m.copy(), (track.time_s >= drop.rest_s) & (track.time_s < drop.impact_s[0])
    # half as fast down as a fall would be, then faster: the mean is gravity's, its own g is not
    whole = drop.impact_s[0] - drop.rest_s
    share = (track.time_s[first] - drop.rest_s) / whole
    position[2, first] = 0.2 * (1.0 - share**4)
    assert find_bounces(track, segment, UP, drop.rate_hz, G_M_S2).free_fall is not None
    assert find_bounces(replace(track, position_m=position), segment, UP, drop.rate_hz, G_M_S2).free_fall is None
