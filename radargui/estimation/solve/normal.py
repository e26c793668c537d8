"""The normal matrix: block tridiagonal in the motion, dense in the global parameters (method 4, Minimum)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from scipy.linalg.blas import dtrsm
from scipy.linalg.lapack import dpbtrf, dtrtri
from scipy.sparse import csc_matrix, csr_matrix
from scipy.sparse.linalg import splu

from radargui.model.arrays import FloatArray, IntArray, pieces
from radargui.model.errors import SolveError

# A bin meets four neighbouring coefficients: bandwidth 3 x 3 + 2 = 11. Any block above 11 is right; 24 by hand: smaller
# ones cost calls, larger ones arithmetic.
_BLOCK = 24
_TOGETHER = 32 * _BLOCK  # rows multiplied at once, chosen by hand
_FELT = 1e-17  # parts below this share of a column's largest are lost in rounding when squared


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
        self.count = -(-self.size // _BLOCK)
        factor, bad = dpbtrf(band, lower=1)
        if bad:
            raise np.linalg.LinAlgError(f"leading minor {bad}")
        padded = np.zeros((width, self.count * _BLOCK))
        padded[0] = 1.0
        padded[:, : self.size] = factor
        self.lower, self.below = (
            _blocks(padded, count, shift) for count, shift in ((self.count, 0), (self.count - 1, _BLOCK))
        )

    def half_solve(self, right: FloatArray) -> FloatArray:
        """Return L^-1 right for (n, m), padded to whole blocks."""
        out = np.zeros((self.count * _BLOCK, right.shape[1]))
        out[: self.size] = right
        blocks = out.reshape(self.count, _BLOCK, -1)
        for k in range(self.count):
            if k:
                blocks[k] -= self.below[k - 1] @ blocks[k - 1]
            _lower_solve(self.lower[k], blocks[k])
        return out

    def back_solve(self, half: FloatArray) -> FloatArray:
        """Return L^-T half, shape (n, m)."""
        blocks = half.copy().reshape(self.count, _BLOCK, -1)
        for k in range(self.count - 1, -1, -1):
            if k + 1 < self.count:
                blocks[k] -= self.below[k].T @ blocks[k + 1]
            _lower_solve(self.lower[k], blocks[k], transposed=True)
        return np.asarray(blocks.reshape(self.count * _BLOCK, -1)[: self.size])

    def log_determinant(self) -> float:
        """Return ln det S."""
        return float(2.0 * np.log(np.diagonal(self.lower, axis1=1, axis2=2)).sum())

    def selected_inverse(self) -> SelectedInverse:
        """Return the blocks of S^-1 on and beside the diagonal (Takahashi's recursion)."""
        n = self.count
        on, beside = np.empty_like(self.lower), np.empty_like(self.below)
        identity = np.eye(_BLOCK)
        for k in range(n - 1, -1, -1):
            inverse = _lower_solve(self.lower[k], identity.copy())
            on[k] = inverse.T @ inverse
            if k + 1 < n:
                gain = self.below[k] @ inverse
                beside[k] = -on[k + 1] @ gain
                on[k] += gain.T @ on[k + 1] @ gain
        shape = -1, _BLOCK // 3, 3, _BLOCK // 3, 3
        return SelectedInverse(on.reshape(shape), beside.reshape(shape))


@dataclass(frozen=True, slots=True)
class SelectedInverse:
    """Blocks of S^-1, x, y and z of eight coefficients each.

    Attributes
    ----------
    on, beside
        On and below the diagonal, shapes (count, 8, 3, 8, 3) and (count - 1, 8, 3, 8, 3).
    """

    on: FloatArray
    beside: FloatArray

    def between(self, one: IntArray, other: IntArray) -> FloatArray:
        """Return the blocks of pairs of coefficients that are at most eight apart, (n, 3, 3)."""
        low, high = np.minimum(one, other), np.maximum(one, other)
        (block, column), (below, row) = divmod(low, _BLOCK // 3), divmod(high, _BLOCK // 3)
        out = self.on[block, row * (block == below), :, column]
        apart = below > block
        out[apart] = self.beside[block[apart], row[apart], :, column[apart]]
        # rows belong to the later one
        swapped = one < other
        out[swapped] = out[swapped].transpose(0, 2, 1)
        return out


def _blocks(band: FloatArray, count: int, shift: int) -> FloatArray:
    """Return blocks (count, 24, 24) of a lower band, those whose rows begin so far below their columns."""
    row, column = np.indices((_BLOCK, _BLOCK))
    below = row + shift - column
    row, column = np.nonzero((below >= 0) & (below < len(band)))
    out = np.zeros((max(count, 0), _BLOCK, _BLOCK))
    out[:, row, column] = band[row + shift - column, _BLOCK * np.arange(len(out))[:, None] + column]
    return out


def _lower_solve(lower: FloatArray, right: FloatArray, *, transposed: bool = False) -> FloatArray:
    """Return L^-1 right, or L^-T right, in place of `right`, whose rows must lie one after the other."""
    return np.asarray(dtrsm(1.0, lower.T, right.T, side=1, trans_a=int(transposed), overwrite_b=1).T)


def _gram(half: FloatArray) -> FloatArray:
    """Return half^T half without the parts of columns that are zero to rounding: a break is felt near it alone."""
    if half.shape[0] <= 2 * _TOGETHER:
        return np.asarray(half.T @ half)
    out = np.zeros((half.shape[1], half.shape[1]))
    parts = [half[part] for part in pieces(half.shape[0], _TOGETHER)]
    tops = np.array([np.maximum(part.max(axis=0), -part.min(axis=0)) for part in parts])
    for part, felt in zip(parts, tops > _FELT * tops.max(axis=0), strict=True):
        places = np.flatnonzero(felt)
        part = part[:, places]
        out[np.ix_(places, places)] += part.T @ part
    return out


def solve_sparse(matrix: csr_matrix, right: FloatArray) -> FloatArray:
    """Return the solution of a sparse square system, shape as `right`.

    Raises
    ------
    SolveError
        The matrix is singular.
    """
    try:
        factor = splu(csc_matrix(matrix))
    except RuntimeError as error:  # scipy's word for an exactly singular factor
        raise SolveError("The motion is not determined: its equations are singular.") from error
    return np.asarray(factor.solve(right))


@dataclass(frozen=True, slots=True)
class Reduced:
    """H = [[S, C], [C^T, M]] with S factored; fields as of `NormalMatrix`, the complement not factored yet."""

    motion: BlockTridiagonal
    half: FloatArray
    complement: FloatArray

    @staticmethod
    def of(band: FloatArray, c: FloatArray, m: FloatArray) -> Reduced:
        """Factor S, given by its `lower_band`.

        Raises
        ------
        SolveError
            It is not positive definite.
        """
        try:
            motion = BlockTridiagonal(band)
        except np.linalg.LinAlgError as error:
            raise SolveError("The normal matrix of the joint estimate is not positive definite.") from error
        half = motion.half_solve(c)
        left = _gram(half)
        return Reduced(motion, half, np.subtract(m, left, out=left))

    def factor(self, added: FloatArray | None = None) -> NormalMatrix:
        """Return the factored matrix, something added to the diagonal of M.

        Raises
        ------
        SolveError
            It is not positive definite, or not finite.
        """
        complement = self.complement.copy()
        if added is not None:
            complement[np.diag_indices(added.size)] += added
        try:
            schur = cho_factor(complement.T, lower=True, overwrite_a=True, check_finite=False)
        except np.linalg.LinAlgError as error:
            raise SolveError("The normal matrix of the joint estimate is not positive definite.") from error
        if not np.isfinite(np.diag(schur[0])).all():  # LAPACK carries what is not a number through without a word
            raise SolveError("The normal matrix of the joint estimate is not finite.")
        return NormalMatrix(self.motion, self.half, schur)


@dataclass(frozen=True, slots=True)
class NormalMatrix:
    """H = [[S, C], [C^T, M]] factored by the Schur complement M - C^T S^-1 C.

    Attributes
    ----------
    motion
        Factor of S.
    half
        L^-1 C.
    schur
        Cholesky factor of the Schur complement as scipy's `cho_factor` gives it: H of the global parameters with the
        motion marginalised.
    """

    motion: BlockTridiagonal
    half: FloatArray
    schur: tuple[FloatArray, bool]

    def solve(self, slope_motion: FloatArray, slope_global: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return both parts of H^-1 applied to a vector, or to some, shapes (n_motion, ...) and (n_global, ...)."""
        first = self.motion.half_solve(slope_motion.reshape(len(slope_motion), -1))
        right = slope_global.reshape(len(slope_global), -1) - self.half.T @ first
        of_global = cho_solve(self.schur, right, check_finite=False)
        motion = self.motion.back_solve(first - self.half @ of_global)
        return motion.reshape(slope_motion.shape), of_global.reshape(slope_global.shape)

    def global_variances(self) -> FloatArray:
        """Return the variances of the global parameters."""
        # M^-1 = L^-T L^-1: its diagonal needs half of the work of all of it
        inverse = np.tril(dtrtri(self.schur[0], lower=1)[0])
        return np.asarray((inverse**2).sum(axis=0))

    def global_covariance(self, places: slice) -> FloatArray:
        """Return the covariance of some neighbouring global parameters, shape (n, n)."""
        columns = np.eye(self.half.shape[1])[:, places]
        return np.asarray(cho_solve(self.schur, columns, check_finite=False)[places])

    def log_determinant(self) -> float:
        """Return ln det H."""
        return self.motion.log_determinant() + float(2.0 * np.log(np.diag(self.schur[0])).sum())
