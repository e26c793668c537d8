"""Simulate the mismatch: mixers and converter, constant for a session, and what changes with the tracer."""

from dataclasses import dataclass

import numpy as np

from radargui.model.arrays import ComplexArray, FloatArray, RawArray
from radargui.model.daq import Daq
from radargui.model.front_end import channels_of
from radargui.model.simulation import Simulation
from radargui.sources.simulated.seeds import Draw, generator

_CODES = 32768
"""Codes of 16 bits on either side of zero."""


@dataclass(frozen=True, slots=True)
class Mixer:
    """One receiver's mixer: I = Re Z + offset_i, Q = gain (sin e Re Z + cos e Im Z) + offset_q.

    Attributes
    ----------
    gain
        Amplitude of Q over amplitude of I.
    quadrature_error_rad
        e.
    offset_i, offset_q
        In amplitudes.
    """

    gain: float = 1.0
    quadrature_error_rad: float = 0.0
    offset_i: float = 0.0
    offset_q: float = 0.0

    def i(self, signal: ComplexArray) -> FloatArray:
        """Return I of the complex signal (n,), in amplitudes."""
        return np.asarray(signal.real + self.offset_i)

    def q(self, signal: ComplexArray) -> FloatArray:
        """Return Q of the complex signal (n,), in amplitudes."""
        return np.asarray(channels_of(signal, signal, self.gain, self.quadrature_error_rad)[1] + self.offset_q)


def make_mixer(simulation: Simulation, receiver: int) -> Mixer:
    """Return the mixer of a receiver: the same for all runs with one seed, different for each receiver.

    The offset (I, Q) has the size of `dc_offset` and a random direction; the gain is 1 + or - 0.6 to 1 times
    `gain_error`; the quadrature error is + or - 0.6 to 1 times its size, or exactly `quadrature_error_deg` where
    that is set.
    """
    draw = generator(simulation.seed, Draw.HARDWARE, receiver)
    direction = draw.uniform(0.0, 2.0 * np.pi)
    # never near zero: every receiver has something to correct
    share = draw.choice([-1.0, 1.0], 2) * draw.uniform(0.6, 1.0, 2)
    error = share[1] * simulation.size("quadrature_error")
    if simulation.quadrature_error_deg is not None:
        error = np.radians(simulation.quadrature_error_deg)
    return Mixer(
        gain=1.0 + float(share[0] * simulation.size("gain_error")),
        quadrature_error_rad=float(error),
        offset_i=float(simulation.size("dc_offset") * np.cos(direction)),
        offset_q=float(simulation.size("dc_offset") * np.sin(direction)),
    )


class Converter:
    """An ADC of `adc_bits` bits over +-range_v, its codes left-justified in int16.

    code = step round(volts / (step lsb)), lsb = range_v / 32768, step = 2^(16 - bits); what lies outside gives the end
    codes -32768 and 32767. Zero bits: no converter at all, volts stay volts.
    """

    def __init__(self, simulation: Simulation, daq: Daq) -> None:
        self._bits = simulation.adc_bits
        self._lsb_v = daq.range_v / _CODES

    def scaling(self, n_channels: int) -> tuple[tuple[float, ...], ...] | None:
        """Return the coefficients of volts = sum c_k code^k of each channel; None for volts."""
        return ((0.0, self._lsb_v),) * n_channels if self._bits else None

    def convert(self, volts: FloatArray) -> RawArray:
        """Return samples (n_channels, n): int16 codes, or the volts themselves."""
        if not self._bits:
            return volts
        step = float(2 ** (16 - self._bits))
        # a coarser converter leaves the low bits zero: its codes are left-justified
        codes = np.rint(volts / (self._lsb_v * step)) * step
        # beyond the range a converter stays at its end codes: by them clipping is known
        return np.clip(codes, -_CODES, _CODES - 1).astype(np.int16)


LENGTH_M = 0.12
"""Over which what the tracer adds changes: some fringes, so that it varies over a fall."""
_N_WAVES = 4
"""Plane waves of random direction that make a smooth field. Chosen by hand."""


class SmoothField:
    """A random function of position with root mean square 1, real or complex.

    The sum of four cosines whose wave vectors have a normal distribution of standard deviation 1 / 0.12 m: a draw
    from a Gaussian process with the kernel exp(-d^2 / (2 (0.12 m)^2)) in random Fourier features (Rahimi & Recht
    2007). The complex field gives each cosine a random direction in the IQ plane.
    """

    def __init__(self, generator: np.random.Generator) -> None:
        self._wave_vector = generator.normal(0.0, 1.0 / LENGTH_M, (_N_WAVES, 3))
        self._phase = generator.uniform(0.0, 2.0 * np.pi, _N_WAVES)
        self._direction = np.exp(1j * generator.uniform(0.0, 2.0 * np.pi, _N_WAVES))

    def real_at(self, position_m: FloatArray) -> FloatArray:
        """Return the real field at positions (3, n), shape (n,)."""
        return np.asarray(self._waves(position_m).sum(axis=0))

    def complex_at(self, position_m: FloatArray) -> ComplexArray:
        """Return the complex field at positions (3, n), shape (n,)."""
        return np.asarray(self._direction @ self._waves(position_m))

    def _waves(self, position_m: FloatArray) -> FloatArray:
        """Return the cosines at positions (3, n), each of mean square 1 / 4: shape (4, n)."""
        phase = self._wave_vector @ position_m + self._phase[:, None]
        return np.asarray(np.sqrt(2.0 / _N_WAVES) * np.cos(phase))


class TracerMismatch:
    """Amplitude and offset of one receiver as functions of position, the same in all runs of a session.

    Z -> Z exp(v f(p)) + b F(p): f and F are smooth fields of root mean square 1, v and b the sizes of
    `amplitude_variation` and `bias`; f is counted from the release, where the amplitude stays as it is.
    """

    def __init__(self, simulation: Simulation, receiver: int, release_m: FloatArray) -> None:
        self._variation = simulation.size("amplitude_variation")
        self._bias = simulation.size("bias")
        self._amplitude_field = SmoothField(generator(simulation.seed, Draw.AMPLITUDE, receiver))
        self._bias_field = SmoothField(generator(simulation.seed, Draw.BIAS, receiver))
        # counted from there, so that `amplitude_v` is the amplitude at the release
        self._at_release = self._amplitude_field.real_at(release_m[:, None])

    def applied(self, signal: ComplexArray, position_m: FloatArray) -> ComplexArray:
        """Return the signal (n,) with the mismatch of positions (3, n); in amplitudes."""
        if self._variation:
            field = self._amplitude_field.real_at(position_m) - self._at_release
            # an exponential stays positive: a negative amplitude would turn the phase
            signal = signal * np.exp(self._variation * field)
        if self._bias:
            signal = signal + self._bias * self._bias_field.complex_at(position_m)
        return signal
