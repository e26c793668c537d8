"""Scattering of a plane wave by a sphere, conducting or dielectric: Mie's series as Legendre series in the cosine."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

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
    order = _orders(size)
    j, j_slope = (spherical_jn(order, size, derivative=d) for d in (False, True))
    y, y_slope = (spherical_yn(order, size, derivative=d) for d in (False, True))
    h, h_slope = j + 1j * y, j_slope + 1j * y_slope
    return (j + size * j_slope) / (h + size * h_slope), j / h


def dielectric_coefficients(size: float, index: complex) -> tuple[Complex, Complex]:
    """Return a_n and b_n of a sphere of relative refractive index m (Bohren & Huffman 1983, eq. 4.53).

    a_n = (m psi_n(m x) psi_n'(x) - psi_n(x) psi_n'(m x)) / (m psi_n(m x) xi_n'(x) - xi_n(x) psi_n'(m x)), and b_n with
    m at the other products; psi_n = x j_n, xi_n = x h_n.
    """
    order = _orders(size)
    outside = size * spherical_jn(order, size)
    outside_slope = spherical_jn(order, size) + size * spherical_jn(order, size, derivative=True)
    sent = outside + 1j * size * spherical_yn(order, size)
    sent_slope = outside_slope + 1j * (
        spherical_yn(order, size) + size * spherical_yn(order, size, derivative=True)
    )  # fmt: skip
    within = index * size
    inside = within * spherical_jn(order, within)
    inside_slope = spherical_jn(order, within) + within * spherical_jn(order, within, derivative=True)
    a = (index * inside * outside_slope - outside * inside_slope) / (index * inside * sent_slope - sent * inside_slope)
    b = (inside * outside_slope - index * outside * inside_slope) / (inside * sent_slope - index * sent * inside_slope)
    return a, b


def _orders(size: float) -> NDArray[np.int64]:
    return np.arange(1, int(np.ceil(size + 4.05 * np.cbrt(size) + 6.0)) + 1)


@dataclass(frozen=True)
class Sphere:
    """A sphere in a medium: radius, the wavenumber K there and the refractive index, None of a conductor."""

    radius_m: float
    wavenumber_rad_m: float
    index: complex | None = None

    @property
    def size(self) -> float:
        """Size parameter x = K a."""
        return self.wavenumber_rad_m * self.radius_m

    def series(self) -> tuple[Complex, Complex]:
        """Return a_n and b_n, n = 1, 2, ..."""
        return coefficients(self.size) if self.index is None else dielectric_coefficients(self.size, self.index)

    def amplitudes(self, cosine: Array) -> tuple[Complex, Complex]:
        """Return S1 and S2 at the cosines of scattering angles.

        With pi_n = P_n'(mu) and tau_n = mu P_n'(mu) - (1 - mu^2) P_n''(mu), the sums over n are derivatives of two
        Legendre series: no recurrence, and nothing is singular forward or backward.
        """
        slope_a, slope_b, bend_a, bend_b = legendre.legval(cosine, self._derivatives)
        tau_a, tau_b = (cosine * s - (1.0 - cosine**2) * c for s, c in ((slope_a, bend_a), (slope_b, bend_b)))
        return slope_a + tau_b, tau_a + slope_b

    @cached_property
    def _derivatives(self) -> Complex:
        """First derivatives of the Legendre series of a and of b, then the second ones, shape (n, 4)."""
        a, b = self.series()
        order = np.arange(1, a.size + 1)
        weight = (2.0 * order + 1.0) / (order * (order + 1.0))
        series = np.zeros((a.size + 1, 2), complex)
        series[1:] = weight[:, None] * np.stack([a, b], axis=1)
        slopes = legendre.legder(series)
        bends = legendre.legder(series, 2)
        return np.concatenate([slopes, np.pad(bends, ((0, 1), (0, 0)))], axis=1)

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
        return _dot(self.field(incoming, field, outgoing), receiving)

    def field(self, incoming: Array, field: Complex, outgoing: Array) -> Complex:
        """Return the field (3, n) that the sphere scatters, but for i exp(i K r) / (K r) (Bohren & Huffman, eq. 3.12).

        S2 goes with the parts in the plane of scattering, S1 with those across it.
        """
        across = _cross(incoming, outgoing)
        sine = np.linalg.norm(across, axis=0)
        spare = _cross(incoming, _min_along(incoming))
        across = np.where(sine > _PARALLEL, across, spare)
        across = across / np.linalg.norm(across, axis=0)
        s1, s2 = self.amplitudes(np.einsum("in,in->n", incoming, outgoing))
        before, after = (_cross(way, across) for way in (incoming, outgoing))
        return s2 * _dot(before, field) * after + s1 * _dot(across, field) * across


def _cross(left: Array, right: Array) -> Array:
    """Return the cross product of vectors (3, n); numpy's moves axes about for longer than few of them take."""
    (a, b, c), (x, y, z) = left, right
    return np.stack([b * z - c * y, c * x - a * z, a * y - b * x])


def _dot(left: Complex, right: Complex) -> Complex:
    return np.einsum("in,in->n", left, right)


def _min_along(direction: Array) -> Array:
    """Return the axis that lies least along each direction, shape (3, n)."""
    return np.eye(3)[np.argmin(np.abs(direction), axis=0)].T
