"""Restitution and free fall from flights fitted to paths whose truth is exact, and uncertainties that hold."""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np
import pytest
from benchmarks.world.drop import Body, Floor, fall
from support.changed import changed
from support.drops import Drop
from support.flown import flown, paths_of, setup_at, track_of

from radargui.model.gravity import drag_of_sphere
from radargui.model.result import Bounce, Bounces, Segment, Track
from radargui.restitution.bounces import find_bounces
from radargui.restitution.cross_check import disagreements
from radargui.restitution.setup_chi_square import SetupChiSquare

UP = np.array([0.0, 0.0, 1.0])


@pytest.mark.parametrize(("height", "e"), [(0.06, 0.9), (0.25, 0.8), (0.30, 0.5), (0.12, 0.92)])
def test_an_exact_track_gives_exact_coefficients(height: float, e: float) -> None:
    drop = Drop(height_m=height, e=e, rate_hz=5000.0)
    track, segment = track_of(drop)
    found = flown(track, segment, drop.rate_hz)
    first, second = found.bounces.impacts[:2]
    assert (first.e, second.e) == pytest.approx((e, e), rel=2e-4)
    assert first.speed_before_m_s == pytest.approx(np.sqrt(2 * 9.81 * height), rel=1e-4)
    assert first.time_s == pytest.approx(drop.impact_s[0], abs=1e-6)
    fallen = found.bounces.free_fall
    assert fallen is not None
    assert fallen.g_m_s2 == pytest.approx(9.81, rel=2e-4)
    assert fallen.drop_height_m == pytest.approx(height, abs=1e-4)
    assert found.cause is None


def test_uncertainties_hold_the_truth_as_often_as_they_should() -> None:
    e_pull, g_pull = [], []
    for seed in range(30):
        track, segment = _in_air(7850.0, 0.0)
        track = replace(track, u_position_m=np.full_like(track.u_position_m, 1e-9))
        setup = setup_at(track.position_m[:, 0], density_kg_m3=7850.0)
        paths = paths_of(track, setup)
        # each receiver has noise of its own: that of places would be in all of them alike
        noisy = paths.change_m + 50e-6 * np.random.default_rng(seed).standard_normal(paths.change_m.shape)
        found = find_bounces(track, replace(paths, change_m=noisy), segment, setup, 5000.0)
        _, e, g = found.directions()
        first, fallen = found.bounces.impacts[0], found.bounces.free_fall
        assert fallen is not None
        e_pull.append((first.e - 0.8) / np.hypot(first.u_e, np.linalg.norm(e[:, 0])))
        in_air = Body(radius_m=0.005, density_kg_m3=7850.0, gravity_m_s2=9.81).acceleration_m_s2
        g_pull.append((fallen.g_m_s2 - in_air) / np.hypot(fallen.u_g_m_s2, np.linalg.norm(g)))
    for pull in (e_pull, g_pull):
        assert np.mean(np.abs(pull) < 2.0) > 0.9
    # antennas are where they are stated: of g next to nothing of what they may be off by is seen
    assert 0.5 < np.std(e_pull) < 1.2


@pytest.mark.parametrize(("density_kg_m3", "seen"), [(7850.0, False), (1050.0, True)])
def test_a_sphere_of_plastic_is_told_by_its_flights_where_no_density_is_given(density_kg_m3: float, seen: bool) -> None:
    track, segment = _in_air(density_kg_m3, 5e-5)
    setup, metal = setup_at(track.position_m[:, 0], density_kg_m3=None), drag_of_sphere(0.01, None)
    found = flown(track, segment, 5000.0, setup).bounces
    assert (found.braked_1_m is not None) is seen
    if found.braked_1_m is not None:
        assert found.braked_1_m == pytest.approx(drag_of_sphere(0.01, density_kg_m3).k_1_m, rel=0.3)
        assert found.braked_1_m > 1.5 * metal.k_1_m
    # who gives a density is believed
    assert flown(track, segment, 5000.0, setup_at(track.position_m[:, 0])).bounces.braked_1_m is None


@pytest.mark.parametrize("density_kg_m3", [7850.0, 1050.0])
def test_drag_makes_no_error_of_e_and_g(density_kg_m3: float) -> None:
    track, segment = _in_air(density_kg_m3, 0.0)
    found = flown(track, segment, 5000.0, setup_at(track.position_m[:, 0], density_kg_m3=density_kg_m3)).bounces
    assert [one.e for one in found.impacts[:3]] == pytest.approx([0.8] * 3, rel=1e-4)
    assert found.free_fall is not None
    in_air = Body(radius_m=0.005, density_kg_m3=density_kg_m3, gravity_m_s2=9.81).acceleration_m_s2
    assert found.free_fall.g_m_s2 == pytest.approx(in_air, rel=5e-4)


