"""What a plate returns of a sphere's outgoing vector waves: plane waves of every direction, each with its own R.

Waves, coefficients and their order are those of `exchange`. The expansions of outgoing waves in plane ones and of plane
waves in regular ones are those of Egel et al. 2021 (https://doi.org/10.1016/j.jqsrt.2021.107846).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Reflections = Callable[[Complex], tuple[Complex, Complex]]
"""R_TE and R_TM of a conductor's image, 1 and 1 of a conductor itself, at complex cosines."""

_NODES, _FARTHEST = 240, 60.0
"""Of the contour, and of i times the cosine at its end: exp(-2 K h 60) is nothing even where a small sphere touches."""


def reaction(heights: Array, m: int, orders: int, reflections: Reflections) -> Complex:
    """Return the regular waves (n, 2 k, 2 k) about the sphere, K h over a plate, that outgoing ones come back as.

    An outgoing wave below its source is i^-l / 2 pi times the integral of C_lm (of M) or i B_lm (of N) exp(i k r) over
    directions down, with cosines c from one to zero and on to i times infinity; the plate gives each part R_TM and
    R_TE of the mirrored field and exp(2 i K h c). The contour passes through the first quadrant: guided waves of a
    plate are poles beside the imaginary axis, beyond it.
    """
    node, weight = np.polynomial.legendre.leggauss(_NODES)
    # a parabola from one to the imaginary axis far up, with most of its nodes near its beginning
    way = 0.5 * (1.0 + node)
    c = (1.0 - way) ** 2 + 1j * _FARTHEST * way**3
    step = (2.0 * (1.0 - way) - 3j * _FARTHEST * way**2) * 0.5 * weight
    pi, tau = _angular(c, m, orders)
    r_te, r_tm = reflections(c)
    order = np.arange(max(m, 1), orders + 1)
    parity = (-1.0) ** (order + m)
    # theta and phi parts of what goes down, M before N: pi and tau at the mirrored direction
    theta = np.concatenate([1j * parity[:, None] * pi, -1j * parity[:, None] * tau])
    phi = np.concatenate([parity[:, None] * tau, -parity[:, None] * pi])
    of_theta = np.concatenate([-1j * pi, -1j * tau])
    of_phi = np.concatenate([tau, pi])
    turn = np.tile(1j**order, 2)
    kernel = np.einsum("ag,bg,g->gab", of_theta, theta, r_tm * step)
    kernel += np.einsum("ag,bg,g->gab", of_phi, phi, r_te * step)
    waves = np.exp(2j * np.outer(heights, c)) @ kernel.reshape(c.size, -1)
    return 4.0 * np.pi * turn[:, None] * waves.reshape(heights.size, turn.size, turn.size) / turn


def _angular(c: Complex, m: int, orders: int) -> tuple[Complex, Complex]:
    """Return m P / sin and dP / d angle over sqrt(l (l + 1)), shape (k, n), at complex cosines; P orthonormal."""
    sine = np.sqrt(1.0 - c**2)
    legendre = np.zeros((orders + 1, c.size), complex)
    first = np.full(c.shape, np.sqrt(0.25 / np.pi), complex)
    for one in range(1, m + 1):
        first = -np.sqrt(1.0 + 0.5 / one) * sine * first
    legendre[m] = first
    for order in range(m + 1, orders + 1):
        below = legendre[order - 2] / _ratio(order - 1, m) if order > m + 1 else 0.0
        legendre[order] = _ratio(order, m) * (c * legendre[order - 1] - below)
    pi, tau = [], []
    for order in range(max(m, 1), orders + 1):
        size = np.sqrt(order * (order + 1.0))
        down = np.sqrt((2.0 * order + 1.0) / (2.0 * order - 1.0) * (order**2 - m**2)) * legendre[order - 1]
        pi.append(m * legendre[order] / sine / size)
        tau.append((order * c * legendre[order] - down) / sine / size)
    return np.array(pi), np.array(tau)


def _ratio(order: int, m: int) -> float:
    return float(np.sqrt((4.0 * order**2 - 1.0) / (order**2 - m**2)))
