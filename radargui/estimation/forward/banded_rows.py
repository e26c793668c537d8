"""Rows of four neighbouring coefficients each: what splines, their slopes and the equation of motion are of.

Method 4, Motion.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import csr_matrix

from radargui.model.arrays import BoolArray, FloatArray, IntArray


@dataclass(frozen=True)
class BandedRows:
    """Rows R of which each touches four neighbours of the coefficients (release, c_0, c_1, ...); the release is zero.

    Attributes
    ----------
    value
        Shape (n_rows, 4).
    first
        Which of (release, c_0, ...) comes first, shape (n_rows,).
    size
        Number of coefficients without the release.
    """

    value: FloatArray
    first: IntArray
    size: int

    @cached_property
    def matrix(self) -> csr_matrix:
        """The rows as a matrix, shape (n_rows, size)."""
        column = self.first[:, None] + np.arange(-1, 3)
        kept = column >= 0
        pointer = np.concatenate([[0], np.cumsum(kept.sum(axis=1))])
        return csr_matrix((self.value[kept], column[kept], pointer), shape=(self.first.size, self.size))

    @cached_property
    def of_place(self) -> csr_matrix:
        """The rows as a matrix that acts on x, y and z alike, interleaved, shape (3 n_rows, 3 size)."""
        column = self.first[:, None, None] + np.arange(-1, 3)
        kept = np.broadcast_to(column >= 0, (self.first.size, 3, 4))
        column, value = 3 * column + np.arange(3)[:, None], np.broadcast_to(self.value[:, None], kept.shape)
        pointer = np.concatenate([[0], np.cumsum(kept.sum(axis=2))])
        return csr_matrix((value[kept], column[kept], pointer), shape=(3 * self.first.size, 3 * self.size))

    def __matmul__(self, coefficients: FloatArray) -> FloatArray:
        """Return R c for coefficients (size, ...), shape (n_rows, ...)."""
        padded = np.concatenate([np.zeros_like(coefficients[:1]), coefficients])
        value = self.value.reshape(*self.value.shape, *(1,) * (coefficients.ndim - 1))
        out = value[:, 0] * padded[self.first]
        for k in range(1, 4):
            out += value[:, k] * padded[self.first + k]
        return np.asarray(out)

    def transposed(self, right: FloatArray) -> FloatArray:
        """Return R^T right for (n_rows, n), shape (size, n)."""
        n = right.shape[1]
        # a matrix of its own, built for each step, costs five times as much
        place = (self.first[:, None, None] + np.arange(4)[:, None]) * n + np.arange(n)
        products = self.value[:, :, None] * right[:, None]
        total = np.bincount(place.ravel(), weights=products.ravel(), minlength=(self.size + 1) * n)
        return np.asarray(total.reshape(-1, n)[1:])

    def __getitem__(self, rows: slice | IntArray | BoolArray) -> BandedRows:
        """Return some of the rows."""
        return BandedRows(self.value[rows], self.first[rows], self.size)

    def above(self, other: BandedRows) -> BandedRows:
        """Return these rows and then those of another."""
        return BandedRows(
            np.concatenate([self.value, other.value]), np.concatenate([self.first, other.first]), self.size
        )

    def gram(self, weight: FloatArray) -> FloatArray:
        """Return the diagonals (j, j + d) of R^T diag(weight) R, the release at their head, shape (4, size + 1)."""
        # cubic functions more than three apart share no span: four diagonals hold all
        out = np.zeros((4, self.size + 1))
        for k in range(4):
            for other in range(k, 4):
                products = weight * self.value[:, k] * self.value[:, other]
                out[other - k] += np.bincount(self.first + k, weights=products, minlength=self.size + 1)
        return out
