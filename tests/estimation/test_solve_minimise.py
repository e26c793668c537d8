"""The minimum, its evidence and what steps are refused, on a small problem with known truth."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.normal_matrices import dense_normal
from support.small_problem import (
    BOUNCE_S,
    CONSTANTS,
    FLOOR_PLANE,
    LARGE_SPHERE,
    START_S,
    WALL_PLANE,
    positions,
    small_problem,
)

from radargui.estimation.forward.parameters import lobe_places, polarisation_places
from radargui.estimation.solve.assemble import assemble
from radargui.estimation.solve.changed_problem import problem_with_flights
from radargui.estimation.solve.initial_problem import first_motion, initial_problem
from radargui.estimation.solve.minimise import (
    MinimiseSettings,
    chi_square,
    local_chi_square,
    log_evidence,
    minimise,
    receiver_misfits,
)
from radargui.estimation.solve.priors import PRIORS
from radargui.estimation.solve.problem import Start, linearise


def test_the_truth_is_found_within_its_standard_uncertainties() -> None:
    made = small_problem(delay_s=5e-5)
    start = made.away(1.0)
    assert linearise(start.problem, start.state).cost > 1.5 * linearise(made.problem, made.truth).cost
    solution = minimise(start, 15)
    u = np.sqrt(solution.normal.global_variances())
    away = (solution.state.theta - made.truth.theta) / u
    assert solution.settled
    assert np.abs(away).max() < 4.5
    assert np.sqrt((away**2).mean()) < 1.3
    assert chi_square(solution) == pytest.approx(1.0, abs=0.25)


def test_at_the_minimum_the_slope_is_nothing_against_its_curvature() -> None:
    solution = minimise(small_problem().away(1.0), 20, MinimiseSettings(close=1e-6))
    blocks = assemble(solution.problem, solution.state, solution.at)
    gain = 0.5 * blocks.slope @ solution.normal.solve(blocks.slope)
    assert abs(gain) < 0.1


def test_evidence_is_laplaces_formula_of_the_dense_matrix_and_what_deviations_are_likely() -> None:
    flies = problem_with_flights(minimise(small_problem((FLOOR_PLANE,), n_bins=120).start, 2))
    assert flies is not None
    solution = minimise(flies, 6)
    problem = replace(solution.problem, noise_scale=np.array([1.0, 1.1, 1.3]))
    at = linearise(problem, solution.state)
    blocks = assemble(problem, solution.state, at)
    dense = dense_normal(blocks.normal)
    wanted = (
        -at.cost
        - 0.5 * np.linalg.slogdet(dense)[1]
        - np.log(problem.prior.sd).sum()
        - 3.0 * np.log(problem.equation_sd).sum()
        - 2.0 * problem.use.sum() * np.log(problem.noise_scale).sum()
        - problem.equation_sd[at.equation.rows.is_flight].sum() / PRIORS.off_flight_m_s2
    )
    for own in problem.layout.receivers:
        wanted -= problem.prior.sd[own.bias_i.start] / PRIORS.bias_beside_floor.scale
        wanted -= problem.prior.sd[own.amplitude_map.start] / PRIORS.log_amplitude_map.scale
    assert at.equation.rows.is_flight.any()
    found = log_evidence(replace(solution, problem=problem, at=at, normal=blocks.factor()))
    assert found == pytest.approx(wanted, rel=1e-8)


def test_the_local_misfit_is_one_for_noise_and_counts_the_noise_scale() -> None:
    made = small_problem()
    solution = minimise(made.start, 3)
    assert np.median(local_chi_square(solution.problem, solution.at), axis=1) == pytest.approx(1.0, abs=0.25)
    louder = replace(made.problem, noise_scale=np.full(3, 2.0))
    wider = minimise(replace(made.start, problem=louder), 0)
    assert chi_square(wider) == pytest.approx(chi_square(minimise(made.start, 0)), rel=0.03)


def test_a_lobe_of_a_mirror_that_hardly_reflects_goes_anywhere_and_overflows_nothing() -> None:
    made = small_problem((WALL_PLANE,), reflection=1e-6, n_bins=60)
    theta = made.truth.theta.copy()
    for factor in (-1e5, 1e5):
        # those over the wall
        theta[lobe_places(made.problem.layout).reshape(4, 2, 3)[:, 1]] = factor
        with np.errstate(over="raise", invalid="raise"):
            at = linearise(made.problem, replace(made.truth, theta=theta))
        assert np.abs(at.residual).max() < 100.0


def test_an_angle_turned_by_half_turns_shows_the_same_and_a_step_brings_it_back_to_what_the_setup_says() -> None:
    data = replace(small_problem(sigma=0.003, n_bins=60).data, sphere=LARGE_SPHERE)
    motion = first_motion(data, positions(data.bins.time_s), START_S, np.array([BOUNCE_S]))
    start = initial_problem(data, motion, CONSTANTS, (), 0.09)
    problem, theta = start.problem, start.state.theta.copy()
    angles = polarisation_places(problem.layout)
    theta[angles] += np.pi * np.array([0.0, -3.0, 4.0, 1.0])
    turned = replace(start.state, theta=theta)
    here, there = linearise(problem, start.state), linearise(problem, turned)
    for a, b in zip(here.signals, there.signals, strict=True):
        assert a.value == pytest.approx(b.value, abs=1e-12)
    found = minimise(Start(problem, turned), 1)
    assert np.abs(found.state.theta[angles] - problem.prior.mean[angles]).max() < np.pi / 2.0
    assert found.at.cost < there.cost - 1000.0


def test_misfits_are_squares_over_what_noise_leaves_against_the_white_noise_alone() -> None:
    made = small_problem(sigma=0.003, n_bins=60)
    bins = replace(made.problem.bins, expected=np.full((6, 60), 0.5))
    problem = replace(made.problem, bins=bins, noise_scale=np.array([1.0, 2.0, 3.0]))
    at = linearise(problem, made.truth)
    wanted = at.residual.reshape(3, 2, -1) ** 2 / 0.5
    wanted = wanted.mean(axis=1) * np.array([[1.0], [4.0], [9.0]])
    found = receiver_misfits(problem, at)
    assert found[:, problem.use.all(axis=0)] == pytest.approx(wanted[:, problem.use.all(axis=0)])
    # a receiver's noise does not depend on what its misfit made of it
    assert found.mean(axis=1) == pytest.approx(np.full(3, 2.0), rel=0.4)
