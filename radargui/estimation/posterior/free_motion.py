"""The motion as the samples give it, without the equation of motion: places at times, and segments."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import BSpline

from radargui.estimation.forward.motion_spline import SplineMotion
from radargui.model.arrays import FloatArray
from radargui.model.gravity import UNKNOWN_DRAG, Drag


@dataclass(frozen=True, slots=True)
class MotionSegment:
    """The motion between two neighbouring edges (start, breaks, end): a cubic spline with its own velocity.

    Attributes
    ----------
    begin_s, end_s
        Its edges.
    knot_share
        Knots as shares of its duration, from 0 to 1, shape (n_spans + 1,).
    first_coefficient
        Number of its first coefficient in each coordinate, which it has in common with the segment before. The one at
        the start of the motion has number 0 and is zero. Coefficients k to k + 3 hold span k of the first segment.
    """

    begin_s: float
    end_s: float
    knot_share: FloatArray
    first_coefficient: int

    @property
    def n_spans(self) -> int:
        """Number of spans between knots."""
        return self.knot_share.size - 1

    @property
    def duration_s(self) -> float:
        """Time between the edges."""
        return self.end_s - self.begin_s

    @property
    def stop_coefficient(self) -> int:
        """One past the number of its last coefficient."""
        return self.first_coefficient + self.n_spans + 3

    @property
    def knot_s(self) -> FloatArray:
        """Times of the knots, shape (n_spans + 1,)."""
        return self.begin_s + self.duration_s * self.knot_share

    def collocation(self) -> tuple[FloatArray, FloatArray]:
        """Return the Greville points as shares of the duration, (n,), and the matrix from values there, (n, n).

        The matrix times the values of a function at these points are the coefficients that interpolate it (de Boor, A
        Practical Guide to Splines, XIII).
        """
        # multiplicity 4 at both ends: the segment as a spline of its own
        knots = np.concatenate([np.zeros(3), self.knot_share, np.ones(3)])
        # collocation at Greville points is well conditioned for any knots
        greville = np.array([knots[j + 1 : j + 4].mean() for j in range(knots.size - 4)]).clip(0.0, 1.0)
        return greville, np.linalg.inv(BSpline.design_matrix(greville, knots, 3).toarray())


@dataclass(frozen=True, slots=True)
class FreeMotion:
    """A motion relative to where it starts, p(t) = release + B(t) c.

    Attributes
    ----------
    motion
        Spline and coefficients.
    release_m
        Shape (3,).
    gravity_m_s2
        g of the place.
    drag
        What is known of the air's drag where it flies.
    """

    motion: SplineMotion
    release_m: FloatArray
    gravity_m_s2: float
    drag: Drag = UNKNOWN_DRAG

    @property
    def edge_s(self) -> FloatArray:
        """Start, breaks, end, shape (n_segments + 1,)."""
        return self.motion.spline.edge_s

    @property
    def segments(self) -> tuple[MotionSegment, ...]:
        """The segments between the edges."""
        spline, out, first = self.motion.spline, [], 0
        for begin, end, share in zip(spline.edge_s[:-1], spline.edge_s[1:], spline.fractions, strict=True):
            out.append(MotionSegment(float(begin), float(end), share, first))
            # neighbours share the coefficient at the break: the place where they meet
            first = out[-1].stop_coefficient - 1
        return tuple(out)

    def position_m(self, time_s: FloatArray) -> FloatArray:
        """Return the places at some times, shape (3, n); before the start that of the release."""
        return np.asarray((self.motion.spline.offset(time_s, self.motion.coefficients) + self.release_m).T)

    def first_coefficient_from(self, time_s: float) -> int:
        """Return the number of the first coefficient whose function is zero before a time."""
        return int(np.searchsorted(self.motion.spline.knots(), time_s))
