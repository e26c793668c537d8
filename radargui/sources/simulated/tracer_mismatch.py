"""Mismatch that moves with the tracer: an amplitude and an offset that vary smoothly with its position."""

import numpy as np

from radargui.model.arrays import ComplexArray, FloatArray
from radargui.model.simulation import Simulation
from radargui.sources.simulated.seeds import Draw, generator

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
        self._at_release = self._amplitude_field.real_at(release_m[:, None])

    def applied(self, signal: ComplexArray, position_m: FloatArray) -> ComplexArray:
        """Return the signal (n,) with the mismatch of positions (3, n); in amplitudes."""
        if self._variation:
            field = self._amplitude_field.real_at(position_m) - self._at_release
            signal = signal * np.exp(self._variation * field)
        if self._bias:
            signal = signal + self._bias * self._bias_field.complex_at(position_m)
        return signal
