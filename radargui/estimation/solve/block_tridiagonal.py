"""A band factored in blocks: Cholesky factor, half solves, and the inverse near its diagonal (method 4, Minimum)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.linalg.blas import dtrsm
from scipy.linalg.lapack import dpbtrf, dtbtrs
from scipy.sparse import csr_matrix

from radargui.model.arrays import FloatArray, IntArray

# A bin meets four neighbouring coefficients: bandwidth 3 x 3 + 2 = 11. Any block above 11 is right; 24 by hand: smaller
# ones cost calls, larger ones arithmetic.
_BLOCK = 24
_FEW = 12  # columns: as many as 16 cost the same one by one, at any size


def padded_size(size: int) -> int:
    """Return how many rows whole blocks have that hold `size`."""
    return -(-size // _BLOCK) * _BLOCK


def lower_band(matrix: csr_matrix) -> FloatArray:
    """Return the diagonals of a symmetric matrix (n, n) from the main one down, (d, j) for row j + d, shape (m, n)."""
    entries = matrix.tocoo()
    below = entries.row - entries.col
    out = np.zeros((int(below.max(initial=0)) + 1, matrix.shape[0]))
    kept = below >= 0
    out[below[kept], entries.col[kept]] = entries.data[kept]
    return out


class BlockTridiagonal:
    """Cholesky factor of a symmetric banded matrix, in blocks of 24; cost linear in its size.

    S = L L^T with diagonal blocks L_k and blocks W_k = L_{k+1,k} below them.

    Parameters
    ----------
    band
        Of S, positive definite, bandwidth below 24, as `lower_band` gives it.

    Raises
    ------
    LinAlgError
        It is not positive definite.
    """

    def __init__(self, band: FloatArray) -> None:
        width, self.size = band.shape
        self.count = padded_size(self.size) // _BLOCK
        factor, bad = dpbtrf(band, lower=1) if self.size else (band, 0)
        if bad:
            raise np.linalg.LinAlgError(f"leading minor {bad}")
        self._band = factor
        padded = np.zeros((width, self.count * _BLOCK))
        # ones on the diagonal of what is padded: it stays by itself
        padded[0] = 1.0
        padded[:, : self.size] = factor
        self.lower, self.below = (
            _blocks(padded, count, shift) for count, shift in ((self.count, 0), (self.count - 1, _BLOCK))
        )

    def half_solve(self, right: FloatArray) -> FloatArray:
        """Return L^-1 right for (n, m), padded to whole blocks."""
        out = np.zeros((self.count * _BLOCK, right.shape[1]))
        out[: self.size] = right
        self.half_solve_padded(out)
        return out

    def half_solve_padded(self, right: FloatArray) -> None:
        """Put L^-1 right in place of `right`, padded to whole blocks, whose rows must lie one after the other."""
        if self._are_few(right):
            right[: self.size] = dtbtrs(self._band, right[: self.size], uplo="L")[0]
            return
        blocks = right.reshape(self.count, _BLOCK, right.shape[1])
        for k in range(self.count):
            if k:
                blocks[k] -= self.below[k - 1] @ blocks[k - 1]
            _lower_solve(self.lower[k], blocks[k])

    def back_solve(self, half: FloatArray) -> FloatArray:
        """Return L^-T half, shape (n, m)."""
        out = half.copy()
        self.back_solve_padded(out)
        return out[: self.size]

    def back_solve_padded(self, half: FloatArray) -> None:
        """Put L^-T half in place of `half`, whose rows must lie one after the other."""
        if self._are_few(half):
            half[: self.size] = dtbtrs(self._band, half[: self.size], uplo="L", trans="T")[0]
            return
        blocks = half.reshape(self.count, _BLOCK, half.shape[1])
        for k in range(self.count - 1, -1, -1):
            if k + 1 < self.count:
                blocks[k] -= self.below[k].T @ blocks[k + 1]
            _lower_solve(self.lower[k], blocks[k], transposed=True)

    def _are_few(self, right: FloatArray) -> bool:
        """Whether columns one by one cost less than calls for each block."""
        return bool(self.size > 0 and right.shape[1] <= _FEW)

    def log_determinant(self) -> float:
        """Return ln det S."""
        return float(2.0 * np.log(np.diagonal(self.lower, axis1=1, axis2=2)).sum())

    def selected_inverse(self, together: int = 3) -> SelectedInverse:
        """Return the blocks of S^-1 on and beside the diagonal (Takahashi's recursion), some unknowns together."""
        n = self.count
        on, beside = np.empty_like(self.lower), np.empty_like(self.below)
        identity = np.eye(_BLOCK)
        # Z_kk = L_k^-T (1 + W_k^T Z_{k+1,k+1} W_k) L_k^-1, from the last block, where nothing follows
        for k in range(n - 1, -1, -1):
            inverse = _lower_solve(self.lower[k], identity.copy())
            on[k] = inverse.T @ inverse
            if k + 1 < n:
                gain = self.below[k] @ inverse
                beside[k] = -on[k + 1] @ gain
                on[k] += gain.T @ on[k + 1] @ gain
        shape = _BLOCK // together, together, _BLOCK // together, together
        return SelectedInverse(on.reshape(len(on), *shape), beside.reshape(len(beside), *shape))


@dataclass(frozen=True, slots=True)
class SelectedInverse:
    """Blocks of S^-1 of 24 unknowns, k of which belong together: x, y and z of a coefficient, or a joint's.

    Attributes
    ----------
    on, beside
        On and below the diagonal, shapes (count, 24 / k, k, 24 / k, k) and (count - 1, 24 / k, k, 24 / k, k).
    """

    on: FloatArray
    beside: FloatArray

    def between(self, one: IntArray, other: IntArray) -> FloatArray:
        """Return the blocks of pairs of coefficients or joints that are at most 24 / k apart, (n, k, k)."""
        low, high = np.minimum(one, other), np.maximum(one, other)
        (block, column), (below, row) = divmod(low, self.on.shape[1]), divmod(high, self.on.shape[1])
        out = self.on[block, row * (block == below), :, column]
        apart = below > block
        out[apart] = self.beside[block[apart], row[apart], :, column[apart]]
        # rows belong to the later one
        swapped = one < other
        out[swapped] = out[swapped].transpose(0, 2, 1)
        return out

    def diagonal(self) -> FloatArray:
        """Return the diagonal of S^-1, shape (24 count,)."""
        return np.diagonal(self.on.reshape(len(self.on), _BLOCK, _BLOCK), axis1=1, axis2=2).ravel()


def _blocks(band: FloatArray, count: int, shift: int) -> FloatArray:
    """Return blocks (count, 24, 24) of a lower band, those whose rows begin so far below their columns."""
    out = np.zeros((max(count, 0), _BLOCK, _BLOCK))
    if count <= 0:
        return out
    row, column = _places(len(band), shift)
    out[:, row, column] = band[row + shift - column, _BLOCK * np.arange(len(out))[:, None] + column]
    return out


@lru_cache(maxsize=8)
def _places(width: int, shift: int) -> tuple[IntArray, IntArray]:
    """Return rows and columns of a block that a lower band fills."""
    row, column = np.indices((_BLOCK, _BLOCK))
    below = row + shift - column
    row, column = np.nonzero((below >= 0) & (below < width))
    return row, column


def _lower_solve(lower: FloatArray, right: FloatArray, *, transposed: bool = False) -> FloatArray:
    """Return L^-1 right, or L^-T right, in place of `right`, whose rows must lie one after the other."""
    return np.asarray(dtrsm(1.0, lower.T, right.T, side=1, trans_a=int(transposed), overwrite_b=1).T)
