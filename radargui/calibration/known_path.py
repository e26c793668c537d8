"""Known motions: stage, turntable, pendulum, or a table of places, read from a file and checked."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, TypeAdapter, ValidationError
from scipy.interpolate import CubicSpline, PchipInterpolator
from scipy.special import ellipj, ellipk

from radargui.calibration.unknowns import Unknown
from radargui.model.arrays import BoolArray, FloatArray
from radargui.model.errors import SetupError
from radargui.model.gravity import NOMINAL_GRAVITY_M_S2
from radargui.model.section import Real, Section, Vector
from radargui.model.setup import load_toml

Positive = Annotated[Real, Field(gt=0.0, le=1e4)]
Small = Annotated[Real, Field(ge=0.0, le=1.0)]
Angle = Annotated[Real, Field(ge=-360.0, le=360.0)]
Clock = Literal["free", "shared"]
DIFFERENCE_S, DIFFERENCE_DEG = 1e-4, 1e-3
"""Half the step of differences for velocity and acceleration: they carry a place over the delay between channels; step
of a turntable's zero."""


class _Path(Section):
    """The keys that all kinds of known motions share.

    Attributes
    ----------
    u_position_m
        Standard uncertainty of the trajectory's place as a whole, each coordinate.
    clock
        free: time 0 is anywhere in the recording, and the clock's scale is unknown; shared: the recording's own clock.
    u_clock_scale
        Standard uncertainty of the duration of a second, relative.
    """

    u_position_m: Small = 2e-4
    clock: Clock = "free"
    u_clock_scale: Small = 1e-4


class Stage(_Path):
    """A straight stage: from one point to the other at a speed, or in equal steps with a rest after each.

    Attributes
    ----------
    from_m, to_m
        Centre of the sphere at both ends.
    speed_m_s, ramp_s
        Speed between the ends, and duration of the even acceleration and deceleration; with steps, of each step.
    steps, dwell_s
        Number of steps, and rest after each.
    """

    kind: Literal["stage"]
    from_m: Vector
    to_m: Vector
    speed_m_s: Positive
    ramp_s: Annotated[Real, Field(ge=0.0, le=60.0)] = 0.0
    steps: Annotated[int, Field(ge=1, le=10000)] = 1
    dwell_s: Annotated[Real, Field(ge=0.0, le=600.0)] = 0.0

    def trajectory(self, folder: Path) -> Trajectory:
        """Return its motion."""
        begin, whole = np.array(self.from_m), np.array(self.to_m) - np.array(self.from_m)
        length = float(np.linalg.norm(whole)) / self.steps
        # a longer ramp would end before the speed is reached
        ramp = min(self.ramp_s, length / self.speed_m_s)
        moving = length / self.speed_m_s + ramp
        period = moving + self.dwell_s

        def place(time: FloatArray) -> FloatArray:
            number = np.clip(np.floor(time / period), 0, self.steps - 1)
            share = _ramped(time - number * period, moving, ramp) * self.speed_m_s / length if length else 0.0 * time
            return np.asarray(begin[:, None] + whole[:, None] * ((number + share) / self.steps))

        return Trajectory(self, "straight stage", place, self.steps * period - self.dwell_s, folder=folder)


