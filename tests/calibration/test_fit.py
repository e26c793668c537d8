"""The fit on exact paths: it finds what is true, with the u it says, and says what it cannot tell."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from radargui.calibration.fit import LEAST, Fit, fit, unfitted, working
from radargui.calibration.known_path import KnownMotion, read_known
from radargui.calibration.likelihood import Measured, MotionModel, PathLikelihood, World
from radargui.calibration.preparing import Falls
from radargui.calibration.unknowns import USUAL, antenna_unknowns, fall_unknowns, place_unknowns, setup_with
from radargui.calibration.verdict import (
    GAIN,
    fit_paths,
    leaned,
    left_out,
    orders_words,
    other_orders,
    put_right,
    undecidable,
    untold,
)
from radargui.model.arrays import FloatArray
from radargui.model.setup import Setup, read_setup
from radargui.physics.path_length import path_lengths, place_antennas

RESOURCES = Path(__file__).parents[2] / "resources"
PLACES = ((0.0, 0.0, 0.12), (0.08, 0.02, 0.10), (-0.03, 0.09, 0.14))
NOISE_M = 2e-5


def stated() -> Setup:
    """Return the laboratory's setup with wide uncertainties."""
    setup = read_setup(RESOURCES / "setups" / "laboratory.toml")
    wide = {"u_tilt_deg": 2.0, "u_azimuth_deg": 2.0, "u_distance_m": 0.01}
    receivers = tuple(one.model_copy(update=wide) for one in setup.receiver)
    sender = setup.transmitter.model_copy(update={"u_distance_m": 0.01})
    return setup.model_copy(update={"receiver": receivers, "transmitter": sender})


def made(seed: int, *, falls: bool) -> tuple[World, FloatArray, list[PathLikelihood]]:
    """Return a world, its true shifts in prior deviations, and exact paths with a little noise."""
    setup, rng = stated(), np.random.default_rng(seed)
    unknowns = antenna_unknowns(setup)
    motions: list[MotionModel] = []
    if falls:
        for n, place in enumerate(PLACES):
            unknowns += place_unknowns(setup, place, f"place.{n}")
            after = np.array([[0.02, -0.01, 1.6]])
            motions += [Falls(f"place.{n}", 0.3, np.array([0.52]), after, 0.8)]
        unknowns += fall_unknowns(setup)
    else:
        # two circles in different planes
        table = read_known(RESOURCES / "paths" / "turntable.toml")
        motions += [KnownMotion(table, 0.3, 0.01)]
        pendulum = read_known(RESOURCES / "paths" / "pendulum.toml")
        motions += [KnownMotion(pendulum, 0.3, 0.01)]
    world = World(setup, tuple(unknowns))
    # the floor lies where the first fall of each comes down: the same for all up to the places
    true = np.array([rng.uniform(-1.0, 1.0) * bool(one.key) for one in unknowns])
    values = world.values(true)
    antennas = place_antennas(setup_with(setup, unknowns, values))
    out = []
    for motion in motions:
        time = np.linspace(0.0, 0.8 if falls else 4.0, 300)
        own = np.array([one.value + one.u * rng.standard_normal() * (not falls) for one in motion.own])
        place = motion.at(time, values, own)[0][0]
        path = path_lengths(place, antennas) + NOISE_M * rng.standard_normal((3, time.size))
        # what a correction leaves of bias and quadrature error
        turn = 2.0 * np.pi / setup.radar.wavelength_m * path
        path = path + 1e-4 * sum(rng.standard_normal((3, 1)) * f(m * turn) for m in (1, 2) for f in (np.sin, np.cos))
        out.append(PathLikelihood(Measured(time, path - path[:, :1], NOISE_M), motion, setup.radar.wavelength_m))
    return world, true, out


def found_of(world: World, recordings: list[PathLikelihood]) -> Fit:
    return fit_paths(unfitted(world, recordings), recordings)


