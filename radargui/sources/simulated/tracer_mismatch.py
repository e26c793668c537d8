"""Mismatch that moves with the tracer: an amplitude and an offset that vary smoothly with its position."""

from __future__ import annotations

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.model.simulation import Simulation
from radargui.sources.simulated.arrays import ComplexArray
from radargui.sources.simulated.seeds import Stream, generator
from radargui.sources.simulated.smooth_field import SmoothField


class TracerMismatch:
    """Amplitude and offset of one receiver as functions of position, the same in all runs of a session.

    Z -> Z exp(v f(p)) + b F(p): f and F are smooth fields of root mean square 1, v and b the sizes of
    `amplitude_variation` and `bias`; f is counted from the release, where the amplitude stays as it is.
    """

    def __init__(self, simulation: Simulation, receiver: int, release_m: FloatArray) -> None:
        self._variation = simulation.size("amplitude_variation")
        self._bias = simulation.size("bias")
        self._amplitude_field = SmoothField(generator(simulation.seed, Stream.AMPLITUDE, receiver))
        self._bias_field = SmoothField(generator(simulation.seed, Stream.BIAS, receiver))
        self._at_release = self._amplitude_field.real_at(release_m[:, None])

    def applied(self, signal: ComplexArray, position_m: FloatArray) -> ComplexArray:
        """Return the signal (n,) with the mismatch of positions (3, n); in amplitudes."""
        if self._variation:
            field = self._amplitude_field.real_at(position_m) - self._at_release
            signal = signal * np.exp(self._variation * field)
        if self._bias:
            signal = signal + self._bias * self._bias_field.complex_at(position_m)
        return signal