def _in_air(density_kg_m3: float, noise_m: float) -> tuple[Track, Segment]:
    body = Body(radius_m=0.005, density_kg_m3=density_kg_m3, gravity_m_s2=9.81)
    floor = Floor(UP, np.array([0.0, 0.0, -0.13]), restitution=0.8, scatter=0.0)
    drop = fall(np.random.default_rng(1), body, floor, np.array([0.0, 0.0, 0.12]), start_s=0.3, duration_s=1.2)
    time_s = np.arange(6000) / 5000.0
    exact = drop.position(time_s)
    position = exact + noise_m * np.random.default_rng(2).standard_normal(exact.shape)
    position[:, 0] = exact[:, 0]
    u_m = np.full_like(position, max(noise_m, 1e-6))
    return Track(time_s, position, u_m, np.ones(time_s.size, dtype=bool), "exact"), Segment(1500, time_s.size, 0, 1450)


def test_waves_as_long_as_a_rebound_are_in_the_uncertainty_of_e_and_g() -> None:
    drop = Drop(height_m=0.12, e=0.5, rate_hz=5000.0)
    track, segment = track_of(drop)
    bent = replace(track, u_position_m=np.full_like(track.u_position_m, 2e-4))
    exact, uncertain = (flown(one, segment, drop.rate_hz).bounces for one in (track, bent))
    first, wide = exact.impacts[0], uncertain.impacts[0]
    # the rebound rises e^2 = a quarter as high: 0.2 e u / h = 0.2 * 0.5 * 0.2 mm / 30 mm
    assert wide.u_e == pytest.approx(np.hypot(first.u_e, 0.1 * 2e-4 / 0.03), rel=1e-3)
    assert wide.e == first.e
    assert exact.free_fall is not None
    assert uncertain.free_fall is not None
    u_g = np.hypot(exact.free_fall.u_g_m_s2, 9.81 * 2e-4 / 0.12)
    assert uncertain.free_fall.u_g_m_s2 == pytest.approx(u_g, rel=1e-3)


def test_a_tilted_floor_is_judged_along_its_normal() -> None:
    drop = Drop(rate_hz=5000.0)
    track, segment = track_of(drop)
    normal = np.array([0.1, 0.0, 1.0])
    setup = changed(setup_at(track.position_m[:, 0]), floor={"normal": tuple(normal / np.linalg.norm(normal))})
    found = flown(track, segment, drop.rate_hz, setup).bounces
    assert found.impacts[0].e == pytest.approx(0.8, rel=1e-4)
    assert found.free_fall is not None
    assert found.free_fall.g_m_s2 == pytest.approx(9.81, rel=1e-4), "g is vertical, whatever the floor"


def test_flight_time_and_height_give_the_same_coefficient() -> None:
    drop = Drop(rate_hz=10000.0)
    track, segment = track_of(drop, 10e-6)
    impacts = flown(track, segment, drop.rate_hz).bounces.impacts
    assert [impact.e_flight_time for impact in impacts[:4]] == pytest.approx([0.8] * 4, abs=1e-3)
    assert [impact.e_height for impact in impacts[:4]] == pytest.approx([0.8] * 4, abs=1e-3)
    assert np.isnan(impacts[-1].e_flight_time)
    assert disagreements(Bounces(impacts)) == []


def test_coefficients_that_disagree_are_told() -> None:
    first = Bounce(0.7, 2.2, 1.76, 0.8, 1e-4, "flights", valid=True, e_flight_time=0.7)
    (finding,) = disagreements(Bounces((first,)))
    assert "0.7000 from the flight time" in finding.text
    assert disagreements(Bounces((replace(first, valid=False),))) == [], "what is not valid is not compared"
    slow = replace(first, speed_before_m_s=0.1, speed_after_m_s=0.08)
    assert disagreements(Bounces((slow,))) == [], "the impact after it may be below what is resolved"


