"""The initial problem, and a solution's problem with other breaks, mirrors or maps."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.small_problem import (
    BOUNCE_S,
    FLOOR_PLANE,
    START_S,
    WALL_PLANE,
    positions,
    small_problem,
)

from radargui.estimation.forward.equation_of_motion import EquationRows
from radargui.estimation.forward.motion_spline import make_spline
from radargui.estimation.solve.changed_problem import (
    problem_with_flights,
    problem_with_mirrors,
)
from radargui.estimation.solve.initial_problem import (
    INITIAL,
    first_motion,
    release_times,
)
from radargui.estimation.solve.minimise import minimise, solved_at
from radargui.estimation.solve.priors import flight_prior
from radargui.estimation.solve.problem import Start, State, linearise
from radargui.model.gravity import NOMINAL_GRAVITY_M_S2


def shown(start: Start) -> np.ndarray:
    return np.concatenate([signal.value for signal in linearise(start.problem, start.state).signals])


def test_the_first_motion_is_the_dense_minimum_of_places_and_jerk_each_by_its_deviation() -> None:
    made = small_problem(n_bins=60)
    time, count = made.data.bins.time_s, np.arange(1, 61)
    data = replace(made.data, bins=replace(made.data.bins, count=count))
    # places that no smooth motion makes: weights and jerk decide
    place = positions(time) + 1e-4 * np.random.default_rng(3).standard_normal((3, 60))
    motion = first_motion(data, place, START_S, np.array([BOUNCE_S]))
    moving = ~data.rest
    design, jerk = motion.spline.design(time[moving]).toarray(), motion.spline.jerk()[0].matrix.toarray()
    # long bins know their place better; a jerk three times as large as before its deviation is re-estimated
    weight = count[moving] / count[moving].mean() / INITIAL.u_place_m**2
    rows = np.vstack([np.sqrt(weight)[:, None] * design, jerk / (3.0 * INITIAL.jerk_m_s3)])
    offset = (place[:, moving] - data.release_m[:, None]).T
    wanted = np.linalg.lstsq(rows, np.vstack([np.sqrt(weight)[:, None] * offset, np.zeros((len(jerk), 3))]), rcond=None)
    assert motion.coefficients == pytest.approx(wanted[0], abs=1e-8)


def test_one_more_mirror_starts_the_bias_again_and_changes_nothing_else() -> None:
    made = small_problem((FLOOR_PLANE,), reflection=0.1)
    solution = minimise(made.start, 2)
    more = problem_with_mirrors(solution, (FLOOR_PLANE, WALL_PLANE))
    unbiased = solution.state.theta.copy()
    for own in solution.problem.layout.receivers:
        assert unbiased[own.bias_i].any()
        unbiased[own.bias_i] = unbiased[own.bias_q] = 0.0
    expected = Start(solution.problem, State(solution.state.coefficients, unbiased))
    assert shown(more) == pytest.approx(shown(expected), abs=1e-12)
    same = problem_with_mirrors(solution, (FLOOR_PLANE,))
    assert shown(same) == pytest.approx(shown(Start(solution.problem, solution.state)), abs=1e-12)
    assert more.problem.layout.sizes.mirrors == 2
    fewer = problem_with_mirrors(solution, ())
    assert np.abs(shown(fewer) - shown(more)).max() > 0.05


def test_what_flies_gets_gravity_and_keeps_everything_else() -> None:
    made = small_problem((FLOOR_PLANE,), reflection=0.1)
    settled = minimise(made.start, 2)
    equation_sd = np.linspace(1.0, 50.0, settled.problem.equation_sd.size)
    solution = solved_at(Start(replace(settled.problem, equation_sd=equation_sd), settled.state))
    start = problem_with_flights(solution)
    assert start is not None
    problem, old, new = start.problem, solution.problem.layout, start.problem.layout
    rows = EquationRows.of(problem.spline, problem.in_flight)
    middle = problem.spline.span_middles()
    assert problem.in_flight.tolist() == (middle > START_S + INITIAL.release_s).tolist()
    # what flies bends by so much, what does not jerks as it did
    bends = problem.equation_sd[rows.is_flight]
    assert np.ptp(bends) == 0.0
    assert bends[0] >= 0.1
    assert problem.equation_sd[~rows.is_flight] == pytest.approx(equation_sd[rows.span[~rows.is_flight]])
    mean, sd = flight_prior(None, NOMINAL_GRAVITY_M_S2)
    assert start.state.theta[new.flight].tolist() == mean.tolist() == [0.0, 0.0, NOMINAL_GRAVITY_M_S2, 0.0]
    assert problem.prior.sd[new.flight].tolist() == sd.tolist()
    # breaks stand first, then the four numbers of the flight, then all others as they stood
    before, after = slice(old.breaks.start, old.breaks.stop), slice(old.breaks.stop, None)
    moved = slice(new.flight.stop, None)
    for found, was in (
        (start.state.theta, solution.state.theta),
        (problem.prior.mean, solution.problem.prior.mean),
        (problem.prior.sd, solution.problem.prior.sd),
    ):
        assert found[new.breaks].tolist() == was[before].tolist()
        assert found[moved].tolist() == was[after].tolist()
    shift = new.size - old.size
    assert [one.index.tolist() for one in problem.prior.groups] == [
        (one.index + shift).tolist() for one in solution.problem.prior.groups
    ]
    assert start.state.coefficients is solution.state.coefficients


def test_a_motion_that_gravity_does_not_make_flies_nowhere() -> None:
    solution = minimise(small_problem().start, 1)
    half = State(0.5 * solution.state.coefficients, solution.state.theta)
    assert problem_with_flights(solved_at(Start(solution.problem, half))) is None


def test_the_acceleration_does_not_ring_after_a_release_between_two_knots() -> None:
    time, released_s, onset_s = np.arange(0.3, 0.6, 5e-4), 0.3562, 0.360
    fallen = 0.5 * NOMINAL_GRAVITY_M_S2 * np.clip(time - released_s, 0.0, None) ** 2

    def off_gravity(sharp_s: np.ndarray) -> float:
        spline = make_spline(0.32, 0.6, np.zeros(0), sharp_s)
        coefficients = np.linalg.lstsq(spline.design(time).toarray(), -fallen, rcond=None)[0]
        at = np.arange(onset_s + INITIAL.release_s, 0.55, 1e-3)
        step = 1e-4
        place = [spline.offset(at + shift, coefficients[:, None])[:, 0] for shift in (-step, 0.0, step)]
        return float(np.abs((place[0] - 2.0 * place[1] + place[2]) / step**2 + NOMINAL_GRAVITY_M_S2).max())

    assert off_gravity(release_times(onset_s)) < 0.02
    assert off_gravity(np.zeros(0)) > 0.1


def test_a_mirror_that_is_put_elsewhere_counts_from_there_and_one_that_stays_keeps_its_place() -> None:
    made = small_problem((FLOOR_PLANE, WALL_PLANE), reflection=0.1)
    theta, places = made.truth.theta.copy(), made.problem.layout.planes
    theta[places] = [0.01, 0.02, 0.003, 0.1, -0.01, 0.004]
    solution = solved_at(Start(made.problem, State(made.truth.coefficients, theta)))
    elsewhere = replace(WALL_PLANE, foot_m=np.array([0.16, 0.0, 0.0]))
    moved = problem_with_mirrors(solution, (FLOOR_PLANE, elsewhere)).state.theta[places]
    assert moved == pytest.approx([0.01, 0.02, 0.003, 0.0, 0.0, 0.0])
    stays = problem_with_mirrors(solution, (FLOOR_PLANE, WALL_PLANE)).state.theta[places]
    assert stays == pytest.approx(theta[places])
