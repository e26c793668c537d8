"""Covariances of what is linear in the motion, all else marginalised: S^-1 near its diagonal, and what M adds to it."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from scipy.linalg import solve_triangular
from scipy.sparse import csr_matrix

from radargui.estimation.forward.banded_rows import BandedRows
from radargui.estimation.solve.normal import NormalMatrix
from radargui.model.arrays import FloatArray, pieces

_ROWS = 1 << 12


class MotionCovariance:
    """Covariances of rows that act alike on x, y and z, from H^-1 = [[S^-1 + X X^T, ...], ...], X = S^-1 C L_M^-T.

    Parameters
    ----------
    normal
        H, factored.
    """

    def __init__(self, normal: NormalMatrix) -> None:
        self.normal, self.inverse = normal, normal.motion.selected_inverse()

    @cached_property
    def _spread(self) -> FloatArray:
        """X, shape (3 size, n_global)."""
        cross = self.normal.motion.back_solve(self.normal.half)
        return np.asarray(solve_triangular(self.normal.schur[0], cross.T, lower=True, check_finite=False).T)

    def of(
        self,
        rows: BandedRows,
        others: BandedRows | None = None,
        *,
        by_global: csr_matrix | None = None,
        places: slice = slice(0, 0),
    ) -> FloatArray:
        """Return the covariance of what rows give, with what as many others do (themselves where left out), (n, 3, 3).

        Parameters
        ----------
        rows, others
            Of the coefficients, at most eight apart.
        by_global, places
            What the rows give besides, x, y and z interleaved, for some places of the global parameters.
        """
        others, out = rows if others is None else others, np.empty((rows.first.size, 3, 3))
        for part in pieces(rows.first.size, _ROWS):
            alone = self._through(
                rows[part], by_global[3 * part.start : 3 * part.stop] if by_global is not None else None, places
            )
            beside = alone if others is rows else self._through(others[part], None, places)
            out[part] = self._of_motion(rows[part], others[part]) + alone @ beside.transpose(0, 2, 1)
        return out

    def _through(self, rows: BandedRows, by_global: csr_matrix | None, places: slice) -> FloatArray:
        """Return R X, less what the global parameters give by themselves, shape (n, 3, n_global)."""
        through = rows.of_place @ self._spread
        if by_global is not None:
            unit = np.eye(self.normal.half.shape[1])[:, places]
            root = solve_triangular(self.normal.schur[0], unit, lower=True, check_finite=False).T
            through -= by_global @ root
        return np.asarray(through).reshape(rows.first.size, 3, -1)

    def _of_motion(self, rows: BandedRows, others: BandedRows) -> FloatArray:
        """Return R S^-1 R'^T, the release of variance zero, shape (n, 3, 3)."""
        out = np.zeros((rows.first.size, 3, 3))
        for k, own in enumerate(rows.value.T):
            for m, other in enumerate(others.value.T):
                one, two = rows.first + k - 1, others.first + m - 1
                weight = np.where((one < 0) | (two < 0), 0.0, own * other)
                out += weight[:, None, None] * self.inverse.between(np.maximum(one, 0), np.maximum(two, 0))
        return out
