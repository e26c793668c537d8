"""The hardware, constant for a session: mixers with offset, gain ratio and quadrature error, and the converter."""

from dataclasses import dataclass

import numpy as np

from radargui.model.arrays import ComplexArray, FloatArray, RawArray
from radargui.model.daq import Daq
from radargui.model.front_end_equations import channels_of
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
        q = channels_of(signal, signal, self.gain, self.quadrature_error_rad)[1]
        return np.asarray(q + self.offset_q)


def make_mixer(simulation: Simulation, receiver: int) -> Mixer:
    """Return the mixer of a receiver: the same for all runs with one seed, different for each receiver.

    The offset (I, Q) has the size of `dc_offset` and a random direction; the gain is 1 + or - 0.6 to 1 times
    `gain_error`; the quadrature error is + or - 0.6 to 1 times its size, or exactly `quadrature_error_deg` where
    that is set.
    """
    draw = generator(simulation.seed, Draw.HARDWARE, receiver)
    direction = draw.uniform(0.0, 2.0 * np.pi)
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
        codes = np.rint(volts / (self._lsb_v * step)) * step
        return np.clip(codes, -_CODES, _CODES - 1).astype(np.int16)
