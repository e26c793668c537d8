"""What the joint estimate makes of a chosen model: its uncertainties, its constants, what it says of each receiver."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.small_problem import START_S, small_problem

from radargui.estimation.joint import JointEstimate, estimate_of_model
from radargui.estimation.posterior.samples import AtSamples
from radargui.estimation.select.chosen_model import Alternative, ChosenModel
from radargui.estimation.signals import ScaledSignals
from radargui.estimation.solve.minimise import Solution, minimise
from radargui.estimation.solve.problem import State
from radargui.model.setup import read_setup
from radargui.system.resources import default_setup_path

TIME_S = np.linspace(0.0, 0.449, 400)


@pytest.fixture(scope="module")
def solution() -> Solution:
    return minimise(small_problem(n_bins=120).start, 2)


def signals() -> ScaledSignals:
    return ScaledSignals(
        time_s=TIME_S,
        value=np.zeros((6, 400)),
        valid=np.ones((3, 400), bool),
        usable=np.arange(400) != 7,
        unusable_share=np.zeros(3),
        sigma=np.full(6, 0.01),
        scale_v=np.ones(3),
        delay_s=np.zeros(6),
        mixers=(None,) * 3,
        before=None,
        rate_hz=1000.0,
        rest_end_s=START_S,
        onset_s=START_S,
    )


def values(misfit: np.ndarray) -> AtSamples:
    ones = np.ones((3, 400))
    phase = np.linspace(0.0, 60.0, 400)
    return AtSamples(0.1 * ones, 3e-5 * ones, 1e-3 * phase * ones, 4e-5 * ones, np.cos(phase) * ones,
                     np.sin(phase) * ones, misfit)  # fmt: skip


def estimated(
    solution: Solution, alternatives: tuple[Alternative, ...] = (), misfit: np.ndarray | None = None
) -> JointEstimate:
    setup = read_setup(default_setup_path())
    chosen = ChosenModel(solution, alternatives, ("said",))
    return estimate_of_model(setup, signals(), chosen, values(np.ones((3, 400)) if misfit is None else misfit))


def test_samples_that_the_model_does_not_fit_or_that_cannot_be_used_are_not_valid(solution: Solution) -> None:
    misfit = np.ones((3, 400))
    misfit[1, 20], misfit[1, 21] = 8.9, 9.1
    valid = estimated(solution, misfit=misfit).valid
    assert not valid[:, 7].any()
    assert not valid[1, 21]
    assert (~valid).sum() == 4


def test_constants_are_those_of_theta_and_half_as_uncertain_again(solution: Solution) -> None:
    u = np.sqrt(solution.normal.global_variances())
    theta = solution.state.theta
    for one, own in zip(estimated(solution).constants, solution.problem.layout.receivers, strict=True):
        assert one.gain_ratio == pytest.approx(np.exp(theta[own.log_gain]))
        assert one.u_gain_ratio == pytest.approx(1.5 * np.exp(theta[own.log_gain]) * u[own.log_gain])
        assert one.quadrature_error_deg == pytest.approx(np.degrees(theta[own.quadrature_error]))
        assert one.u_quadrature_error_deg == pytest.approx(np.degrees(1.5 * u[own.quadrature_error]))


def test_what_was_moved_along_the_best_shares_its_posterior_and_another_model_has_its_own(solution: Solution) -> None:
    moved = replace(solution, state=State(solution.state.coefficients + 1e-6, solution.state.theta))
    other = minimise(small_problem(n_bins=120, seed=2).start, 1)
    estimate = estimated(solution, (Alternative(moved, 0.3), Alternative(other, 0.2)))
    assert [one.weight for one in estimate.alternatives] == [0.3, 0.2]
    assert estimate.alternatives[0].posterior.like is estimate.posterior
    assert estimate.alternatives[1].posterior.like is None
    assert estimate.choices == ("said",)
    wider = estimate.widened(2.0)
    assert wider.u_change_m == pytest.approx(2.0 * estimate.u_change_m)
    assert wider.u_position_m == pytest.approx(2.0 * estimate.u_position_m)
