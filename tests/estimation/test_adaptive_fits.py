"""Circle fits and rough arcs in closed form: covariance, evidence, what noise does to a radius, completed arcs."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from radargui.estimation.adaptive.circle_fit import CircleData, CircleFit, fit_circle
from radargui.estimation.adaptive.circle_layout import CircleLayout, CircleSettings
from radargui.signals.ellipse import Ellipse

TRUE = Ellipse(0.2, -0.1, 0.9, 1.15, 0.12)
TIGHT = CircleSettings(close=1e-9, worth=1e-3, steps=100)


def circle(n: int = 400, sigma: float = 0.01, n_bias: int = 3, n_map: int = 2, seed: int = 0) -> CircleData:
    phase, rng, place = np.linspace(0.0, 40.0, n), np.random.default_rng(seed), np.linspace(-1.0, 1.0, n)
    i = TRUE.i0_v + TRUE.amplitude_v * np.cos(phase)
    q = TRUE.q0_v + TRUE.gain_ratio * TRUE.amplitude_v * np.sin(phase + TRUE.quadrature_error_rad)
    noise, spread = sigma * rng.standard_normal((2, n)), np.full(n, sigma)
    bias = np.sin(np.outer(place, np.arange(1.0, n_bias + 1.0)))
    level = np.cos(np.outer(place, np.arange(1.0, n_map + 1.0)))
    return CircleData(i + noise[0], q + noise[1], spread, spread, np.ones(n), bias, level)


def fitted(data: CircleData, **given: Any) -> tuple[CircleFit, np.ndarray]:
    start = np.zeros(data.layout.size)
    start[CircleLayout.constants] = CircleFit.still(TRUE).theta
    mean = start[CircleLayout.constants] + 0.02
    return fit_circle(data, start, mean, updates=0, settings=TIGHT, **given), mean


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
    # a circle without it would have 0.922
    fit, _ = fitted(data)
    assert np.exp(fit.theta[CircleLayout.log_amplitude]) == pytest.approx(0.9, abs=0.009)
