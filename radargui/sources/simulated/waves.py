"""Spherical waves from the transmitter to the tracer and on to a receiver, with range and lobe."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from radargui.model.arrays import ComplexArray, FloatArray
from radargui.model.scattering import ConductingSphere, scattered_field
from radargui.sources.simulated.arrays import dot, phasor

SIDE_LOBE = 0.1
"""Field far off the axis against that on it: -20 dB. Chosen by hand."""
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
    field
        Direction of the electric field that it sends or answers to, shape (3,); mirrored like a vector, the change of
        sign stays in `coefficient`. Only a metal sphere asks for it.
    """

    place_m: FloatArray
    axis: FloatArray
    lobe: Lobe
    coefficient: complex = 1.0
    field: FloatArray | None = None

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


def aimed_antenna(place_m: FloatArray, lobe: Lobe, field: FloatArray | None = None) -> Antenna:
    """Return a real antenna that looks at the origin."""
    return Antenna(place_m, -place_m / np.linalg.norm(place_m), lobe, field=field)


class Waves:
    """Complex signal of each receiver for a tracer anywhere, before mixer and converter.

    Z_i = a (sum of waves of the transmitter and its images) (sum of waves of receiver i and its images): by image
    theory the product holds the direct path, one reflection on either leg, and one on both (coefficient squared). A
    metal sphere gives each of these pairs a factor of its own, f = e_b . E(image a -> sphere -> image b) (Mie).

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
    sphere
        The metal sphere; None: a point, f = 1.
    """

    def __init__(
        self,
        transmitters: tuple[Antenna, ...],
        receivers: tuple[tuple[Antenna, ...], ...],
        wavelength_m: float,
        reference_m: FloatArray,
        sphere: ConductingSphere | None = None,
    ) -> None:
        self._transmitters = transmitters
        self._receivers = receivers
        self._wavelength_m = wavelength_m
        self._sphere = sphere
        place = reference_m[:, None]
        direct, n = [transmitters[0].wave(place, wavelength_m)], len(receivers)
        self._scale = [1.0] * n
        self._scale = [float(1.0 / abs(self.received(number, place, direct, 1)[0])) for number in range(n)]

    def at_tracer(self, position_m: FloatArray) -> list[ComplexArray]:
        """Return the waves of the transmitter and of its images at positions (3, n), shape (n,) each."""
        return [antenna.wave(position_m, self._wavelength_m) for antenna in self._transmitters]

    def received(
        self, receiver: int, position_m: FloatArray, at_tracer: list[ComplexArray], n_images: int | None = None
    ) -> ComplexArray:
        """Return the signal of a receiver, shape (n,), from the waves at the tracer; amplitude 1 at the reference.

        Of all pairs of images, of the transmitter's those whose waves are given, of the receiver's the first
        `n_images`, itself among them; None: all.
        """
        total: ComplexArray | float = 0.0
        for antenna in self._receivers[receiver][:n_images]:
            wave = antenna.wave(position_m, self._wavelength_m)
            if self._sphere is None or antenna.field is None:
                total = total + sum(at_tracer) * wave
                continue
            field: ComplexArray | float = 0.0
            for source, sent in zip(self._transmitters, at_tracer, strict=False):
                if source.field is not None:
                    here, there = source.place_m, antenna.place_m
                    field = field + sent * scattered_field(self._sphere, position_m, here, source.field, there)
            total = total + (antenna.field @ field) * wave
        return np.asarray(self._scale[receiver] * total)
