"""Spherical waves from the transmitter to the tracer and on to a receiver, with range and lobe."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from radargui.model.arrays import ComplexArray, FloatArray
from radargui.sources.simulated.arrays import dot, phasor

SIDE_LOBE = 0.1
_HALF_POWER = np.sqrt(0.5)


@dataclass(frozen=True, slots=True)
class Lobe:
    """Pattern of an antenna, as amplitude against the angle from its axis.

    gain = s + (1 - s) exp(-k sin^2(angle / 2)): for small angles a Gaussian, half power (amplitude 0.71) at half
    the beam width, and never below s = 0.1 (-20 dB, where a real horn's side lobes begin), so that a sphere that
    leaves the main lobe is heard weakly instead of not at all.
    """

    falloff: float

    @classmethod
    def of_beamwidth(cls, beamwidth_deg: float) -> Lobe:
        """Return the lobe with this full width at half power."""
        level = np.log((1.0 - SIDE_LOBE) / (_HALF_POWER - SIDE_LOBE))
        return cls(float(level / np.sin(np.radians(beamwidth_deg) / 4.0) ** 2))

    def gain(self, cosine: FloatArray) -> FloatArray:
        """Return the amplitude gain at the cosine of an angle: sin^2(angle / 2) = (1 - cosine) / 2."""
        return np.asarray(SIDE_LOBE + (1.0 - SIDE_LOBE) * np.exp(0.5 * self.falloff * (cosine - 1.0)))


@dataclass(frozen=True, slots=True)
class Antenna:
    """An antenna, real or mirrored.

    Attributes
    ----------
    place_m
        Shape (3,).
    axis
        Unit vector of its lobe, shape (3,).
    lobe
        Its pattern.
    coefficient
        1 for the real one, the reflection coefficient for a mirrored one: beside the direct path the mirrored one of
        length r' has the amplitude |coefficient| (r / r') (ratio of the lobes' gains).
    """

    place_m: FloatArray
    axis: FloatArray
    lobe: Lobe
    coefficient: complex = 1.0

    def gain(self, position_m: FloatArray) -> FloatArray:
        """Return the gain of its lobe towards positions (3, n), shape (n,)."""
        away = position_m - self.place_m[:, None]
        return self.lobe.gain(dot(self.axis[:, None], away) / np.sqrt(dot(away, away)))

    def wave(self, position_m: FloatArray, wavelength_m: float) -> ComplexArray:
        """Return coefficient gain exp(j 2 pi r / wavelength) / r at positions (3, n), shape (n,)."""
        away = position_m - self.place_m[:, None]
        distance = np.sqrt(dot(away, away))
        amplitude = self.lobe.gain(dot(self.axis[:, None], away) / distance) / distance
        wave = phasor((2.0 * np.pi / wavelength_m) * distance, amplitude)
        return wave if self.coefficient == 1.0 else self.coefficient * wave


def aimed_antenna(place_m: FloatArray, lobe: Lobe) -> Antenna:
    """Return a real antenna that looks at the origin."""
    return Antenna(place_m, -place_m / np.linalg.norm(place_m), lobe)


class Waves:
    """Complex signal of each receiver for a tracer anywhere, before mixer and converter.

    Z_i = a (sum of waves of the transmitter and its images) (sum of waves of receiver i and its images): by image
    theory the product holds the direct path, one reflection on either leg, and one on both (coefficient squared).

    Parameters
    ----------
    transmitters
        The transmitter and its images.
    receivers
        For each receiver: itself and its images.
    wavelength_m
        Wavelength.
    reference_m
        Where the direct path has the amplitude 1, shape (3,).
    """

    def __init__(
        self,
        transmitters: tuple[Antenna, ...],
        receivers: tuple[tuple[Antenna, ...], ...],
        wavelength_m: float,
        reference_m: FloatArray,
    ) -> None:
        self._transmitters = transmitters
        self._receivers = receivers
        self._wavelength_m = wavelength_m
        place = reference_m[:, None]
        outward = abs(transmitters[0].wave(place, wavelength_m)[0])
        self._scale = [1.0 / (outward * abs(images[0].wave(place, wavelength_m)[0])) for images in receivers]

    def at_tracer(self, position_m: FloatArray) -> ComplexArray:
        """Return the transmitted field at positions (3, n), shape (n,)."""
        return _total(self._transmitters, position_m, self._wavelength_m)

    def received(self, receiver: int, position_m: FloatArray, at_tracer: ComplexArray) -> ComplexArray:
        """Return the signal of a receiver, shape (n,), from the field at the tracer; amplitude 1 at the reference."""
        return np.asarray(
            self._scale[receiver] * at_tracer * _total(self._receivers[receiver], position_m, self._wavelength_m)
        )


def _total(antennas: tuple[Antenna, ...], position_m: FloatArray, wavelength_m: float) -> ComplexArray:
    total = antennas[0].wave(position_m, wavelength_m)
    for antenna in antennas[1:]:
        total = total + antenna.wave(position_m, wavelength_m)
    return total
