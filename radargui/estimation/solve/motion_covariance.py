"""Covariances of what is linear in motion and breaks, all else marginalised: near the diagonal, and what M adds.

Method 4, Minimum.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from radargui.estimation.forward.banded_rows import BandedRows
from radargui.estimation.solve.normal import NormalMatrix
from radargui.model.arrays import FloatArray, IntArray, pieces

_ROWS = 1 << 10  # looked at together: bounds the memory, changes nothing


class MotionCovariance:
    """Covariances of rows that act alike on x, y and z and may move with the breaks beside them.

    With H = L L^T in the order of `NormalMatrix` they are sums of what motion between the breaks, joints and the rest
    leave open: R_b S_b^-1 R_b^T, G T^-1 G^T with G = R_j - R_b S_b^-1 E, and R X X^T R^T, X the columns of L^-T of the
    rest.

    Parameters
    ----------
    normal
        H, factored.
    """

    def __init__(self, normal: NormalMatrix) -> None:
        self.normal, self.segments = normal, normal.segments
        self.inverse = normal.between.motion.selected_inverse()
        self.joint_inverse = normal.breaks.selected_inverse(4)
        # the place at a break belongs to the joint
        self.is_open = np.ones(self.segments.size + 1, dtype=bool)
        self.is_open[[0, *self.segments.joint.tolist()]] = False

    def of(
        self, rows: BandedRows, others: BandedRows | None = None, *, by_breaks: FloatArray | None = None
    ) -> FloatArray:
        """Return the covariance of what rows give, with what as many others do (themselves where left out), (n, 3, 3).

        Parameters
        ----------
        rows, others
            Of the coefficients, at most eight apart, in the same segment or in neighbours.
        by_breaks
            What the rows give besides for the times of the breaks before and after their segment, shape (n, 3, 2).
        """
        others, out = rows if others is None else others, np.empty((rows.first.size, 3, 3))
        for part in pieces(rows.first.size, _ROWS):
            one = self._through(rows[part], None if by_breaks is None else by_breaks[part])
            other = one if others is rows else self._through(others[part], None)
            out[part] = self._of_motion(rows[part], others[part]) + one[1] @ other[1].transpose(0, 2, 1)
            if self.segments.n_breaks:
                between = self._between_joints(*(self.segments.of(each.first[part]) for each in (rows, others)))
                out[part] += one[0] @ between @ other[0].transpose(0, 2, 1)
        return out

    @cached_property
    def _spread(self) -> tuple[FloatArray, FloatArray]:
        """X of the motion, and of the breaks before and after each segment."""
        motion, breaks = self.normal.spread()
        return motion, self.segments.breaks_beside(breaks)

    @cached_property
    def _joints(self) -> FloatArray:
        """What each segment's functions give for a unit of the joints before and after it, (n_functions, 3, 8)."""
        segments = self.segments
        solved = self.normal.between.motion.back_solve(self.normal.between.to_joints).reshape(-1, 3, 8)
        out = -np.concatenate([np.zeros((1, 3, 8)), solved])[segments.coefficient]
        # at a break the function is the joint itself: of the segment before it the one after, and the other way round
        out[segments.ends] = np.eye(8)[4:7]
        out[segments.ends + 1] = np.eye(8)[:3]
        return out

    def _through(self, rows: BandedRows, by_breaks: FloatArray | None) -> tuple[FloatArray, FloatArray]:
        """Return G, shape (n, 3, 8), and R X, shape (n, 3, n_rest)."""
        place, (motion, breaks) = self.segments.of(rows.first), self._spread
        through = np.asarray(rows.of_place @ motion).reshape(-1, 3, motion.shape[1])
        joints = np.zeros((rows.first.size, 3, 8))
        if self.segments.n_breaks:
            for k, value in enumerate(rows.value.T):
                joints += value[:, None, None] * self._joints[rows.first + place + k]
        if by_breaks is not None:
            joints[:, :, 3::4] += by_breaks
            through += by_breaks @ breaks[place]
        return joints, through

    def _between_joints(self, one: IntArray, other: IntArray) -> FloatArray:
        """Return T^-1 between the joints before and after some segments and those of others, shape (n, 8, 8)."""
        out = np.zeros((one.size, 2, 4, 2, 4))
        last = self.segments.n_breaks - 1
        for side in range(2):
            for beside in range(2):
                row, column = one - 1 + side, other - 1 + beside
                is_there = (np.minimum(row, column) >= 0) & (np.maximum(row, column) <= last)
                out[is_there, side, :, beside] = self.joint_inverse.between(row[is_there], column[is_there])
        return out.reshape(-1, 8, 8)

    def _of_motion(self, rows: BandedRows, others: BandedRows) -> FloatArray:
        """Return R_b S_b^-1 R_b'^T, the release and the joints left out, shape (n, 3, 3)."""
        k, m = np.divmod(np.arange(16), 4)
        one, two = rows.first[:, None] + k, others.first[:, None] + m
        weight = rows.value[:, k] * others.value[:, m] * (self.is_open[one] & self.is_open[two])
        between = self.inverse.between(np.maximum(one - 1, 0).ravel(), np.maximum(two - 1, 0).ravel())
        return np.asarray((weight[:, None] @ between.reshape(-1, 16, 9)).reshape(-1, 3, 3))
