"""Motions other than drops against closed forms: radius, speed, energy, ways and times; truth from end to end."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from benchmarks.world.course import UP, along, circle, downhill
from benchmarks.world.draw import draw
from benchmarks.world.draw_course import COURSES, FASTEST_M_S, FIELD_M, SIZES_M
from benchmarks.world.drop import ROLLING, Body, Drop, Floor
from benchmarks.world.hand import Move, carried
from benchmarks.world.pendulum import swing
from benchmarks.world.profile import Profile, Span, held, joined, trapezoid
from benchmarks.world.scene import Scene, make_record
from benchmarks.world.throw import thrown

STEEL = Body(0.005, 7850.0, 9.81)
HEAVY = Body(0.008, 25e3, 9.81)  # hardly braked by air
FASTEST_DROP_M_S = 2.45
Offsets = Callable[[np.ndarray], np.ndarray]


def velocity(offset_m: Offsets, time_s: np.ndarray, step_s: float = 1e-5) -> np.ndarray:
    return (offset_m(time_s + step_s) - offset_m(time_s - step_s)) / (2.0 * step_s)


def generator() -> np.random.Generator:
    return np.random.default_rng(3)


def test_the_way_is_the_integral_of_the_rate() -> None:
    profile = Profile((Span(0.3, 2.0, gentle=True), held(0.4, 2.0), Span(0.2, -1.0), Span(0.1, 0.0, gentle=True)))
    times = np.linspace(0.0, 1.2, 120_001)
    rate = np.interp(times, [0.3, 0.7, 0.9], [2.0, 2.0, -1.0])
    first, last = np.clip(times / 0.3, 0.0, 1.0), np.clip((times - 0.9) / 0.1, 0.0, 1.0)
    rate = np.where(times < 0.3, 2.0 * first**2 * (3.0 - 2.0 * first), rate)
    rate = np.where(times > 0.9, -1.0 + last**2 * (3.0 - 2.0 * last), rate)
    way = np.concatenate([[0.0], np.cumsum((rate[1:] + rate[:-1]) / 2.0) * (times[1] - times[0])])
    np.testing.assert_allclose(profile.way(times), way, atol=1e-9)
    assert profile.way(np.array([-0.5]))[0] == 0.0


def test_an_arm_keeps_its_radius_and_its_plane_and_moves_at_radius_times_rate() -> None:
    normal = np.array([0.36, 0.48, 0.8])
    profile = Profile((Span(0.4, 3.0, gentle=True), held(2.0, 3.0)))
    offset_m = circle(profile, 0.1, normal, 0.8)
    times = np.linspace(0.0, 2.4, 500)
    places = offset_m(times)
    np.testing.assert_allclose(normal @ places, 0.0, atol=1e-15)
    even = times > 0.41
    np.testing.assert_allclose(np.linalg.norm(velocity(offset_m, times[even]), axis=0), 0.3, rtol=1e-6)
    full = 2.0 * np.pi / 3.0
    np.testing.assert_allclose(offset_m(np.array([0.5])), offset_m(np.array([0.5 + full])), atol=1e-12)
    middle = (offset_m(np.array([0.6])) + offset_m(np.array([0.6 + full / 2.0]))) / 2.0
    np.testing.assert_allclose(np.linalg.norm(places - middle, axis=0), 0.1, rtol=1e-12)


def test_a_pendulum_keeps_its_thread_and_loses_no_energy_but_to_the_brakes() -> None:
    hang = np.array([0.1, 0.0, -0.3])
    free = swing(HEAVY, hang, push_m_s=np.zeros(3), push_s=0.1, decay_s=1e9, lasts_s=2.0)
    times = np.linspace(1e-4, 1.9, 400)
    energy = 0.5 * np.square(velocity(free, times)).sum(axis=0) + HEAVY.acceleration_m_s2 * free(times)[2]
    np.testing.assert_allclose(np.linalg.norm(hang[:, None] + free(times), axis=0), np.linalg.norm(hang), rtol=1e-9)
    np.testing.assert_allclose(energy, 0.0, atol=2e-3 * HEAVY.acceleration_m_s2 * 0.016)
    braked = swing(HEAVY, hang, push_m_s=np.zeros(3), push_s=0.1, decay_s=5.0, lasts_s=2.0)
    assert np.linalg.norm(velocity(braked, times), axis=0).max() < np.linalg.norm(velocity(free, times), axis=0).max()


def test_a_short_swing_takes_the_time_of_its_thread_and_dies_as_asked() -> None:
    length, decay_s = 0.5, 4.0
    hang = np.array([0.002, 0.0, -np.sqrt(length**2 - 0.002**2)])
    offset_m = swing(HEAVY, hang, push_m_s=np.zeros(3), push_s=0.1, decay_s=decay_s, lasts_s=4.0)
    times = np.linspace(0.0, 4.0, 400)
    # x'' + x' / T + w^2 x = 0: the amplitude falls with 2 T
    rate = np.sqrt(HEAVY.acceleration_m_s2 / length - 0.25 / decay_s**2)
    phase = rate * times
    expected = np.exp(-0.5 * times / decay_s) * (np.cos(phase) + np.sin(phase) / (2.0 * decay_s * rate))
    np.testing.assert_allclose((hang[0] + offset_m(times)[0]) / 0.002, expected, atol=2e-3)


def test_a_hand_brings_the_sphere_where_it_goes_and_trembles_only_while_it_holds_it() -> None:
    moves = [Move(0.0, 0.5, np.array([0.1, 0.0, 0.0])), Move(0.4, 0.5, np.array([0.0, 0.1, 0.05]))]
    still = carried(moves, 0.0, generator(), put_down_s=1.5)
    np.testing.assert_allclose(still(np.array([0.9, 2.0])), np.array([[0.1, 0.1, 0.05]] * 2).T, atol=1e-15)
    speed = np.linalg.norm(velocity(still, np.array([0.25])))
    assert speed == pytest.approx(1.875 * 0.1 / 0.5, rel=1e-6)
    shaking = carried(moves, 2e-4, generator(), put_down_s=21.5)
    times = np.linspace(0.0, 22.0, 20_000)
    tremor = shaking(times) - still(times)
    held_s = (times > 1.5) & (times < 21.0)
    np.testing.assert_allclose(tremor[:, held_s].std(axis=1), 2e-4, rtol=0.05)
    np.testing.assert_array_equal(tremor[:, times >= 21.5], 0.0)
    assert np.abs(tremor[:, 1:10]).max() < 1e-7  # taken up gently


def test_a_sphere_thrown_up_rises_by_its_energy_and_comes_back_to_the_hand_with_its_speed() -> None:
    up = np.array([0.0, 0.0, 1.5])
    course = thrown(generator(), HEAVY, speed_m_s=up, push_s=0.06, floor=None, caught_within_m=0.03, lasts_s=0.8)
    let_go = 0.06 * 1.5 / 2.0
    top = 1.5**2 / (2.0 * HEAVY.acceleration_m_s2)
    assert course.places_m()[2].max() == pytest.approx(let_go + top, rel=2e-3)
    back_s = 0.06 + 2.0 * 1.5 / HEAVY.acceleration_m_s2
    assert velocity(course.offset_m, np.array([back_s - 1e-3]))[2, 0] == pytest.approx(-1.49, abs=5e-3)
    np.testing.assert_allclose(course.offset_m(np.array([0.7]))[2], let_go - 0.03, atol=1e-6)
    assert course.impacts == ()
    # no jump where the push, the flight and the catch meet
    assert np.abs(np.diff(course.places_m()[2])).max() < 1.6 * course.lasts_s / 1999


def test_a_sphere_thrown_over_a_floor_bounces_on_it() -> None:
    floor = Floor(UP, -0.03 * UP, 0.7, 0.0)
    course = thrown(
        generator(), STEEL, speed_m_s=np.array([0.1, 0.0, 1.2]), push_s=0.05, floor=floor, caught_within_m=0.02,
        lasts_s=0.9,
    )  # fmt: skip
    first = course.impacts[0]
    fallen = 0.03 + 0.05 * 1.2 / 2.0 + 1.2**2 / (2.0 * 9.81)
    assert first.before_m_s == pytest.approx(np.sqrt(2.0 * 9.81 * fallen), rel=5e-3)
    assert first.e == pytest.approx(0.7)
    assert course.offset_m(np.array([first.time_s]))[2, 0] == pytest.approx(-0.03, abs=1e-9)
    assert course.places_m()[2].min() > -0.03 - 1e-9


def test_a_sphere_that_rolls_down_gains_five_sevenths_of_its_height() -> None:
    slope, azimuth = 0.2, 1.0
    down, normal = downhill(slope, azimuth)
    assert down @ normal == pytest.approx(0.0, abs=1e-15)
    assert down[2] == pytest.approx(-np.sin(slope))
    gain = ROLLING * 9.81 * np.sin(slope)
    offset_m = along(down, Profile((Span(0.5, 0.5 * gain),)))
    times = np.array([0.2, 0.4])
    speed = np.linalg.norm(velocity(offset_m, times), axis=0)
    np.testing.assert_allclose(0.7 * speed**2, -9.81 * offset_m(times)[2], rtol=1e-6)


@pytest.mark.parametrize("length", [0.2, -0.2, 0.001])
def test_a_stage_goes_its_length_no_faster_than_told_and_comes_back(length: float) -> None:
    there, back = (trapezoid(sign * length, 0.3, 2.0) for sign in (1, -1))
    profile = joined(there, (held(0.2, 0.0),), back)
    one_s = Profile(there).lasts_s
    times = np.linspace(0.0, profile.lasts_s, 2001)
    rate = np.diff(profile.way(times)) / np.diff(times)
    assert profile.way(np.array([one_s]))[0] == pytest.approx(length)
    assert profile.way(np.array([profile.lasts_s]))[0] == pytest.approx(0.0, abs=1e-15)
    assert np.abs(rate).max() <= 0.3 + 1e-9
    assert np.abs(np.diff(rate)).max() / (times[1] - times[0]) <= 2.0 * (1.0 + 1e-6)
    assert one_s == pytest.approx(abs(length) / 0.3 + 0.3 / 2.0 if abs(length) > 0.045 else 2.0 * np.sqrt(0.001 / 2.0))


@pytest.fixture(scope="module", params=COURSES)
def scenes(request: pytest.FixtureRequest) -> list[Scene]:
    return [draw(seed, motion=request.param) for seed in range(10)]


def looked_at(drop: Drop) -> tuple[np.ndarray, np.ndarray]:
    times = np.linspace(0.0, drop.duration_s, 5000)
    return times, drop.position(times)


def test_motions_stay_in_the_field_of_view_and_are_as_large_and_fast_as_asked_for(scenes: list[Scene]) -> None:
    for one in scenes:
        times, places = looked_at(one.drop)
        low, high = places.min(axis=1), places.max(axis=1)
        reached = np.linalg.norm(places - places[:, :1], axis=0).max()
        assert np.maximum(-low, high).max() < FIELD_M + 0.03  # a throw of 28 cm needs some more
        assert SIZES_M[0] / 2.0 - 0.01 < reached < 0.45
        speed = np.linalg.norm(np.diff(places, axis=1), axis=0) / np.diff(times)
        assert speed.max() < (FASTEST_DROP_M_S if one.motion in ("throw", "pendulum") else FASTEST_M_S + 1e-6)
        assert 0.2 < one.drop.duration_s - one.drop.start_s < 8.0


def test_the_sphere_rests_where_the_setup_says_and_then_leaves(scenes: list[Scene]) -> None:
    for one in scenes:
        times, places = looked_at(one.drop)
        resting = times <= one.drop.start_s
        start = np.array(one.setup.tracer.release_position_m)
        np.testing.assert_allclose(places[:, resting], np.repeat(start[:, None], resting.sum(), axis=1), atol=1e-15)
        soon = one.drop.position(np.array([one.drop.start_s + 0.15]))
        assert np.linalg.norm(soon[:, 0] - start) > 1e-5


def test_it_passes_no_mirror(scenes: list[Scene]) -> None:
    for one in scenes:
        _, places = looked_at(one.drop)
        for mirror in one.room.mirrors:
            assert (mirror.normal @ places - mirror.offset_m).min() > one.body.radius_m - 1e-9


def test_only_a_throw_falls_and_only_a_floor_is_hit(scenes: list[Scene]) -> None:
    for one in scenes:
        assert one.falls == (one.motion == "throw")
        assert bool(one.drop.impacts) == (one.facts.get("mode") == "bouncing")


def test_values_are_held_and_the_world_is_the_same_whatever_is_stated() -> None:
    free = draw(2, motion="circle")
    one = draw(2, motion="circle", start_m=[0.05, 0.0, 0.02], snr_db=50.0, size_m=0.1)
    assert one.setup.tracer.release_position_m == (0.05, 0.0, 0.02)
    assert one.mixers == free.mixers
    exact, drawn = (draw(2, stated, motion="stage", rate_hz=2000.0) for stated in ("exact", "drawn"))
    np.testing.assert_array_equal(make_record(exact).recording.raw, make_record(drawn).recording.raw)
    assert drawn.setup.tracer.release_position_m != exact.setup.tracer.release_position_m


def test_an_exact_setup_states_how_a_board_leans() -> None:
    scene = draw(4, motion="incline", lean_deg=9.0)
    normal = np.array(scene.setup.floor.normal)
    assert np.degrees(np.arccos(normal[2] / np.linalg.norm(normal))) == pytest.approx(9.0)
    np.testing.assert_allclose(normal, scene.room.mirrors[0].normal)
    assert draw(4, motion="stage", tilt_deg=1.0).setup.floor.normal == (0.0, 0.0, 1.0)


def test_a_motion_that_is_not_there_is_refused_by_name() -> None:
    with pytest.raises(ValueError, match="juggle"):
        draw(0, motion="juggle")
