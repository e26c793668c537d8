"""One-receiver scenes by seed and number: the drawing of a scene, its voltages, and what can be known of it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from benchmarks.world.one_receiver.disturbances import Converter, Mixer, amplitude_along, drift, fades, hum, tone
from benchmarks.world.one_receiver.paths import draw_turns
from benchmarks.world.one_receiver.scene import Echo, Scene, expectation, knowable_moments, moment_samples

from radargui.model.recording import Digitisation, Recording, iq_names
from radargui.model.setup import Setup

BANDS_HZ = (5.8e9, 9.0e9, 10.0e9, 10.525e9, 24.125e9)
RATES_HZ = (5.0e3, 8.0e3, 10.0e3, 20.0e3, 31.25e3, 50.0e3)
ALWAYS_MOVING = ("car", "plate", "pendulum", "walker", "passing")


@dataclass(frozen=True, slots=True)
class Plan:
    """What a kind of scene has; levels are ranges against the echo (largest of both), drawn evenly in dB."""

    families: tuple[str, ...] = ALWAYS_MOVING
    fading: bool = False
    hum: tuple[float, float] | None = None
    tone: tuple[float, float] | None = None
    second: tuple[float, float] | None = None
    target: bool = True
    reach: tuple[float, float] = (0.3, 0.9)
    drift_share: float = 0.3


KINDS: dict[str, Plan] = {
    "plain": Plan(),
    "from rest": Plan(("start",)),
    "stops": Plan(("stop",)),
    "fading": Plan(fading=True),
    "hum": Plan((*ALWAYS_MOVING, "start", "stop"), hum=(0.05, 3.0)),
    "tone": Plan((*ALWAYS_MOVING, "start", "stop"), tone=(0.05, 2.0)),
    "second target": Plan(second=(0.1, 1.0)),
    "clipped": Plan(reach=(1.02, 1.35)),
    "mixture": Plan(("car", "start", "stop", "plate"), True, (0.02, 0.3), (0.02, 0.3), (0.05, 0.2), drift_share=0.7),
    "only noise": Plan(target=False),
    "only hum": Plan(target=False, hum=(0.3, 1.0)),
    "only tone": Plan(target=False, tone=(0.3, 1.0)),
    "only offset": Plan(target=False, drift_share=0.0),
}
ORDER = (
    *("plain", "from rest", "fading", "hum", "stops", "tone", "second target", "clipped", "mixture", "only noise"),
    *("plain", "from rest", "fading", "hum", "stops", "tone", "second target", "clipped", "mixture", "only hum"),
    *("fading", "hum", "tone", "second target", "mixture", "plain", "only tone", "only offset"),
)


def scene_kind(number: int) -> str:
    """Return the kind of a scene: they take turns."""
    return ORDER[number % len(ORDER)]


def one_receiver_setup(frequency_hz: float, phase_sign: int, correction: str) -> Setup:
    """Return a monostatic radar: transmitter and receiver at one place."""
    return Setup.model_validate(
        {
            "schema": 1,
            "radar": {"frequency_hz": frequency_hz, "phase_sign": phase_sign},
            "transmitter": {"distance_m": 1.0},
            "receiver": [{"tilt_deg": 0.0, "azimuth_deg": 0.0, "distance_m": 1.0}],
            "processing": {"correction": correction, "geometry": "exact"},
        }
    )


def make_scene(seed: int, number: int, kind: str | None = None) -> Scene:
    """Return scene `number` of a seed; the same again each time."""
    kind = kind or scene_kind(number)
    plan = KINDS[kind]
    rng = np.random.default_rng([seed, number, sorted(KINDS).index(kind)])
    rate_hz = float(rng.choice(RATES_HZ))
    duration_s = float(np.exp(rng.uniform(np.log(1.0), np.log(10.0))))
    time_s = np.arange(round(duration_s * rate_hz)) / rate_hz
    sign = -1 if number % 3 == 2 else 1
    setup = one_receiver_setup(float(rng.choice(BANDS_HZ)), sign, "adaptive")
    wavelength_m = setup.radar.wavelength_m
    mixer = Mixer(float(np.exp(rng.uniform(np.log(0.6), np.log(1.6)))), float(np.deg2rad(rng.uniform(-35.0, 35.0))))
    skew_s = float(rng.choice([5.0e-6, 10.0e-6])) if rng.random() < 0.2 else 0.0
    converter = _converter(rng)

    echoes, interference = [], np.zeros((2, len(time_s)))
    echo_v = np.zeros((2, len(time_s)))
    for level in _levels(rng, plan):
        doppler_hz, turns = draw_turns(rng, time_s, _peak_hz(rng, rate_hz), plan.families)
        amplitude = level * amplitude_along(rng, turns, rng.random() < 0.3)
        if plan.fading and not echoes:
            amplitude = amplitude * fades(rng, time_s)
        seen = sign * turns + rng.uniform(0.0, 1.0)
        voltages = mixer.echo(amplitude, seen, seen + sign * doppler_hz * skew_s)
        if echoes:
            interference += voltages
        echo_v += voltages
        echoes.append(Echo(wavelength_m * turns, amplitude))
    added = np.zeros_like(echo_v)
    if plan.hum:
        added += hum(rng, time_s, _even_db(rng, plan.hum))
    if plan.tone:
        added += tone(rng, time_s, skew_s, rng.uniform(100.0, min(3000.0, 0.4 * rate_hz)), _even_db(rng, plan.tone))
    interference += added
    volts = echo_v + added
    if rng.random() < plan.drift_share:
        volts = volts + drift(rng, time_s, rng.uniform(0.05, 0.3))

    # from here on in volts: the largest swing takes its share of the range, beside an offset that leaves it room
    reach = rng.uniform(*plan.reach)
    half_range_v = (converter.high_v - converter.low_v) / 2.0
    gain_v = 0.7 * reach * half_range_v / max(float(np.abs(volts).max()), 1e-9) if volts.any() else 0.1 * half_range_v
    offset_v = 0.3 * reach * half_range_v * rng.uniform(-1.0, 1.0, (2, 1))
    if plan.reach[0] > 1.0:
        offset_v = 0.3 * reach * half_range_v * rng.choice([-1.0, 1.0], (2, 1))
    noise_v = gain_v / np.sqrt(2.0 * 10.0 ** (rng.uniform(5.0, 45.0) / 10.0))
    if kind == "only offset":
        noise_v = converter.step_v * rng.uniform(0.3, 2.0)
    volts = gain_v * volts + offset_v + converter.middle_v + noise_v * rng.standard_normal(volts.shape)
    raw, scaling, clipped = converter.digitise(volts)
    digitisation = Digitisation(iq_names(1), rate_hz, scaling, skew_s, device="simulated")

    echoes = [replace(echo, amplitude_v=gain_v * echo.amplitude_v) for echo in echoes]
    knowable = np.zeros(len(time_s) // moment_samples(rate_hz), dtype=np.bool_)
    if echoes:
        against_v = gain_v * np.hypot(*mixer.inverse(interference))
        total_noise_v = float(np.hypot(noise_v, converter.step_v / np.sqrt(12.0)))
        knowable = knowable_moments(echoes[0], against_v, clipped, total_noise_v, wavelength_m, rate_hz)
    return Scene(
        name=f"{number:03d} {kind}",
        kind=kind,
        recording=Recording(f"scene-{number:03d}", raw, digitisation),
        setup=setup,
        echoes=tuple(echoes),
        knowable=knowable,
        expected=expectation(echoes[0] if echoes else None, knowable, wavelength_m, rate_hz),
        gain_ratio=mixer.gain_ratio,
        quadrature_error_deg=float(np.rad2deg(mixer.quadrature_error_rad)),
    )


def _even_db(rng: np.random.Generator, ends: tuple[float, float]) -> float:
    return float(np.exp(rng.uniform(*np.log(ends))))


def _levels(rng: np.random.Generator, plan: Plan) -> list[float]:
    if not plan.target:
        return []
    return [1.0, _even_db(rng, plan.second)] if plan.second else [1.0]


def _peak_hz(rng: np.random.Generator, rate_hz: float) -> float:
    """Return a largest Doppler of 20 to 2000 Hz, below half of the Nyquist rate."""
    return _even_db(rng, (20.0, min(2000.0, 0.24 * rate_hz)))


def _converter(rng: np.random.Generator) -> Converter:
    as_codes = bool(rng.random() < 0.5)
    if rng.random() < 0.5:
        return Converter(0.0, 3.3, 12, as_codes)
    range_v = float(rng.choice([0.5, 1.0, 5.0, 10.0]))
    return Converter(-range_v, range_v, 16, as_codes)
