"""Prepare the curves of a run's figures: the moving part, decimated, broken at gaps and lost paths.

Decimate curves to what paper shows: the lowest and the highest point of each column.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from radargui.correction.phase import unwrap, wrapped_phase
from radargui.correction.published import ChannelSteps, PublishedSteps
from radargui.model.arrays import FloatArray, IntArray, extremes
from radargui.model.front_end import with_phase_sign
from radargui.model.result import FreeFall, RunResult
from radargui.model.rounding import COVERAGE, alone

COLUMNS = 500
"""One minimum and maximum each third of a millimetre across an A4 page."""
COMPACT = 150
"""The same across half a page."""


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
"""Of no points: what stands where nothing is known."""


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
    inside = sorted({place for place in breaks if 0 < place < len(y)})
    pieces = pairwise([0, *inside, len(y)])
    keep = np.concatenate([extremes(y[first:last], size) + first for first, last in pieces])
    at = np.searchsorted(keep, inside)
    return Curve(np.insert(x[keep], at, x[np.array(inside, np.intp)]), np.insert(y[keep], at, np.nan))


def every(count: int, points: int) -> IntArray:
    """Return about `points` indices spread evenly over `count` samples, ends included."""
    return np.unique(np.linspace(0, count - 1, min(count, points)).round().astype(np.intp))


_MARGIN = 0.15
"""Share of the motion that is drawn before and after it."""
_MIN_MARGIN_S = 0.05
"""Chosen by hand: of a short motion the share alone would be too little to see the rest beside it."""
_FALL_COLUMNS = 40
"""Of the way fallen, two points each (chosen by hand): a parabola has no more to show, and a series draws one a run."""
_FITTED = 4000
"""Samples that offset and circle are fitted to (chosen by hand): white noise of 1 % leaves 0.02 % of uncertainty."""
_ALONG = 4
"""How often offset and circle are fitted along an amplitude that the place changes: the fourth is
within 0.2 to 1.1 % of what more would leave (rms, three receivers of a simulated drop)."""
_TRACK_POINTS = 1500
"""Of the track in squares of 36 mm (chosen by hand): fewer cut the corners at the bounces."""


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
class CircleCurves:
    """What an estimate makes of one channel, volts against seconds.

    Attributes
    ----------
    name
        Of the channel.
    signal
        As recorded.
    fitted
        Of the joint estimate and the flights their model (method 1), mirrors included; of the adaptive one offset and
        circle at the phase found, by least squares over the motion.
    rest
        Signal less that: of the joint estimate and the flights noise and what the model lacks; of the adaptive one also
        what changes with position (amplitude, floor and walls that reflect).
    kind
        "model" or "circle".
    """

    name: str
    signal: Curve
    fitted: Curve
    rest: Curve
    kind: str


class PairCurves(NamedTuple):
    """I and Q against seconds, and I against Q."""

    i: Curve
    q: Curve
    plane: Curve


@dataclass(frozen=True, slots=True)
class ReceiverCurves:
    """One receiver against seconds: volts, amplitudes, rad, metres."""

    name: str
    raw: PairCurves
    corrected: PairCurves
    phase_raw: Curve
    phase: Curve
    phase_difference: Curve
    change: Curve
    u_change: Curve
    whole_change: Curve
    """As `change`, over the whole recording."""
    steps: tuple[StepCurves, ...]
    circles: tuple[CircleCurves, ...]


@dataclass(frozen=True, slots=True)
class TrackFigures:
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
    fallen
        Way fallen below the vertex of the parabola over that span; its times, as those of `since_vertex`, count from
        the vertex.
    since_vertex
        `residual`, from the vertex on.
    """

    x: Curve
    y: Curve
    height: Curve
    level: bool
    u: tuple[Curve, Curve, Curve]
    places_m: FloatArray
    parabola: Curve | None = None
    residual: Curve | None = None
    fallen: Curve | None = None
    since_vertex: Curve | None = None


class Banded(NamedTuple):
    """A curve with the ends of its band of two standard uncertainties."""

    value: Curve
    low: Curve
    high: Curve

    @classmethod
    def of(cls, x: FloatArray, y: FloatArray, u: FloatArray) -> Banded:
        """Return it of values at x, shape (n,) each."""
        return cls(Curve(x, y), Curve(x, y - COVERAGE * u), Curve(x, y + COVERAGE * u))


