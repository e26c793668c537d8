"""What a receiver should show: closed forms without mirrors, image theory with them, slow noise, bins."""

from __future__ import annotations

import numpy as np
import pytest
from support.receiver_signal import receiver_signal
from support.small_problem import FLOOR_PLANE, WALL_PLANE, small_problem

from radargui.estimation.forward.bins import BinSettings, bin_by_fringe, pool
from radargui.estimation.forward.parameters import Sizes, lobe_places, make_layout
from radargui.estimation.forward.signal_model import FrontEndState, log_ways, turn_of, waves_at
from radargui.estimation.forward.slow_noise import SlowNoiseSettings, measure_drift
from radargui.estimation.signals import ScaledSignals
from radargui.estimation.solve.problem import linearise


def signals_of(value: np.ndarray, rate: float, sigma: float = 0.01) -> ScaledSignals:
    n_channels, n = value.shape
    return ScaledSignals(
        time_s=np.arange(n) / rate,
        value=value,
        valid=np.ones((n_channels // 2, n), bool),
        usable=np.ones(n, bool),
        unusable_share=np.zeros(n_channels // 2),
        sigma=np.full(n_channels, sigma),
        scale_v=np.ones(n_channels // 2),
        delay_s=np.zeros(n_channels),
        mixers=(None,) * (n_channels // 2),
        before=None,
        rate_hz=rate,
        rest_end_s=0.8 * n / rate,
        onset_s=0.8 * n / rate,
    )


def range_at_nodes(at_bins: np.ndarray, legs: list[np.ndarray]) -> np.ndarray:
    """Return how the amplitude falls with both ways, around what it is at the bins."""
    product = legs[0] * legs[1]
    return at_bins * product.mean(axis=1, keepdims=True) / product


def test_without_maps_and_mirrors_the_channels_show_the_closed_form() -> None:
    made = small_problem(delay_s=1e-4)
    inputs, layout, theta = made.problem.inputs, made.problem.layout, made.truth.theta
    # antennas that shine alike in all directions
    theta[lobe_places(layout)] = 0.0
    at = linearise(made.problem, made.truth)
    antennas, release = inputs.antennas, inputs.release_m
    for n, own in enumerate(layout.receivers):
        node = at.node_m[:, 2 * n : 2 * n + 2]
        ends = antennas.transmitter_m, antennas.receivers_m[n]
        legs = [np.linalg.norm(node - a[:, None, None, None], axis=0) for a in ends]
        path = sum(leg - np.linalg.norm(release - a) for leg, a in zip(legs, ends, strict=True))
        amplitude = np.exp(theta[own.log_amplitude]) * range_at_nodes(inputs.range_factor[n], legs)
        z = (amplitude * np.exp(1j * (inputs.wavenumber * path + theta[own.phase]))).mean(axis=1)
        gain, error = np.exp(theta[own.log_gain]), theta[own.quadrature_error]
        wanted_i = z[0].real + theta[own.offset][0]
        wanted_q = gain * np.imag(z[1] * np.exp(1j * error)) + theta[own.offset][1]
        assert at.signals[n].value == pytest.approx(np.stack([wanted_i, wanted_q]), abs=1e-9)


def test_mirrors_multiply_the_field_by_image_theory() -> None:
    made = small_problem((FLOOR_PLANE, WALL_PLANE), reflection=0.15)
    inputs, layout, theta = made.problem.inputs, made.problem.layout, made.truth.theta.copy()
    own = layout.receivers[1]
    theta[own.double_reflection] = [0.02, -0.03, 0.01, 0.04]
    theta[layout.transmitter_lobe] = [0.2, -0.9, 0.4, 0.0, 0.3, -0.6]
    theta[own.receiver_lobe] = [-0.3, -1.2, 0.1, 0.1, -0.5, -0.2]
    node = linearise(made.problem, made.truth).node_m[:, 2:4]
    tx, rx, release = inputs.antennas.transmitter_m, inputs.antennas.receivers_m[1], inputs.release_m

    def wave(antenna: np.ndarray, point: np.ndarray) -> np.ndarray:
        r = np.linalg.norm(point - antenna[:, None, None, None], axis=0)
        return np.exp(1j * inputs.wavenumber * r) / r

    def seen(antenna: np.ndarray, target: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        axis = (target - antenna) / np.linalg.norm(target - antenna)
        away = [places - antenna[:, None, None, None] for places in (node, release[:, None, None, None])]
        now, rest = (1.0 - np.einsum("k,k...->...", axis, one) / np.linalg.norm(one, axis=0) for one in away)
        return now, rest

    def main_lobe(antenna: np.ndarray, target: np.ndarray, lobes: np.ndarray) -> np.ndarray:
        q, rest = seen(antenna, target)
        return np.exp((lobes[1] * (q - rest) + lobes[2] * (q**2 - rest**2)) / 0.1)

    def lobe_of(antenna: np.ndarray, mirror: int, lobes: np.ndarray) -> np.ndarray:
        # the direct antenna looks to the origin, its image to the origin's image
        image, target = (inputs.planes[mirror].image(point, np.zeros(3)) for point in (antenna, np.zeros(3)))
        own = lobes[3 * mirror :][:3]
        q, rest = seen(image, target)
        mirrored = np.exp((own[1] * (q - rest) + own[2] * (q - rest) ** 2) / 0.1)
        if mirror == 0:
            mirrored = main_lobe(image, target, lobes)
        height = np.exp(own[0] * (node[2] - release[2]) / 0.3)
        return height * mirrored / main_lobe(antenna, np.zeros(3), lobes)

    def over(antenna: np.ndarray, mirror: int, lobes: np.ndarray) -> np.ndarray:
        image = inputs.planes[mirror].image(antenna, np.zeros(3))
        ratio = wave(image, node) / wave(antenna, node)
        at_rest = wave(image, release[:, None, None, None]) / wave(antenna, release[:, None, None, None])
        return ratio * np.exp(-1j * np.angle(at_rest)) * lobe_of(antenna, mirror, lobes)

    by_tx = [over(tx, m, theta[layout.transmitter_lobe]) for m in range(2)]
    by_rx = [over(rx, m, theta[own.receiver_lobe]) for m in range(2)]
    x = [0.02 - 0.03j, 0.01 + 0.04j]
    factor = (1.0 + 0.15 * sum(by_tx)) * (1.0 + 0.15 * sum(by_rx))
    factor = factor + sum(value * a * b for value, a, b in zip(x, by_tx, by_rx, strict=True))
    bare = theta.copy()
    for places in (layout.transmitter_reflection, own.receiver_reflection, own.double_reflection):
        bare[places] = 0.0
    direct = receiver_signal(node, bare, layout, inputs, 1)
    with_mirrors = receiver_signal(node, theta, layout, inputs, 1)
    legs = [np.linalg.norm(node - a[:, None, None, None], axis=0) for a in (tx, rx)]
    amplitude = range_at_nodes(inputs.range_factor[1], legs) * np.exp(theta[own.log_amplitude])
    for antenna, places in ((tx, layout.transmitter_lobe), (rx, own.receiver_lobe)):
        amplitude = amplitude * main_lobe(antenna, np.zeros(3), theta[places])
    path = sum(legs) - sum(np.linalg.norm(release - a) for a in (tx, rx))
    field = amplitude * np.exp(1j * (inputs.wavenumber * path + theta[own.phase]))
    assert direct.field == pytest.approx(field.mean(axis=(0, 1)), abs=1e-9)
    assert with_mirrors.field == pytest.approx((field * factor).mean(axis=(0, 1)), abs=1e-9)


def test_a_front_end_shows_and_its_slope_is_a_finite_difference() -> None:
    z = np.exp(1j * np.linspace(0.0, 6.0, 30)) * 0.8
    here = FrontEndState(1.2, 0.1)
    up, down = (FrontEndState(1.2, 0.1 + s * 1e-6).channels(np.stack([z, z]))[1] for s in (1, -1))
    own, values = make_layout(Sizes(0, 0, 1, 1, 1, 0)).own, np.zeros(9)
    values[[own.log_gain, own.quadrature_error]] = np.log(1.2), 0.1
    turned = turn_of(values, own)[:, None] * z
    assert here.channels(np.stack([z, z])) == pytest.approx(turned.real)
    assert -turned[1].imag == pytest.approx((up - down) / 2e-6, abs=1e-8)


def flicker(level: float, n: int, rate: float, seed: int) -> np.ndarray:
    """Return noise of one-sided spectral density level / f."""
    rng = np.random.default_rng(seed)
    frequency = np.fft.rfftfreq(n, 1.0 / rate)
    spectrum = rng.standard_normal((6, frequency.size)) + 1j * rng.standard_normal((6, frequency.size))
    spectrum[:, 1:] *= np.sqrt(level / frequency[1:] * n * rate / 4.0)
    spectrum[:, 0] = 0.0
    return np.fft.irfft(spectrum, n, axis=1)


def test_flicker_noise_is_measured_and_widens_the_bins_as_derived() -> None:
    level, rate, n = 3e-5, 5000.0, 20000
    value = flicker(level, n, rate, 2) + 0.01 * np.random.default_rng(3).standard_normal((6, n))
    signals = signals_of(value, rate)
    drift = measure_drift(signals, 3.2)
    assert drift.count == 80
    assert np.median(drift.level) == pytest.approx(level, rel=0.35)
    bins = pool(signals, 0.004)
    wide = drift.widen(bins)
    assert wide.sigma**2 == pytest.approx(bins.sigma**2 + 12.0 * drift.level[:, None] * np.ones(bins.n_bins))
    assert ((wide.expected > 0.0) & (wide.expected <= 1.0)).all()
    fourier, own = drift.functions(bins.time_s), drift.uncorrelated(wide)
    assert own.shape[2] < 60  # 20 cycles are 40 numbers, and what the edges add
    for functions, sd, sigma in zip(own, drift.sd, wide.sigma, strict=True):
        lost = (fourier * sd**2) @ fourier.T - functions @ functions.T
        assert np.abs(lost).max() < 1e-4 * sigma.min() ** 2


def test_a_slope_of_the_rest_gets_functions_that_can_carry_it() -> None:
    rate, n = 5000.0, 10000
    time = np.arange(n) / rate
    value = 0.01 * np.random.default_rng(4).standard_normal((6, n)) + 0.005 * time
    drift = measure_drift(signals_of(value, rate), 1.6)
    assert drift.count == 12
    assert not drift.level.any()
    functions = drift.functions(time)
    assert functions.shape == (n, 12)
    ridge = functions.T @ functions / 0.01**2 + np.diag(drift.sd[0] ** -2.0)
    wanted = value[0] - value[0].mean()
    carried = functions @ np.linalg.solve(ridge, functions.T @ wanted / 0.01**2)
    assert np.std((wanted - carried)[:8000] - (wanted - carried)[:8000].mean()) < 1.2 * 0.01
    assert measure_drift(signals_of(value, rate), 1.6, SlowNoiseSettings(drift_sigmas=1e9)).count == 0


def test_bins_shorten_with_the_doppler_frequency_and_with_the_setting() -> None:
    signals = signals_of(np.zeros((2, 20000)), 20000.0)
    time, turns = np.array([0.0, 0.5, 0.50001, 1.0]), np.array([2.0, 2.0, 100.0, 100.0])
    usual = bin_by_fringe(signals, time, turns, 0.1, np.zeros(0))
    length = np.diff(usual.time_s)
    assert np.median(length[usual.time_s[1:] < 0.09]) == pytest.approx(0.010, rel=0.02)
    assert np.median(length[(usual.time_s[1:] > 0.15) & (usual.time_s[1:] < 0.45)]) == pytest.approx(0.004, rel=0.02)
    assert np.median(length[usual.time_s[1:] > 0.55]) == pytest.approx(1.0 / 2400.0, rel=0.15)
    finer = bin_by_fringe(signals, time, turns, 0.1, np.zeros(0), BinSettings(per_fringe=48.0))
    assert finer.n_bins > 1.5 * usual.n_bins
    assert usual.count.sum() == 20000
    assert usual.sigma[0] == pytest.approx(0.01 / np.sqrt(usual.count))


def test_flicker_noise_on_longer_bins_leaves_the_residuals_that_are_expected_of_it() -> None:
    level, rate, n = 3e-5, 5000.0, 20000
    value = flicker(level, n, rate, 2) + 0.002 * np.random.default_rng(3).standard_normal((6, n))
    signals = signals_of(value, rate, 0.002)
    drift = measure_drift(signals, 3.2)
    bins = drift.widen(pool(signals, 0.001))
    for most in (1, 3):
        longer = bins.together(bins.runs(np.ones(bins.n_bins, bool), most))
        slow = drift.functions(longer.time_s) * drift.sd[0]
        left = longer.value - longer.value @ slow @ np.linalg.solve(slow.T @ slow + np.eye(80) * 1e-9, slow.T)
        assert (left**2 / longer.sigma**2 / longer.expected).mean() == pytest.approx(1.0, abs=0.2)


def test_the_logs_of_ways_are_those_of_the_waves_but_for_constants() -> None:
    made = small_problem((FLOOR_PLANE, WALL_PLANE), reflection=0.15)
    problem, layout, theta = made.problem, made.problem.layout, made.truth.theta.copy()
    theta[lobe_places(layout)] = 0.3 * np.random.default_rng(4).standard_normal(lobe_places(layout).size)
    node_m = linearise(problem, made.truth).node_m[:, 2:4]
    waves, ways = waves_at(node_m, theta, layout, problem.inputs, 1), log_ways(node_m, theta, layout, problem.inputs, 1)
    ways = ways.reshape(2, 3, *node_m.shape[1:])
    both = np.exp(ways[0][:, None] + ways[1][None])
    # of a way against the direct one, and of both against the first bin: range and maps are common to all
    found, wanted = (one / one[:1, :1] for one in (both, waves.path))
    assert found / found[..., :1] == pytest.approx(wanted / wanted[..., :1])
    turned = both[0, 0] / waves.path[0, 0]
    assert np.angle(turned / turned[..., :1]) == pytest.approx(0.0, abs=1e-9)
    lobes = np.abs(both[0, 0]) / waves.lobes.of_direct().reshape(both[0, 0].shape)
    assert lobes == pytest.approx(np.ones(lobes.shape))
