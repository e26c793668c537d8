"""What the motion obeys between its breaks: an acceleration that changes slowly, or flight (method 4, Flight)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix

from radargui.estimation.forward.banded_rows import BandedRows
from radargui.estimation.forward.motion_spline import MotionSpline, SplineMotion
from radargui.model.arrays import BoolArray, FloatArray, IntArray


@dataclass(frozen=True, slots=True)
class FreeFlightSettings:
    """Where a motion counts as free flight. Chosen by hand.

    Attributes
    ----------
    off_gravity
        A segment whose mean acceleration is within this share of gravity flies: a wall that is missing in the model
        bends a fall by less (it makes waves along the way, the faster the sphere the more), and a body that lies or is
        held is off by all of it.
    min_spans
        A flight lasts at least so many spans of 10 ms: over less, nothing is gained.
    """

    off_gravity: float = 0.102
    min_spans: int = 3


FREE_FLIGHT = FreeFlightSettings()


@dataclass(frozen=True)
class EquationRows:
    """The equation of motion as rows of the spline's coefficients, outside of flights first.

    Outside of flights a row is a span's third derivative. In a flight it is the acceleration at a knot, of which
    a = -g - k (|v| + v1) v is expected: one row more than spans, so that with place and velocity they say all of a
    cubic.

    Attributes
    ----------
    rows
        (n_rows, size).
    velocity
        Velocities at the rows in flight, (n_flying, size).
    n_jerk
        How many rows are third derivatives.
    span, segment
        Of each row, shape (n_rows,).
    duration_s
        Of the segment of each row in flight, shape (n_flying,).
    """

    rows: BandedRows
    velocity: BandedRows
    n_jerk: int
    span: IntArray
    segment: IntArray
    duration_s: FloatArray

    @staticmethod
    def of(spline: MotionSpline, in_flight: BoolArray) -> EquationRows:
        """Return the rows of a spline of which some spans, (n_spans,), are in flight."""
        segment = spline.polynomials.segment
        jerk, _, _ = spline.jerk()
        outside = np.flatnonzero(~in_flight)
        if outside.size == in_flight.size:
            return EquationRows(jerk, jerk[:0], outside.size, outside, segment, np.zeros(0))
        follows = np.append(in_flight[1:] & (segment[1:] == segment[:-1]), False)
        begin, last = np.flatnonzero(in_flight), np.flatnonzero(in_flight & ~follows)
        span = np.concatenate([begin, last])
        order = np.argsort(span, kind="stable")
        span, is_end = span[order], (np.arange(span.size) >= begin.size)[order]
        velocity, acceleration = spline.at_ends(span, is_end)
        return EquationRows(
            jerk[outside].above(acceleration),
            velocity,
            outside.size,
            np.concatenate([outside, span]),
            segment[np.concatenate([outside, span])],
            np.diff(spline.edge_s)[segment[span]],
        )

    @property
    def is_flight(self) -> BoolArray:
        """Which rows are in flight, shape (n_rows,)."""
        return np.arange(self.span.size) >= self.n_jerk


@dataclass(frozen=True)
class EquationDeviation:
    """By how much a motion deviates from the equation, and what moves that.

    Attributes
    ----------
    rows
        The equation.
    value
        m/s^3 or m/s^2, shape (n_rows, 3).
    drag
        (|v| + v1) v in flight, else zero, shape (n_rows, 3): the slope with respect to k.
    by_breaks
        Slopes with respect to the times of the breaks before and after each row's segment, shape (n_rows, 3, 2).
    n_breaks
        How many breaks there are.
    """

    rows: EquationRows
    value: FloatArray
    drag: FloatArray
    by_breaks: FloatArray
    n_breaks: int

    @staticmethod
    def of(
        rows: EquationRows, coefficients: FloatArray, gravity_and_drag: FloatArray, slow_m_s: float, n_breaks: int
    ) -> EquationDeviation:
        """Return the deviation for coefficients (size, 3), (g_x, g_y, g_z, k) and v1, empty where nothing flies."""
        value = rows.rows @ coefficients
        drag, by_breaks = np.zeros_like(value), np.zeros((*value.shape, 2))
        if rows.duration_s.size:
            velocity = rows.velocity @ coefficients
            flying = slice(rows.n_jerk, None)
            drag[flying] = (np.linalg.norm(velocity, axis=1)[:, None] + slow_m_s) * velocity
            # knots move with the breaks: at fixed coefficients an acceleration goes with the duration to the power -2
            shorter = 2.0 * value[flying] / rows.duration_s[:, None]
            # start and end of the record do not move
            segment = rows.segment[flying, None]
            by_breaks[flying, :, 0] = np.where(segment > 0, shorter, 0.0)
            by_breaks[flying, :, 1] = np.where(segment < n_breaks, -shorter, 0.0)
            # what is left of a = -g - k (|v| + v1) v
            value[flying] += gravity_and_drag[:3] + gravity_and_drag[3] * drag[flying]
        return EquationDeviation(rows, value, drag, by_breaks, n_breaks)

    @property
    def by_global(self) -> csr_matrix:
        """Slopes of the rows in flight by the times of all breaks, by gravity and by drag, (3 n_flying, n_breaks + 4).

        So do these stand among the global parameters, the breaks first.
        """
        flying = slice(self.rows.n_jerk, None)
        by_breaks, drag, segment = self.by_breaks[flying], self.drag[flying], self.rows.segment[flying]
        values = np.concatenate([by_breaks, np.ones((*drag.shape, 1)), drag[:, :, None]], axis=2)
        columns = np.empty(values.shape, dtype=np.intp)
        # start and end of the record are no breaks: their slopes are zero, and stand at some break
        columns[:, :, :2] = np.clip(segment[:, None] + np.array([-1, 0]), 0, max(self.n_breaks - 1, 0))[:, None]
        columns[:, :, 2], columns[:, :, 3] = self.n_breaks + np.arange(3), self.n_breaks + 3
        pointer = np.arange(0, values.size + 1, 4)
        return csr_matrix((values.ravel(), columns.ravel(), pointer), shape=(drag.size, self.n_breaks + 4))


def spans_in_flight(motion: SplineMotion, released_s: float, gravity_m_s2: float) -> BoolArray:
    """Return which spans belong to segments that fly, the release before `released_s` left out, shape (n_spans,)."""
    spline = motion.spline
    # before, a hand or a magnet acted
    after = spline.span_middles() > released_s
    rows = EquationRows.of(spline, after)
    acceleration = (rows.rows @ motion.coefficients)[rows.n_jerk :]
    out = np.zeros(after.size, dtype=bool)
    segment = spline.polynomials.segment
    for number in range(len(spline.spans)):
        here = rows.segment[rows.n_jerk :] == number
        if here.sum() > FREE_FLIGHT.min_spans:
            # the mean: at single knots the spline rings by more
            off = acceleration[here].mean(axis=0) + np.array([0.0, 0.0, gravity_m_s2])
            out[after & (segment == number)] = np.linalg.norm(off) < FREE_FLIGHT.off_gravity * gravity_m_s2
    return out
