"""From the complex signal to codes: mixer, slow and white noise, multiplexer with crosstalk, converter."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

_SLOWEST_HZ, _FASTEST_HZ = 0.5, 1000.0
_CODES = 32768
_TINY = 1e-12


@dataclass(frozen=True)
class Mixer:
    """One receiver's IQ mixer; all in units of its own echo's amplitude but `amplitude_v`.

    Attributes
    ----------
    amplitude_v
        Volts of I for an echo of size 1.
    gain_ratio, quadrature_error_rad
        Q over I, and the quadrature error eps.
    offset
        Of I and Q: the direct leakage from the transmitter, what the empty room reflects, the mixer's own.
    harmonics
        Waves that turn at -3 and +3 times the phase, complex, over the echo.
    """

    amplitude_v: float
    gain_ratio: float
    quadrature_error_rad: float
    offset: tuple[float, float]
    harmonics: tuple[complex, complex] = (0.0, 0.0)

    def volts(self, echo: Complex, part: int) -> Array:
        """Return I = A (Re Z + b_I) (part 0) or Q = A (g Im(Z exp(i eps)) + b_Q) (part 1) of an echo Z."""
        if any(self.harmonics):
            size = np.maximum(np.abs(echo), _TINY)
            backward, forward = self.harmonics
            echo = echo + backward * echo.conj() ** 3 / size**2 + forward * echo**3 / size**2
        if part == 0:
            return self.amplitude_v * (echo.real + self.offset[0])
        turned = (echo * np.exp(1j * self.quadrature_error_rad)).imag
        return self.amplitude_v * (self.gain_ratio * turned + self.offset[1])


@dataclass(frozen=True)
class Noise:
    """Noise before the multiplexer, in units of the echo's amplitude: white and 1/f (rms), drift over the record."""

    white: float
    flicker: float = 0.0
    drift: float = 0.0

    def made(self, rng: np.random.Generator, count: int, rate_hz: float) -> Array:
        """Return noise of one channel, shape (n,)."""
        out = self.white * rng.standard_normal(count)
        out += self.drift * rng.standard_normal() * np.linspace(-1.0, 1.0, count)
        return out + self.flicker * _flicker(rng, count, rate_hz) if self.flicker > 0.0 else out


def _flicker(rng: np.random.Generator, count: int, rate_hz: float) -> Array:
    frequency = np.fft.rfftfreq(count, 1.0 / rate_hz)
    inside = (frequency >= _SLOWEST_HZ) & (frequency < _FASTEST_HZ)
    turn = np.exp(2j * np.pi * rng.random(frequency.size))
    noise = np.fft.irfft(np.where(inside, turn / np.sqrt(np.maximum(frequency, _SLOWEST_HZ)), 0.0), count)
    return noise / noise.std()


@dataclass(frozen=True)
class Converter:
    """A multiplexed 16-bit converter.

    Attributes
    ----------
    rate_hz, skew_s
        True rate of each channel; channel k is converted k skews after channel 0.
    crosstalk
        Share of the voltage of the conversion before that the sampling capacitor keeps.
    range_v
        Codes cover +- this, or the range that whoever sets the board up takes instead (`for_signals`).
    """

    rate_hz: float
    skew_s: float
    crosstalk: float = 0.0
    range_v: float = 5.0

    @property
    def step_v(self) -> float:
        """Volts of one code."""
        return self.range_v / _CODES

    def for_signals(self, largest_v: float) -> Converter:
        """Return it with twice the range, and twice again, until the signals of a drop as it was foreseen fit in."""
        doubled = max(0, math.ceil(math.log2(largest_v / self.range_v)))
        return replace(self, range_v=self.range_v * 2.0**doubled)

    def times_s(self, count: int, channel: int) -> Array:
        """Return when a channel is converted, shape (n,)."""
        return np.arange(count) / self.rate_hz + channel * self.skew_s

    def codes(self, volts: Array) -> NDArray[np.int16]:
        """Return codes of the channels' voltages (n_channels, n) at their own times.

        One capacitor is charged by all channels in turn, channel 0 after the last of the scan before:
        v'_k = v_k + kappa (v'_before - v_k).
        """
        turns = volts.T.ravel()
        start = [self.crosstalk * turns[0]]  # as if it had always seen the first voltage
        kept, _ = lfilter([1.0 - self.crosstalk], [1.0, -self.crosstalk], turns, zi=start)
        codes = np.round(kept.reshape(volts.T.shape).T / self.step_v)
        return np.clip(codes, -_CODES, _CODES - 1).astype(np.int16)
