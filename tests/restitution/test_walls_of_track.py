"""Walls beside the fall of a track: flights that turn aside, impacts that throw back, and what is no wall."""

from __future__ import annotations

import numpy as np
import pytest
from benchmarks.accuracy import with_method
from benchmarks.world.draw import draw
from benchmarks.world.scene import make_record

from radargui.model.result import RunResult, Track
from radargui.processing.process import process
from radargui.restitution.walls_of_track import Aside

RATE_HZ, U_M = 5000.0, 2e-4
BEGIN_S, END_S = np.array([0.0, 0.3, 0.5]), np.array([0.3, 0.5, 0.54])
NORMAL = np.array([0.0, 0.0, 1.0])


def track(x_m: np.ndarray, u_m: float = U_M) -> Track:
    time = np.arange(x_m.size) / RATE_HZ
    position = np.zeros((3, x_m.size))
    position[0] = x_m + 1e-4 * np.random.default_rng(2).standard_normal(x_m.size)
    return Track(time, position, np.full((3, x_m.size), u_m), np.ones(x_m.size, dtype=np.bool_), "exact")


TIME_S = np.arange(int(0.56 * RATE_HZ)) / RATE_HZ


@pytest.mark.parametrize(("wall_s", "number"), [(0.15, 0), (0.28, 0), (0.4, 1)])
def test_a_flight_that_turns_aside_met_a_wall_there(wall_s: float, number: int) -> None:
    found = Aside.of(track(0.3 * TIME_S - 0.5 * np.maximum(0.0, TIME_S - wall_s)), BEGIN_S, END_S)
    assert found.turned.tolist() == [k == number for k in range(3)]
    assert found.when_s[number] == pytest.approx(wall_s, abs=0.01)
    assert found.before_m_s[number, 0] == pytest.approx(0.3, abs=0.03)
    assert found.after_m_s[number, 0] == pytest.approx(-0.2, abs=0.08)


def test_impacts_that_kick_and_waves_within_u_are_no_walls() -> None:
    kicked = track(0.1 * TIME_S + 0.05 * np.maximum(0.0, TIME_S - 0.3))
    assert not Aside.of(kicked, BEGIN_S, END_S).turned.any()
    waves = 2e-3 * np.sin(2.0 * np.pi * TIME_S / 0.1)
    assert not Aside.of(track(waves, u_m=2e-3), BEGIN_S, END_S).turned.any()


def test_a_gap_hides_a_wall_and_tells_none() -> None:
    made = track(0.3 * TIME_S - 0.5 * np.maximum(0.0, TIME_S - 0.15))
    made.valid[600:700] = False
    found = Aside.of(made, BEGIN_S, END_S)
    assert not found.turned.any()
    assert np.isnan(found.when_s[0])


@pytest.mark.parametrize(("after_m_s", "is_wall"), [(-0.2, True), (0.2, False), (-0.01, False)])
def test_an_impact_that_throws_back_along_the_floor_met_a_wall(after_m_s: float, *, is_wall: bool) -> None:
    found = Aside.of(track(0.3 * TIME_S + (after_m_s - 0.3) * np.maximum(0.0, TIME_S - 0.3)), BEGIN_S, END_S)
    thrown = found.thrown_back(np.full(2, -2.0), np.full(2, 1.5), NORMAL)
    assert thrown.tolist() == [is_wall, False]


def measured(seed: int, motion: str, correction: str) -> RunResult:
    scene = draw(seed, "exact", motion=motion)
    return process(make_record(scene).recording, with_method(scene.setup, f"{correction}-exact"))


def test_no_e_is_told_where_a_wall_was_met_with_the_floor() -> None:
    """A wall 13 ms after the impact: e was 8.4 u off in silence, the parabola as good as any."""
    result = measured(9912341, "box", "adaptive")
    assert result.bounces is not None
    assert [one.valid for one in result.bounces.impacts] == [True, False, True]
    assert any(one.startswith("impact 2: a wall was met together with the floor, or in") for one in result.warnings)


def test_a_drop_without_walls_meets_none() -> None:
    result = measured(7305001, "drop", "adaptive")
    assert result.bounces is not None
    assert result.bounces.walls_s == ()
    assert sum(one.valid for one in result.bounces.impacts) > 4
