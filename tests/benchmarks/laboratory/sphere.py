"""Scattering of a plane wave by a conducting sphere: Mie's series as two Legendre series in the cosine of the angle."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray
from scipy.special import spherical_jn, spherical_yn

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

_PARALLEL = 1e-9  # below this sine of the scattering angle any direction across serves: S1 = +-S2 there


def coefficients(size: float) -> tuple[Complex, Complex]:
    """Return a_n and b_n, n = 1, 2, ..., of a perfectly conducting sphere, time factor exp(-i w t).

    The tangential field vanishes on the surface: a_n = [x j_n]' / [x h_n]', b_n = j_n / h_n at x = K a
    (Bohren & Huffman 1983, section 4.3, limit m -> infinity).
    """
    order = np.arange(1, int(np.ceil(size + 4.05 * np.cbrt(size) + 6.0)) + 1)
    j, j_slope = (spherical_jn(order, size, derivative=d) for d in (False, True))
    y, y_slope = (spherical_yn(order, size, derivative=d) for d in (False, True))
    h, h_slope = j + 1j * y, j_slope + 1j * y_slope
    return (j + size * j_slope) / (h + size * h_slope), j / h


@dataclass(frozen=True)
class Sphere:
    """A conducting sphere in a medium: radius and the wavenumber K there."""

    radius_m: float
    wavenumber_rad_m: float

    @property
    def size(self) -> float:
        """Size parameter x = K a."""
        return self.wavenumber_rad_m * self.radius_m

    def amplitudes(self, cosine: Array) -> tuple[Complex, Complex]:
        """Return S1 and S2 at the cosines of scattering angles.

        With pi_n = P_n'(mu) and tau_n = mu P_n'(mu) - (1 - mu^2) P_n''(mu), the sums over n are derivatives of two
        Legendre series: no recurrence, and nothing is singular forward or backward.
        """
        a, b = coefficients(self.size)
        order = np.arange(1, a.size + 1)
        weight = (2.0 * order + 1.0) / (order * (order + 1.0))
        series = [np.concatenate([[0.0], weight * one]) for one in (a, b)]
        slopes = [legendre.legval(cosine, legendre.legder(one)) for one in series]
        bends = [legendre.legval(cosine, legendre.legder(one, 2)) for one in series]
        tau_a, tau_b = (cosine * s - (1.0 - cosine**2) * c for s, c in zip(slopes, bends, strict=True))
        return slopes[0] + tau_b, tau_a + slopes[1]

    def scattered(self, incoming: Array, field: Complex, outgoing: Array, receiving: Complex) -> Complex:
        """Return what a receiver gets of the wave that the sphere scatters, without the range to it, shape (n,).

        Parameters
        ----------
        incoming, outgoing
            Unit vectors of the way of the wave before and after the sphere, shape (3, n).
        field
            Electric field at the sphere, shape (3, n), across `incoming`.
        receiving
            Field that the receiver would send along `-outgoing` (reciprocity), shape (3, n), across it.
        """
        across = np.cross(incoming, outgoing, axis=0)
        sine = np.linalg.norm(across, axis=0)
        spare = np.cross(incoming, _least_along(incoming), axis=0)
        across = np.where(sine > _PARALLEL, across, spare)
        across = across / np.linalg.norm(across, axis=0)
        s1, s2 = self.amplitudes(np.einsum("in,in->n", incoming, outgoing))
        before, after = (np.cross(way, across, axis=0) for way in (incoming, outgoing))
        return s2 * _dot(before, field) * _dot(after, receiving) + s1 * _dot(across, field) * _dot(across, receiving)


def _dot(left: Array, right: Complex) -> Complex:
    return np.einsum("in,in->n", left, right)


def _least_along(direction: Array) -> Array:
    """Return the axis that lies least along each direction, shape (3, n)."""
    return np.eye(3)[np.argmin(np.abs(direction), axis=0)].T
