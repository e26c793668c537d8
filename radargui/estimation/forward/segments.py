"""A motion's coefficients from break to break: what a break moves lies in the two segments beside it.

Method 4, Minimum.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from radargui.model.arrays import FloatArray, IntArray


@dataclass(frozen=True, slots=True)
class BesideJoints:
    """Elements of the band of S, of width 12, their distance below the diagonal and their column, at places at breaks.

    Attributes
    ----------
    near
        Those that couple such a place to the motion between breaks, shape (2, n).
    row, side
        Rows of that motion, and to which of x, y, z of the break before (0 to 2) or after (4 to 6), shape (n,).
    all
        All in rows and columns of places at breaks but the diagonal, shape (2, m).
    own, to_next
        Those that couple x, y, z of each place, shape (2, n_breaks, 3, 3), and of one to that before it, (2, n, 3, 3);
        where they are too far from each other, an element that is zero.
    """

    near: IntArray
    row: IntArray
    side: IntArray
    all: IntArray
    own: IntArray
    to_next: IntArray


@dataclass(frozen=True)
class Segments:
    """Where the breaks stand among a spline's coefficients (release, c_0, c_1, ...).

    Neighbouring segments share the place at their break. What each segment says of its own coefficients stands segment
    by segment, such a place twice: `n_functions` in all.

    Attributes
    ----------
    joint
        Which of (release, c_0, ...) is the place at each break, shape (n_breaks,).
    size
        Number of coefficients without the release.
    """

    joint: IntArray
    size: int

    @property
    def n_breaks(self) -> int:
        """How many breaks there are; segments are one more."""
        return int(self.joint.size)

    @property
    def n_functions(self) -> int:
        """Number of coefficients, the release too, counted in each segment."""
        return self.size + 1 + self.n_breaks

    @cached_property
    def segment(self) -> IntArray:
        """The segment of each function, shape (n_functions,)."""
        return np.repeat(np.arange(self.n_breaks + 1), np.diff([0, *self.joint.tolist(), self.size]) + 1)

    @cached_property
    def coefficient(self) -> IntArray:
        """Which of (release, c_0, ...) each function belongs to, shape (n_functions,)."""
        return np.arange(self.n_functions) - self.segment

    @cached_property
    def ends(self) -> IntArray:
        """The last function before each break; the next one is the first after it, shape (n_breaks,)."""
        return self.joint + np.arange(self.n_breaks)

    @cached_property
    def _once(self) -> IntArray:
        return np.delete(np.arange(self.n_functions), self.ends + 1)

    @cached_property
    def joint_rows(self) -> IntArray:
        """Rows of the place at each break, x, y and z interleaved, the release left out, shape (n_breaks, 3)."""
        return 3 * (self.joint - 1)[:, None] + np.arange(3)

    @cached_property
    def beside_joints(self) -> BesideJoints:
        """What in the band of S couples places at breaks to the motion beside them."""
        edges = [-1, *self.joint_rows[:, 0].tolist(), 3 * self.size]
        near, cut = [np.zeros((4, 0), dtype=np.intp)], [np.zeros((2, 0), dtype=np.intp)]
        for before, joint, after in zip(edges[:-2], edges[1:-1], edges[2:], strict=True):
            for axis in range(3):
                row, distance = joint + axis, np.arange(1, 12)
                above, below = row - distance[distance <= row], row + distance
                cut += [np.stack([row - above, above]), np.stack([distance, np.full(11, row)])]
                # not those of the same place, nor of places at other breaks
                above = above[(above < joint) & (above > before + 2)] if before >= 0 else above[above < joint]
                below = below[(below > joint + 2) & (below < after)]
                near.append(np.stack([row - above, above, above, np.full(above.size, 4 + axis)]))
                near.append(np.stack([below - row, np.full(below.size, row), below, np.full(below.size, axis)]))
        (distance, column, row, side), others = np.concatenate(near, axis=1), np.concatenate(cut, axis=1)
        rows, n_rows = self.joint_rows, 3 * self.size
        own, to_next = _pairs(rows, rows, n_rows), _pairs(rows[1:], rows[:-1], n_rows)
        return BesideJoints(np.stack([distance, column]), row, side, others, own, to_next)

    def of(self, first: IntArray) -> IntArray:
        """Return the segments of rows of four neighbours (`BandedRows`) by the first of them, both shapes (n,)."""
        return np.searchsorted(self.joint, first, side="right")

    def folded(self, values: FloatArray) -> FloatArray:
        """Return values of functions, (n_functions, ...), summed where two are one coefficient, (size + 1, ...)."""
        out = values[self._once]
        out[self.joint] += values[self.ends + 1]
        return out

    def breaks_beside(self, values: FloatArray) -> FloatArray:
        """Return values of breaks, (n_breaks, ...), before and after each segment, zero where none is, (n, 2, ...)."""
        out = np.zeros((self.n_breaks + 1, 2, *values.shape[1:]))
        out[1:, 0] = out[:-1, 1] = values
        return out

    def of_breaks(self, beside: FloatArray) -> FloatArray:
        """Return what segments say of the breaks before and after them, (n, 2, ...), summed, (n_breaks, ...)."""
        return np.asarray(beside[1:, 0] + beside[:-1, 1])


def _pairs(rows: IntArray, columns: IntArray, n_rows: int) -> IntArray:
    """Return elements of a band of width 12 for rows and columns, (n, 3) each, shape (2, n, 3, 3)."""
    low, away = np.minimum(rows[:, :, None], columns[:, None]), np.abs(rows[:, :, None] - columns[:, None])
    # the last column has nothing below it
    return np.where(away < 12, np.stack([away, low]), np.array([11, n_rows - 1])[:, None, None, None])
