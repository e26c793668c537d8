"""What the figures of one run draw, small enough to keep for every run of a session."""

from __future__ import annotations

from dataclasses import dataclass

from radargui.model.arrays import FloatArray
from radargui.report.decimation import Curve


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
