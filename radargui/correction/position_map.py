"""Functions of position that carry slow mismatch: a Gaussian process reduced to its strongest functions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from radargui.model.arrays import FloatArray

_LARGEST_SUBSET = 90


@dataclass(frozen=True, slots=True)
class PositionBasis:
    """Functions f_k(x) with unit-variance coefficients whose sum has covariance exp(-|x - x'|^2 / 2 l^2).

    With the kernel matrix K_mm = U diag(w) U^T on a subset of the visited places, f(x) = K(x, m) U diag(w)^-1/2.

    Attributes
    ----------
    centre
        Subset of visited places, shape (n_dimensions, n_centres).
    mix
        Shape (n_centres, n_functions).
    length_m
        l.
    """

    centre: FloatArray
    mix: FloatArray
    length_m: float

    @property
    def size(self) -> int:
        """Number of functions."""
        return int(self.mix.shape[1])

    def __call__(self, place: FloatArray) -> FloatArray:
        """Return the functions at places (n_dimensions, n) as (n, n_functions)."""
        return np.asarray(_kernel(place, self.centre, self.length_m) @ self.mix)


def make_basis(visited: FloatArray, length_m: float, largest: int = 35) -> PositionBasis:
    """Return the strongest functions of a Gaussian process of length l over the visited places.

    Parameters
    ----------
    visited
        Shape (n_dimensions, n).
    length_m
        Correlation length l.
    largest
        At most this many functions; those below 1e-8 of the strongest are left out.
    """
    centre = farthest_points(visited, 0.15 * length_m)
    w, u = np.linalg.eigh(_kernel(centre, centre, length_m))
    strong = np.flatnonzero(w > 1e-8 * w[-1])[-largest:]
    return PositionBasis(centre, u[:, strong] / np.sqrt(w[strong]), length_m)


def farthest_points(place: FloatArray, spacing_m: float) -> FloatArray:
    """Return a subset of places (n_dimensions, n), each time the one farthest from those chosen."""
    thin = place[:, :: max(1, place.shape[1] // 3000)]
    chosen = [0]
    distance = np.linalg.norm(thin - thin[:, :1], axis=0)
    while len(chosen) < _LARGEST_SUBSET:
        farthest = int(np.argmax(distance))
        if distance[farthest] < spacing_m:
            break
        chosen.append(farthest)
        distance = np.minimum(distance, np.linalg.norm(thin - thin[:, farthest : farthest + 1], axis=0))
    return np.asarray(thin[:, chosen])


def _kernel(a: FloatArray, b: FloatArray, length_m: float) -> FloatArray:
    square = (a**2).sum(axis=0)[:, None] + (b**2).sum(axis=0)[None] - 2.0 * (a.T @ b)
    return np.asarray(np.exp(-np.maximum(square, 0.0) / (2.0 * length_m**2)))