class Turntable(_Path):
    """A turntable that carries the sphere on a circle.

    Attributes
    ----------
    centre_m, radius_m, normal
        Centre, radius and normal of the circle; seen from the tip of the normal it turns anticlockwise.
    rate_deg_s, turns, ramp_s
        Rate, number of turns, and duration of the even acceleration and deceleration.
    encoder
        CSV file `time_s,angle_deg` instead of rate and turns.
    zero_deg
        Angle at the start (or of the encoder's zero), from the x axis projected into the plane; left out: unknown.
    """

    kind: Literal["turntable"]
    centre_m: Vector
    radius_m: Positive
    normal: Vector = (0.0, 0.0, 1.0)
    rate_deg_s: Annotated[Real, Field(ge=-7200.0, le=7200.0)] | None = None
    turns: Positive = 1.0
    ramp_s: Annotated[Real, Field(ge=0.0, le=60.0)] = 0.0
    encoder: str | None = None
    zero_deg: Angle | None = None

    def trajectory(self, folder: Path) -> Trajectory:
        """Return its motion."""
        normal = np.array(self.normal) / np.linalg.norm(self.normal)
        # towards the x axis, or the y axis where that is the normal
        first = np.eye(3)[0 if abs(normal[0]) < 0.9 else 1]
        first = first - normal * (normal @ first)
        first /= np.linalg.norm(first)
        second, centre = np.cross(normal, first), np.array(self.centre_m)
        if self.encoder is not None:
            # between two values a monotone curve: a table that stands still must not swing past its angle
            table = read_table(folder / self.encoder, ("time_s", "angle_deg"))
            curve, duration, begin = PchipInterpolator(table[0], table[1]), float(table[0, -1]), float(table[0, 0])
            angle: Callable[[FloatArray], FloatArray] = lambda t: curve(np.clip(t, begin, duration))  # noqa: E731
        elif self.rate_deg_s:
            rate, begin = self.rate_deg_s, 0.0
            # in a ramp half as far is gone: both together cost one more ramp of time
            duration = 360.0 * self.turns / abs(rate) + self.ramp_s
            angle = lambda t: rate * _ramped(t, duration, self.ramp_s)  # noqa: E731
        else:
            raise SetupError("a turntable needs rate_deg_s or encoder", remedy="Give one of them in the path file.")

        def place(time: FloatArray, zero_deg: float = 0.0) -> FloatArray:
            turned = np.radians(angle(time) + zero_deg)
            around = first[:, None] * np.cos(turned) + second[:, None] * np.sin(turned)
            return np.asarray(centre[:, None] + self.radius_m * around)

        words = f"turntable, radius {1e3 * self.radius_m:g} mm"
        return Trajectory(self, words, place, duration, begin, self.zero_deg, has_zero=True, folder=folder)


class PendulumPath(_Path):
    """A simple pendulum of any amplitude, let go at rest, caught at a turning point.

    theta: sin(theta / 2) = sin(theta_0 / 2) cd(sqrt(g / l) t, m), m = sin^2(theta_0 / 2) (NIST Digital Library of
    Mathematical Functions, 22.19.2).

    Attributes
    ----------
    pivot_m, length_m, amplitude_deg, azimuth_deg
        Where it hangs, its length to the sphere's centre, and where it starts.
    swings
        Number of swings until it is caught.
    g_m_s2
        Gravity of the place.
    """

    kind: Literal["pendulum"]
    pivot_m: Vector
    length_m: Positive
    amplitude_deg: Annotated[Real, Field(gt=0.0, lt=180.0)]
    azimuth_deg: Angle = 0.0
    swings: Positive = 1000.0
    g_m_s2: Annotated[Real, Field(ge=0.1, le=30.0)] = NOMINAL_GRAVITY_M_S2

    def trajectory(self, folder: Path) -> Trajectory:
        """Return its motion."""
        m = float(np.sin(0.5 * np.radians(self.amplitude_deg))) ** 2
        rate, pivot = np.sqrt(self.g_m_s2 / self.length_m), np.array(self.pivot_m)
        # from turning point to turning point; at 30 degrees 1.7 % longer than for a small swing
        half = 2.0 * float(ellipk(m)) / rate
        # caught where it rests by itself: anywhere else the hand that catches it would be part of the motion
        duration = half * max(round(2.0 * self.swings), 1)
        azimuth = np.radians(self.azimuth_deg)
        heading = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])

        def place(time: FloatArray) -> FloatArray:
            # cd = cn / dn: one at time 0, where the pendulum is let go at rest
            _, cn, dn, _ = ellipj(rate * np.clip(time, 0.0, duration), m)
            angle = 2.0 * np.arcsin(np.sqrt(m) * cn / dn)
            along = heading[:, None] * np.sin(angle) - np.array([[0.0], [0.0], [1.0]]) * np.cos(angle)
            return np.asarray(pivot[:, None] + self.length_m * along)

        return Trajectory(self, f"pendulum, length {1e3 * self.length_m:g} mm", place, duration, folder=folder)


