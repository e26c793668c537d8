"""Still ellipses, rough phases, circle fits and what a round of them starts from, against closed forms."""

from __future__ import annotations

from dataclasses import astuple, replace
from types import SimpleNamespace

import numpy as np
import pytest
from support.small_problem import ANTENNAS, CONSTANTS, RELEASE_M, positions, small_problem

from radargui.estimation.adaptive.circle_fit import (
    CircleData,
    CircleFit,
    CircleLayout,
    CircleSettings,
    fit_circle,
)
from radargui.estimation.adaptive.found import AdaptiveRounds, foretold_round, unwound_round
from radargui.estimation.adaptive.rough import RoughPhases
from radargui.estimation.adaptive.rounds import best_round, first_round, next_round, still_round, timed_round
from radargui.estimation.forward.bins import BinnedData
from radargui.physics.path_length import path_lengths
from radargui.signals.ellipse import Ellipse, circle_through

TRUE = Ellipse(0.2, -0.1, 0.9, 1.15, 0.12)


def shown(phase: np.ndarray, ellipse: Ellipse = TRUE) -> tuple[np.ndarray, np.ndarray]:
    i = ellipse.i0_v + ellipse.amplitude_v * np.cos(phase)
    q = ellipse.q0_v + ellipse.gain_ratio * ellipse.amplitude_v * np.sin(phase + ellipse.quadrature_error_rad)
    return i, q


def circle(seed: int = 0, n: int = 400, sigma: float = 0.01, n_bias: int = 3, n_map: int = 2) -> CircleData:
    rng = np.random.default_rng(seed)
    i, q = shown(np.linspace(0.0, 40.0, n))
    noise = sigma * rng.standard_normal((2, n))
    place = np.linspace(-1.0, 1.0, n)
    bias = np.stack([np.sin((k + 1.0) * place) for k in range(n_bias)], axis=1) if n_bias else np.zeros((n, 0))
    level = np.stack([np.cos((k + 1.0) * place) for k in range(n_map)], axis=1) if n_map else np.zeros((n, 0))
    spread = np.full(n, sigma)
    return CircleData(i + noise[0], q + noise[1], spread, spread, np.ones(n), bias, level)


def test_a_short_arc_of_a_circle_gives_it_back() -> None:
    true = replace(TRUE, gain_ratio=1.0, quadrature_error_rad=0.0)
    phase = np.linspace(0.0, 0.5, 60)
    pair = np.stack(shown(phase, true))
    found = circle_through(pair)
    assert astuple(found) == pytest.approx(astuple(true), abs=1e-6)
    x, y = found.apply(pair)
    assert np.unwrap(np.arctan2(y, x)) == pytest.approx(phase, abs=1e-6)


def test_a_point_of_twice_the_weight_counts_as_two() -> None:
    rng = np.random.default_rng(5)
    phase, weight = np.linspace(0.0, 6.0, 100), np.where(np.arange(100) < 40, 2, 1)
    pair = np.stack([0.1 + np.cos(phase), 1.1 * np.sin(phase + 0.1)]) + 0.02 * rng.standard_normal((2, 100))
    found, doubled = circle_through(pair, weight.astype(np.float64)), circle_through(np.repeat(pair, weight, axis=1))
    assert astuple(found) == pytest.approx(astuple(doubled), abs=1e-9)
    # or the test would say nothing: the first third pulls
    assert astuple(found) != pytest.approx(astuple(circle_through(pair)), abs=1e-4)


def test_a_fit_finds_the_constants_within_their_uncertainty_and_switches_needless_maps_off() -> None:
    data = circle(3)
    start = np.concatenate([CircleFit.still(replace(TRUE, i0_v=0.25, amplitude_v=0.8)).theta, np.zeros(8)])
    prior_mean = start[CircleLayout.constants].copy()
    prior_mean[CircleLayout.front_end] = 0.0
    fit = fit_circle(data, start, prior_mean)
    assert fit.chi_square == pytest.approx(1.0, abs=0.15)
    u = np.sqrt(np.diag(fit.covariance))[CircleLayout.front_end]
    true = np.array([np.log(TRUE.gain_ratio), TRUE.quadrature_error_rad])
    assert np.abs(fit.theta[CircleLayout.front_end] - true).max() < 4.0 * u.max()
    assert np.abs(fit.theta[fit.layout.bias]).max() < 0.02
    fixed = fit_circle(data, start, prior_mean, updates=0)
    assert fit.log_evidence != fixed.log_evidence


def test_a_fit_ends_in_its_minimum_where_functions_hardly_differ() -> None:
    data = circle(5, n_bias=20, n_map=12)
    slow_i, slow_q = 0.05 * np.random.default_rng(5).standard_normal((2, 20)) @ data.bias.T
    data = replace(data, i=data.i + slow_i, q=data.q + slow_q)
    start = np.zeros(data.layout.size)
    start[CircleLayout.constants] = CircleFit.still(replace(TRUE, i0_v=0.25, amplitude_v=0.8)).theta
    ended, thorough = (
        fit_circle(data, start, start[CircleLayout.constants], updates=0, settings=settings)
        for settings in (CircleSettings(), CircleSettings(close=1e-7, steps=200))
    )
    off = ended.point(data.i, data.q, data.bias) - thorough.point(data.i, data.q, data.bias)
    # a thousandth of what the noise leaves open: a fit that stays damped creeps, and ends before
    assert np.sqrt(np.mean(off**2)) < 1e-3 * np.sqrt(thorough.phase_variance(data).mean() - 0.01**2)
    assert ended.log_evidence == pytest.approx(thorough.log_evidence, abs=2e-4)


