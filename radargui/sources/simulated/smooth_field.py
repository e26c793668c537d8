"""A smooth random field: a few waves of long wavelength, drawn from a seed."""

from __future__ import annotations

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.sources.simulated.arrays import ComplexArray, dot

LENGTH_M = 0.12
_N_WAVES = 4


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
        return _weighted(self._waves(position_m), np.ones(_N_WAVES))

    def complex_at(self, position_m: FloatArray) -> ComplexArray:
        """Return the complex field at positions (3, n), shape (n,)."""
        field = np.empty(position_m.shape[1], dtype=np.complex128)
        waves = self._waves(position_m)
        field.real = _weighted(waves, self._direction.real)
        field.imag = _weighted(waves, self._direction.imag)
        return field

    def _waves(self, position_m: FloatArray) -> list[FloatArray]:
        return [
            np.cos(dot(vector[:, None], position_m) + phase)
            for vector, phase in zip(self._wave_vector, self._phase, strict=True)
        ]


def _weighted(waves: list[FloatArray], weight: FloatArray) -> FloatArray:
    total = weight[0] * waves[0]
    for share, wave in zip(weight[1:], waves[1:], strict=True):
        total += share * wave
    return np.asarray(np.sqrt(2.0 / _N_WAVES) * total)
