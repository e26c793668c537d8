"""Antennas, release and wavelength as unknowns: their slopes, and what a drop says of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.small_problem import FLOOR_PLANE, WALL_PLANE, SmallProblem, small_problem

from radargui.estimation.forward.parameters import lobe_places
from radargui.estimation.forward.signal_model import EVERY, nodes_of
from radargui.estimation.forward.signal_slopes import receiver_slopes
from radargui.estimation.solve.changed_problem import problem_with_flights
from radargui.estimation.solve.held_setup import setup_posterior, with_setup_held
from radargui.estimation.solve.minimise import Solution, minimise, solved_at
from radargui.estimation.solve.problem import JointProblem, Start, State, linearise
from radargui.model.assumed import UncertainInput
from radargui.model.gravity import NOMINAL_GRAVITY_M_S2, U_ANYWHERE_M_S2, UNKNOWN_DRAG
from radargui.model.setup import read_setup
from radargui.physics.setup_unknowns import SetupUnknowns
from radargui.system.resources import default_setup_path

N = 7


def unknowns() -> SetupUnknowns:
    rng = np.random.default_rng(3)
    inputs = tuple(UncertainInput(f"receiver[1].tilt_deg{n}", "", 1.0, False) for n in range(N))
    return SetupUnknowns(
        inputs,
        np.ones(N),
        1e-3 * rng.standard_normal((4, 3, N)),
        1e-3 * rng.standard_normal((3, N)),
        1e-3 * rng.standard_normal(N),
        NOMINAL_GRAVITY_M_S2,
        U_ANYWHERE_M_S2,
        UNKNOWN_DRAG,
    )


def flying(made: SmallProblem) -> Start:
    problem: JointProblem = made.problem  # type: ignore[assignment]
    problem = replace(problem, inputs=replace(problem.inputs, setup=unknowns()))
    start = problem_with_flights(solved_at(Start(problem, made.truth)))  # type: ignore[arg-type]
    assert start is not None
    return start


def test_the_slopes_by_the_setup_are_those_of_the_model() -> None:
    start = flying(small_problem((FLOOR_PLANE, WALL_PLANE), reflection=0.2))
    layout, theta = start.problem.layout, start.state.theta.copy()
    # what lobes change by is left out of the slopes
    theta[lobe_places(layout)] = 0.0
    theta[layout.setup] = 0.3 * np.random.default_rng(4).standard_normal(N)
    problem = start.problem.placed(theta)
    at = linearise(problem, State(start.state.coefficients, theta))
    excess = at.excess.reshape(3, 2, -1)
    slopes = receiver_slopes(nodes_of(at.node_m), theta, layout, problem.inputs, EVERY, excess, at.waves)
    columns = slopes.by_shared[..., layout.setup.start - layout.shared.start :]

    def shown(number: int, step: float) -> np.ndarray:
        moved = theta.copy()
        moved[layout.setup.start + number] += step
        signals = linearise(problem, State(start.state.coefficients, moved)).signals
        return np.stack([one.value for one in signals])

    for number in range(N):
        difference = (shown(number, 1e-3) - shown(number, -1e-3)) / 2e-3
        assert np.abs(difference).max() > 1e-3
        np.testing.assert_allclose(columns[..., number], difference, atol=1e-5)


def solved(made: SmallProblem) -> Solution:
    return minimise(flying(made), 4)


def test_a_solution_that_holds_the_setup_shows_the_same_signals_and_knows_the_motion_better() -> None:
    solution = solved(small_problem((FLOOR_PLANE,), reflection=0.1))
    found, held = setup_posterior(solution), with_setup_held(solution)
    assert found is not None
    np.testing.assert_allclose(found.mean, solution.state.theta[solution.problem.layout.setup])
    # a recording only adds to what was known
    variances = np.linalg.eigvalsh(found.covariance)
    assert variances.min() > 0.0
    assert variances.max() < 1.0 + 1e-9
    assert held.problem.layout.sizes.setup == 0
    for one, other in zip(held.at.signals, solution.at.signals, strict=True):
        np.testing.assert_allclose(one.value, other.value, atol=1e-12)
    np.testing.assert_allclose(held.problem.inputs.release_m, solution.problem.inputs.release_m)
    assert setup_posterior(held) is None
    assert with_setup_held(held) is held


def test_every_value_of_antennas_release_and_wave_is_an_unknown_and_what_is_exact_hardly() -> None:
    setup = read_setup(default_setup_path())
    first, *others = setup.receiver
    setup = setup.model_copy(update={"receiver": (first.model_copy(update={"u_tilt_deg": 0.0}), *others)})
    found = SetupUnknowns.of(setup)
    keys = [one.key for one in found.inputs]
    for key in (
        "transmitter.position_m[1]",
        "receiver[3].azimuth_deg",
        "tracer.release_position_m[3]",
        "radar.frequency_hz",
    ):
        assert found.deviation[keys.index(key)] == 1.0
    assert found.deviation[keys.index("receiver[1].tilt_deg")] < 0.01
    # along its direction, by 3 mm; and a turn by half a degree across it
    distance = found.by_antenna[1, :, keys.index("receiver[1].distance_m")]
    assert np.linalg.norm(distance) == pytest.approx(0.003)
    turn = found.by_antenna[2, :, keys.index("receiver[2].tilt_deg")]
    assert np.linalg.norm(turn) == pytest.approx(np.radians(0.5) * others[0].distance_m, rel=1e-3)
    assert found.by_antenna[0, 2] @ found.by_antenna[2, 2] == 0.0