def test_the_variance_of_a_phase_is_that_of_repeated_noise() -> None:
    fits = [circle(seed, n_bias=0, n_map=0) for seed in range(60)]
    phases, variance = [], None
    for data in fits:
        start = CircleFit.still(TRUE).theta
        fit = fit_circle(data, start, start)
        x, y = fit.point(data.i, data.q, data.bias)
        phases.append(np.unwrap(np.arctan2(y, x)))
        variance = fit.phase_variance(data)
    assert variance is not None
    assert (np.var(phases, axis=0) / variance).mean() == pytest.approx(1.0, abs=0.15)


ROUGH = tuple(
    Ellipse(c.offset_i + 0.03, c.offset_q - 0.02, np.exp(c.log_amplitude), np.exp(c.log_gain), c.quadrature_error_rad)
    for c in CONSTANTS
)


def seen() -> tuple[BinnedData, np.ndarray, np.ndarray]:
    """Return bins, true places and true phases of a small problem."""
    binned = small_problem(sigma=0.005, lobe=0.0).data
    true = positions(binned.bins.time_s)
    change = path_lengths(true, ANTENNAS) - path_lengths(RELEASE_M[:, None], ANTENNAS)
    return binned, true, 2.0 * np.pi * change / binned.wavelength_m


def test_a_receiver_that_hardly_winds_may_not_wind_at_all() -> None:
    binned, _, phase = seen()
    one = next_round(binned, first_round(binned, still_round(binned, ROUGH, phase)), 0.15)
    assert unwound_round(binned, one) is None
    # on a level circle: what came over the floor was counted
    winding = replace(one, phase_rad=np.array([phase[0], np.linspace(0.0, 9.0, phase.shape[1]), phase[2]]))
    found = unwound_round(binned, winding)
    assert found is not None
    assert found.phase_rad[1].tolist() == [0.0] * phase.shape[1]
    assert found.phase_rad[[0, 2]] == pytest.approx(phase[[0, 2]])
    change = path_lengths(found.place, ANTENNAS) - path_lengths(RELEASE_M[:, None], ANTENNAS)
    assert np.abs(change[1][~binned.rest]).max() < 1e-6
    # the circle was that of what winds; a wave at rest and an offset look alike, and the echo is the larger
    constants = found.receiver_constants()[1]
    assert (constants.offset_i, constants.offset_q) == (0.0, 0.0)
    shows = binned.bins.value[2:4].mean(axis=1)
    assert np.exp(constants.log_amplitude + 1j * constants.phase_rad) == pytest.approx(shows[0] + 1j * shows[1])


def test_less_than_a_turn_does_not_tell_its_circle_and_the_still_ellipse_is_tried_too() -> None:
    binned, _, phase = seen()
    rough = RoughPhases(binned.bins.time_s, phase, np.zeros(phase.shape[1]), ROUGH, {})
    right = next_round(binned, first_round(binned, still_round(binned, ROUGH, phase)), 0.15)
    few, last = np.array([[1.0], [5.0 / np.ptp(phase[1])], [1.0]]), np.zeros(0)
    wide = AdaptiveRounds(SimpleNamespace(), binned, rough, replace(right, phase_rad=few * phase), last, last)
    normal = np.array([0.0, 0.0, 1.0])
    still = still_round(binned, ROUGH, phase).receiver_constants()
    assert wide.other_counts(normal)[-1].last.receiver_constants() == still
    for other in (replace(wide, last=right), replace(wide, impact_s=np.array([0.5]))):
        assert all(one.last.receiver_constants() != still for one in other.other_counts(normal))


def test_a_receiver_that_lost_fringes_is_foretold_by_the_others() -> None:
    binned, _, phase = seen()
    still = still_round(binned, ROUGH, phase)
    lost = phase.copy()
    lost[1] = np.clip(phase[1], -4.0, 4.0)
    one = replace(next_round(binned, first_round(binned, still), 0.15), phase_rad=lost)
    found = foretold_round(binned, one, np.array([0.0, 0.0, 1.0]))
    assert np.abs(lost - phase).max() > 4.0 * np.pi
    # it drifts by 20 mm, of which two receivers see one part
    assert np.abs(found.phase_rad - phase).max() < np.pi
    assert found.phase_rad[[0, 2]] == pytest.approx(lost[[0, 2]])
    constants = found.receiver_constants()[1]
    assert constants.offset_i == pytest.approx(CONSTANTS[1].offset_i, abs=0.2)
    assert np.angle(np.exp(1j * (constants.phase_rad - CONSTANTS[1].phase_rad))) == pytest.approx(0.0, abs=1.0)


def test_rounds_find_phases_and_places_from_rough_ellipses() -> None:
    binned, true, phase = seen()
    still = still_round(binned, ROUGH, phase)
    assert still.prior_mean[:, CircleLayout.front_end].tolist() == [[0.0, 0.0]] * 3
    first = first_round(binned, still)
    mapped = next_round(binned, first, 0.15)
    for one, most in (
        (first, 0.1),
        (timed_round(binned, still), 0.2),
        (mapped, 0.1),
        (best_round(binned, mapped), 0.1),
    ):
        assert np.abs(one.phase_rad - phase).max() < most
    assert np.abs(mapped.place - true).max() < 5e-4
    for found, constants in zip(first.receiver_constants(), CONSTANTS, strict=True):
        assert found.log_gain == pytest.approx(constants.log_gain, abs=0.01)
        assert found.quadrature_error_rad == pytest.approx(constants.quadrature_error_rad, abs=0.01)
        assert found.offset_i == pytest.approx(constants.offset_i, abs=0.01)