@pytest.mark.parametrize("tilt_deg", [0.0, 0.2, 3.0])
def test_the_normal_of_a_tilted_floor_is_found_from_the_impacts(tilt_deg: float) -> None:
    normal = np.array([np.sin(np.radians(tilt_deg)), 0.0, np.cos(np.radians(tilt_deg))])
    rate, g = 10000.0, np.array([0.0, 0.0, -9.81])
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
    time_s = np.arange(round(start * rate)) / rate
    which = np.searchsorted([segment[0] for segment in segments], time_s, side="right") - 1
    d = time_s - np.array([segment[0] for segment in segments])[which]
    track_m = (
        np.array([segment[1] for segment in segments])[which].T
        + np.array([segment[2] for segment in segments])[which].T * d
        + 0.5 * g[:, None] * d**2
    )
    noisy = track_m + np.random.default_rng(0).normal(0, 20e-6, track_m.shape)
    noisy[:, 0] = track_m[:, 0]
    track = Track(time_s, noisy, np.full_like(track_m, 20e-6), np.ones(time_s.size, dtype=bool), "exact")
    setup = setup_at(track.position_m[:, 0], given=False)
    found = flown(track, Segment(0, time_s.size, 0, 0), rate, setup).bounces
    assert found.u_tilt_deg is not None
    assert found.normal is not None
    between_deg = np.degrees(np.arccos(min(1.0, float(normal @ found.normal))))
    assert between_deg < max(0.1, 3.0 * found.u_tilt_deg)
    assert found.u_tilt_deg < 0.2
    assert found.impacts[0].e == pytest.approx(0.8, abs=2e-3)
    known = changed(setup, floor={"normal": found.normal})
    assert found.impacts[0].u_e > flown(track, Segment(0, time_s.size, 0, 0), rate, known).bounces.impacts[0].u_e


def test_without_impacts_there_is_no_coefficient() -> None:
    time_s = np.arange(20000) / 10000.0
    position = np.stack([0.1 * np.cos(3 * time_s), 0.1 * np.sin(3 * time_s), np.zeros_like(time_s)])
    track = Track(time_s, position, np.ones_like(position), np.ones(time_s.size, dtype=bool), "exact")
    found = flown(track, Segment(0, 20000, 0, 0), 10000.0)
    assert found.bounces == Bounces()
    assert found.posterior is None


def test_jerks_that_no_gravity_follows_are_no_bounces() -> None:
    time_s = np.arange(30000) / 10000.0
    position = np.stack([np.zeros_like(time_s), np.zeros_like(time_s), 0.05 * np.abs(np.sin(2 * np.pi * time_s))])
    position += np.random.default_rng(0).normal(0, 10e-6, position.shape)
    track = Track(time_s, position, np.ones_like(position), np.ones(time_s.size, dtype=bool), "exact")
    assert flown(track, Segment(0, 30000, 0, 0), 10000.0).bounces.impacts == ()


def test_impacts_beside_a_flight_that_is_unknown_have_no_coefficient_and_those_after_it_have() -> None:
    drop = Drop(rate_hz=5000.0)
    track, segment = track_of(drop)
    gone = (track.time_s > drop.impact_s[1] + 0.001) & (track.time_s < drop.impact_s[2] - 0.001)
    cut = replace(track, position_m=np.where(gone, np.nan, track.position_m), valid=~gone)
    impacts = flown(cut, segment, drop.rate_hz, setup_at(track.position_m[:, 0])).bounces.impacts
    beside = [one for one in impacts if one.time_s < drop.impact_s[3] + 0.01]
    assert beside
    assert not any(one.valid for one in beside)
    after = [one for one in impacts if one.time_s > drop.impact_s[3] + 0.01]
    assert [one.e for one in after[:5]] == pytest.approx([0.8] * 5, abs=1e-3)
    assert all(one.valid for one in after[:5])


def test_a_flight_that_is_no_parabola_does_not_spoil_the_others() -> None:
    drop = Drop(rate_hz=5000.0)
    track, segment = track_of(drop, 5e-6)
    share = np.clip((track.time_s - drop.impact_s[2]) / (drop.impact_s[3] - drop.impact_s[2]), 0.0, 1.0)
    bent = replace(track, position_m=track.position_m + np.outer([0.0, 0.0, 3e-3], np.sin(4 * np.pi * share)))
    impacts = flown(bent, segment, drop.rate_hz, setup_at(track.position_m[:, 0])).bounces.impacts
    assert [impact.valid for impact in impacts[:6]] == [True, True, False, False, True, True]
    assert [impacts[k].e for k in (0, 1, 4, 5)] == pytest.approx([0.8] * 4, abs=2e-4)


