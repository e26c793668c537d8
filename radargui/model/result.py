"""The values that the chain produces, from the segment to the bounces, and the result that holds them."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any, Generic, Literal, TypeVar

import numpy as np

from radargui.model.arrays import BoolArray, FloatArray, IntArray
from radargui.model.channel_quality import ChannelQuality
from radargui.model.finding import Finding, texts
from radargui.model.front_end import FrontEndPrior
from radargui.model.recording import Recording
from radargui.model.setup import Setup
from radargui.model.setup_pool import SetupPrior
from radargui.model.setup_posterior import SetupLikelihood, SetupValue
from radargui.model.uncertainty_budget import UncertaintyBudget


@dataclass(frozen=True, slots=True)
class Bounce:
    """One impact.

    Attributes
    ----------
    time_s, speed_before_m_s, speed_after_m_s
        Instant of impact, and speeds along the floor's normal there, positive.
    e
        Coefficient of restitution, after / before.
    u_e
        Its standard uncertainty.
    method
        How the speeds were found.
    valid
        False if the signal does not support the coefficient.
    e_flight_time
        e from the time T until the next impact, g T / (2 v_before); NaN without a next impact.
    e_height
        e from the height h of the following apex, sqrt(2 g h) / v_before; NaN without a next impact.
    u_e_combined
        Standard uncertainty of e with what antennas, floor and sphere leave open; NaN where it was not carried.
    x_m, y_m, z_m, u_position_m
        Where the centre was, and the standard uncertainty of a coordinate, root mean square of the three.
    u_speed_before_m_s, u_speed_after_m_s
        Standard uncertainties of the speeds.
    angle_deg, u_angle_deg
        Angle of incidence from the normal.
    vt_before_m_s, vt_after_m_s
        Speeds along the floor.
    e_t, u_e_t
        Component of the velocity along the floor after the impact in the direction of the one before, over that before;
        NaN where that is zero within three times its uncertainty.
    e_times, u_e_times
        From times alone: the flight after the impact over the one before, under the air's drag, and its standard
        uncertainty, that of the instants. NaN without a next impact, and where the flights were not fitted.
    mu, u_mu
        Apparent friction: the change of the velocity along the floor over that along the normal, a lower limit of the
        coefficient of sliding friction.

    All velocities are of the centre: e_t is not the restitution of the point of contact, which spin would need. Values
    that were not computed are NaN.
    """

    time_s: float
    speed_before_m_s: float
    speed_after_m_s: float
    e: float
    u_e: float
    method: str
    valid: bool
    e_flight_time: float = float("nan")
    e_height: float = float("nan")
    u_e_combined: float = float("nan")
    x_m: float = float("nan")
    y_m: float = float("nan")
    z_m: float = float("nan")
    u_position_m: float = float("nan")
    u_speed_before_m_s: float = float("nan")
    u_speed_after_m_s: float = float("nan")
    angle_deg: float = float("nan")
    u_angle_deg: float = float("nan")
    vt_before_m_s: float = float("nan")
    vt_after_m_s: float = float("nan")
    e_t: float = float("nan")
    u_e_t: float = float("nan")
    mu: float = float("nan")
    u_mu: float = float("nan")
    e_times: float = float("nan")
    u_e_times: float = float("nan")

    @property
    def u_stated(self) -> float:
        """What people read behind the ±: the combined uncertainty of e where it is known, else the statistical."""
        return self.u_e_combined if math.isfinite(self.u_e_combined) else self.u_e


@dataclass(frozen=True, slots=True)
class FreeFall:
    """The first fall, compared with a parabola.

    Attributes
    ----------
    g_m_s2, u_g_m_s2
        Acceleration and its standard uncertainty.
    first_time_s, last_time_s
        Span of the fit.
    release_height_m
        Height at rest before the fall, along the floor's normal.
    drop_height_m
        Height at rest above the height of the first impact; NaN where the fall ends without one.
    parabola
        Coefficients of the height along the floor's normal, a + b (t - first) + c (t - first)^2 in m, m/s, m/s^2.
    residual_rms_m
        Root mean square of the height against the parabola.
    """

    g_m_s2: float
    u_g_m_s2: float
    first_time_s: float
    last_time_s: float
    release_height_m: float
    drop_height_m: float
    parabola: tuple[float, float, float]
    residual_rms_m: float


@dataclass(frozen=True, slots=True)
class VelocitiesAtImpacts:
    """Velocities of the centre at impacts, as an estimate knows them.

    Attributes
    ----------
    time_s
        Shape (n_impacts,).
    before_m_s, after_m_s
        Shape (n_impacts, 3).
    covariance
        Covariance of (before x, y, z, after x, y, z) with the setup held, shape (n_impacts, 6, 6).
    slope_variance
        Variance of the floor's slope, x / z and y / z of its normal, where the impacts determined it.
    """

    time_s: FloatArray
    before_m_s: FloatArray
    after_m_s: FloatArray
    covariance: FloatArray
    slope_variance: float = 0.0

    def widened(self, factor: float) -> VelocitiesAtImpacts:
        """Return them with uncertainties times a factor."""
        return replace(self, covariance=factor**2 * self.covariance)


@dataclass(frozen=True, slots=True)
class Bounces:
    """All impacts of a run in time order, and the fall before the first.

    Attributes
    ----------
    impacts, free_fall
        What was found.
    normal
        Unit vector away from the floor, along which speeds and heights are counted; None without any.
    u_tilt_deg
        Standard uncertainty of its angle from the vertical, where it was found from the impacts with one.
    braked_1_m, walls_s, with_walls_s
        k of the drag that flights show beyond a metal sphere's; when walls were met, or the floor with one (not valid).
    falls_with_m_s2
        Acceleration with which something falls and bounces, if it is not the g of the site; then nothing else is given.
    velocities
        Velocities from which speeds, angles and friction are computed; None after that, and where unknown.
    """

    impacts: tuple[Bounce, ...] = ()
    free_fall: FreeFall | None = None
    normal: tuple[float, float, float] | None = None
    u_tilt_deg: float | None = None
    braked_1_m: float | None = None
    walls_s: tuple[float, ...] = ()
    with_walls_s: tuple[float, ...] = ()
    falls_with_m_s2: float | None = None
    velocities: VelocitiesAtImpacts | None = field(default=None, repr=False, compare=False)

    def widened(self, factor: float) -> Bounces:
        """Return them with the uncertainties of every e and of g times a factor."""
        fall = self.free_fall
        # not the combined ones: the budget makes them later, from these
        return replace(
            self,
            impacts=tuple(replace(one, u_e=factor * one.u_e) for one in self.impacts),
            free_fall=None if fall is None else replace(fall, u_g_m_s2=factor * fall.u_g_m_s2),
            velocities=None if self.velocities is None else self.velocities.widened(factor),
        )


@dataclass(frozen=True, slots=True)
class Segment:
    """Sample ranges of the motion and of the rest before it.

    Attributes
    ----------
    first, last
        Samples first:last hold the motion (last excluded).
    rest_first, rest_last
        Samples rest_first:rest_last lie at rest before the motion; equal where there is no rest.
    """

    first: int
    last: int
    rest_first: int
    rest_last: int

    @property
    def has_rest(self) -> bool:
        """Whether there is rest before the motion."""
        return self.rest_last > self.rest_first


@dataclass(frozen=True, slots=True)
class CorrectedIQ:
    """I and Q without mismatch.

    Attributes
    ----------
    time_s
        Shape (n_samples,).
    i, q
        In amplitudes (unit circle), shape (n_receivers, n_samples); NaN where unknown.
    valid
        Shape (n_receivers, n_samples).
    u_phase_rad
        Standard uncertainty of the phase, shape (n_receivers, n_samples).
    method, channels
        Correction used: joint, flights, adaptive, published, ellipse or none; quality of each receiver.
    steps
        Intermediate results of the correction for display, one a receiver: PublishedSteps, Ellipse or None.
    decisions
        Choices of an estimate by evidence, one sentence each.
    """

    time_s: FloatArray
    i: FloatArray
    q: FloatArray
    valid: BoolArray
    u_phase_rad: FloatArray
    method: str
    channels: tuple[ChannelQuality, ...]
    steps: tuple[object, ...] = ()
    decisions: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class PathLengths:
    """Change of each receiver's path length.

    Attributes
    ----------
    time_s
        Shape (n_samples,).
    phase_rad
        Unwrapped, sign applied, 0 at rest, shape (n_receivers, n_samples); NaN where unknown.
    change_m
        wavelength * phase / (2 pi), shape (n_receivers, n_samples); NaN where unknown.
    u_m
        Standard uncertainty of `change_m`, same shape.
    valid
        Shape (n_receivers, n_samples).
    piece
        Number of the piece each sample belongs to, from 0, shape (n_samples,): it changes where a path was lost, and
        lengths of two pieces have no common zero. None: all is one piece.
    """

    time_s: FloatArray
    phase_rad: FloatArray
    change_m: FloatArray
    u_m: FloatArray
    valid: BoolArray
    piece: IntArray | None = None

    def restarts(self) -> IntArray:
        """Return the first sample of each piece but the first, shape (n_pieces - 1,)."""
        if self.piece is None:
            return np.empty(0, dtype=np.intp)
        # lengths of two pieces have no common zero: nothing may be differenced across one
        return np.flatnonzero(np.diff(self.piece)) + 1


@dataclass(frozen=True, slots=True)
class Track:
    """Position against time.

    Attributes
    ----------
    time_s
        Shape (n_samples,).
    position_m
        Centre of the sphere, shape (3, n_samples); NaN where unknown.
    u_position_m
        Standard uncertainty, shape (3, n_samples).
    valid
        Shape (n_samples,).
    geometry
        exact or plane.
    u_combined_m
        Standard uncertainty with what antennas, release and sphere leave open, shape (3, n_samples); None where it was
        not carried.
    """

    time_s: FloatArray
    position_m: FloatArray
    u_position_m: FloatArray
    valid: BoolArray
    geometry: str
    u_combined_m: FloatArray | None = None


@dataclass(frozen=True, slots=True)
class Kinematics:
    """Place, velocity and acceleration of the sphere's centre a thousand times a second, from the whole estimate.

    Attributes
    ----------
    time_s
        Of the motion, whole milliseconds, shape (n,).
    position_m, velocity_m_s, acceleration_m_s2
        Shape (3, n). At an impact's very instant the velocity is that after it.
    u_position_m, u_velocity_m_s, u_acceleration_m_s2
        Standard uncertainties with the setup held, same shape.
    flight
        Number of the flight, from 0; -1 where the sphere does not fly, shape (n,).
    """

    time_s: FloatArray
    position_m: FloatArray
    velocity_m_s: FloatArray
    acceleration_m_s2: FloatArray
    u_position_m: FloatArray
    u_velocity_m_s: FloatArray
    u_acceleration_m_s2: FloatArray
    flight: IntArray

    def speed(self) -> tuple[FloatArray, FloatArray]:
        """Return the speed along the way and its standard uncertainty, shape (n,) each."""
        speed = np.linalg.norm(self.velocity_m_s, axis=0)
        # what is known across the way is no part of it
        along = self.velocity_m_s / np.maximum(speed, 1e-9)
        return speed, np.sqrt(((along * self.u_velocity_m_s) ** 2).sum(axis=0))

    def widened(self, factor: float) -> Kinematics:
        """Return it with uncertainties times a factor."""
        return replace(
            self,
            u_position_m=factor * self.u_position_m,
            u_velocity_m_s=factor * self.u_velocity_m_s,
            u_acceleration_m_s2=factor * self.u_acceleration_m_s2,
        )


def whole_milliseconds(first_s: float, last_s: float) -> FloatArray:
    """Return the whole milliseconds from one time to another, shape (n,)."""
    return np.arange(math.ceil(1e3 * first_s), math.floor(1e3 * last_s) + 1) / 1e3


Status = Literal["ok", "no_motion", "rejected"]


_T = TypeVar("_T")


class Deferred(Generic[_T]):
    """A value of a result, or how it is made: once, when it is first asked for.

    A result has one column for each stored sample, and few readers want all of them.
    """

    def __set_name__(self, owner: type, name: str) -> None:
        self._name = name

    def __get__(self, result: Any, owner: type) -> _T | None:
        value = result.__dict__[self._name]
        if callable(value):
            value = result.__dict__[self._name] = value()
        made: _T | None = value
        return made

    def __set__(self, result: Any, value: _T | Callable[[], _T] | None) -> None:
        # where a field is left out the dataclass gives its default: the descriptor itself
        result.__dict__[self._name] = None if value is self else value


@dataclass(frozen=True, slots=True)
class Quality:
    """Which correction was used, and how good each receiver is by it."""

    method: str
    channels: tuple[ChannelQuality, ...]


@dataclass(frozen=True)
class RunResult:
    """What one recording gave under one setup.

    Attributes
    ----------
    recording, setup
        What went in.
    status
        ok; no_motion (an answer, not an error); rejected.
    segment
        The motion and the rest before it; None without motion.
    corrected, paths, track
        The intermediate values, made when they are first asked for; None where the chain ended before. `track` is None
        with fewer than 3 receivers.
    bounces
        Impacts and first fall.
    motion
        Velocities and accelerations; None if the correction does not determine them.
    uncertainty_budget
        The shares of the uncertainty; None without a track.
    setup_posterior
        What the recording says of antennas, release and wavelength; empty where it says nothing.
    setup_likelihood
        The likelihood of these values by the recording alone, without a prior, for pooling; None: nothing is said.
    findings
        The findings: those that refuse the run, else why nothing moves, and those that the operator must know.
    preliminary
        Whether this result is by a simpler correction, because the wanted one is still being computed or was stopped.
    front_end_prior
        What earlier runs of the session said about the front ends, and whether it was used; None where nothing was
        known or asked.
    setup_prior
        What other runs of the session said of antennas, release and wavelength, and whether it was used; None where
        nothing was known or asked.
    reported_quality
        What `quality` says where it is known without making `corrected`.
    """

    recording: Recording = field(repr=False)
    setup: Setup = field(repr=False)
    status: Status
    segment: Segment | None = None
    corrected: Deferred[CorrectedIQ] = field(default=Deferred[CorrectedIQ](), repr=False)
    paths: Deferred[PathLengths] = field(default=Deferred[PathLengths](), repr=False)
    track: Deferred[Track] = field(default=Deferred[Track](), repr=False)
    bounces: Bounces = field(default_factory=Bounces)
    motion: Kinematics | None = field(default=None, repr=False)
    uncertainty_budget: UncertaintyBudget | None = None
    setup_posterior: tuple[SetupValue, ...] = ()
    setup_likelihood: SetupLikelihood | None = field(default=None, repr=False, compare=False)
    findings: tuple[Finding, ...] = ()
    preliminary: bool = False
    front_end_prior: FrontEndPrior | None = None
    setup_prior: SetupPrior | None = None
    reported_quality: Quality | None = field(default=None, repr=False, compare=False)

    @property
    def reason(self) -> str:
        """Why the status is not ok, in words."""
        return "; ".join(texts(one for one in self.findings if one.severity == "refuse"))

    @property
    def warnings(self) -> tuple[str, ...]:
        """Findings that the operator must know, in words."""
        return texts(one for one in self.findings if one.severity == "warn")

    @property
    def quality(self) -> Quality | None:
        """The correction used and the quality of its receivers; None where the flow ended before."""
        if self.reported_quality is not None:
            return self.reported_quality
        corrected = self.corrected
        return None if corrected is None else Quality(corrected.method, corrected.channels)

    @property
    def zero(self) -> tuple[float, str]:
        """The instant that counts as t = 0 for people, in s of the recording, and what it is.

        The trigger, else the first motion, else the first sample. Tables for programs keep the recording's own time.
        """
        recording = self.recording
        time_s = recording.time_s()
        if time_s.size == 0:
            return 0.0, "the first sample"
        # what the operator set goes before what was found
        if recording.trigger_index is not None:
            return float(recording.trigger_index / recording.digitisation.sample_rate_hz), "the trigger"
        if self.segment is not None:
            return float(time_s[min(self.segment.first, time_s.size - 1)]), "the first motion"
        return float(time_s[0]), "the first sample"
