"""Experiments of granular physics: motions without jumps that meet what they are said to meet, and truths of them."""

from __future__ import annotations

from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from benchmarks.world.draw import draw
from benchmarks.world.draw_grain import EXPERIMENTS
from benchmarks.world.scene import Scene, make_record


@cache
def drawn(motion: str, seed: int) -> Scene:
    return draw(seed, motion=motion)


@pytest.fixture(scope="module", params=EXPERIMENTS)
def scenes(request: pytest.FixtureRequest) -> list[Scene]:
    return [drawn(request.param, seed) for seed in range(4 if request.param == "shaken" else 10)]


def looked_at(scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    times = np.linspace(0.0, scene.drop.duration_s, 20_001)
    return times, scene.drop.position(times)


def test_the_sphere_rests_where_the_setup_says(scenes: list[Scene]) -> None:
    for one in scenes:
        times, places = looked_at(one)
        start = np.array(one.setup.tracer.release_position_m)
        resting = times <= one.drop.start_s
        np.testing.assert_allclose(places[:, resting], np.repeat(start[:, None], resting.sum(), axis=1), atol=1e-12)
        assert np.linalg.norm(places - start[:, None], axis=0).max() > 1e-3


def test_it_passes_no_mirror(scenes: list[Scene]) -> None:
    for one in scenes:
        _, places = looked_at(one)
        for mirror in one.room.mirrors:
            assert (mirror.normal @ places - mirror.offset_m).min() > one.body.radius_m - 1e-9


def test_between_its_meetings_it_flies_as_gravity_has_it(scenes: list[Scene]) -> None:
    for one in scenes[:6]:
        if one.motion in ("bed", "shaken"):
            continue
        sides = one.drop.start_s + np.array(one.facts.get("side_impacts", []))
        meetings = np.sort([*(impact.time_s for impact in one.drop.impacts), *sides])
        lies = min((impact.time_s for impact in one.drop.impacts if impact.after_m_s == 0.0), default=np.inf)
        checked = 0
        for begin, end in pairwise(meetings):
            if not 0.03 < end - begin < 0.5 or begin >= lies:
                continue
            times = np.linspace(begin + 0.005, end - 0.005, 7)
            step = 2e-4
            before, at, after = (one.drop.position(times + shift) for shift in (-step, 0.0, step))
            speed = np.linalg.norm(after - before, axis=0) / (2.0 * step)
            assert np.linalg.norm((after - 2.0 * at + before) / step**2 + [[0.0], [0.0], [9.8]], axis=0).max() < (
                0.03 + one.body.braking_1_s(float(speed.max())) * 1.1 * speed.max()
            )
            checked += 1
        assert checked


def test_impacts_turn_the_speed_along_the_floor_by_e(scenes: list[Scene]) -> None:
    for one in scenes:
        if one.motion == "shaken":
            continue
        normal = np.array(one.setup.floor.normal) if one.motion == "box" else one.room.mirrors[0].normal
        for impact in one.drop.impacts[:4]:
            times = impact.time_s + np.array([-2e-5, -1e-5, 0.0, 1e-5, 2e-5])
            height = normal @ one.drop.position(times)
            if impact.after_m_s > 0.1:
                assert np.diff(height)[[0, -1]] / 1e-5 == pytest.approx(
                    [-impact.before_m_s, impact.after_m_s], abs=2e-3
                )


def test_a_bed_stops_the_sphere_without_a_rebound() -> None:
    for seed in range(4):
        scene = draw(seed, motion="bed", depth_m=0.03)
        _, places = looked_at(scene)
        assert scene.drop.impacts == ()
        assert np.diff(places[2]).max() < 1e-9
        sunk = scene.room.bed.grains.surface_z_m + scene.body.radius_m - places[2, -1]
        assert sunk == pytest.approx(0.03 + 1e-3 * scene.facts["settle_mm"], abs=3e-4)
        assert 0.01 < 1e-3 * scene.facts["stop_ms"] < 0.1


def test_a_shaken_sphere_s_own_speeds_do_not_give_e() -> None:
    scene = draw(5, motion="shaken", mode="dropped", shake_hz=10.0, shake_g=1.0, e=0.8, scatter=0.0)
    heights = [scene.drop.position(one.time_s + np.array([-1e-5, 0.0, 1e-5]))[2] for one in scene.drop.impacts]
    ratios = [(z[2] - z[1]) / (z[1] - z[0]) for z in heights]
    assert all(one.e == pytest.approx(0.8) for one in scene.drop.impacts if one.after_m_s > 0.0)
    assert np.std(ratios) > 0.05


def test_a_box_has_impacts_on_its_walls_that_are_no_floor_impacts() -> None:
    met = 0
    for seed in range(12):
        scene = drawn("box", seed)
        for time_s in scene.facts.get("side_impacts", []):
            met += 1
            assert all(abs(one.time_s - scene.drop.start_s - time_s) > 1e-4 for one in scene.drop.impacts)
    assert met > 6


def test_twice_begins_its_second_fall_near_the_first_and_lies_between() -> None:
    scene = drawn("twice", 1)
    _, places = looked_at(scene)
    again = scene.drop.start_s + scene.facts["again_s"]
    second = scene.drop.position(np.array([again]))[:, 0]
    assert np.linalg.norm(second - places[:, 0]) < 0.01
    between = [one for one in scene.drop.impacts if one.time_s < again]
    assert 4 < len(between) < len(scene.drop.impacts) - 4
    assert scene.converter.rate_hz <= 10_000.0
    assert np.isclose(places[2], places[2].min(), atol=1e-9).mean() > 0.1


@pytest.mark.parametrize("mode", ["swings", "slides", "slips", "magnet"])
def test_a_bad_release_moves_by_some_millimetres_and_its_speed_has_no_jump(mode: str) -> None:
    scene = draw(3, motion="loose", mode=mode)
    way = 1e-3 * scene.facts["way_mm"]
    assert 1e-5 < way < 3.5e-3
    released = scene.drop.start_s + 1e-3 * scene.facts["ms"]
    step = 1e-5
    slow = np.diff(scene.drop.position(released + step * np.arange(-3.0, 4.0)), axis=1) / step
    assert np.linalg.norm(np.diff(slow, axis=1), axis=0).max() < 2e-3  # g over a step is 1e-4 m/s
    first = np.diff(scene.drop.position(scene.drop.start_s + np.array([0.0, 1e-4])), axis=1)
    assert np.linalg.norm(first) < 1e-7


def test_an_edge_has_two_floors() -> None:
    for seed in (*range(8), 931105):
        scene = drawn("edge", seed)
        heights = scene.drop.position(np.array([one.time_s for one in scene.drop.impacts]))[2]
        on_block = int(scene.facts["on_block"])
        assert 1 <= on_block < heights.size
        np.testing.assert_allclose(heights[:on_block], heights[0], atol=1e-9)
        np.testing.assert_allclose(heights[on_block:], heights[0] - scene.facts["step"], atol=1e-4)


def test_records_are_made_of_them_and_the_world_is_the_same_whatever_is_stated() -> None:
    for motion in ("bed", "box"):
        exact, drawn = (make_record(draw(2, stated, motion=motion, rate_hz=2000.0)) for stated in ("exact", "drawn"))
        np.testing.assert_array_equal(exact.recording.raw, drawn.recording.raw)
        assert exact.truth.impact_time_s.size == len(exact.scene.drop.impacts)
