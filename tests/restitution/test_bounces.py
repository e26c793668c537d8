"""Restitution and free fall from paths whose truth is exact, antennas that are off, uncertainties that hold."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from benchmarks.world.drop import Body, Floor, fall
from support.changed import changed
from support.drops import Drop
from support.small_setups import quick_setup

from radargui.estimation.flights.of_paths import PathFlights
from radargui.geometry.path_length import path_lengths, place_antennas
from radargui.model.arrays import FloatArray
from radargui.model.assumed import uncertain_inputs
from radargui.model.gravity import drag_of_sphere_1_m, share_in_air
from radargui.model.result import Bounces, PathLengths, Segment, Track
from radargui.model.setup import Setup
from radargui.processing.locate import locate
from radargui.restitution.bounces import find_bounces
from radargui.restitution.cross_check import disagreements
from radargui.restitution.track_fit import fit_track

UP = (0.0, 0.0, 1.0)
LEVEL = {"normal": UP}


def setup_of(height_m: float = 0.25, **tables: dict[str, Any]) -> Setup:
    """Return a setup whose release is so high above the floor z = 0, in a place of known g."""
    tracer = {"release_position_m": (0.0, 0.0, height_m), "density_kg_m3": None}
    known = {"floor": LEVEL, "site": {"g_m_s2": 9.81 / share_in_air(None), "u_g_m_s2": 1e-4}, **tables}
    return changed(quick_setup(), tracer=tracer, **known)


def without_normal(setup: Setup) -> Setup:
    """Return a setup that says nothing of the floor."""
    plain = setup.model_dump(by_alias=True)
    del plain["floor"]["normal"]
    return Setup.model_validate(plain)


def paths_of(
    position_m: FloatArray, time_s: FloatArray, setup: Setup, noise_m: float = 0.0, seed: int = 0
) -> PathLengths:
    antennas, release = place_antennas(setup), np.array(setup.tracer.release_position_m)
    change = path_lengths(position_m, antennas) - path_lengths(release[:, None], antennas)
    change += noise_m * np.random.default_rng(seed).standard_normal(change.shape)
    known = np.isfinite(change)
    return PathLengths(time_s, change, change, np.full_like(change, max(noise_m, 1e-9)), known)


def measured(
    paths: PathLengths, setup: Setup, begin_s: float, end_s: float
) -> tuple[Bounces, PathFlights | None, Track]:
    track = locate(paths, setup)
    assert track is not None
    rate_hz = 1.0 / float(paths.time_s[1] - paths.time_s[0])
    segment = Segment(round(begin_s * rate_hz), round(end_s * rate_hz), 0, round((begin_s - 0.02) * rate_hz))
    fit = fit_track(paths, track, segment, setup, rate_hz)
    return Bounces() if fit is None else find_bounces(fit, track, segment, setup), fit, track


def position_of(drop: Drop) -> FloatArray:
    position = np.zeros((3, drop.time_s.size))
    position[2] = drop.height(drop.time_s)
    return position


def bounces_of(drop: Drop, setup: Setup, noise_m: float = 0.0, seed: int = 0) -> Bounces:
    paths = paths_of(position_of(drop), drop.time_s, setup, noise_m, seed)
    return measured(paths, setup, drop.rest_s, drop.impact_s[-1] + 0.02)[0]


@pytest.mark.parametrize(("height", "e"), [(0.06, 0.9), (0.25, 0.8), (0.30, 0.5)])
def test_exact_paths_give_exact_coefficients(height: float, e: float) -> None:
    drop = Drop(height_m=height, e=e, rate_hz=5000.0)
    bounces = bounces_of(drop, setup_of(height))
    assert [one.e for one in bounces.impacts[:2]] == pytest.approx([e, e], abs=2e-4)
    assert bounces.impacts[0].speed_before_m_s == pytest.approx(np.sqrt(2 * 9.81 * height), rel=2e-4)
    assert bounces.impacts[0].time_s == pytest.approx(drop.impact_s[0], abs=2e-6)
    assert bounces.free_fall is not None
    assert bounces.free_fall.g_m_s2 == pytest.approx(9.81, rel=1e-3)
    assert bounces.free_fall.drop_height_m == pytest.approx(height, abs=1e-3)


def antennas_off(setup: Setup, rng: np.random.Generator) -> Setup:
    """Return the setup as it might really be: all that moves paths is off by a draw from its u."""
    for one in uncertain_inputs(setup):
        if one.key.startswith(("transmitter", "receiver", "radar", "tracer.release")):
            setup = one.moved(setup, float(rng.standard_normal()))
    return setup


def test_uncertainties_hold_the_truth_where_the_setup_is_off_by_its_own() -> None:
    drop = Drop(rate_hz=2000.0, settle_s=0.1, e=0.6)
    stated, rng = setup_of(), np.random.default_rng(3)
    e_pull, g_pull, shapes = [], [], []
    for seed in range(40):
        real = antennas_off(stated, rng)
        offset = np.array(real.tracer.release_position_m) - (0.0, 0.0, drop.height_m)
        position = position_of(drop) + offset[:, None]
        paths = paths_of(position, drop.time_s, real, 30e-6, seed)
        bounces, fit, track = measured(paths, stated, drop.rest_s, drop.impact_s[-1] + 0.02)
        assert fit is not None
        assert bounces.free_fall is not None
        slopes = fit.impact_velocities()[1][0, [2, 5]]
        by_e = (slopes[1] + bounces.impacts[0].e * slopes[0]) / bounces.impacts[0].speed_before_m_s
        e_pull.append((bounces.impacts[0].e - 0.6) / np.sqrt(by_e @ fit.covariance @ by_e))
        of_g = np.concatenate(fit.directions(prior_of_g=False))[:, fit.model.gravity] * fit.model.deviation[4]
        u_g = np.hypot(bounces.free_fall.u_g_m_s2, np.linalg.norm(of_g))
        g_pull.append((bounces.free_fall.g_m_s2 - 9.81) / u_g)
        part = slice(round(drop.rest_s * drop.rate_hz), round(drop.impact_s[-1] * drop.rate_hz))
        located, fitted = track.position_m[:, part], fit.flights.position_m(track.time_s[part])
        off = [
            (one - position[:, part]) - (one - position[:, part]).mean(axis=1, keepdims=True)
            for one in (located, fitted)
        ]
        shapes.append([float(np.sqrt((one**2).sum(axis=0).mean())) for one in off])
    for pull in (e_pull, g_pull):
        assert 0.6 < np.std(pull) < 1.4
        assert np.mean(np.abs(pull) < 2.0) > 0.87
    as_stated, found = np.median(shapes, axis=0)
    assert found < 0.4 * as_stated


def test_what_a_correction_leaves_of_a_place_widens_the_uncertainty_and_is_held_by_it() -> None:
    drop, rng = Drop(rate_hz=2000.0, settle_s=0.1, e=0.7), np.random.default_rng(5)
    setup, inside, u = setup_of(), [], []
    for number in range(24):
        paths = paths_of(position_of(drop), drop.time_s, setup, 10e-6, number)
        length, turn = 0.01 * 10.0 ** rng.uniform(size=(3, 6, 1)), 2 * np.pi * rng.uniform(size=(3, 6, 1))
        waves = 5e-5 * np.sin(2 * np.pi * paths.change_m[:, None] / length + turn).sum(axis=1)
        bounces, *_ = measured(replace(paths, change_m=paths.change_m + waves), setup, 0.5, drop.impact_s[-1] + 0.02)
        u.append(bounces.impacts[0].u_e)
        inside.append(abs(bounces.impacts[0].e - 0.7) < 2.0 * u[-1])
    assert np.mean(inside) > 0.8
    assert np.median(u) > 2.0 * bounces_of(drop, setup, 10e-6).impacts[0].u_e


@pytest.mark.parametrize(("density_kg_m3", "seen"), [(7850.0, False), (1050.0, True)])
def test_a_sphere_of_plastic_is_told_by_its_flights_where_no_density_is_given(density_kg_m3: float, seen: bool) -> None:
    body = Body(radius_m=0.005, density_kg_m3=density_kg_m3, gravity_m_s2=9.81)
    floor = Floor(np.array(UP), np.array([0.0, 0.0, -0.13]), restitution=0.8, scatter=0.0)
    drop = fall(np.random.default_rng(1), body, floor, np.array([0.0, 0.0, 0.12]), start_s=0.3, duration_s=1.2)
    time = np.arange(6000) / 5000.0
    setup = setup_of(0.12)
    found, *_ = measured(paths_of(drop.position(time), time, setup, 1e-5), setup, 0.3, 1.2)
    assert (found.braked_1_m is not None) is seen
    if found.braked_1_m is not None:
        assert found.braked_1_m == pytest.approx(body.drag_1_m, rel=0.15)
        assert found.braked_1_m > 1.5 * drag_of_sphere_1_m(0.01, None)
    assert all(abs(one.e - 0.8) < 3.0 * one.u_e for one in found.impacts[:3])
    # who gives a density is believed
    told = changed(setup, tracer={"release_position_m": (0.0, 0.0, 0.12), "density_kg_m3": density_kg_m3})
    assert measured(paths_of(drop.position(time), time, told, 1e-5), told, 0.3, 1.2)[0].braked_1_m is None


def test_a_tilted_floor_is_judged_along_its_normal() -> None:
    normal = np.array([0.1, 0.0, 1.0]) / np.hypot(0.1, 1.0)
    bounces = bounces_of(Drop(rate_hz=5000.0), setup_of(floor={"normal": tuple(normal.tolist())}))
    assert bounces.impacts[0].e == pytest.approx(0.8, abs=2e-4)
    assert bounces.free_fall is not None
    assert bounces.free_fall.g_m_s2 == pytest.approx(9.81, rel=1e-3), "g is vertical, whatever the floor"


def test_flight_time_and_height_give_the_same_coefficient() -> None:
    impacts = bounces_of(Drop(rate_hz=5000.0), setup_of(), 10e-6).impacts
    assert [impact.e_flight_time for impact in impacts[:4]] == pytest.approx([0.8] * 4, abs=1e-3)
    assert [impact.e_height for impact in impacts[:4]] == pytest.approx([0.8] * 4, abs=1e-3)
    assert np.isnan(impacts[-1].e_flight_time)
    assert disagreements(Bounces(impacts)) == []


def test_coefficients_that_disagree_are_told() -> None:
    first = replace(bounces_of(Drop(rate_hz=5000.0), setup_of()).impacts[0], e_flight_time=0.7)
    (finding,) = disagreements(Bounces((first,)))
    assert "0.7000 from the flight time" in finding.text
    assert disagreements(Bounces((replace(first, valid=False),))) == [], "what is not valid is not compared"
    slow = replace(first, speed_before_m_s=0.1, speed_after_m_s=0.08)
    assert disagreements(Bounces((slow,))) == [], "the impact after it may be below what is resolved"


@pytest.mark.parametrize("tilt_deg", [0.0, 3.0])
def test_the_normal_of_a_tilted_floor_is_found_from_the_impacts(tilt_deg: float) -> None:
    normal = np.array([np.sin(np.radians(tilt_deg)), 0.0, np.cos(np.radians(tilt_deg))])
    body = Body(radius_m=0.005, density_kg_m3=7850.0, gravity_m_s2=9.81)
    floor = Floor(normal, np.array([0.0, 0.0, -0.13]), restitution=0.8, scatter=0.0)
    drop = fall(np.random.default_rng(1), body, floor, np.array([0.0, 0.0, 0.12]), start_s=0.3, duration_s=1.2)
    time = np.arange(6000) / 5000.0
    setup = without_normal(setup_of(0.12))
    found, *_ = measured(paths_of(drop.position(time), time, setup, 1e-5), setup, 0.3, 1.2)
    assert found.normal is not None
    assert found.u_tilt_deg is not None
    between_deg = np.degrees(np.arccos(min(1.0, float(normal @ np.array(found.normal)))))
    assert between_deg < max(0.05, 3.0 * found.u_tilt_deg)
    assert found.u_tilt_deg < 0.5
    assert found.impacts[0].e == pytest.approx(0.8, abs=2e-3)


@pytest.mark.parametrize("moves", ["in a circle", "with jerks that no gravity follows"])
def test_what_does_not_fly_has_no_coefficient(moves: str) -> None:
    time = np.arange(20000) / 10000.0
    position = np.stack([0.1 * np.cos(3 * time), 0.1 * np.sin(3 * time), np.zeros_like(time)])
    if moves != "in a circle":
        position = np.stack([0.0 * time, 0.0 * time, 0.05 * np.abs(np.sin(2 * np.pi * time))])
    setup = changed(quick_setup(), tracer={"release_position_m": tuple(position[:, 0].tolist())})
    bounces, fit, _ = measured(paths_of(position, time, setup, 1e-5), setup, 0.1, 2.0)
    assert fit is None
    assert bounces == Bounces()


def test_an_impact_whose_flights_are_unknown_has_no_coefficient() -> None:
    drop = Drop(rate_hz=5000.0)
    position, setup = position_of(drop), setup_of()
    gone = (drop.time_s > drop.impact_s[0] + 0.015) & (drop.time_s < drop.impact_s[1] - 0.015)
    paths = paths_of(np.where(gone, np.nan, position), drop.time_s, setup)
    impacts = measured(paths, setup, drop.rest_s, drop.impact_s[-1] + 0.02)[0].impacts
    assert [one.valid for one in impacts[:4]] == [False, False, True, True]
    assert np.isnan(impacts[0].e)
    assert impacts[0].speed_before_m_s == pytest.approx(np.sqrt(2 * 9.81 * 0.25), rel=1e-3)
    assert impacts[2].e == pytest.approx(0.8, abs=1e-3)


def test_a_flight_that_is_no_parabola_does_not_spoil_the_others() -> None:
    drop = Drop(rate_hz=5000.0)
    position, setup = position_of(drop), setup_of()
    share = np.clip((drop.time_s - drop.impact_s[2]) / (drop.impact_s[3] - drop.impact_s[2]), 0.0, 1.0)
    position[2] += 3e-3 * np.sin(4 * np.pi * share)
    paths = paths_of(position, drop.time_s, setup, 5e-6)
    impacts = measured(paths, setup, drop.rest_s, drop.impact_s[-1] + 0.02)[0].impacts
    assert [impact.valid for impact in impacts[:6]] == [True, True, False, False, True, True]
    assert [impacts[k].e for k in (0, 1, 4, 5)] == pytest.approx([0.8] * 4, abs=2e-3)


def test_a_coefficient_that_is_clearly_above_one_is_not_valid() -> None:
    drop = Drop(rate_hz=5000.0)
    setup, position = setup_of(height_m=0.0), position_of(drop)[:, ::-1]
    paths = paths_of(position, drop.time_s, setup, 5e-6)
    last_s = drop.time_s[-1]
    impacts = measured(paths, setup, last_s - drop.impact_s[-1] - 0.02, last_s - drop.rest_s)[0].impacts
    assert [impact.e for impact in impacts[-3:]] == pytest.approx([1.25] * 3, abs=1e-2)
    assert not any(impact.valid for impact in impacts[-3:])


def test_what_rides_a_plate_before_it_is_thrown_does_not_fall_freely() -> None:
    drop = Drop(height_m=0.2, e=0.8, rate_hz=5000.0)
    position, setup = position_of(drop), setup_of(0.2)
    end_s = drop.impact_s[-1] + 0.02
    falls, *_ = measured(paths_of(position, drop.time_s, setup), setup, drop.rest_s, end_s)
    first = (drop.time_s >= drop.rest_s) & (drop.time_s < drop.impact_s[0])
    # slower than a fall at first, then faster
    share = (drop.time_s[first] - drop.rest_s) / (drop.impact_s[0] - drop.rest_s)
    position[2, first] = 0.2 * (1.0 - share**4)
    rides, *_ = measured(paths_of(position, drop.time_s, setup), setup, drop.rest_s, end_s)
    assert falls.free_fall is not None
    assert rides.free_fall is None