def test_known_motions_find_the_antennas_within_their_u() -> None:
    off = []
    for seed in (1, 2, 3):
        world, true, recordings = made(seed, falls=False)
        found = found_of(world, recordings)
        u = np.sqrt(np.diag(found.covariance()))
        assert (u < 0.35).all(), "better than the setup"
        off.append((found.z - true) / u)
    share = (np.abs(np.concatenate(off)) < 2.0).mean()
    assert 0.85 <= share <= 1.0
    assert float(np.sqrt(np.mean(np.square(off)))) == pytest.approx(1.0 / LEAST, abs=0.35)


def test_a_recording_left_out_is_foretold() -> None:
    world, _, recordings = made(4, falls=False)
    found = found_of(world, [recordings[0], recordings[0], recordings[1]])
    foretold = left_out(found, [recordings[0], recordings[0], recordings[1]])[0]
    assert (foretold < 2.0 * NOISE_M).all()


def test_recordings_shared_out_among_processes_fit_alike() -> None:
    world, _, recordings = made(7, falls=True)
    here = fit(unfitted(world, recordings), recordings, steps=2)
    with working(2):
        there = fit(unfitted(world, recordings), recordings, steps=2)
    assert np.array_equal(there.z, here.z)
    assert np.array_equal(there.locals_[2].residual_m, here.locals_[2].residual_m, equal_nan=True)


def test_a_motion_held_antenna_lends_its_u() -> None:
    world, _, recordings = made(5, falls=False)
    held = np.array([one.name == "transmitter.distance_m" for one in world.unknowns])
    free = found_of(world, recordings)
    some = fit_paths(unfitted(world, recordings, held), recordings)
    number = int(np.argmax(held))
    assert some.z[number] == 0.0
    # what is held at a value that is known to 10 mm leaves the others no better known than it allows
    assert (np.diag(some.covariance())[~held] > 0.9 * np.diag(free.covariance())[~held]).all()


def test_a_release_that_the_held_gravity_makes_worse_known_is_named_with_what_is_held() -> None:
    world, _, falls = made(5, falls=True)
    recordings = [made(5, falls=False)[2][0], falls[0]]
    names = [one.name for one in world.unknowns]
    release = [names.index(f"place.0.{axis}") for axis in "xyz"]
    held = np.array([bool(one.group) and one.group not in USUAL for one in world.unknowns])
    (said,) = leaned(fit_paths(unfitted(world, recordings, held), recordings), release)
    assert "better: place.0.x, place.0.y; what is not free" in said
    assert said.endswith(": gravity")
    free = fit_paths(unfitted(world, recordings), recordings)
    assert np.diag(free.covariance()).max() <= 1.0, "where nothing is held nothing is worse known than before"
    assert leaned(free, release) == ()


def test_one_circle_on_the_axis_leaves_a_common_turn(tmp_path: Path) -> None:
    path = tmp_path / "axis.toml"
    text = (RESOURCES / "paths" / "turntable.toml").read_text()
    text = text.replace("[0.03, 0.02, 0.0]", "[0.0, 0.0, 0.0]").replace("[0.0, 0.3, 1.0]", "[0.0, 0.0, 1.0]")
    path.write_text(text.replace("zero_deg = 0.0 ", "# "))
    world, _, recordings = made(6, falls=False)
    motion = KnownMotion(read_known(path), 0.3, 0.01)
    time, antennas = recordings[0].measured.time_s, place_antennas(world.setup)
    place = motion.at(time, {}, np.array([one.value for one in motion.own]))[0][0]
    measured = replace(recordings[0].measured, change_m=path_lengths(place, antennas))
    words, condition = untold(found_of(world, [replace(recordings[0], measured=measured, motion=motion)]))
    assert "a common turn of all azimuths about the vertical" in words
    assert condition > 10.0


