"""The normal matrix, a band with a border: factor, solve, determinant and covariance."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.linalg.blas import dsyrk
from scipy.linalg.lapack import dpbsv, dpbtrf, dpotrf, dpotri, dtbtrs, dtrtri, dtrtrs

from radargui.estimation.forward.banded_rows import BandedRows
from radargui.model.arrays import FloatArray, IntArray, pieces
from radargui.model.errors import SolveError

WIDTH = 12
"""Diagonals of the band, the main one and those below: x, y and z of four neighbouring coefficients meet in a bin."""
_TOGETHER = (
    8  # coefficients for which the inverse is found at a time: the band couples each to the next such block alone
)
_ROWS = 1 << 10  # covariances of so many rows at a time: bounds the memory, changes nothing


def solve_band(band: FloatArray, right: FloatArray) -> FloatArray:
    """Return the solution of a symmetric banded system, (width, n) as of `NormalMatrix`, shape as `right`, (n, k).

    Raises
    ------
    SolveError
        The matrix is not positive definite.
    """
    _, solution, bad = dpbsv(band, right, lower=1)
    if bad:
        raise SolveError("The motion is not determined: its equations are singular.")
    return np.asarray(solution)


def band_times(band: FloatArray, vectors: FloatArray) -> FloatArray:
    """Return the product of a symmetric band, (width, n) as of `NormalMatrix`, and vectors, (n,) or (n, k)."""
    columns = vectors.reshape(len(vectors), -1)
    out = band[0][:, None] * columns
    for below in range(1, min(len(band), len(columns))):
        diagonal = band[below, :-below, None]
        out[below:] += diagonal * columns[:-below]
        out[:-below] += diagonal * columns[below:]
    return np.asarray(out.reshape(vectors.shape))


@dataclass(frozen=True, slots=True)
class NormalMatrix:
    """H = [[S, C], [C^T, M]]: a band for the motion, with the global parameters as its border.

    Attributes
    ----------
    band
        S from its main diagonal down, x, y and z interleaved: row j + d of column j stands at (d, j), shape
        (`WIDTH`, n_motion).
    coupling
        C, shape (n_motion, n_global).
    corner
        M, shape (n_global, n_global).
    """

    band: FloatArray
    coupling: FloatArray
    corner: FloatArray

    def diagonal_raised(self, share: float) -> NormalMatrix:
        """Return H with its diagonal raised by a share."""
        band, corner = self.band.copy(), self.corner.copy()
        # a share, not a sum: metres, radians and seconds stand on one diagonal (Marquardt 1963)
        band[0] *= 1.0 + share
        corner[np.diag_indices(len(corner))] *= 1.0 + share
        return replace(self, band=band, corner=corner)

    def factor(self) -> FactoredNormal:
        """Return H as L L^T.

        Raises
        ------
        SolveError
            It is not positive definite, or not finite.
        """
        lower, bad = dpbtrf(self.band, lower=1)
        if bad:
            raise SolveError("The normal matrix of the joint estimate is not positive definite.")
        half = dtbtrs(lower, self.coupling, uplo="L")[0]
        # Schur complement M - C^T S^-1 C; only its lower triangle is meant
        left = dsyrk(-1.0, half, beta=1.0, c=self.corner.T, trans=1, lower=1)
        return FactoredNormal(lower, half, left, _root(left))


@dataclass(frozen=True)
class FactoredNormal:
    """H = L L^T with L = [[L_S, 0], [half^T, root]].

    Vectors have the motion first and the global parameters after it, shape (n, ...).

    Attributes
    ----------
    lower
        L_S, a band as S is.
    half
        L_S^-1 C, shape (n_motion, n_global).
    left
        M with the motion marginalised, M - half^T half; its lower triangle.
    root
        The lower Cholesky factor of that.
    """

    lower: FloatArray
    half: FloatArray
    left: FloatArray
    root: FloatArray

    def with_added(self, added: FloatArray) -> FactoredNormal:
        """Return the same with something, (n_global,), added to the diagonal of M; errors as of `factor`."""
        left = self.left.copy(order="F")
        left[np.diag_indices(len(left))] += added
        return replace(self, left=left, root=_root(left))

    @property
    def n_motion(self) -> int:
        """How many unknowns the motion has."""
        return len(self.half)

    def half_solve(self, right: FloatArray) -> FloatArray:
        """Return L^-1 of vectors, (n, k)."""
        motion = dtbtrs(self.lower, right[: self.n_motion], uplo="L")[0]
        rest = right[self.n_motion :] - self.half.T @ motion
        return np.concatenate([motion, dtrtrs(self.root, rest, lower=1)[0]])

    def back_solve(self, half: FloatArray) -> FloatArray:
        """Return L^-T of vectors, (n, k)."""
        rest = dtrtrs(self.root, half[self.n_motion :], lower=1, trans=1)[0]
        motion = half[: self.n_motion] - self.half @ rest
        return np.concatenate([dtbtrs(self.lower, motion, uplo="L", trans="T")[0], rest])

    def solve(self, right: FloatArray) -> FloatArray:
        """Return H^-1 of a vector, (n,), or of some, (n, k)."""
        return self.back_solve(self.half_solve(right.reshape(len(right), -1))).reshape(right.shape)

    def log_determinant(self) -> float:
        """Return ln det H."""
        return 2.0 * float(np.log(self.lower[0]).sum() + np.log(np.diag(self.root)).sum())

    @cached_property
    def global_covariance(self) -> FloatArray:
        """The covariance of the global parameters, shape (n_global, n_global)."""
        inverse = np.tril(dpotri(self.root, lower=1)[0])
        return np.asarray(inverse + np.tril(inverse, -1).T)

    def global_variances(self) -> FloatArray:
        """Return the variances of the global parameters, shape (n_global,)."""
        return self.global_covariance.diagonal()

    def covariance(self) -> Covariance:
        """Return H^-1 near its diagonal and in its border.

        From the last block of the band to the first (Takahashi et al. 1973): with L_kk on the diagonal, W below it, and
        B the border's, Z = H^-1 has Z_k+1,k = -(Z_k+1,k+1 W + Z_k+1,b B) / L_kk and the like for the border, and Z_kk =
        (1 / L_kk^T - W^T Z_k+1,k - B^T Z_b,k) / L_kk.
        """
        size, n_global = 3 * _TOGETHER, len(self.root)
        count = -(-self.n_motion // size)
        # ones on the diagonal of what the last block has too much: it stays by itself
        padded, every = np.zeros((WIDTH, count * size)), np.arange(size)
        padded[0], padded[:, : self.n_motion] = 1.0, self.lower
        columns = np.zeros((count, 2 * size, size))
        for below, diagonal in enumerate(padded.reshape(WIDTH, count, size)):
            columns[:, every + below, every] = diagonal
        to_global = np.zeros((count * size, n_global))
        to_global[: self.n_motion] = self.half
        weighted = (to_global @ self.global_covariance).reshape(count, size, n_global)
        to_global = to_global.reshape(weighted.shape)
        near, with_global = np.zeros((count, size, 2 * size)), np.empty_like(weighted)
        after, global_after = np.zeros((size, size)), np.zeros((size, n_global))
        for k in range(count - 1, -1, -1):
            inverse = dtrtri(columns[k, :size], lower=1)[0]
            gain, own = columns[k, size:] @ inverse, inverse.T @ to_global[k]
            with_global[k] = -(gain.T @ global_after) - inverse.T @ weighted[k]
            beside = -(after @ gain) - global_after @ own.T
            after = inverse.T @ inverse - gain.T @ beside - own @ with_global[k].T
            near[k, :, :size], near[k, :, size:], global_after = after, beside.T, with_global[k]
        near = near.reshape(count, _TOGETHER, 3, 2 * _TOGETHER, 3)
        return Covariance(near, with_global.reshape(-1, 3, n_global), self.global_covariance)


@dataclass(frozen=True, slots=True)
class Covariance:
    """Parts of Z = H^-1: of neighbouring coefficients, of coefficients with global parameters, and of these.

    Attributes
    ----------
    near
        Z of eight coefficients each with these and the next eight, shape (count, 8, 3, 16, 3).
    with_global
        Z of coefficients with global parameters, shape (8 count, 3, n_global).
    of_global
        Shape (n_global, n_global).
    """

    near: FloatArray
    with_global: FloatArray
    of_global: FloatArray

    def of_rows(
        self,
        rows: BandedRows,
        others: BandedRows | None = None,
        *,
        by_global: FloatArray | None = None,
        places: IntArray | None = None,
    ) -> FloatArray:
        """Return the covariance of what rows give, with what as many others do (themselves where left out), (n, 3, 3).

        Parameters
        ----------
        rows, others
            Of the coefficients, acting alike on x, y and z; at most five apart.
        by_global, places
            Slopes of what the rows give besides by some global parameters, shape (n, 3, m), and which, shape (n, m).
        """
        others, out = rows if others is None else others, np.empty((rows.first.size, 3, 3))
        for part in pieces(rows.first.size, _ROWS):
            out[part] = self._of_motion(rows[part], others[part])
            if by_global is None or places is None:
                continue
            slopes, place, out_part = by_global[part], places[part], out[part]
            value, coefficient = _without_release(rows[part])
            along = self.with_global[coefficient[:, :, None], :, place[:, None]]
            mixed = slopes @ np.einsum("nk,nkma->nma", value, along)
            out_part += mixed + mixed.transpose(0, 2, 1)
            out_part += slopes @ self.of_global[place[:, :, None], place[:, None]] @ slopes.transpose(0, 2, 1)
        return out

    def _of_motion(self, rows: BandedRows, others: BandedRows) -> FloatArray:
        (value, one), (other_value, other) = _without_release(rows), _without_release(others)
        weight = (value[:, :, None] * other_value[:, None]).reshape(len(value), 1, 16)
        one, other = np.repeat(one, 4, axis=1), np.tile(other, 4)
        block, row = divmod(np.minimum(one, other), self.near.shape[1])
        found = self.near[block, row, :, row + np.abs(one - other)]
        # of two coefficients the earlier one has the rows
        swapped = one > other
        found[swapped] = found[swapped].transpose(0, 2, 1)
        return np.asarray((weight @ found.reshape(len(value), 16, 9)).reshape(-1, 3, 3))


def _without_release(rows: BandedRows) -> tuple[FloatArray, IntArray]:
    """Return the values of rows and which coefficient each is of, both (n, 4); the release, which is zero, has none."""
    coefficient = rows.first[:, None] + np.arange(-1, 3)
    return np.where(coefficient >= 0, rows.value, 0.0), np.maximum(coefficient, 0)


def _root(matrix: FloatArray) -> FloatArray:
    """Return the lower Cholesky factor of the lower triangle of a matrix; errors as of `NormalMatrix.factor`."""
    root, bad = dpotrf(matrix, lower=1, clean=1)
    if bad:
        raise SolveError("The normal matrix of the joint estimate is not positive definite.")
    if not np.isfinite(np.diag(root)).all():  # LAPACK carries what is not a number through without a word
        raise SolveError("The normal matrix of the joint estimate is not finite.")
    return np.asarray(root)
