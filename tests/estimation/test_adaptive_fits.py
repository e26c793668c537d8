"""Circle fits and rough arcs in closed form: covariance, evidence, what noise does to a radius, completed arcs."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from support.small_problem import ANTENNAS, RELEASE_M

from radargui.estimation.adaptive.circle_data import map_places
from radargui.estimation.adaptive.circle_fit import CircleData, CircleFit, _evaluate, fit_circle
from radargui.estimation.adaptive.circle_layout import CircleLayout, CircleSettings
from radargui.estimation.adaptive.rough import _arcs_completed, _drop_outliers
from radargui.estimation.adaptive.still_ellipse import StillEllipse, fit_still_ellipse
from radargui.geometry.path_length import Antennas

TRUE = StillEllipse(0.2, -0.1, np.log(1.15), 0.12, 0.9)
TIGHT = CircleSettings(close=1e-9, worth=1e-3, steps=100)


def circle(n: int = 400, sigma: float = 0.01, n_bias: int = 3, n_map: int = 2, seed: int = 0) -> CircleData:
    phase, rng, place = np.linspace(0.0, 40.0, n), np.random.default_rng(seed), np.linspace(-1.0, 1.0, n)
    i = TRUE.offset_i + TRUE.amplitude * np.cos(phase)
    q = TRUE.offset_q + TRUE.gain_ratio * TRUE.amplitude * np.sin(phase + TRUE.quadrature_error_rad)
    noise, spread = sigma * rng.standard_normal((2, n)), np.full(n, sigma)
    bias = np.sin(np.outer(place, np.arange(1.0, n_bias + 1.0)))
    level = np.cos(np.outer(place, np.arange(1.0, n_map + 1.0)))
    return CircleData(i + noise[0], q + noise[1], spread, spread, np.ones(n), bias, level)


def fitted(data: CircleData, **given: Any) -> tuple[CircleFit, np.ndarray]:
    start = np.zeros(data.layout.size)
    start[CircleLayout.constants] = CircleFit.still(TRUE).theta
    mean = start[CircleLayout.constants] + 0.02
    return fit_circle(data, start, mean, updates=0, settings=TIGHT, **given), mean


def test_covariance_and_evidence_are_laplaces_of_the_dense_normal_matrix() -> None:
    data = circle()
    fit, mean = fitted(data)
    prior_mean, precision = np.zeros(data.layout.size), fit.deviation**-2.0
    prior_mean[CircleLayout.constants] = mean
    at = _evaluate(fit.theta, data, TIGHT)
    normal, slope = at.with_priors(prior_mean, precision)
    assert np.abs(np.linalg.solve(normal, slope) / np.sqrt(np.diag(fit.covariance))).max() < 1e-3
    scale = np.sqrt(np.outer(np.diag(fit.covariance), np.diag(fit.covariance)))
    assert np.abs((fit.covariance - np.linalg.inv(normal)) / scale).max() < 1e-3
    cost = at.loss + 0.5 * precision @ (fit.theta - prior_mean) ** 2
    wanted = -cost - 0.5 * np.linalg.slogdet(normal)[1] + 0.5 * np.log(precision).sum()
    assert fit.log_evidence == pytest.approx(wanted, abs=1e-3)
    assert fit.chi_square == pytest.approx((at.weight * at.residual**2).mean(), rel=1e-4)


def test_the_slope_of_a_prior_leads_to_its_mean() -> None:
    data = circle()
    theta, mean = np.zeros(data.layout.size), np.full(data.layout.size, 0.3)
    theta[CircleLayout.constants] = CircleFit.still(TRUE).theta
    at, precision = _evaluate(theta, data, TIGHT), np.linspace(1.0, 5.0, theta.size)
    _, with_it = at.with_priors(mean, precision)
    _, without = at.with_priors(theta, precision)
    assert with_it - without == pytest.approx(precision * (theta - mean))
    assert at.cost(mean, precision) - at.loss == pytest.approx(0.5 * (precision * (theta - mean) ** 2).sum())


def test_the_variance_of_a_phase_holds_what_every_unknown_leaves_open() -> None:
    data = circle(n=60)
    rng, size = np.random.default_rng(3), data.layout.size
    theta = np.zeros(size)
    theta[CircleLayout.constants] = CircleFit.still(TRUE).theta
    root = 1e-3 * rng.standard_normal((size, size))
    fit = CircleFit(data.layout, theta, root @ root.T, 0.0, 1.0, np.ones(size))

    def phase(shift: np.ndarray) -> np.ndarray:
        x, y = replace(fit, theta=theta + shift).point(data.i, data.q, data.bias)
        return np.arctan2(y, x)

    steps = 1e-6 * np.eye(size)
    slopes = np.array([np.angle(np.exp(1j * (phase(one) - phase(-one)))) / 2e-6 for one in steps])
    x, y = fit.point(data.i, data.q, data.bias)
    noise = ((data.sigma_i * y) ** 2 + (data.sigma_q / TRUE.gain_ratio * x) ** 2) / (x**2 + y**2) ** 2
    wanted = noise + np.einsum("kn,kl,ln->n", slopes, fit.covariance, slopes)
    assert fit.phase_variance(data) == pytest.approx(wanted, rel=1e-4)


def test_noise_across_a_radius_does_not_make_the_circle_larger() -> None:
    data = circle(n=20000, sigma=0.2, n_bias=0, n_map=0)
    # sigma^2 / 2 A^2 is 0.025, a ninth of a deviation: on the true circle nothing is left of it
    at = _evaluate(CircleFit.still(TRUE).theta, data, TIGHT)
    assert at.residual.mean() == pytest.approx(0.0, abs=0.02)
    assert at.residual.std() == pytest.approx(1.0, abs=0.03)
    # a circle without it would have 0.922
    fit, _ = fitted(data)
    assert np.exp(fit.theta[CircleLayout.log_amplitude]) == pytest.approx(0.9, abs=0.009)


def test_one_of_two_bins_is_half_of_them() -> None:
    data = circle(n=41)
    assert data.every(1) is data
    half = data.every(2)
    assert half.i.tolist() == data.i[::2].tolist()
    assert half.bias.tolist() == data.bias[::2].tolist()
    assert half.layout == data.layout


def test_before_it_moves_a_path_is_zero_and_places_that_no_paths_have_lie_between_their_neighbours() -> None:
    change, rest = np.full((2, 6), 0.4), np.arange(6) < 2
    two = Antennas(ANTENNAS.transmitter_m, ANTENNAS.receivers_m[:2])
    assert map_places(change.copy(), two, RELEASE_M, rest).tolist() == [[0.0, 0.0, 0.2, 0.2, 0.2, 0.2]] * 2
    three = np.zeros((3, 6))
    three[0, 3] = np.nan
    found = map_places(three, ANTENNAS, RELEASE_M, rest)
    assert found == pytest.approx(np.tile(RELEASE_M[:, None], 6), abs=1e-9)


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_short_arc_gets_the_others_radius_and_the_centre_with_the_smaller_offset(side: float) -> None:
    phase, moving = np.linspace(0.0, 12.0, 601), np.arange(601) > 50
    # one volt of amplitude in the one that goes round; its samples are scaled by half of that
    whole = np.stack([0.1 + 0.5 * np.cos(phase), 0.5 * np.sin(phase)])
    # a seventh of a turn of circles of one volt, most samples on one end, where it was slow
    arc = np.radians(25.0) * (2.0 * np.linspace(0.0, 1.0, 550) ** 2 - 1.0)
    short = []
    for scale_v in (1.0, 4.0):
        pair = np.zeros((2, 601))
        # its offset is small on one side of the arc and large on the other
        pair[:, moving] = np.stack([0.05 + side * np.cos(arc), np.sin(arc)]) / scale_v
        short.append(pair)
    ellipses = [StillEllipse(0.0, 0.0, 0.1, 0.1, 7.0)] * 3
    found = _arcs_completed(np.concatenate([whole, *short]), moving, ellipses, np.array([2.0, 1.0, 4.0]))
    assert found[0] is ellipses[0]
    for own, scale_v in zip(found[1:], (1.0, 4.0), strict=True):
        assert (own.log_gain, own.quadrature_error_rad) == (0.0, 0.0)
        assert own.amplitude * scale_v == pytest.approx(1.0, rel=1e-3)
        # as far off as samples on an arc lie above its chord, and their main direction leans
        assert (own.offset_i * scale_v, own.offset_q * scale_v) == pytest.approx((0.05 + 0.05 * side, 0.0), abs=0.06)


def test_points_near_the_centre_and_far_away_are_left_out_while_most_stay() -> None:
    phase = np.linspace(0.0, 6.0, 200)
    i, q, weight = 0.1 + np.cos(phase), np.sin(phase), np.ones(200)
    i[:5], q[5:10] = 0.1, 40.0
    q[:5] = 0.0
    ellipse = StillEllipse(0.1, 0.0, 0.0, 0.0, 1.0)
    found = _drop_outliers(i, q, weight, ellipse)
    clean = fit_still_ellipse(i[10:], q[10:], weight[10:])
    assert found == clean
    assert found.amplitude == pytest.approx(1.0, abs=1e-9)
    # where half of them would go the ellipse itself is wrong
    far = replace(ellipse, amplitude=10.0)
    assert _drop_outliers(i, q, weight, far) is far
    # distances count in amplitudes of the ellipse: of half an amplitude the same are left out
    half = _drop_outliers(0.5 * i, 0.5 * q, weight, StillEllipse(0.05, 0.0, 0.0, 0.0, 0.5))
    assert half.amplitude == pytest.approx(0.5 * found.amplitude)
