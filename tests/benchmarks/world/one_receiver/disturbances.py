"""What an echo meets on its way into the file: range, fading, hum, tones, drift, the converter."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from benchmarks.world.one_receiver.paths import slow

from radargui.model.arrays import BoolArray, FloatArray, RawArray


def amplitude_along(rng: np.random.Generator, turns: FloatArray, walking: bool) -> FloatArray:
    """Return the echo's amplitude along the way, 1 at its strongest, shape (n_samples,).

    The amplitude of a radar echo goes with 1 / r^2; a reflection from the floor beside the direct one adds a ripple
    over some fringes; a walker's limbs change it with the step.
    """
    way = turns - turns.min()
    farthest = rng.uniform(1.0, 2.0)  # r_max / r_min: amplitude changes up to four times
    range_ratio = 1.0 + (farthest - 1.0) * way / max(float(way.max()), 1e-9)
    ripple = 1.0 + rng.uniform(0.0, 0.2) * np.cos(2.0 * np.pi * turns / rng.uniform(5.0, 30.0) + rng.uniform(0.0, 6.0))
    limbs = 1.0 + (0.2 * np.cos(2.0 * np.pi * turns / rng.uniform(20.0, 60.0)) if walking else 0.0)
    amplitude = ripple * limbs / range_ratio**2
    return np.asarray(amplitude / amplitude.max())


def fades(rng: np.random.Generator, time_s: FloatArray) -> FloatArray:
    """Return a factor that goes to nothing for one or two stretches and comes back, shape (n_samples,)."""
    factor = np.ones_like(time_s)
    duration_s = float(time_s[-1])
    holes = 1 if duration_s < 2.5 else int(rng.integers(1, 3))
    for hole in range(holes):
        length_s = rng.uniform(0.12, 0.3) * duration_s / holes
        middle_s = duration_s * (hole + rng.uniform(0.35, 0.65)) / holes
        edge_s = rng.uniform(0.05, 0.15)
        outside = np.clip((np.abs(time_s - middle_s) - length_s / 2.0) / edge_s, 0.0, 1.0)
        factor *= 0.5 - 0.5 * np.cos(np.pi * outside)
    return factor


def hum(rng: np.random.Generator, time_s: FloatArray, level_v: float) -> FloatArray:
    """Return mains hum with harmonics in I and Q, shape (2, n_samples), its largest voltage `level_v`."""
    mains_hz = rng.choice([50.0, 60.0]) + rng.uniform(-0.03, 0.03)
    wave = np.zeros((2, len(time_s)))
    for harmonic in range(1, 6):
        for channel in range(2):
            size = rng.uniform(0.2, 1.0) / harmonic
            wave[channel] += size * np.sin(2 * np.pi * harmonic * mains_hz * time_s + rng.uniform(0.0, 2.0 * np.pi))
    return np.asarray(level_v * wave / np.abs(wave).max())


def tone(
    rng: np.random.Generator, time_s: FloatArray, skew_s: float, frequency_hz: float, level_v: float
) -> FloatArray:
    """Return a real tone of one frequency in I and Q, shape (2, n_samples).

    Its phases and sizes are kept from being those of a mixer (90 +- 35 degrees apart, sizes 0.6 to 1.6): a tone that
    turns as an echo does is a target at constant speed, and nobody can know better.
    """
    apart_deg = rng.uniform(-40.0, 40.0) + rng.choice([0.0, 180.0])
    start_rad = rng.uniform(0.0, 2.0 * np.pi)
    first = np.cos(2.0 * np.pi * frequency_hz * time_s + start_rad)
    second = np.cos(2.0 * np.pi * frequency_hz * (time_s + skew_s) + start_rad + np.deg2rad(apart_deg))
    return level_v * np.array([first * rng.uniform(0.5, 1.0), second * rng.uniform(0.5, 1.0)])


def drift(rng: np.random.Generator, time_s: FloatArray, level_v: float) -> FloatArray:
    """Return offsets that wander slower than 0.5 Hz, shape (2, n_samples)."""
    return level_v * np.array([slow(rng, time_s, 0.5), slow(rng, time_s, 0.5)])


@dataclass(frozen=True, slots=True)
class Mixer:
    """I = i, Q = g (q cos e + i sin e): gain ratio g, quadrature error e."""

    gain_ratio: float
    quadrature_error_rad: float

    def inverse(self, volts: FloatArray) -> FloatArray:
        """Return i, q of voltages at the outputs, shape (2, n_samples)."""
        sine, cosine = np.sin(self.quadrature_error_rad), np.cos(self.quadrature_error_rad)
        return np.array([volts[0], (volts[1] / self.gain_ratio - volts[0] * sine) / cosine])

    def echo(self, amplitude_v: FloatArray, turns: FloatArray, later_turns: FloatArray) -> FloatArray:
        """Return the voltages of an echo, shape (2, n_samples); Q is sampled at `later_turns`."""
        angle = 2.0 * np.pi * later_turns + self.quadrature_error_rad
        return amplitude_v * np.array([np.cos(2.0 * np.pi * turns), self.gain_ratio * np.sin(angle)])


@dataclass(frozen=True, slots=True)
class Converter:
    """12 bit over 0 to 3.3 V, or 16 bit over +- range, as codes or as volts in the file."""

    low_v: float
    high_v: float
    bits: int
    as_codes: bool

    @property
    def step_v(self) -> float:
        """Volts of one code."""
        return (self.high_v - self.low_v) / 2**self.bits

    @property
    def middle_v(self) -> float:
        """Middle of the range."""
        return (self.high_v + self.low_v) / 2.0

    def digitise(self, volts: FloatArray) -> tuple[RawArray, tuple[tuple[float, ...], ...] | None, BoolArray]:
        """Return samples, scaling, and where either channel is at the end of the range."""
        lowest = 0 if self.low_v == 0.0 else -(2 ** (self.bits - 1))
        highest = lowest + 2**self.bits - 1
        codes = np.clip(np.round(volts / self.step_v), lowest, highest)
        clipped = np.asarray(((codes == lowest) | (codes == highest)).any(axis=0))
        if self.as_codes:
            return codes.astype(np.int16), ((0.0, self.step_v),) * 2, clipped
        return codes * self.step_v, None, clipped