def test_other_orders_are_all_there_and_named() -> None:
    orders = dict(other_orders(stated()))
    assert len(orders) == 11
    azimuths = [one.azimuth_deg for one in orders["receivers 1 and 3 are swapped"].receiver]
    assert azimuths == [330.0, 210.0, 90.0]
    mirrored = [one.azimuth_deg for one in orders["the azimuths run the other way round (mirror image)"].receiver]
    assert mirrored == [-90.0, -210.0, -330.0]


def test_swapped_receivers_fit_worse_than_the_right_order() -> None:
    world, _, recordings = made(7, falls=False)
    swapped = [
        replace(one, measured=replace(one.measured, change_m=one.measured.change_m[[2, 1, 0]])) for one in recordings
    ]
    right = World(dict(other_orders(world.setup))["receivers 1 and 3 are swapped"], ())
    right = World(right.setup, tuple(antenna_unknowns(right.setup)))
    assert found_of(right, swapped).cost < found_of(world, swapped).cost - GAIN


def test_what_a_path_does_not_show_of_the_order_is_named() -> None:
    world, _, recordings = made(7, falls=False)
    assert undecidable(found_of(world, recordings), recordings) == []
    # between receivers that stand alike around the axis, a sphere that only goes up and down sees no difference
    setup = stated()
    pendulum = read_known(RESOURCES / "paths" / "pendulum.toml")
    lift = replace(pendulum, place=lambda t: np.stack([0.0 * t, 0.0 * t, 0.05 * np.sin(t)]))
    world, motion = World(setup, tuple(antenna_unknowns(setup))), KnownMotion(lift, 0.3, 0.01)
    time = np.linspace(0.0, 4.0, 100)
    path = path_lengths(np.stack([0.0 * time, 0.0 * time, 0.05 * np.sin(time - 0.3)]), place_antennas(setup))
    one = PathLikelihood(Measured(time, path, NOISE_M), motion, setup.radar.wavelength_m)
    orders = undecidable(found_of(world, [one]), [one])
    assert len(orders) == 11
    # a line that people read
    begin = "these motions cannot tell whether"
    named = f"{begin} {', or '.join(orders[:3])}"
    assert orders_words(orders) == f"{named}, or the receivers come in any of 8 other orders"
    assert orders_words(orders[:4]) == f"{begin} {', or '.join(orders[:4])}"
    assert orders_words([]) == ""


def test_a_lost_fringe_is_found_and_put_right() -> None:
    world, _, recordings = made(8, falls=False)
    change = recordings[0].measured.change_m.copy()
    change[1, 150:] += world.setup.radar.wavelength_m
    slipped = [replace(recordings[0], measured=replace(recordings[0].measured, change_m=change)), recordings[1]]
    right, slips = put_right(found_of(world, slipped), slipped)
    assert [(one.recording, one.receiver) for one in slips] == [(0, 1)]
    assert slips[0].time_s == pytest.approx(float(recordings[0].measured.time_s[150]))
    assert np.allclose(right[0].measured.change_m, recordings[0].measured.change_m)


def test_flights_follow_gravity_drag_and_meet_at_the_impact() -> None:
    world, _, recordings = made(9, falls=True)
    motion = recordings[0].motion
    values, own = world.values(np.zeros(len(world.unknowns))), np.array([one.value for one in motion.own])
    time = np.linspace(0.3, 0.8, 5001)
    (place, velocity, acceleration), _ = motion.at(time, values, own)
    law = -values["drag_1_m"] * np.linalg.norm(velocity, axis=0) * velocity
    law[2] -= values["gravity.g_m_s2"]
    inside = np.abs(time - 0.52) > 0.001
    assert np.abs(acceleration - law)[:, inside].max() < 2e-3
    assert np.abs(np.diff(place, axis=1)).max() < 2e-4 * 1.1
    fallen = place[2, 0] - place[2, np.searchsorted(time, 0.5)]
    assert fallen == pytest.approx(0.5 * values["gravity.g_m_s2"] * 0.2**2, rel=2e-3)
