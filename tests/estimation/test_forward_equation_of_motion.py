"""The equation of free flight: its rows in closed form, slopes against differences, where it holds, what it brings."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.normal_matrices import dense_normal
from support.small_problem import BOUNCE_S, END_S, FLOOR_PLANE, START_S, WALL_PLANE, positions, small_problem

from radargui.estimation.forward.equation_of_motion import EquationDeviation, EquationRows, spans_in_flight
from radargui.estimation.forward.motion_spline import MotionSpline, SplineMotion, make_spline
from radargui.estimation.select.converge import converge
from radargui.estimation.solve.assemble import assemble
from radargui.estimation.solve.changed_problem import (
    positions_at_bins,
    problem_with_flights,
)
from radargui.estimation.solve.minimise import Solution, minimise
from radargui.estimation.solve.problem import Start, State, linearise
from radargui.model.gravity import NOMINAL_GRAVITY_M_S2

GRAVITY = np.array([0.0, 0.0, 9.81])


def drawn(spline: MotionSpline, seed: int = 1) -> np.ndarray:
    return np.random.default_rng(seed).standard_normal((spline.size, 3))


def fitted(spline: MotionSpline, time_s: np.ndarray, place_m: np.ndarray) -> SplineMotion:
    offset = (place_m - place_m[:, :1]).T
    return SplineMotion(spline, np.linalg.lstsq(spline.design(time_s).toarray(), offset, rcond=None)[0])


def flying(solution: Solution) -> Start:
    start = problem_with_flights(solution)
    assert start is not None
    return start


def test_velocity_and_acceleration_at_the_ends_of_spans_are_the_splines_seen_from_inside() -> None:
    spline = make_spline(0.0, 0.5, np.array([0.2, 0.37]), np.array([0.3]))
    c, span = drawn(spline), np.arange(sum(spline.spans))
    pieces = zip(spline.edge_s, spline.edge_s[1:], spline.fractions, strict=False)
    edge = np.concatenate([*(a + (b - a) * share[:-1] for a, b, share in pieces), [0.5]])
    for is_end, inside in ((False, edge[:-1] + 1e-6), (True, edge[1:] - 1e-6)):
        velocity, acceleration = spline.at_ends(span, np.full(span.size, is_end))
        near = [spline.offset(inside + step, c) for step in (-5e-7, 0.0, 5e-7)]
        assert velocity @ c == pytest.approx(
            (near[2] - near[0]) / 1e-6, rel=1e-3, abs=1e-2 * np.abs(velocity @ c).max()
        )
        jerk, _, length = spline.jerk()
        away = (length if is_end else -length) / 2.0
        before = spline.at_ends(span, np.full(span.size, not is_end))[1]
        # of a cubic the acceleration goes straight from one end to the other
        assert acceleration @ c - before @ c == pytest.approx(2.0 * away[:, None] * (jerk @ c), rel=1e-6)


def test_a_fall_with_drag_deviates_from_the_law_by_nothing() -> None:
    spline, k, speed = make_spline(0.0, 0.3, np.zeros(0)), 0.05, np.sqrt(9.81 / 0.05)
    time = np.linspace(0.0, 0.3, 400)
    # v = v_end tanh(g t / v_end) from rest
    place = np.stack([0.0 * time, 0.0 * time, -np.log(np.cosh(9.81 * time / speed)) / k])
    motion = fitted(spline, time, place)
    rows = EquationRows.of(spline, np.ones(30, dtype=bool))
    equation = EquationDeviation.of(rows, motion.coefficients, np.append(GRAVITY, k), 0.0, 0)
    assert np.abs(equation.value).max() < 2e-4
    without = EquationDeviation.of(rows, motion.coefficients, np.append(GRAVITY, 0.0), 0.0, 0)
    assert without.value[-1, 2] == pytest.approx(k * (speed * np.tanh(9.81 * 0.3 / speed)) ** 2, rel=1e-3)
    assert equation.drag[-1, 2] == pytest.approx(-without.value[-1, 2] / k, rel=1e-3)
    slower = EquationDeviation.of(rows, motion.coefficients, np.append(GRAVITY, k), 0.3, 0)
    velocity = rows.velocity @ motion.coefficients
    assert slower.drag - equation.drag == pytest.approx(0.3 * velocity)


def test_what_the_breaks_move_equals_differences() -> None:
    spline = make_spline(0.0, 0.5, np.array([0.2, 0.37]))
    in_flight = np.ones(sum(spline.spans), dtype=bool)
    in_flight[[0, 25, 26]] = False
    c, known = drawn(spline), np.append(GRAVITY, 0.0)
    equation = EquationDeviation.of(EquationRows.of(spline, in_flight), c, known, 0.2, 2)
    for k in range(2):
        up, down = (
            EquationDeviation.of(
                EquationRows.of(spline.with_breaks(spline.break_s + step * np.eye(2)[k]), in_flight), c, known, 0.2, 2
            )
            for step in (1e-7, -1e-7)
        )
        flies = equation.rows.is_flight
        wanted = ((up.value - down.value) / 2e-7)[flies]
        by_break = sum(
            np.where(equation.rows.segment == k + side, 1.0, 0.0)[:, None] * equation.by_breaks[:, :, 1 - side]
            for side in (0, 1)
        )
        assert by_break[flies] == pytest.approx(wanted, rel=1e-5, abs=1e-6 * np.abs(wanted).max())


def test_only_what_falls_freely_after_the_release_flies() -> None:
    time = np.linspace(START_S, END_S, 500)
    spline = make_spline(START_S, END_S, np.array([BOUNCE_S]))
    _, middle, _ = spline.jerk()
    fall = fitted(spline, time, positions(time))
    assert (spans_in_flight(fall, START_S + 0.01, NOMINAL_GRAVITY_M_S2) == (middle > START_S + 0.01)).all()
    rolling = fitted(spline, time, np.stack([0.1 * (time - START_S) ** 2, 0.0 * time, 0.0 * time]))
    assert not spans_in_flight(rolling, START_S, NOMINAL_GRAVITY_M_S2).any()
    caught = positions(time)
    caught[:, time > BOUNCE_S] = positions(np.array([BOUNCE_S]))
    assert (spans_in_flight(fitted(spline, time, caught), START_S, NOMINAL_GRAVITY_M_S2) == (middle < BOUNCE_S)).all()


def test_with_flights_the_slope_and_the_matrix_are_those_of_the_cost() -> None:
    made = small_problem(n_bins=450)
    start = flying(minimise(made.start, 2))
    rng = np.random.default_rng(5)
    # another one for each row, so that none stands for its neighbour
    equation_sd = rng.uniform(0.05, 0.2, start.problem.equation_sd.size)
    # outside of flights a jerk is no matter of the breaks
    equation_sd[: int((~start.problem.in_flight).sum())] = 1e6
    problem = replace(start.problem, equation_sd=equation_sd)
    state = State(
        start.state.coefficients + 1e-5 * rng.standard_normal(start.state.coefficients.shape), start.state.theta
    )
    at = linearise(problem, state)
    blocks = assemble(problem, state, at)
    layout = problem.layout
    for place in [*range(layout.breaks.start, layout.flight.stop)]:
        size = 1e-7 if place < layout.breaks.stop else 1e-5
        step = size * np.eye(layout.size)[place]
        up, down = (linearise(problem, State(state.coefficients, state.theta + s * step)) for s in (1, -1))
        scale = np.sqrt(blocks.normal.corner[place, place])
        assert blocks.slope[state.coefficients.size + place] == pytest.approx(
            (up.cost - down.cost) / (2.0 * size), rel=2e-3, abs=0.05 * scale
        )
    whole = dense_normal(blocks.normal)
    assert whole == pytest.approx(whole.T)
    # the coupling of gravity with the motion, from the deviation itself
    moved = state.coefficients.copy()
    moved[3, 2] += 1e-6
    weight = problem.equation_sd**-2.0
    change = (linearise(problem, State(moved, state.theta)).equation.value - at.equation.value)[:, 2] / 1e-6
    wanted = float((weight * change * at.equation.rows.is_flight).sum())
    assert blocks.normal.coupling[3 * 3 + 2, layout.flight.start + 2] == pytest.approx(wanted, rel=1e-3)


def test_gravity_is_found_and_a_motion_between_mirrors_is_better_known() -> None:
    square = np.zeros(2)
    for seed in range(3):
        made = small_problem((FLOOR_PLANE, WALL_PLANE), reflection=0.05, seed=seed)
        free = converge(made.start, 4, lambda: None)
        equation = converge(flying(free), 4, lambda: None)
        true = positions(made.data.bins.time_s)
        square += [float(((positions_at_bins(one) - true) ** 2).sum(axis=0).mean()) for one in (free, equation)]
        places = equation.problem.layout.flight
        u = np.sqrt(equation.normal.global_variances()[places])
        assert (np.abs(equation.state.theta[places][:3] - GRAVITY) < 3.0 * u[:3]).all()
        assert u[2] < 0.05
        assert equation.problem.equation_sd[equation.at.equation.rows.is_flight].max() < 0.1
    assert square[1] < 0.8 * square[0]
