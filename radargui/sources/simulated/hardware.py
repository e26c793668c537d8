"""The receivers' hardware: offset, gain ratio and quadrature error, constant for a session."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.model.simulation import Simulation
from radargui.sources.simulated.arrays import ComplexArray
from radargui.sources.simulated.seeds import Stream, generator


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
        if self.quadrature_error_rad == 0.0:
            return np.asarray(self.gain * signal.imag + self.offset_q)
        in_phase = self.gain * np.sin(self.quadrature_error_rad)
        quadrature = self.gain * np.cos(self.quadrature_error_rad)
        return np.asarray(in_phase * signal.real + quadrature * signal.imag + self.offset_q)


def make_mixer(simulation: Simulation, receiver: int) -> Mixer:
    """Return the mixer of a receiver: the same for all runs with one seed, different for each receiver.

    The offset (I, Q) has the size of `dc_offset` and a random direction; the gain is 1 + or - 0.6 to 1 times
    `gain_error`; the quadrature error is + or - 0.6 to 1 times its size, or exactly `quadrature_error_deg` where
    that is set.
    """
    draw = generator(simulation.seed, Stream.HARDWARE, receiver)
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
