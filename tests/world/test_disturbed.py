"""Disturbances in the room: each moves, rings and reflects as its physics says, and never touches the truth."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from benchmarks.world.disturbance import Array, Complex
from benchmarks.world.disturbed.draw import DISTURBED, disturbed
from benchmarks.world.disturbed.reflector import Reflector
from benchmarks.world.disturbed.second import SecondSphere
from benchmarks.world.disturbed.shock import Shock
from benchmarks.world.draw import draw
from benchmarks.world.room import Room
from benchmarks.world.scene import Record, Scene, make_record

SEEDS = range(5)
QUICK = {"rate_hz": 2000.0, "skew_s": 0.0, "walls": 0}
EACH = [f"{name}/{variant}" for name, (_, variants) in DISTURBED.items() for variant in variants]


@cache
def made(which: str, seed: int, strength: float | None = None) -> Scene:
    return disturbed(which, seed, strength=strength, **QUICK)


@cache
def plain_record() -> Record:
    """The drop of the third seed without a disturbance."""
    return make_record(draw(3, **QUICK))


def times(scene: Scene, rate_hz: float = 2000.0) -> Array:
    return np.arange(0.0, scene.drop.duration_s, 1.0 / rate_hz)


def added(scene: Scene, receiver: int, time_s: Array) -> Complex:
    """What the disturbances alone send to a receiver."""
    out = np.zeros(time_s.size, complex)
    for one in scene.disturbances:
        out = one.echo(receiver, time_s, scene.drop.position(time_s), out)
    return out


@pytest.mark.parametrize("which", EACH)
def test_truth_and_setup_stay_those_of_the_drop_and_the_samples_change(which: str) -> None:
    scene = made(which, 3, 1.0)
    record, plain = make_record(scene), plain_record()
    assert record.scene.setup == plain.scene.setup
    came = record.recording.index()
    np.testing.assert_array_equal(record.truth.position_m, plain.truth.position_m[:, came])
    np.testing.assert_array_equal(record.truth.impact_time_s, plain.truth.impact_time_s)
    assert record.recording.raw.shape != plain.recording.raw.shape or np.any(
        record.recording.raw != plain.recording.raw
    )
    assert scene.name == f"{which}-3"


def test_strength_changes_the_size_and_nothing_else() -> None:
    weak, strong = (added(made("foreign", 4, strength), 1, np.arange(0.0, 1.0, 1e-3)) for strength in (0.0, 1.0))
    np.testing.assert_allclose(strong, 20.0 * weak, rtol=1e-9)  # 0.5 to 10 %


@pytest.mark.parametrize("which", ["ghost", "hand/waves"])
def test_what_is_not_there_is_refused_by_name(which: str) -> None:
    with pytest.raises(ValueError, match="no such"):
        disturbed(which, 0)
    with pytest.raises(ValueError, match="strength"):
        disturbed("hand", 0, strength=1.5)


def test_a_reflector_turns_with_its_path_and_weakens_with_both_ranges() -> None:
    room = draw(0, lobes=False, **QUICK).room
    near, far = np.array([0.1, 0.0, 0.1]), np.array([0.3, -0.2, 0.0])
    one = Reflector(room, lambda t: np.where(t < 1.0, near[:, None], far[:, None]), np.array([0.1, 0.2j, 0.3]), near)
    time_s = np.array([0.0, 2.0])
    for receiver in range(3):
        echo = one.echo(receiver, time_s, np.zeros((3, 2)), np.zeros(2, complex))
        assert echo[0] == pytest.approx(one.shares[receiver])
        ranges = [
            [np.linalg.norm(place - antenna.position_m) for antenna in (room.antennas[0], room.antennas[receiver + 1])]
            for place in (near, far)
        ]
        longer = sum(ranges[1]) - sum(ranges[0])
        expected = np.prod(ranges[0]) / np.prod(ranges[1]) * np.exp(1j * room.sphere.wavenumber_rad_m * longer)
        assert echo[1] / echo[0] == pytest.approx(expected)


@pytest.mark.parametrize("seed", SEEDS)
def test_the_shock_lengthens_paths_as_antennas_that_are_moved_do(seed: int) -> None:
    scene = made("shock", seed)
    (shock,) = scene.disturbances
    assert isinstance(shock, Shock)
    time_s = times(scene)
    place = scene.drop.position(time_s)
    for at in (np.searchsorted(time_s, scene.drop.impacts[0].time_s) + 20, 500):
        moved = tuple(
            replace(one, position_m=one.position_m + ring.moved_m(time_s[at : at + 1])[:, 0])
            for one, ring in zip(scene.room.antennas, shock.rings, strict=True)
        )
        longer = replace(scene.room, antennas=moved).path_m(place[:, at : at + 1])
        longer -= scene.room.path_m(place[:, at : at + 1])
        found = [shock.path_change_m(number, time_s, place)[at] for number in range(3)]
        np.testing.assert_allclose(found, longer[:, 0], atol=1e-7)
        apart = [np.linalg.norm(moved[n].position_m - moved[0].position_m) for n in (1, 2, 3)]
        before = [
            np.linalg.norm(scene.room.antennas[n].position_m - scene.room.antennas[0].position_m) for n in (1, 2, 3)
        ]
        found = [shock.direct_change_m(number, time_s)[at] for number in range(3)]
        np.testing.assert_allclose(found, np.subtract(apart, before), atol=1e-7)


@pytest.mark.parametrize("seed", SEEDS)
def test_the_shock_begins_with_the_release_is_hardest_after_the_first_impact_and_dies_out(seed: int) -> None:
    scene = made("shock", seed)
    (shock,) = scene.disturbances
    drop, time_s = scene.drop, times(scene, 20000.0)
    for ring in shock.rings:
        size = np.linalg.norm(ring.moved_m(time_s), axis=0)
        assert np.all(size[time_s < drop.start_s] == 0.0)
        first = size[(time_s > drop.impacts[0].time_s) & (time_s < drop.impacts[0].time_s + 0.05)].max()
        released = size[time_s < drop.impacts[0].time_s].max()
        assert 5e-6 * 0.4 < first <= 2.6e-4
        assert 0.0 < released < first
        alone = replace(ring, blows=((0.0, 1.0),)).moved_m(np.arange(0.0, 2.0, 1e-4))
        assert np.abs(alone[:, -1000:]).max() < 2e-3 * np.abs(alone).max()
    echo = np.zeros(time_s.size, complex)
    assert np.abs(shock.echo(0, time_s, drop.position(time_s), echo)).max() > 0.0  # the offsets ring


@pytest.mark.parametrize("seed", SEEDS)
def test_the_second_sphere_is_lit_as_the_first_and_bounces_on_the_same_floor(seed: int) -> None:
    scene = made("second/sphere", seed)
    (second,) = scene.disturbances
    assert isinstance(second, SecondSphere)
    time_s = times(scene)
    place = second.drop.position(time_s)
    touch = scene.drop.position(np.array([scene.drop.impacts[0].time_s]))
    normal = scene.room.mirrors[0].normal
    lower = second.room.sphere.radius_m - scene.room.sphere.radius_m
    above = normal @ (place - touch) - lower
    assert -1e-9 < above.min() < 5e-4
    assert np.linalg.norm(place[:, 0] - scene.drop.position(np.zeros(1))[:, 0]) > 0.019
    alone = replace(second.room, mirrors=())
    at_centre = alone.received(1, np.zeros((3, 1)))[0] / abs(scene.room.direct(1, np.zeros((3, 1)))[0])
    found = replace(second, room=alone, drop=replace(second.drop, position=lambda t: np.zeros((3, t.size))))
    echo = found.echo(1, np.zeros(1), np.zeros((3, 1)), np.zeros(1, complex))[0]
    assert abs(echo) == pytest.approx(abs(at_centre))
    assert 0.4 <= second.room.sphere.radius_m / scene.room.sphere.radius_m <= 1.0
    assert isinstance(second.room, Room)
