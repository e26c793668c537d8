"""The waves that a sphere and a reflecting plane send to and fro: the sphere and its image as two coupled bodies.

Vector spherical waves about the sphere's centre, z along the plane's normal, time factor exp(-i w t), with orthonormal
harmonics B = r grad Y / s, C = curl(r Y) / s, s = sqrt(l (l + 1)): M = z_l(k r) C, N = curl M / k. A field is a vector
of coefficients, those of M first; the sphere multiplies them by T = -(b_l, a_l) of Mie's series, the plane returns the
scattered wave as one that its image sends, and a translation along z expands that about the sphere again:

    c = T (a + R A(2h) P c),   so   c = (1 - R T A P)^-1 T a,   one system for each order m

(Kristensson, Scattering of Electromagnetic Waves by Obstacles, 2016, ch. 7 to 9, gives waves and translations).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from benchmarks.world.layers import Reflections, reaction
from numpy.typing import NDArray
from scipy.interpolate import make_interp_spline
from scipy.special import sph_legendre_p_all, spherical_jn, spherical_yn

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

ORDERS = 8
"""Of the spherical waves: two more change the echo by less than 1e-3 of itself even where the sphere touches."""
_MIN_SINE = 1e-7
_NEAR_M, _NEAR_STEP_M, _STEP_M = 5e-3, 1e-4, 5e-4
"""The matrices are tabulated in the gap: between sphere and plane they turn by 0.2 rad a step, near it by less."""


@dataclass(frozen=True)
class Waves:
    """Coefficients (orders + 1, 2 orders + 1, n) of spherical waves M and N; index [l, m], negative m from the end."""

    m: Complex
    n: Complex


def sum_of(waves: Iterable[Waves]) -> Waves:
    """Return the sum of fields."""
    parts = list(waves)
    return Waves(np.sum([one.m for one in parts], axis=0), np.sum([one.n for one in parts], axis=0))


def incident(direction: Array, field: Complex, orders: int = ORDERS) -> Waves:
    """Return plane waves along unit vectors (3, n) with fields (3, n) at the centre as regular waves about it.

    4 pi i^l C*_lm . E and 4 pi i^(l - 1) B*_lm . E (Kristensson, eq. 7.28).
    """
    c, b = _harmonics(direction, field.conj(), orders)
    turn = 4.0 * np.pi * 1j ** np.arange(orders + 1)[:, None, None]
    return Waves(turn * c.conj(), -1j * turn * b.conj())


def radiated(direction: Array, receiving: Complex, orders: int = ORDERS) -> Waves:
    """Return what unit coefficients of outgoing waves give a receiver along unit vectors (3, n).

    The far field without i exp(i k r) / (k r): -i (-i)^(l + 1) C_lm and -i (-i)^l B_lm, times the receiver's field.
    """
    c, b = _harmonics(direction, receiving, orders)
    turn = (-1j) ** np.arange(orders + 1)[:, None, None]
    return Waves(-turn * c, -1j * turn * b)


def _harmonics(direction: Array, field: Complex, orders: int) -> tuple[Complex, Complex]:
    """Return C_lm . field and B_lm . field, shape (orders + 1, 2 orders + 1, n) each."""
    theta = np.arccos(np.clip(direction[2], -1.0, 1.0))
    # straight up and down m P / sin(theta) is a limit
    theta = np.clip(theta, _MIN_SINE, np.pi - _MIN_SINE)
    phi = np.arctan2(direction[1], direction[0])
    sine, cosine = np.sin(theta), np.cos(theta)
    along = field[0] * cosine * np.cos(phi) + field[1] * cosine * np.sin(phi) - field[2] * sine
    around = field[1] * np.cos(phi) - field[0] * np.sin(phi)
    order, degree = np.arange(orders + 1)[:, None, None], _degrees(orders)[:, None]
    legendre, slope = sph_legendre_p_all(orders, orders, theta, diff_n=1)
    size = 1.0 / np.sqrt(np.maximum(order * (order + 1.0), 1.0))
    turn = np.exp(1j * degree * phi)
    across, slope = 1j * degree / sine * legendre * size * turn, slope * size * turn
    return across * along - slope * around, slope * along + across * around


def _degrees(orders: int) -> NDArray[np.int64]:
    return np.concatenate([np.arange(orders + 1), np.arange(-orders, 0)])


class Exchange:
    """What a sphere sends beyond its own scattering, over a plane that returns a share of the field.

    Parameters
    ----------
    size
        K a of the sphere.
    series
        Mie's a_n and b_n, n = 1, 2, ...
    reflection
        R: 1 of a conductor; one number for all angles, which a dielectric has only about.
    wavenumber_rad_m, highest_m
        K, and the largest gap that will be asked for.
    orders
        Of the waves.
    layers
        R_TE and R_TM of a plate at cosines, which then stand for the one number.
    """

    def __init__(
        self, radius_m: float, series: tuple[Complex, Complex], reflection: complex, wavenumber_rad_m: float,
        highest_m: float, orders: int = ORDERS, layers: Reflections | None = None,
    ) -> None:  # fmt: skip
        self.orders = orders
        far = np.arange(_NEAR_M, highest_m + 4.0 * _STEP_M, _STEP_M)
        self._gaps_m = np.concatenate([np.arange(0.0, _NEAR_M, _NEAR_STEP_M), far])
        a, b = (np.pad(one, (0, orders))[:orders] for one in series)
        heights = wavenumber_rad_m * (self._gaps_m + radius_m)
        self._tables = [
            make_interp_spline(self._gaps_m, _coupled(heights, -b, -a, reflection, m, layers))
            for m in range(orders + 1)
        ]

    def received(self, gap_m: Array, arriving: Waves, leaving: list[Waves]) -> Complex:
        """Return what the exchange adds to each receiver's signal, shape (n_receivers, n), at gaps (n,).

        `arriving` is all that meets the sphere but for the exchange, `leaving` what each receiver gets of unit waves by
        all ways together.
        """
        out = np.zeros((len(leaving), gap_m.size), complex)
        for m, table in enumerate(self._tables):
            first = max(m, 1)
            matrix = table(np.maximum(gap_m, 0.0))
            for degree in {m, -m}:
                sent, *seen = (
                    np.concatenate([one.m[first:, degree], np.copysign(1.0, degree or 1) * one.n[first:, degree]])
                    for one in (arriving, *leaving)
                )
                scattered = np.einsum("nij,jn->in", matrix, sent)
                out += [np.einsum("in,in->n", one, scattered) for one in seen]
        return out


def _coupled(
    heights: Array, t_m: Complex, t_n: Complex, reflection: complex, m: int, layers: Reflections | None
) -> Complex:
    """Return (1 - R T A P)^-1 T - T at heights K h of the centre, shape (n, 2 k, 2 k), for orders l >= max(m, 1).

    Of -m the parts between M and N have the other sign.
    """
    orders = t_m.size
    order = np.arange(max(m, 1), orders + 1)
    # T^(1/2) on both sides: by themselves high orders are tiny in T and huge in A
    root = np.sqrt(np.concatenate([t_m[order - 1], t_n[order - 1]]))
    parity = (-1.0) ** (order + m)
    if layers is None:
        returned = reflection * translation(heights, m, orders) * np.concatenate([parity, -parity])
    else:
        returned = reaction(heights, m, orders, layers)
    loop = root[:, None] * returned * root
    return root[:, None] * np.linalg.solve(np.eye(root.size) - loop, loop) * root


def translation(heights: Array, m: int, orders: int) -> Complex:
    """Return the coefficients (n, 2 k, 2 k) of outgoing waves of the image, 2 h below, as regular ones.

    The radial parts of a wave and of its curl about the other centre tell them: with psi = h_l Y_lm about the image,
    d = -2 h and s S psi' = sum of psi, r . M = -i m d psi / s and r . curl M = s psi + K d (curl M)_z, whose z part is
    a sum of psi of the orders l - 1 and l + 1.
    """
    order = np.arange(max(m, 1), orders + 1)
    scalar = _scalar_translation(heights, m, orders)
    size = np.sqrt(order * (order + 1.0))
    lower, upper = (np.sqrt((n**2 - m**2) / (4.0 * n**2 - 1.0)) for n in (order, order + 1.0))
    down = -2.0 * heights[:, None, None]
    at = scalar[:, order][:, :, order]
    beside = scalar[:, order][:, :, order + 1] * (order * upper / size) + scalar[:, order][:, :, order - 1] * (
        (order + 1.0) * lower / size
    )
    same = (at * size + down * beside) / size[:, None]
    other = -1j * m * down * at / (size * size[:, None])
    return np.block([[same, other], [other, same]])


def _scalar_translation(heights: Array, m: int, orders: int) -> Complex:
    """Return S (n, orders + 1, orders + 2): h_l Y_lm about a centre 2 h below is the sum over v of S_vl j_v Y_vm.

    S_vl = sum over p of i^(v - l + p) (2 p + 1) h_p(2 K h) times the integral of Y_lm Y*_vm P_p.
    """
    node, weight = np.polynomial.legendre.leggauss(2 * orders + 4)
    harmonic = sph_legendre_p_all(orders + 1, max(m, 1), np.arccos(node))[0][:, m]
    p = np.arange(2 * orders + 2)
    polynomial = np.polynomial.legendre.legvander(node, p[-1])
    gaunt = 2.0 * np.pi * np.einsum("vg,lg,gp,g->vlp", harmonic[:-1], harmonic, polynomial, weight)
    v, order = np.arange(orders + 1)[:, None, None], np.arange(orders + 2)[:, None]
    # the rest of the integrals is zero, and rounding would meet h_p beyond all bounds
    there = (p >= abs(v - order)) & (p <= v + order) & ((v + order + p) % 2 == 0)
    gaunt = np.where(there, gaunt, 0.0) * (2.0 * p + 1.0) * 1j ** ((v - order + p) % 4)
    argument = 2.0 * heights[:, None]
    return np.tensordot(spherical_jn(p, argument) + 1j * spherical_yn(p, argument), gaunt, axes=(1, 2))
