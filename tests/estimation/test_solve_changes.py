"""The initial problem, and a solution's problem with other breaks, mirrors or maps."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.small_problem import (
    BOUNCE_S,
    CONSTANTS,
    FLOOR_PLANE,
    START_S,
    WALL_PLANE,
    positions,
    small_problem,
)

from radargui.estimation.forward.equation_of_motion import EquationRows
from radargui.estimation.forward.motion_spline import SplineMotion, make_spline
from radargui.estimation.forward.parameters import Sizes, lobe_places, make_layout
from radargui.estimation.forward.position_map import make_basis
from radargui.estimation.select.breaks import respline
from radargui.estimation.solve.changed_problem import (
    carried_places,
    positions_at_bins,
    problem_with_breaks,
    problem_with_flights,
    problem_with_mirrors,
)
from radargui.estimation.solve.initial_problem import (
    INITIAL,
    first_motion,
    initial_problem,
    release_times,
    usable_bins,
)
from radargui.estimation.solve.minimise import minimise, solved_at
from radargui.estimation.solve.priors import flight_prior
from radargui.estimation.solve.problem import Start, State, linearise
from radargui.model.gravity import NOMINAL_GRAVITY_M_S2


def shown(start: Start) -> np.ndarray:
    return np.concatenate([signal.value for signal in linearise(start.problem, start.state).signals])


def test_the_first_motion_follows_the_places_and_rests_before_it_starts() -> None:
    made = small_problem()
    time = made.data.bins.time_s
    motion = first_motion(made.data, positions(time), START_S, np.array([BOUNCE_S]))
    away = motion.spline.offset(time, motion.coefficients).T + made.data.release_m[:, None] - positions(time)
    assert np.abs(away).max() < 2e-4
    assert np.abs(away[:, time < START_S]).max() == 0.0


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


def test_the_initial_problem_starts_with_the_constants_found_and_nothing_else() -> None:
    made = small_problem((FLOOR_PLANE,))
    motion = SplineMotion(made.problem.spline, made.truth.coefficients)
    start = initial_problem(made.data, motion, CONSTANTS, (FLOOR_PLANE,), 0.09)
    theta, layout = start.state.theta, start.problem.layout
    assert theta[layout.breaks] == pytest.approx([BOUNCE_S])
    for own, constants in zip(layout.receivers, CONSTANTS, strict=True):
        assert theta[own.constants].tolist() == constants.in_order().tolist()
    lobes = lobe_places(layout)
    assert theta[lobes].tolist() == start.problem.prior.mean[lobes].tolist()
    others = np.r_[layout.shared, *(slice(own.constants.stop, own.last) for own in layout.receivers)]
    assert not theta[np.setdiff1d(others, lobes)].any()
    assert start.problem.inputs.wavenumber == pytest.approx(2.0 * np.pi / 0.03)


def test_bins_that_hold_a_break_do_not_count() -> None:
    made = small_problem()
    bins = made.data.bins
    use = usable_bins(bins, np.array([0.1001, 0.2503]))
    assert (~use).sum() == 2
    for moment in (0.1001, 0.2503):
        assert not use[(bins.first_s < moment) & (bins.last_s > moment)].any()


def test_every_parameter_that_both_layouts_have_is_carried_to_its_own_place() -> None:
    old = make_layout(Sizes(breaks=1, mirrors=1, receivers=3, bias=4, amplitude_map=3, drift=2))
    new = make_layout(replace(old.sizes, mirrors=2))
    source, target = carried_places(old, new)
    assert sorted(source.tolist()) == list(range(old.size))
    assert len(set(target.tolist())) == target.size
    theta = np.zeros(new.size)
    theta[target] = np.arange(old.size)[source]
    for was, now in zip(old.receivers, new.receivers, strict=True):
        for name in ("bias_i", "bias_q", "amplitude_map", "drift_i", "drift_q", "constants"):
            a, b = getattr(was, name), getattr(now, name)
            assert theta[b].tolist() == list(range(a.start, a.stop))
        assert theta[now.receiver_reflection][:2].tolist() == [
            was.receiver_reflection.start,
            was.receiver_reflection.start + 1,
        ]
        assert not theta[now.double_reflection][2:].any()


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


def test_other_bias_maps_start_at_zero_at_the_present_places() -> None:
    solution = minimise(small_problem().away(0.5), 2)
    basis = make_basis(positions_at_bins(solution), 0.2)
    start = problem_with_mirrors(solution, (), basis)
    assert start.problem.bias_basis is basis
    assert start.problem.inputs.bias == pytest.approx(basis(positions_at_bins(solution)))
    for own in start.problem.layout.receivers:
        assert not start.state.theta[own.bias_i].any()


def test_other_breaks_keep_every_other_parameter_and_its_prior() -> None:
    made = small_problem((FLOOR_PLANE,), reflection=0.1)
    solution = minimise(made.start, 2)
    motion = respline(solution.at.spline, solution.state.coefficients, np.array([0.15, BOUNCE_S, 0.35]), np.zeros(0))
    start = problem_with_breaks(solution, motion)
    assert start.state.theta[:3].tolist() == [0.15, BOUNCE_S, 0.35]
    assert start.state.theta[3:] == pytest.approx(solution.state.theta[1:])
    assert start.problem.prior.sd[3:] == pytest.approx(solution.problem.prior.sd[1:])
    before, after = (problem.prior.groups for problem in (solution.problem, start.problem))
    assert all((b.index - a.index == 2).all() for a, b in zip(before, after, strict=True))
    near = np.abs(made.data.bins.time_s - BOUNCE_S) > 0.01
    difference = shown(start) - shown(Start(solution.problem, solution.state))
    assert np.abs(difference[:, near]).max() < 0.02


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


def test_a_floor_put_before_a_wall_starts_at_nothing_and_the_wall_keeps_all_that_it_has() -> None:
    made = small_problem((WALL_PLANE,), reflection=0.1)
    theta, places = made.truth.theta.copy(), made.problem.layout.planes
    theta[places] = [0.1, -0.01, 0.004]
    theta[lobe_places(made.problem.layout)] += 0.01 * np.arange(24)
    solution = solved_at(Start(made.problem, State(made.truth.coefficients, theta)))
    start = problem_with_mirrors(solution, (FLOOR_PLANE, WALL_PLANE))
    # its lobes are those of the direct wave
    lobes = lobe_places(start.problem.layout)
    assert start.state.theta[lobes].tolist() == theta[lobe_places(made.problem.layout)].tolist()
    assert shown(start) == pytest.approx(shown(Start(solution.problem, solution.state)), abs=1e-12)
    assert start.state.theta[start.problem.layout.planes].tolist() == [0.0, 0.0, 0.0, 0.1, -0.01, 0.004]
