"""Breaks on motions made for them: found, dropped, told from what no body does."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from support.small_problem import (
    ASIDE_M_S,
    BACK_M_S,
    BOUNCE_S,
    RELEASE_M,
    WALL_S,
    SmallProblem,
    positions,
    small_problem,
)

from radargui.estimation.forward.motion_spline import SplineMotion
from radargui.estimation.select.breaks import (
    BreakSettings,
    kicks_beside,
    sharp_turns,
    side_kicks,
)
from radargui.estimation.select.converge import converge, settle_breaks
from radargui.estimation.solve.break_velocities import BreakSpeeds, break_speeds
from radargui.estimation.solve.changed_problem import positions_at_bins
from radargui.estimation.solve.minimise import Solution
from radargui.model.gravity import NOMINAL_GRAVITY_M_S2 as G_M_S2

UP = np.array([0.0, 0.0, 1.0])


def nothing() -> None:
    """Report no progress."""


def settled(made: SmallProblem) -> Solution:
    solution = converge(made.start, 4, nothing)
    return settle_breaks(made.data, solution, UP, nothing)


@pytest.fixture(scope="module")
def without_break() -> SmallProblem:
    return small_problem(breaks_s=(), sigma=0.005)


def test_a_bounce_without_a_break_is_seen_as_a_sharp_turn_where_it_is(without_break: SmallProblem) -> None:
    solution = converge(without_break.start, 4, nothing)
    assert sharp_turns(solution, UP) == pytest.approx([BOUNCE_S], abs=0.003)
    assert sharp_turns(solution, UP, BreakSettings(sharp_jerk_m_s3=1e6)).size == 0


def test_a_missing_break_is_added_at_the_bounce(without_break: SmallProblem) -> None:
    solution = settled(without_break)
    assert solution.at.spline.break_s == pytest.approx([BOUNCE_S], abs=2e-4)
    error = positions_at_bins(solution) - positions(solution.problem.bins.time_s)
    assert np.abs(error[2]).max() < 2e-4


def test_a_wall_beside_the_fall_is_a_break_but_no_impact() -> None:
    made = small_problem(sigma=0.005, wall_s=WALL_S)
    begun = converge(made.start, 4, nothing)
    assert side_kicks(begun, UP) == pytest.approx([WALL_S], abs=0.003)
    assert side_kicks(begun, UP, BreakSettings(kick_m_s=2.0 * (ASIDE_M_S - BACK_M_S))).size == 0
    solution = settled(made)
    assert solution.at.spline.break_s == pytest.approx([WALL_S, BOUNCE_S], abs=3e-4)
    speeds = break_speeds(solution, UP)
    assert speeds.are_impacts().tolist() == [False, True]
    assert speeds.are_kicks().tolist() == [True, False]
    assert speeds.kick_m_s[0] == pytest.approx(ASIDE_M_S - BACK_M_S, abs=0.02)
    assert speeds.kick_m_s[0] > 20.0 * speeds.u_kick_m_s[0] > 0.0
    # where it is known there is nothing left to find, and a drift without a wall has no kick
    assert side_kicks(solution, UP).size == 0
    assert side_kicks(converge(small_problem(sigma=0.005).start, 4, nothing), UP).size == 0


@pytest.mark.parametrize(("aside_m_s", "kicks"), [(0.14, False), (0.16, True)])
def test_a_kick_is_a_jump_of_the_velocity_along_the_floor_alone(aside_m_s: float, kicks: bool) -> None:
    normal = np.array([0.6, 0.0, 0.8])
    along = np.array([0.8, 0.0, -0.6])

    def place(time_s: np.ndarray, _: object) -> np.ndarray:
        # an even motion along the floor, thrown aside at 0.5 s, and a bounce along the normal at the same time
        late = np.maximum(time_s - 0.5, 0.0)
        return np.outer(0.3 * time_s + aside_m_s * late, along) + np.outer(2.0 * late, normal)

    spline = SimpleNamespace(edge_s=np.array([0.0, 1.0]), offset=place)
    solution: Any = SimpleNamespace(
        at=SimpleNamespace(spline=spline),
        state=SimpleNamespace(coefficients=None),
        problem=SimpleNamespace(released_s=0.05),
    )
    assert side_kicks(solution, normal) == pytest.approx([0.5] if kicks else [], abs=2e-3)


def test_a_push_at_the_release_is_no_wall() -> None:
    begun = converge(small_problem(sigma=0.005, wall_s=WALL_S).start, 4, nothing)
    assert side_kicks(begun, UP).size == 1
    # the fall begins after it: a break here would leave the first flight no span to begin in, and the run no g
    released = replace(begun, problem=replace(begun.problem, released_s=WALL_S + 0.01))
    assert side_kicks(released, UP).size == 0


@pytest.mark.parametrize("late_s", [-0.008, 0.006, 0.012])
def test_a_wall_met_milliseconds_beside_a_bounce_has_a_break_of_its_own(late_s: float) -> None:
    made = small_problem(sigma=0.002, wall_s=BOUNCE_S + late_s)
    begun = converge(made.start, 4, nothing)
    assert side_kicks(begun, UP).size == 0
    solution = settled(made)
    assert solution.at.spline.break_s == pytest.approx(sorted([BOUNCE_S, BOUNCE_S + late_s]), abs=5e-4)
    speeds = break_speeds(solution, UP)
    assert speeds.are_impacts().tolist() == [late_s < 0.0, late_s > 0.0][::-1]
    impact = int(np.flatnonzero(speeds.are_impacts())[0])
    assert speeds.after_m_s[impact] == pytest.approx(0.7 * 1.962, abs=3.0 * speeds.u_jump_m_s[impact] + 0.01)
    assert kicks_beside(SplineMotion(solution.at.spline, solution.state.coefficients), UP, G_M_S2)[0].size == 0


@pytest.mark.parametrize(("late_s", "lean"), [(0.0, 0.0), (0.0, 0.1), (0.01, 0.0), (-0.01, 0.0)])
def test_lines_that_meet_at_their_bounce_tell_of_no_wall_though_it_kicks_and_the_floor_leans(
    late_s: float, lean: float
) -> None:
    spline = small_problem().problem.spline
    time = np.linspace(spline.edge_s[0], spline.edge_s[-1], 2000)
    fallen, met_s = positions(time).T - RELEASE_M, BOUNCE_S + late_s
    fallen[:, 1] = 0.3 * np.minimum(time, met_s) - 0.1 * np.maximum(time - met_s, 0.0)
    motion = SplineMotion(spline, np.linalg.lstsq(spline.design(time).toarray(), fallen, rcond=None)[0])
    found, number = kicks_beside(motion, np.array([0.0, np.sin(lean), np.cos(lean)]), G_M_S2)
    assert found == pytest.approx([met_s] if late_s else [], abs=0.001)
    assert number.tolist() == [0] * found.size


@pytest.mark.parametrize(
    ("before", "after", "kick", "met"),
    [
        (1.2, 1.1, 0.5, True),  # rising
        (-1.2, -0.9, 0.5, True),  # falling, and rubbed
        (1.2, 1.2, 0.05, False),
        (-1.0, 0.9, 0.3, True),  # an impact that kicks
        (0.2, 2.2, 0.3, False),  # thrown up
    ],
)
def test_a_wall_is_met_rising_and_falling_and_only_rubs(before: float, after: float, kick: float, *, met: bool) -> None:
    one = BreakSpeeds(*(np.array([value]) for value in (1.0, before, after, 1e-3, kick, 1e-3)), G_M_S2)
    assert one.are_kicks().tolist() == [met]


def test_breaks_in_the_middle_of_a_flight_make_no_impacts() -> None:
    made = small_problem(breaks_s=(0.17, BOUNCE_S, 0.36), sigma=0.005)
    solution = settled(made)
    speeds = break_speeds(solution, UP)
    assert speeds.time_s[speeds.are_impacts()] == pytest.approx([BOUNCE_S], abs=2e-4)
    assert speeds.before_m_s[speeds.are_impacts()] == pytest.approx([-1.962], abs=0.02)
    assert speeds.after_m_s[speeds.are_impacts()] == pytest.approx([0.7 * 1.962], abs=0.02)


def speeds(time_s: list[float], before: list[float], after: list[float]) -> BreakSpeeds:
    none, u = np.zeros(len(time_s)), np.full(len(time_s), 1e-3)
    return BreakSpeeds(np.array(time_s), np.array(before), np.array(after), u, none, u, G_M_S2)


@pytest.mark.parametrize(
    ("before", "after", "impact"),
    [
        (-1.0, 0.7, True),
        (-1.0, 0.05, True),
        (-1.0, 0.0, False),  # a dead stop is no impact today: its coefficient zero is not told
        (-1.0, -0.5, False),  # slowed, not thrown back
        (-0.05, 0.06, False),  # below 0.12 m/s
        (0.2, 0.9, False),  # pushed while rising
    ],
)
def test_an_impact_comes_down_goes_up_and_jumps(before: float, after: float, impact: bool) -> None:
    assert speeds([1.0], [before], [after]).are_impacts().tolist() == [impact]


def test_after_the_last_impact_the_body_lands_again_and_again_with_the_same_coefficient() -> None:
    g, e, t, v, times = 9.81, 0.5, 1.0, 2.0, []
    for _ in range(3):
        v *= e
        t += 2.0 * v / g
        times.append(t)
    found = speeds([1.0, 1.0 + 2.0 / g], [-2.0, -1.0], [1.0, 0.5]).expected_impacts(3.0)
    assert found[:2] == pytest.approx(times[1:3], abs=1e-12)
    assert (np.diff(found) >= 0.010).all()
    assert speeds([1.0], [0.0], [1.0]).expected_impacts(3.0).size == 0
    assert speeds([1.0], [-2.0], [1.0]).expected_impacts(1.1).size == 0


def test_where_it_bounces_on_unfollowed_it_is_known_to_the_height_of_the_next_flight() -> None:
    g, last_s = 9.81, 1.0 + 0.4 / 9.81
    bouncing, flight_s, height_m = speeds([1.0, last_s], [-0.4, -0.2], [0.2, 0.1]), 0.2 / g, 0.1**2 / (2.0 * g)
    places = last_s + flight_s * np.array([-1.1, -0.9, 0.0, 1.9, 4.1])
    known = pytest.approx(height_m / np.sqrt(12.0))
    assert bouncing.bouncing_on_m(places).tolist() == [0.0, known, known, known, 0.0]
    # the flights after it, each half as long and a quarter as high, end two flights later
    assert bouncing.bouncing_on_m(last_s + flight_s * np.array([3.0, 3.5])) == pytest.approx(
        height_m / np.sqrt(12.0) * np.array([0.25, 0.0625])
    )
    # arriving faster than it left, as a spline does that has lost a bounce, makes no flight of 0.03 s (laboratory seed
    # 6400861, 45 dB: 0.24 mm off at its end, u 0.0008)
    swung = speeds([1.0, last_s, last_s + 0.2 / g], [-0.4, -0.2, -0.5], [0.2, 0.1, 0.4])
    assert swung.bouncing_on_m(places + 0.2 / g).max() == pytest.approx(1.15**2 / 4.0 * height_m / np.sqrt(12.0))
    # a flight of 0.1 s is followed, or is not over yet
    assert not speeds([1.0, last_s], [-2.0, -1.0], [1.0, 0.5]).bouncing_on_m(places).any()
    assert not speeds([1.0], [0.0], [1.0]).bouncing_on_m(places).any()


def test_a_landing_without_a_break_is_unknown_by_the_bounce_after_it() -> None:
    # 39 dB, the last break of a cascade: the next landing was missed, 0.13 mm off with u 0.0015
    g, missed_s = 9.81, 1.0 + 0.36 / 9.81
    bouncing, height_m = speeds([1.0 - 0.72 / g, 1.0], [-0.72, -0.36], [0.36, 0.18]), 0.09**2 / (2.0 * g)
    places = missed_s + 0.18 / g * np.array([-1.1, -0.5, 0.0, 1.5])
    known = pytest.approx(height_m / np.sqrt(12.0))
    assert bouncing.bouncing_on_m(places).tolist() == [0.0, known, known, known]
    # what lies still there has a break that is no impact
    stopped = speeds([1.0 - 0.72 / g, 1.0, missed_s], [-0.72, -0.36, -0.18], [0.36, 0.18, 0.0])
    assert not stopped.bouncing_on_m(places).any()


def test_what_no_body_does_is_no_impact() -> None:
    held_by_nothing = speeds([1.0, 1.006, 1.1], [-0.2, -36.0, -0.3], [36.0, 0.1, 0.2])
    assert held_by_nothing.are_impacts().tolist() == [False, False, True]
    assert speeds([1.0, 1.05], [-0.5, -0.25], [0.24, 0.15]).are_impacts().tolist() == [True, True]
