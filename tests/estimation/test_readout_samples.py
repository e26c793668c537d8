"""The solution at every sample: positions, uncertainties and corrected I and Q against closed forms."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.small_problem import ANTENNAS, FLOOR_PLANE, RELEASE_M, START_S, WAVELENGTH_M, small_problem

from radargui.estimation.forward.mirrors import MirrorPlane
from radargui.estimation.forward.signal_model import FrontEndState
from radargui.estimation.forward.sphere import SphereFactors
from radargui.estimation.motion_estimate import few_fringes_factor
from radargui.estimation.readout import samples
from radargui.estimation.readout.input_response import STEP, _weakened
from radargui.estimation.readout.samples import SAMPLES, at_samples
from radargui.estimation.signals import ScaledSignals
from radargui.estimation.solve.minimise import Solution, local_chi_square, solved_at
from radargui.estimation.solve.problem import Start, State
from radargui.geometry.bistatic import position_uncertainty
from radargui.geometry.path_length import path_lengths

K = 2.0 * np.pi / WAVELENGTH_M
SIGMA, RATE_HZ = 0.01, 2000.0


def solution_of(planes: tuple[MirrorPlane, ...], *, reflection: float = 0.0, delay_s: float = 0.0) -> Solution:
    """Return a solution whose bins are as short as samples: what they show is what a sample shows."""
    made = small_problem(planes, reflection=reflection, delay_s=delay_s, n_bins=900)
    bins = replace(made.problem.bins, node_s=np.zeros(900))
    theta, layout = made.truth.theta.copy(), made.problem.layout
    for n, own in enumerate(layout.receivers):
        theta[own.bias_i.start] = 0.02 * (n + 1)
    return solved_at(Start(replace(made.problem, bins=bins), State(made.truth.coefficients, theta)))


def samples_of(solution: Solution, value: np.ndarray | None = None) -> ScaledSignals:
    """Return samples at the bins' times that show what the model shows, or something else."""
    shown = np.concatenate([one.value for one in solution.at.signals]) if value is None else value
    time = solution.problem.bins.time_s
    n_receivers = solution.problem.n_receivers
    return ScaledSignals(
        time_s=time,
        value=shown,
        valid=np.ones((n_receivers, time.size), bool),
        usable=np.ones(time.size, bool),
        unusable_share=np.zeros(n_receivers),
        sigma=np.full(2 * n_receivers, SIGMA),
        scale_v=np.ones(n_receivers),
        delay_s=solution.problem.delay_s,
        mixers=(None,) * n_receivers,
        before=None,
        rate_hz=RATE_HZ,
        rest_end_s=START_S,
        onset_s=START_S,
    )


@pytest.mark.parametrize("planes", [(), (FLOOR_PLANE,)], ids=["alone", "over a floor"])
def test_samples_that_show_what_the_model_shows_lie_on_the_circle_of_the_direct_path(
    planes: tuple[MirrorPlane, ...],
) -> None:
    # delays of channels turn a fall of 2 m/s by up to a tenth of a radian
    solution = solution_of(planes, reflection=0.1, delay_s=5e-5)
    found = at_samples(solution, samples_of(solution))
    wanted = np.exp(1j * K * found.change_m)
    assert np.abs(found.i + 1j * found.q - wanted).max() < 0.01
    place = solution.at.spline.offset(solution.problem.bins.time_s, solution.state.coefficients).T + RELEASE_M[:, None]
    assert found.position_m == pytest.approx(place, abs=1e-12)
    from_rest = path_lengths(place, ANTENNAS) - path_lengths(RELEASE_M[:, None], ANTENNAS)
    assert found.change_m == pytest.approx(from_rest, abs=1e-12)


def test_what_a_sample_adds_to_the_model_is_turned_back_through_the_front_end() -> None:
    solution = solution_of(())
    added = 0.1 * np.exp(1j * np.linspace(0.0, 5.0, 900))
    value = []
    for own, signal in zip(solution.problem.layout.receivers, solution.at.signals, strict=True):
        amplitude = np.abs(signal.direct) * np.exp(1j * solution.state.theta[own.phase])
        front_end = FrontEndState.of(solution.state.theta, own)
        value.append(signal.value + front_end.channels(np.stack([added * amplitude] * 2)))
    found = at_samples(solution, samples_of(solution, np.concatenate(value)))
    assert found.i + 1j * found.q == pytest.approx(np.exp(1j * K * found.change_m) + added, abs=1e-6)


