"""Functions of position that carry slow mismatch: a Gaussian process's strongest functions (method 4, Maps)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from radargui.model.arrays import FloatArray


@dataclass(frozen=True, slots=True)
class MapSettings:
    """How a Gaussian process is reduced.

    Attributes
    ----------
    max_functions
        Columns of the normal matrix that a map costs at most. Chosen by hand.
    weakest
        Functions below this share of the strongest eigenvalue are left out: rounding.
    spacing
        Distance of the subset's places in units of l: farther apart the remainder is a few parts in a hundred, and
        mirrors are bent to explain it (accuracy benchmark).
    max_places
        Of the subset: its kernel matrix is diagonalised, cost cubic. Chosen by hand.
    """

    max_functions: int = 35
    weakest: float = 1e-8
    spacing: float = 0.15
    max_places: int = 90


MAPS = MapSettings()
FINE = MapSettings(weakest=3e-7, spacing=0.05, max_places=150)
"""For the chosen model: the subset's remainder, one or two per cent of a map's deviation, is a tenth of that with as
many functions, so that the result does not hang on the motion from which the subset was taken (decision 42)."""


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


def make_basis(visited: FloatArray, length_m: float, settings: MapSettings = MAPS) -> PositionBasis:
    """Return the strongest functions of a Gaussian process of length l over the visited places.

    Parameters
    ----------
    visited
        Shape (n_dimensions, n).
    length_m
        Correlation length l.
    settings
        How many functions.
    """
    # a kernel on all places is singular: a subset that leaves no hole carries the same functions
    centre = farthest_points(visited, settings.spacing * length_m, settings.max_places)
    w, u = np.linalg.eigh(_kernel(centre, centre, length_m))
    # eigenvalues fall fast for a smooth kernel: what is left out no data could determine
    strong = np.flatnonzero(w > settings.weakest * w[-1])[-settings.max_functions :]
    return PositionBasis(centre, u[:, strong] / np.sqrt(w[strong]), length_m)


def farthest_points(place: FloatArray, spacing_m: float, most: int) -> FloatArray:
    """Return at most `most` of the places (n_dimensions, n), each time the one farthest from those chosen."""
    # neighbours in time are neighbours in space
    thin = place[:, :: max(1, place.shape[1] // 3000)]
    chosen = [0]
    x, y = thin, np.square(thin).sum(axis=0)
    distance = y - 2.0 * (x[:, 0] @ x) + y[0]
    while len(chosen) < most:
        farthest = int(np.argmax(distance))
        if distance[farthest] < spacing_m**2:
            break
        chosen.append(farthest)
        np.minimum(distance, y - 2.0 * (x[:, farthest] @ x) + y[farthest], out=distance)
    return np.asarray(thin[:, chosen])


def _kernel(a: FloatArray, b: FloatArray, length_m: float) -> FloatArray:
    # exponent a.b - |a|^2 / 2 - |b|^2 / 2 in units of l, by one product; rounding may make it positive
    a, b = a / length_m, b / length_m
    of_a, of_b = -0.5 * np.square(a).sum(axis=0), -0.5 * np.square(b).sum(axis=0)
    out = np.vstack([a, of_a, np.ones_like(of_a)]).T @ np.vstack([b, np.ones_like(of_b), of_b])
    return np.asarray(np.exp(np.minimum(out, 0.0, out=out), out=out))