@dataclass(frozen=True, slots=True)
class MotionFigures:
    """Velocity in m/s and, of flights, acceleration in m/s^2 against seconds; the speed against metres of height."""

    velocity: tuple[Banded, Banded, Banded]
    acceleration: tuple[Banded, Banded, Banded]
    speed: Banded


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
    motion
        None where the correction knows no velocities.
    """

    span_s: tuple[float, float]
    since: str
    unit: str
    receivers: tuple[ReceiverCurves, ...]
    track: TrackFigures | None
    gaps_s: tuple[tuple[float, float], ...]
    restarts_s: tuple[float, ...]
    impacts: tuple[tuple[float, str], ...]
    motion: MotionFigures | None = None

    @property
    def has_phase(self) -> bool:
        """Whether the phase of any receiver is known."""
        return any(one.phase.largest for one in self.receivers)


def take_curves(result: RunResult, columns: int = COLUMNS) -> RunCurves | None:
    """Return the curves of a run, decimated to so many columns; None where it has no samples."""
    if result.recording.n_samples < 2:
        return None
    return _Taker(result, columns).take()


def take_track(result: RunResult, columns: int = COLUMNS) -> TrackFigures | None:
    """Return the track alone, with its fall; None where there is none."""
    if result.track is None or result.recording.n_samples < 2:
        return None
    return _Taker(result, columns).track()


class _Taker:
    """Curves of one result: samples within the span, broken at the gaps, and what rests on L at the restarts too."""

    def __init__(self, result: RunResult, columns: int) -> None:
        recording, self.columns = result.recording, columns
        self.result = result
        self.zero_s, _ = result.zero
        self.time_s = recording.time_s() - self.zero_s
        self.rate_hz = recording.digitisation.sample_rate_hz
        self.first, self.last = _span(result)
        self.t = self.time_s[self.first : self.last]
        self.breaks = [samples.start - self.first for samples, _ in recording.stretches()][1:]
        restarts = np.empty(0, dtype=np.intp) if result.paths is None else result.paths.restarts()
        self.restarts = restarts[(restarts > self.first) & (restarts < self.last)] - self.first

    @cached_property
    def volts(self) -> FloatArray:
        return self.result.recording.volts()[:, self.first : self.last]

    def take(self) -> RunCurves:
        result, recording = self.result, self.result.recording
        gaps = np.array([(gap.first_index, gap.first_index + gap.count) for gap in recording.gaps_of_whole()])
        return RunCurves(
            span_s=(float(self.t[0]), float(self.t[-1])),
            since=result.zero[1].removeprefix("the "),
            unit=recording.digitisation.unit,
            receivers=tuple(self._receiver(number) for number in range(recording.n_receivers)),
            track=self.track(),
            gaps_s=tuple(
                (first / self.rate_hz - self.zero_s, last / self.rate_hz - self.zero_s) for first, last in gaps
            ),
            restarts_s=tuple(self.t[self.restarts].tolist()),
            impacts=tuple(
                (bounce.time_s - self.zero_s, alone(bounce.e, bounce.u_stated) if bounce.valid else "")
                for bounce in result.bounces.impacts
            ),
            motion=self._motion(),
        )

    def _motion(self) -> MotionFigures | None:
        motion = self.result.motion
        if motion is None or motion.time_s.size == 0:
            return None
        time_s, (speed, u_speed) = motion.time_s - self.zero_s, motion.speed()
        # of a sphere that lies it is noise, a hundred times that of one that flies
        flown = np.where(motion.flight >= 0, motion.acceleration_m_s2, np.nan)
        velocity, acceleration = (
            tuple(Banded.of(time_s, row, u) for row, u in zip(rows, of_rows, strict=True))
            for rows, of_rows in (
                (motion.velocity_m_s, motion.u_velocity_m_s),
                (flown, motion.u_acceleration_m_s2),
            )
        )
        return MotionFigures(
            (velocity[0], velocity[1], velocity[2]),
            (acceleration[0], acceleration[1], acceleration[2]),
            Banded.of(motion.position_m[2], speed, u_speed),
        )

    def _curve(self, values: FloatArray) -> Curve:
        return envelope(self.t, values, self.breaks, self.columns)

    def _of_pieces(self, values: FloatArray) -> Curve:
        return envelope(self.t, values, [*self.breaks, *self.restarts], self.columns)

    def _part(self, values: FloatArray | None, row: int) -> FloatArray:
        if values is None:
            return np.full(self.t.size, np.nan)
        return np.asarray(values[row, self.first : self.last])

    def _receiver(self, row: int) -> ReceiverCurves:
        raw = self.volts[2 * row : 2 * row + 2]
        corrected, paths = self.result.corrected, self.result.paths
        # in the precision that files keep: a stored result draws what a computed one does, sample by sample
        i, q = (
            self._part(values, row).astype(np.float32).astype(np.float64)
            for values in ((corrected.i, corrected.q) if corrected else (None, None))
        )
        phase = self._part(paths.phase_rad if paths else None, row)
        phase_raw = unwrap(wrapped_phase(*with_phase_sign(raw, self.result.setup.radar.phase_sign))[None])[0]
        phase_raw = phase_raw - self._at_start(phase_raw, phase)
        ends = [self.first + place for place in (*self.breaks, *self.restarts)]
        return ReceiverCurves(
            name=str(row + 1),
            raw=self._pair(*raw),
            corrected=self._pair(i, q),
            phase_raw=self._curve(phase_raw),
            phase=self._of_pieces(phase),
            phase_difference=self._of_pieces(phase_raw - phase),
            change=self._of_pieces(self._part(paths.change_m if paths else None, row)),
            u_change=self._of_pieces(self._part(paths.u_m if paths else None, row)),
            whole_change=envelope(self.time_s, paths.change_m[row], ends, self.columns // 2) if paths else EMPTY,
            steps=self._steps(row),
            circles=self._circles(row, phase, np.stack([i, q])),
        )

    def _at_start(self, phase_raw: FloatArray, phase: FloatArray) -> float:
        """Return the offset that lets both phases start alike: over the rest, else at the first known sample."""
        difference = phase_raw - (phase if np.isfinite(phase).any() else 0.0)
        segment = self.result.segment
        rest = difference[: max(1, segment.first - self.first)] if segment and segment.has_rest else difference[:1]
        known = rest[np.isfinite(rest)] if np.isfinite(rest).any() else difference[np.isfinite(difference)][:1]
        return float(known.mean()) if known.size else 0.0

    def _pair(self, i: FloatArray, q: FloatArray) -> PairCurves:
        first, last = 0, self.t.size
        if self.result.segment is not None:
            first, last = self.result.segment.first - self.first, self.result.segment.last - self.first
        keep = first + every(last - first, 5 * self.columns)
        return PairCurves(self._curve(i), self._curve(q), Curve(i[keep], q[keep]))

    def _circles(self, row: int, phase: FloatArray, iq: FloatArray) -> tuple[CircleCurves, ...]:
        corrected, segment = self.result.corrected, self.result.segment
        if corrected is None or corrected.steps or segment is None:
            return ()
        volts, turn = self.volts[2 * row : 2 * row + 2], np.stack([np.cos(phase), np.sin(phase)], axis=1)
        names, is_model = [f"{part}{row + 1}" for part in "IQ"], corrected.method in ("joint", "flights")
        kind = "model" if is_model else "circle"
        known = np.isfinite(turn).all(axis=1) & np.isfinite(volts).all(axis=0)
        known[: segment.first - self.first] = known[segment.last - self.first :] = False
        if np.count_nonzero(known) < 1 + turn.shape[1]:
            return tuple(
                CircleCurves(name, self._curve(one), EMPTY, EMPTY, kind) for name, one in zip(names, volts, strict=True)
            )
        # three numbers a channel need no more than some thousand of samples
        used = np.flatnonzero(known)[:: max(1, np.count_nonzero(known) // _FITTED)]
        strength = np.ones((phase.size, 1))
        for _ in range(_ALONG if is_model else 1):
            columns = np.concatenate([np.ones_like(strength), strength * turn], axis=1)
            found = np.linalg.lstsq(columns[used], volts.T[used])[0]
            if is_model:
                # the corrected IQ counts in amplitudes of the place: far from the antennas a volt is more of them
                wave = np.linalg.norm(volts.T - found[0], axis=1) / np.linalg.norm(iq.T @ found[1:], axis=1)
                strength = wave[:, None]
        # that of a model of all channels is its unit circle plus what the samples add to it (method 4)
        rest = strength * ((iq.T - turn) @ found[1:]) if is_model else volts.T - columns @ found
        return tuple(
            CircleCurves(name, self._curve(one), self._of_pieces(one - own), self._of_pieces(own), kind)
            for name, one, own in zip(names, volts, rest.T, strict=True)
        )

    def _steps(self, row: int) -> tuple[StepCurves, ...]:
        corrected = self.result.corrected
        steps = corrected.steps[row] if corrected is not None and row < len(corrected.steps) else None
        if not isinstance(steps, PublishedSteps):
            return ()
        pair = self.volts[2 * row : 2 * row + 2]
        return tuple(map(self._channel_steps, (f"I{row + 1}", f"Q{row + 1}"), (steps.i, steps.q), pair))

    def _channel_steps(self, name: str, found: ChannelSteps, volts: FloatArray) -> StepCurves:
        segment = found.segment
        motion = self.time_s[segment.first : segment.last]
        jumps = [place + self.first - segment.first for place in self.breaks]
        bias = found.bias[self.first : self.last]
        return StepCurves(
            name=name,
            signal=self._curve(volts),
            upper=envelope(motion, found.upper, jumps, self.columns),
            lower=envelope(motion, found.lower, jumps, self.columns),
            bias=self._curve(bias),
            scale=self._curve(found.scale[self.first : self.last]),
            peaks=self._marks(found.peaks, volts),
            valleys=self._marks(found.valleys, volts),
            zero_crossings=self._marks(found.zero_crossings, bias),
            segment_s=(float(motion[0]), float(motion[-1])),
        )

    def _marks(self, places: IntArray, values: FloatArray) -> Curve:
        inside = places[(places >= self.first) & (places < self.last)]
        return Curve(self.time_s[inside], values[inside - self.first])

    def track(self) -> TrackFigures | None:
        track = self.result.track
        if track is None:
            return None
        position = track.position_m[:, self.first : self.last]
        u = track.u_position_m[:, self.first : self.last]
        known = np.flatnonzero(np.isfinite(position).all(axis=0))
        drawn = known[every(known.size, _TRACK_POINTS)]
        places = np.insert(position[:, drawn], np.searchsorted(drawn, self.restarts), np.nan, axis=1)
        normal = self.result.bounces.normal or self.result.setup.floor.normal
        height = np.asarray(normal) @ position
        x, y, _ = (self._of_pieces(row) for row in position)
        ux, uy, uz = (self._of_pieces(row) for row in u)
        level = normal[2] > 1.0 - 1e-9
        return TrackFigures(x, y, self._of_pieces(height), level, (ux, uy, uz), places, *self._fall(height))

    def _fall(self, height_m: FloatArray) -> tuple[Curve, ...]:
        """Return parabola, residual, way fallen and residual from the vertex on; nothing where no fall was fitted."""
        fall, impacts = self.result.bounces.free_fall, self.result.bounces.impacts
        if fall is None:
            return ()
        first, last = fall.first_time_s - self.zero_s, fall.last_time_s - self.zero_s
        end = max(last, impacts[0].time_s - self.zero_s if impacts else last)
        t = np.linspace(first, end, 100)
        parabola = np.asarray(np.polynomial.polynomial.polyval(t - first, fall.parabola), np.float64)
        time_s = self.t + self.zero_s
        residual, fallen, since_vertex = fall_curves(time_s, height_m, fall, self.columns)
        return Curve(t, parabola), Curve(residual.x - self.zero_s, residual.y), fallen, since_vertex


def fall_curves(
    time_s: FloatArray, height_m: FloatArray, fall: FreeFall, columns: int = COLUMNS
) -> tuple[Curve, Curve, Curve]:
    """Return what the parabola leaves, the way fallen from its vertex on, and what it leaves from there on.

    Parameters
    ----------
    time_s, height_m
        Along the floor's normal, shape (n,).
    fall
        The fitted fall.
    columns
        Of the residual.
    """
    inside = (time_s >= fall.first_time_s) & (time_s <= fall.last_time_s)
    t, height_m = time_s[inside], height_m[inside]
    fitted = np.polynomial.polynomial.polyval(t - fall.first_time_s, fall.parabola)
    at, slope, bend = fall.parabola
    since, top = (-slope / (2.0 * bend), at - slope**2 / (4.0 * bend)) if bend else (0.0, at)
    residual = envelope(t, height_m - fitted, columns=columns)
    since += fall.first_time_s
    return residual, envelope(t - since, top - height_m, columns=_FALL_COLUMNS), Curve(residual.x - since, residual.y)


def _span(result: RunResult) -> tuple[int, int]:
    """Return the samples drawn: the motion and some rest on both sides; all of them without motion."""
    count, segment = result.recording.n_samples, result.segment
    if segment is None or segment.last - segment.first < 2:
        return 0, count
    least = round(_MIN_MARGIN_S * result.recording.digitisation.sample_rate_hz)
    margin = max(least, round(_MARGIN * (segment.last - segment.first)))
    return max(0, segment.first - margin), min(count, segment.last + margin)
