"""What track views draw: the field of view; the live trail, or a result with its impacts and the fitted fall."""

from dataclasses import dataclass, field, replace

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.model.gravity import expected_gravity_m_s2
from radargui.model.result import Kinematics, RunResult
from radargui.model.setup import Setup
from radargui.motion.speed import speed_along
from radargui.physics.path_length import HALF_FIELD_M, place_antennas
from radargui.report.curves import take_track

MM = 1000.0  # in a metre
_MARGIN_MM = 20.0
"""Of the box above the release and below the floor (chosen by hand): the sphere is not drawn upon its edge."""


@dataclass(frozen=True, slots=True)
class Space:
    """The field of view as it is drawn.

    Attributes
    ----------
    low_mm, high_mm
        Corners, shape (3,).
    floor_mm
        z of the centre where it touches.
    antennas
        Name and direction (unit vector, shape (3,)) of each antenna, the transmitter first.
    gravity_m_s2
        g of the place.
    """

    low_mm: FloatArray
    high_mm: FloatArray
    floor_mm: float
    antennas: tuple[tuple[str, FloatArray], ...]
    gravity_m_s2: float

    @property
    def size_mm(self) -> FloatArray:
        """Edges of the box, shape (3,)."""
        return np.asarray(self.high_mm - self.low_mm)


def space_of(setup: Setup) -> Space:
    """Return the box around the field of view (about 30 cm wide), release and floor."""
    release, half = np.array(setup.tracer.release_position_m) * MM, HALF_FIELD_M * MM
    floor = -half if setup.floor.height_m is None else setup.floor.height_m * MM
    # upwards the box ends where the sphere is released, not where the field of view does
    low = np.minimum((-half, -half, min(floor, release[2] - _MARGIN_MM)), release)
    high = np.maximum((half, half, release[2]), release)
    margin = np.array([0.0, 0.0, _MARGIN_MM])
    placed = place_antennas(setup)
    places = np.vstack([placed.transmitter_m, placed.receivers_m])
    directions = places / np.linalg.norm(places, axis=1, keepdims=True)
    names = ("Tx", *(f"Rx {number + 1}" for number in range(placed.n_receivers)))
    antennas = tuple(zip(names, directions, strict=True))
    return Space(low - margin, high + margin, floor, antennas, expected_gravity_m_s2(setup.site))


_MAX_POINTS = 6000
"""Of a track: four for each bin of the height's plot, which draws the lowest and the highest of them."""
_BREAK_POINTS = 8
"""Unknown points where a path was lost: the height's plot draws two of four points, and fewer could vanish in it."""


@dataclass(frozen=True, slots=True)
class ShownTrack:
    """A track thinned for the screen.

    Attributes
    ----------
    time_s
        Shape (n,); of a result from its trigger on, of a live trail before now.
    position_mm
        Shape (3, n); NaN breaks the line.
    impact_time_s, impact_mm
        Shape (n_impacts,) and (3, n_impacts).
    fit_time_s, fit_mm
        Parabola of the first fall, as far as the first impact, shape (n_fit,).
    residual_time_s, residual_mm, residual_u_mm
        Height less the parabola over the span of the fit, its statistical standard uncertainty, shape (n_residual,).
    speed_m_s
        Shape (n,); NaN where unknown.
    u_mm, u_kind
        Standard uncertainty of the position, shape (3, n), and which: combined where it is known, else statistical;
        NaN of a live track.
    motion, zero_s
        Velocities and accelerations of a result that knows them, and the instant that its times count from.
    zero
        What the times of a result count from.
    shaken
        Of a live trail: instants at which the trigger looked, and how hard the voltages shook, shape (2, n).
    sphere_mm
        Where the sphere is drawn, shape (3, 1): now, or where the track of a result ends; (3, 0) where nobody knows.
    """

    time_s: FloatArray
    position_mm: FloatArray
    impact_time_s: FloatArray = field(default_factory=lambda: np.empty(0))
    impact_mm: FloatArray = field(default_factory=lambda: np.empty((3, 0)))
    fit_time_s: FloatArray = field(default_factory=lambda: np.empty(0))
    fit_mm: FloatArray = field(default_factory=lambda: np.empty(0))
    residual_time_s: FloatArray = field(default_factory=lambda: np.empty(0))
    residual_mm: FloatArray = field(default_factory=lambda: np.empty(0))
    residual_u_mm: FloatArray = field(default_factory=lambda: np.empty(0))
    speed_m_s: FloatArray = field(default_factory=lambda: np.empty(0))
    u_mm: FloatArray = field(default_factory=lambda: np.empty((3, 0)))
    u_kind: str = ""
    motion: Kinematics | None = None
    zero_s: float = 0.0
    zero: str = ""
    shaken: FloatArray = field(default_factory=lambda: np.empty((2, 0)))
    sphere_mm: FloatArray = field(default_factory=lambda: np.empty((3, 0)))