def test_uncertainties_grow_with_misfit_with_few_fringes_and_while_a_release_may_be_slow(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    solution, asked = solution_of(()), []
    problem = replace(solution.problem, noise_scale=np.array([1.0, 2.0, 3.0]))
    solution = replace(solution, problem=problem)

    def known(one: Solution, alternatives: object, excess: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        asked.append(excess)
        return np.full((3, 900), 1e-5), np.full((3, 900), 2e-5)

    monkeypatch.setattr(samples, "_with_alternatives", known)
    found = at_samples(solution, samples_of(solution))
    # the misfit beyond what the noise scale says already, and never less than none
    misfit = local_chi_square(problem, solution.at)
    assert found.misfit == pytest.approx(misfit)
    assert asked[0] == pytest.approx(np.sqrt(np.maximum(misfit / np.array([[1.0], [4.0], [9.0]]), 1.0)))
    wide, late = few_fringes_factor(K * found.change_m), solution.problem.bins.time_s > START_S + 0.031
    assert np.ptp(wide) > 0.001
    assert found.u_position_m[:, late] == pytest.approx(1e-5 * wide.max(), rel=1e-3)
    assert found.u_change_m[:, late] == pytest.approx(2e-5 * np.tile(wide[:, None], late.sum()), rel=1e-3)
    # the noise of a mean over 5 ms of a wave of unit amplitude, in metres
    unseen = (
        SIGMA / np.sqrt(0.005 * RATE_HZ) / np.median([np.median(np.abs(s.direct)) for s in solution.at.signals]) / K
    )
    early = solution.problem.bins.time_s < START_S + 0.029
    wanted = np.hypot(2e-5 * wide[:, None], unseen + SAMPLES.smallest_u_m)
    assert found.u_change_m[:, early] == pytest.approx(np.tile(wanted, early.sum()), rel=1e-3)
    assert unseen > 1e-5


@pytest.mark.parametrize("flies", [False, True])
def test_what_reflectors_hide_counts_where_no_flight_holds_the_motion(
    monkeypatch: pytest.MonkeyPatch, flies: bool
) -> None:
    solution = solution_of(())
    in_flight = np.zeros_like(solution.problem.in_flight)
    in_flight[-1] = flies
    solution = replace(solution, problem=replace(solution.problem, in_flight=in_flight))
    known = np.full((3, 900), 4e-5), np.full((3, 900), 2e-5)
    monkeypatch.setattr(samples, "_with_alternatives", lambda *given: known)
    monkeypatch.setattr(samples, "hidden_m", lambda one, place: np.full((3, 900), 3e-5))
    found, late = at_samples(solution, samples_of(solution)), solution.problem.bins.time_s > START_S + 0.031
    wide, hidden = few_fringes_factor(K * found.change_m)[:, None], 0.0 if flies else 3e-5
    assert found.u_change_m[:, late] == pytest.approx(np.tile(np.hypot(2e-5 * wide, hidden), late.sum()), rel=1e-4)
    place = position_uncertainty(found.position_m, np.full((3, 900), hidden + 1e-30), ANTENNAS)
    assert found.u_position_m[:, late] == pytest.approx(np.hypot(4e-5 * wide.max(), place)[:, late], rel=1e-3)


def test_a_hundredth_of_a_sphere_turns_and_weakens_by_a_hundredth() -> None:
    whole = SphereFactors(np.array([0.8 * np.exp(0.3j)]), np.array([1.2 * np.exp(-0.4j)]))
    little = _weakened(whole)
    assert little.direct == pytest.approx(np.array([0.8**STEP * np.exp(0.3j * STEP)]))
    assert little.mirrored == pytest.approx(1.0 + STEP * (whole.mirrored - 1.0))
