"""The solution at every sample: positions, uncertainties and corrected I and Q against closed forms."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.small_problem import ANTENNAS, FLOOR_PLANE, RELEASE_M, START_S, WAVELENGTH_M, small_problem

from radargui.estimation.forward.signal_model import FrontEndState
from radargui.estimation.posterior.samples import at_samples
from radargui.estimation.signals import ScaledSignals
from radargui.estimation.solve.minimise import Solution, solved_at
from radargui.estimation.solve.problem import Start, State
from radargui.physics.mirrors import MirrorPlane
from radargui.physics.path_length import path_lengths

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