NO_TRACK = ShownTrack(np.empty(0), np.empty((3, 0)))
"""Of no points: what is drawn where there is none."""


def live_track(time_s: FloatArray, position_m: FloatArray) -> ShownTrack:
    """Return a live trail for the screen; parameters as for `speed_along`."""
    unknown, place_mm = np.full(position_m.shape, np.nan), position_m * MM
    now = place_mm[:, -1:]
    return ShownTrack(
        time_s,
        place_mm,
        speed_m_s=speed_along(time_s, position_m),
        u_mm=unknown,
        # one drawn where the last known place was would say that it is there
        sphere_mm=now[:, np.isfinite(now).all(axis=0)],
    )


def result_track(result: RunResult) -> ShownTrack | None:
    """Return the track of a result for the screen; None where it has none. Not for the thread that draws."""
    track = result.track
    if track is None:
        return None
    zero, zero_words = result.zero
    known = np.flatnonzero(track.valid & np.isfinite(track.position_m).all(axis=0))
    if known.size == 0:
        return None
    step = max(1, -(-(known[-1] - known[0]) // _MAX_POINTS))
    chosen = np.arange(known[0], known[-1] + 1, step)
    position = np.where(track.valid[chosen], track.position_m[:, chosen], np.nan)
    restarts = np.empty(0, dtype=np.intp) if result.paths is None else result.paths.restarts()
    inside = restarts[(restarts > known[0]) & (restarts <= known[-1])].repeat(_BREAK_POINTS)
    places = np.searchsorted(chosen, inside)
    impacts = np.array([bounce.time_s for bounce in result.bounces.impacts])
    at = np.clip(np.searchsorted(track.time_s, impacts), 0, track.time_s.size - 1)
    speed = speed_along(track.time_s[chosen], position, [*impacts, *track.time_s[inside]])
    own, combined = track.u_position_m, track.u_combined_m
    shown_u = own if combined is None else combined

    def broken(values: FloatArray) -> FloatArray:
        return np.insert(values, places, np.nan, axis=-1)

    shown = ShownTrack(
        time_s=np.insert(track.time_s[chosen], places, track.time_s[inside]) - zero,
        position_mm=broken(position * MM),
        impact_time_s=impacts - zero,
        impact_mm=track.position_m[:, at] * MM,
        speed_m_s=broken(speed),
        u_mm=broken(shown_u[:, chosen] * MM),
        u_kind="statistical" if combined is None else "combined",
        motion=result.motion,
        zero_s=zero,
        zero=zero_words,
        sphere_mm=track.position_m[:, known[-1:]] * MM,
    )
    drawn = take_track(result, _MAX_POINTS // 2)
    if drawn is None or drawn.parabola is None or drawn.residual is None:
        return shown
    normal = np.array(result.bounces.normal or result.setup.floor.normal)
    u_height_mm = MM * np.sqrt(((normal[:, None] * own[:, chosen]) ** 2).sum(axis=0))
    return replace(
        shown,
        fit_time_s=drawn.parabola.x,
        fit_mm=drawn.parabola.y * MM,
        residual_time_s=drawn.residual.x,
        residual_mm=drawn.residual.y * MM,
        residual_u_mm=np.interp(drawn.residual.x, track.time_s[chosen] - zero, u_height_mm),
    )
