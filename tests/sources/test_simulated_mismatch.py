"""Mismatch, noise and converter of the simulated source have the sizes that were asked for."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, strategies as st
from support.simulated_recording import simulate_recording
from support.simulated_setup import PERFECT, perfect_setup, simulated_setup

from radargui.model.daq import Daq
from radargui.model.simulation import MismatchKind, Simulation
from radargui.sources.simulated.model import SimulatedRadar
from radargui.sources.simulated.noise import Converter, Disturbance, SmoothField, make_mixer

KINDS: tuple[MismatchKind, ...] = (
    "dc_offset", "gain_error", "bias", "amplitude_variation", "drift", "reflection", "mains",
)  # fmt: skip
NONE_OF_THEM = {**dict.fromkeys(KINDS, 0.0), "quadrature_error_deg": 0.0}


def _volts(**settings: object) -> np.ndarray:
    return simulate_recording(perfect_setup(**settings))[0].volts()


def test_one_knob_sets_every_kind_and_each_kind_overrides_it() -> None:
    knob = Simulation(mismatch=0.1, mains=0.03, quadrature_error_deg=-3.0)
    assert all(knob.size(kind) == 0.1 for kind in KINDS if kind != "mains")
    assert knob.size("mains") == 0.03
    assert knob.size("quadrature_error") == pytest.approx(np.radians(3.0))
    assert Simulation(mismatch=0.1).size("quadrature_error") == 0.1


def test_every_kind_changes_the_signal_and_all_off_is_the_clean_signal() -> None:
    clean = _volts()
    np.testing.assert_array_equal(_volts(mismatch=0.1, **NONE_OF_THEM), clean)
    for kind in KINDS:
        assert np.abs(_volts(**{kind: 0.1}) - clean).max() > 0.01, kind
    assert np.abs(_volts(quadrature_error_deg=5.0) - clean).max() > 0.05


def test_the_hardware_is_the_mixer_of_the_model() -> None:
    mixer = make_mixer(Simulation(mismatch=0.1), 1)
    signal = np.exp(1j * np.linspace(0, 6, 50))
    np.testing.assert_allclose(mixer.i(signal), signal.real + mixer.offset_i)
    e = mixer.quadrature_error_rad
    expected = mixer.gain * (np.sin(e) * signal.real + np.cos(e) * signal.imag) + mixer.offset_q
    np.testing.assert_allclose(mixer.q(signal), expected)
    assert np.hypot(mixer.offset_i, mixer.offset_q) == pytest.approx(0.1)
    assert 0.06 <= abs(mixer.gain - 1.0) <= 0.1
    assert 0.06 <= abs(e) <= 0.1


def test_hardware_differs_between_receivers_and_seeds_and_a_quadrature_error_that_is_set_is_exact() -> None:
    mixers = {make_mixer(Simulation(mismatch=0.1, seed=seed), receiver) for seed in (1, 2) for receiver in range(4)}
    assert len(mixers) == 8
    for receiver in range(3):
        mixer = make_mixer(Simulation(quadrature_error_deg=-4.0), receiver)
        assert mixer.quadrature_error_rad == pytest.approx(np.radians(-4.0))


def test_runs_of_a_session_share_hardware_and_surroundings_and_differ_in_noise_drift_and_mains() -> None:
    constant = {"mismatch": 0.1, "drift": 0.0, "mains": 0.0}
    first, _ = simulate_recording(perfect_setup(**constant), run=0)
    second, _ = simulate_recording(perfect_setup(**constant), run=1)
    np.testing.assert_array_equal(first.raw, second.raw)
    for varying in ({"drift": 0.1}, {"mains": 0.1}, {"noise": True}):
        first, _ = simulate_recording(perfect_setup(**varying), run=0)
        second, _ = simulate_recording(perfect_setup(**varying), run=1)
        assert np.abs(first.raw - second.raw).max() > 0.001


def test_switching_one_kind_off_leaves_the_random_draws_of_the_others() -> None:
    base = {"mismatch": 0.1, "amplitude_variation": 0.0}
    with_mains = _volts(**base)
    without_mains = _volts(**base, mains=0.0)
    only_mains = _volts(mains=0.1) - _volts()
    np.testing.assert_allclose(with_mains - without_mains, only_mains, atol=1e-12)


def test_bias_and_amplitude_follow_the_position_and_not_the_time() -> None:
    setup = perfect_setup(scene="pendulum", turns=3.0, rest_s=0.0, bias=0.1, amplitude_variation=0.1)
    radar = SimulatedRadar(setup)
    clean = SimulatedRadar(perfect_setup(scene="pendulum", turns=3.0, rest_s=0.0))
    times = np.linspace(0.05, 1.0, 40)
    period = radar.scene.trajectory.duration_s / 3.0
    volts = radar._volts(times)
    np.testing.assert_allclose(radar._volts(times + period), volts, atol=1e-10)
    assert np.ptp(volts - clean._volts(times), axis=1).min() > 0.02


def test_a_smooth_field_has_unit_size_and_changes_little_over_a_centimetre() -> None:
    places = np.random.default_rng(3).uniform(-0.15, 0.15, (3, 300))
    fields = [SmoothField(np.random.default_rng(seed)) for seed in range(60)]
    real = np.array([field.real_at(places) for field in fields])
    whole = np.array([field.complex_at(places) for field in fields])
    assert np.sqrt((real**2).mean()) == pytest.approx(1.0, rel=0.1)
    assert np.sqrt((np.abs(whole) ** 2).mean()) == pytest.approx(1.0, rel=0.1)
    nearby = np.array([field.real_at(places + np.array([[0.0], [0.0], [0.01]])) for field in fields])
    assert np.sqrt(((nearby - real) ** 2).mean()) == pytest.approx(0.01 / 0.12, rel=0.2)


def test_drift_is_slow_and_of_the_size_asked_for() -> None:
    time = np.linspace(0.0, 300.0, 30001)
    drifts = np.array([Disturbance(Simulation(mismatch=0.0, drift=0.1), channel, 0).at(time) for channel in range(40)])
    assert np.sqrt((drifts**2).mean()) == pytest.approx(0.1 / np.sqrt(2), rel=0.05)
    assert np.abs(np.diff(drifts, axis=1)).max() / 0.01 < 0.1 * np.sqrt(3) * 2 * np.pi * 0.3


@pytest.mark.parametrize("frequency", [50.0, 60.0])
def test_mains_is_a_line_at_its_frequency_with_at_most_its_size(frequency: float) -> None:
    setup = {"scene": "rest", "rest_s": 1.0, "settle_s": 0.0, "mains": 0.1, "mains_frequency_hz": frequency}
    volts = _volts(**setup)
    amplitude = 2 * np.abs(np.fft.rfft(volts - volts.mean(axis=1, keepdims=True))) / volts.shape[1]
    assert (amplitude.argmax(axis=1) == round(frequency)).all()
    assert (amplitude.max(axis=1) <= 0.1 + 1e-12).all()
    assert (amplitude.max(axis=1) >= 0.05 - 1e-12).all()


@pytest.mark.parametrize("snr_db", [20.0, 40.0])
def test_noise_is_white_and_gives_the_signal_to_noise_ratio(snr_db: float) -> None:
    noisy = _volts(scene="rest", rest_s=5.0, noise=True, snr_db=snr_db, amplitude_v=2.0)
    noise = noisy - _volts(scene="rest", rest_s=5.0, amplitude_v=2.0)
    sigma = noise.std(axis=1)
    np.testing.assert_allclose(10 * np.log10(2.0**2 / (2 * sigma**2)), snr_db, atol=0.1)
    correlation = np.corrcoef(noise)
    assert np.abs(correlation - np.eye(6)).max() < 0.02
    assert np.abs((noise[:, 1:] * noise[:, :-1]).mean(axis=1)).max() < 0.02 * sigma.max() ** 2


def test_a_skew_of_15_us_at_a_doppler_of_130_hz_is_a_quadrature_error_of_0_7_degrees() -> None:
    skew = 15e-6
    setup = perfect_setup(daq={"channel_skew_s": skew, "rate_hz": 33333.0})
    recording, truth = simulate_recording(setup)
    volts = recording.volts()
    doppler = np.gradient(truth.path_m, 1 / 33333.0, axis=1) / 0.0299792458
    falling = np.flatnonzero(doppler[0] >= 130.0)[0]
    clean = simulate_recording(perfect_setup(daq={"rate_hz": 33333.0}))[0].volts()
    late = np.arctan2(clean[1], clean[0])
    amplitude = np.hypot(clean[0], clean[1])
    error_deg = np.degrees((volts[1] - clean[1])[falling] / (amplitude * np.cos(late))[falling])
    assert error_deg == pytest.approx(360.0 * 130.0 * skew, rel=0.03)
    assert error_deg == pytest.approx(0.7, abs=0.03)


def test_a_skewed_channel_is_the_true_signal_at_its_own_later_time() -> None:
    rate, skew = 10000.0, 12.5e-6
    skewed = _volts(daq={"channel_skew_s": skew, "rate_hz": rate}, mismatch=0.1)
    # eight times the rate samples the multiplexer's instants
    fine = _volts(daq={"rate_hz": 8 * rate}, mismatch=0.1)
    for channel in range(6):
        there = fine[channel, channel::8][: skewed.shape[1]]
        np.testing.assert_allclose(skewed[channel, : there.size], there, atol=1e-9)


def _convert(volts: list[float], bits: int, range_v: float = 5.0) -> np.ndarray:
    return Converter(Simulation(adc_bits=bits), Daq(range_v=range_v)).convert(np.array([volts]))[0]


def test_sixteen_bits_over_the_range_and_the_end_codes_beyond_it() -> None:
    codes = _convert([0.0, 2.5, -5.0, 5.0, 9.0, -9.0], 16)
    assert codes.dtype == np.int16
    np.testing.assert_array_equal(codes, [0, 16384, -32768, 32767, 32767, -32768])


def test_fewer_bits_give_coarser_codes_and_the_same_end_codes() -> None:
    codes = _convert([1.0, 0.0012, 0.0013, 9.0, -9.0], 12)
    np.testing.assert_array_equal(codes, [6560, 0, 16, 32767, -32768])


def test_without_a_converter_volts_stay_volts_and_are_never_clipped() -> None:
    setup = simulated_setup(**{**PERFECT, "amplitude_v": 20.0})
    recording, _ = simulate_recording(setup)
    assert recording.raw.dtype == np.float64
    assert recording.digitisation.scaling is None
    assert np.abs(recording.raw).max() > 15.0
    assert not recording.clipped().any()


def test_a_signal_beyond_the_range_is_clipped_at_both_ends() -> None:
    recording, _ = simulate_recording(perfect_setup(amplitude_v=6.0, adc_bits=8))
    assert {-32768, 32767} <= set(np.unique(recording.raw).tolist())
    assert recording.clipped().any(axis=1).all()


@given(bits=st.integers(1, 16), range_v=st.floats(0.1, 10.0), share=st.floats(-0.999, 0.999))
def test_a_code_stands_for_its_voltage_within_half_a_step(bits: int, range_v: float, share: float) -> None:
    converter = Converter(Simulation(adc_bits=bits), Daq(range_v=range_v))
    scaling = converter.scaling(1)
    assert scaling is not None
    code = int(converter.convert(np.array([[share * range_v]]))[0, 0])
    volts = scaling[0][0] + scaling[0][1] * code
    step = 2 * range_v / 2**bits
    assert abs(volts - share * range_v) <= 0.5 * step * (1 + 1e-9) + range_v / 32768