class Table(_Path):
    """Places at times from a CSV file `time_s,x_m,y_m,z_m`; before the first and after the last the sphere rests."""

    kind: Literal["table"]
    file: str

    def trajectory(self, folder: Path) -> Trajectory:
        """Return its motion: cubic splines through the places."""
        table = read_table(folder / self.file, ("time_s", "x_m", "y_m", "z_m"))
        begin, end = float(table[0, 0]), float(table[0, -1])
        # its acceleration has no jumps: it carries a place over the delay between channels
        curve = CubicSpline(table[0], table[1:].T, bc_type="natural")
        words = f"table {Path(self.file).name}"
        return Trajectory(self, words, lambda t: np.asarray(curve(np.clip(t, begin, end)).T), end, begin, folder=folder)


AnyPath = Annotated[Stage | Turntable | PendulumPath | Table, Field(discriminator="kind")]


@dataclass(frozen=True)
class Trajectory:
    """A known motion in its own time.

    Attributes
    ----------
    path
        The entry of the file that describes it.
    words
        For people.
    place
        Positions (3, n) at times (n,) of its own; a turntable's also by the angle of its zero.
    end_s, begin_s
        Times between which the sphere may move.
    zero_deg, has_zero
        Angle of a turntable's zero, None if unknown; whether the motion has a zero at all.
    folder
        Folder of the files that it names.
    """

    path: _Path
    words: str
    place: Callable[..., FloatArray]
    end_s: float
    begin_s: float = 0.0
    zero_deg: float | None = None
    has_zero: bool = False
    folder: Path = Path()

    def __reduce__(self) -> tuple[Any, ...]:
        # what it is made of goes to another process; functions cannot
        return _made_again, (self.path, self.folder)


