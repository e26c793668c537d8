"""What the figures of one run draw, small enough to keep for every run of a session."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from radargui.model.arrays import FloatArray, IntArray
from radargui.model.decimation import extremes

COLUMNS = 500
"""One minimum and maximum each third of a millimetre across an A4 page."""


@dataclass(frozen=True, slots=True)
class Curve:
    """A polyline; NaN breaks it.

    Attributes
    ----------
    x, y
        Shape (n_points,).
    """

    x: FloatArray
    y: FloatArray

    @property
    def largest(self) -> float:
        """Largest size of a known y; 0 where none is known."""
        known = np.abs(self.y[np.isfinite(self.y)])
        return float(known.max(initial=0.0))


EMPTY = Curve(np.empty(0), np.empty(0))


def envelope(x: FloatArray, y: FloatArray, breaks: Sequence[int] = (), columns: int = COLUMNS) -> Curve:
    """Keep the lowest and the highest point of each of `columns` equal shares of the samples, in their order.

    Parameters
    ----------
    x, y
        Shape (n_samples,); y may be NaN.
    breaks
        Indices before which samples were lost: the curve is broken there.
    columns
        Shares over the whole length.

    Returns
    -------
    Curve
        At most about 2 `columns` points; the curve itself where it is shorter than that.
    """
    size = max(1, -(-len(y) // columns))
    edges = [0, *sorted({place for place in breaks if 0 < place < len(y)}), len(y)]
    xs: list[FloatArray] = []
    ys: list[FloatArray] = []
    for first, last in pairwise(edges):
        if xs:
            xs.append(x[first : first + 1])
            ys.append(np.array([np.nan]))
        keep = extremes(y[first:last], size) + first
        xs.append(x[keep])
        ys.append(y[keep])
    return Curve(np.concatenate(xs), np.concatenate(ys)) if xs else EMPTY


def every(count: int, points: int) -> IntArray:
    """Return about `points` indices spread evenly over `count` samples, ends included."""
    if count <= points:
        return np.arange(count, dtype=np.intp)
    return np.unique(np.linspace(0, count - 1, points).round().astype(np.intp))


@dataclass(frozen=True, slots=True)
class StepCurves:
    """The steps of the published correction in one channel, volts against seconds."""

    name: str
    signal: Curve
    upper: Curve
    lower: Curve
    bias: Curve
    scale: Curve
    peaks: Curve
    valleys: Curve
    zero_crossings: Curve
    segment_s: tuple[float, float]


@dataclass(frozen=True, slots=True)
class ReceiverCurves:
    """One receiver against seconds: volts, amplitudes, rad, metres; the planes are I against Q."""

    name: str
    raw_i: Curve
    raw_q: Curve
    raw_plane: Curve
    i: Curve
    q: Curve
    plane: Curve
    phase_raw: Curve
    phase: Curve
    phase_difference: Curve
    change: Curve
    u_change: Curve
    steps: tuple[StepCurves, ...]


@dataclass(frozen=True, slots=True)
class TrackCurves:
    """The track in metres against seconds, and as places.

    Attributes
    ----------
    x, y
        Against time.
    height
        Along the floor's normal against time: z on a level floor.
    level
        Whether the floor is level, so that `height` is z.
    u
        Of x, y, z against time.
    places_m
        Shape (3, n_points), evenly spread in time; NaN where a path was lost.
    parabola
        The fitted fall, prolonged to the first impact; None where there is none.
    residual
        Height less the parabola over the span of the fit.
    """

    x: Curve
    y: Curve
    height: Curve
    level: bool
    u: tuple[Curve, Curve, Curve]
    places_m: FloatArray
    parabola: Curve | None
    residual: Curve | None


@dataclass(frozen=True, slots=True)
class RunCurves:
    """All curves of one run within the span drawn.

    Attributes
    ----------
    span_s
        First and last time drawn: the motion and some rest on both sides. All times count from `RunResult.zero`.
    since
        What they count from, in words.
    unit
        Of the raw samples.
    receivers
        One entry an IQ pair.
    track
        None with fewer than three receivers or where the run ended before.
    gaps_s
        First and last time of each run of lost samples.
    restarts_s
        Where a path was lost and L has another zero from there on.
    impacts
        Time and e of each impact, to its uncertainty; e is empty where not valid.
    """

    span_s: tuple[float, float]
    since: str
    unit: str
    receivers: tuple[ReceiverCurves, ...]
    track: TrackCurves | None
    gaps_s: tuple[tuple[float, float], ...]
    restarts_s: tuple[float, ...]
    impacts: tuple[tuple[float, str], ...]