def test_a_coefficient_that_is_clearly_above_one_is_not_valid() -> None:
    drop = Drop(rate_hz=5000.0)
    track, segment = track_of(drop, 5e-6)
    n = track.time_s.size
    backwards = replace(track, position_m=track.position_m[:, ::-1].copy())
    setup = setup_at(track.position_m[:, -1])
    impacts = flown(backwards, Segment(n - segment.last, n - segment.first, 0, 0), drop.rate_hz, setup).bounces.impacts
    assert [impact.e for impact in impacts[-5:]] == pytest.approx([1.25] * 5, abs=1e-3)
    assert not any(impact.valid for impact in impacts)


def test_many_impacts_are_fitted_in_chains_that_know_what_those_before_found() -> None:
    drop = Drop(height_m=0.12, e=0.92, rate_hz=5000.0)
    track, segment = track_of(drop, 10e-6)
    begin = time.process_time()
    found = flown(track, segment, drop.rate_hz)
    assert time.process_time() - begin < 2.0
    assert len(found.chains) > 2
    assert len(found.bounces.impacts) > 20
    assert [one.e for one in found.bounces.impacts[:20]] == pytest.approx([0.92] * 20, abs=2e-3)
    along, e, g = found.directions()
    assert along.shape[1] == found.chains[0].fit.n_setup
    assert e.shape == (len(along), len(found.bounces.impacts))
    assert np.isfinite(g).all()


def test_antennas_that_stand_elsewhere_are_found_and_told() -> None:
    drop = Drop(rate_hz=5000.0)
    track, segment = track_of(drop, 10e-6)
    setup = setup_at(track.position_m[:, 0])
    receivers = [one.model_dump() for one in setup.receiver]
    receivers[1]["tilt_deg"] += 8.0
    wrong = type(setup).model_validate({**setup.model_dump(by_alias=True), "receiver": receivers})
    found = find_bounces(track, paths_of(track, setup), segment, wrong, drop.rate_hz)
    assert found.posterior is not None
    pulls = dict(zip((one.key for one in found.posterior.inputs), found.posterior.mean, strict=True))
    # 8 degrees are 16 u, of which others take a part
    assert pulls["receiver[2].tilt_deg"] < -4.0
    assert found.cause is not None
    assert "receiver[2]" in found.cause.text
    assert found.bounces.impacts[0].e == pytest.approx(0.8, rel=2e-3)


def test_chi_square_of_paths_is_least_where_the_setup_was_found() -> None:
    drop = Drop(rate_hz=5000.0)
    track, segment = track_of(drop, 10e-6)
    fit = flown(track, segment, drop.rate_hz).chains[0].fit
    least, _ = SetupChiSquare.of_paths(fit).least()
    assert least == pytest.approx(fit.values[: fit.n_setup], abs=1e-3)


def test_longer_paths_move_what_follows_as_a_fit_of_them_does() -> None:
    drop = Drop(rate_hz=5000.0)
    track, segment = track_of(drop, 10e-6)
    setup = setup_at(track.position_m[:, 0])
    paths = paths_of(track, setup)
    found = find_bounces(track, paths, segment, setup, drop.rate_hz)
    # so small that the variances of the cosines stay what they were
    longer = 1e-7 * np.sin(20.0 * paths.change_m)
    _, e, g = found.by_paths(paths.time_s, longer)
    other = find_bounces(track, replace(paths, change_m=paths.change_m + longer), segment, setup, drop.rate_hz)
    assert e[0] == pytest.approx(other.bounces.impacts[0].e - found.bounces.impacts[0].e, rel=0.3, abs=1e-8)
    assert found.bounces.free_fall is not None
    assert other.bounces.free_fall is not None
    assert g == pytest.approx(other.bounces.free_fall.g_m_s2 - found.bounces.free_fall.g_m_s2, rel=0.3, abs=2e-6)


def test_what_rides_a_plate_before_it_is_thrown_does_not_fall_freely() -> None:
    drop = Drop(height_m=0.2, e=0.8, rate_hz=5000.0)
    track, segment = track_of(drop)
    position, first = track.position_m.copy(), (track.time_s >= drop.rest_s) & (track.time_s < drop.impact_s[0])
    # half as fast down as a fall would be, then faster: the mean is gravity's, its own g is not
    share = (track.time_s[first] - drop.rest_s) / (drop.impact_s[0] - drop.rest_s)
    position[2, first] = 0.2 * (1.0 - share**4)
    assert flown(track, segment, drop.rate_hz).bounces.free_fall is not None
    assert flown(replace(track, position_m=position), segment, drop.rate_hz).bounces.free_fall is None