@dataclass(frozen=True)
class KnownMotion:
    """A trajectory in a recording, with its clock and the uncertainty of its place.

    Attributes
    ----------
    trajectory
        In its own time.
    offset_s, u_offset_s
        Time of the recording at which it begins, first guess and prior deviation.
    zero_deg
        First guess of a turntable's zero where that is not known.
    """

    trajectory: Trajectory
    offset_s: float = 0.0
    u_offset_s: float = 0.0
    zero_deg: float = 0.0
    uses: tuple[str, ...] = ()

    @property
    def own(self) -> tuple[Unknown, ...]:
        """Unknowns of this recording alone; those with u = 0 are held."""
        one, path = self.trajectory, self.trajectory.path
        free = path.clock == "free"
        out = [
            Unknown("clock.offset_s", self.offset_s, self.u_offset_s),
            Unknown("clock.scale", 1.0, path.u_clock_scale if free else 0.0),
            *(Unknown(f"path.{axis}_m", 0.0, path.u_position_m) for axis in "xyz"),
        ]
        if one.has_zero:
            # 24 zeros were tried, so that the best is near: the deviation only leaves it free
            unknown = one.zero_deg is None
            out.append(Unknown("path.zero_deg", self.zero_deg if unknown else one.zero_deg or 0.0, 60.0 * unknown))
        return tuple(out)

    def known(self, time_s: FloatArray) -> BoolArray:
        """Return that the motion is known at all times, shape (n,)."""
        return np.ones(time_s.size, dtype=np.bool_)

    def at(self, time_s: FloatArray, _shared: Mapping[str, float], own: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return place, velocity and acceleration at times, shape (3, 3, n); nothing else is known."""
        h = DIFFERENCE_S
        before, here, after = (self._place(time, own) for time in (time_s - h, time_s, time_s + h))
        return np.stack([here, (after - before) / (2.0 * h), (after - 2.0 * here + before) / h**2]), np.empty(0)

    def slopes(self, time_s: FloatArray, shared: Mapping[str, float], own: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return derivatives of places by its own unknowns, (n_own, 3, n), what is held not; nothing else is known."""
        (place, velocity, _), _ = self.at(time_s, shared, own)
        out = np.zeros((own.size, 3, time_s.size))
        # velocities are by the recording's time
        out[0], out[1] = -velocity, velocity * (time_s - own[0]) / own[1]
        out[2:5] = np.eye(3)[:, :, None]
        for number in range(5, own.size):
            turned = own + DIFFERENCE_DEG * (np.arange(own.size) == number)
            out[number] = (self._place(time_s, turned) - place) / DIFFERENCE_DEG
        return out, np.empty((own.size, 0))

    def _place(self, time_s: FloatArray, own: FloatArray) -> FloatArray:
        # the zero of a turntable comes last, after the clock and the three shifts
        offset, scale, *moved = own
        return np.asarray(self.trajectory.place((time_s - offset) * scale, *moved[3:]) + np.array([moved[:3]]).T)


def _made_again(path: Any, folder: Path) -> Trajectory:
    trajectory: Trajectory = path.trajectory(folder)
    return trajectory


def read_known(path: Path, clock: Clock | None = None) -> Trajectory:
    """Return the trajectory that a path file (TOML) or a table (CSV) describes.

    Parameters
    ----------
    path
        The file; files that it names lie beside it.
    clock
        Instead of the file's.

    Raises
    ------
    SetupError
        Unreadable, or a key missing, unknown or out of range.
    """
    try:
        if path.suffix.lower() == ".csv":
            document: dict[str, Any] = {"kind": "table", "file": path.name}
        else:
            document = load_toml(path.read_text(encoding="utf-8-sig"))
        if clock is not None:
            document["clock"] = clock
        adapter: TypeAdapter[Stage | Turntable | PendulumPath | Table] = TypeAdapter(AnyPath)
        return adapter.validate_python(document).trajectory(path.parent)
    except OSError as error:
        raise SetupError(f"{path}: {error.strerror or error}", remedy="Check the path of the file.") from None
    except ValidationError as error:
        first = error.errors()[0]
        place = ".".join(str(part) for part in first["loc"] if part not in ("stage", "turntable", "pendulum", "table"))
        raise SetupError(f"{path}: {place or 'kind'}: {first['msg']}") from None
    except ValueError as error:
        raise SetupError(f"{path} is no path file: {error}", remedy="Start from one in resources/paths.") from None


def read_table(path: Path, names: tuple[str, ...]) -> FloatArray:
    """Return the columns of a CSV file with this header, shape (n_columns, n).

    Raises
    ------
    SetupError
        Unreadable, another header, fewer than four rows, times that do not grow.
    """
    try:
        header, _, rest = path.read_text(encoding="utf-8-sig").partition("\n")
        if tuple(name.strip() for name in header.split(",")) != names:
            raise SetupError(f"{path}: the header is {header.strip()!r}, allowed: {','.join(names)}")
        table = np.array([line.split(",") for line in rest.splitlines() if line.strip()], dtype=float).T
    except OSError as error:
        raise SetupError(f"{path}: {error.strerror or error}", remedy="Check the path of the file.") from None
    except ValueError:
        raise SetupError(f"{path} is no table of numbers with {len(names)} columns") from None
    if table.ndim != 2 or table.shape[1] < 4 or not np.isfinite(table).all() or (np.diff(table[0]) <= 0.0).any():
        raise SetupError(f"{path}: allowed are four rows of numbers or more, in growing time")
    return table


def _ramped(time: FloatArray, duration: float, ramp: float) -> FloatArray:
    """Return the integral of a speed that is 1 but for an even rise and fall of `ramp` at both ends."""
    t = np.clip(time, 0.0, duration)
    if ramp <= 0.0:
        return np.asarray(t)
    rising, falling = np.minimum(t, ramp), np.maximum(t - (duration - ramp), 0.0)
    # a speed of t / ramp while it rises; what it has lost while it falls
    return np.asarray(t - rising + rising**2 / (2.0 * ramp) - falling**2 / (2.0 * ramp))
