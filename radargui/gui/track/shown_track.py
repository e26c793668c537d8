"""What track views draw: the field of view; the live trail, or a result with its impacts and the fitted fall."""

from dataclasses import dataclass, field

import numpy as np

from radargui.geometry.path_length import place_antennas
from radargui.model.arrays import FloatArray
from radargui.model.result import RunResult
from radargui.model.setup import Setup

MM = 1000.0
_HALF_FIELD_MM = 150.0
_MARGIN_MM = 20.0


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
    """

    low_mm: FloatArray
    high_mm: FloatArray
    floor_mm: float
    antennas: tuple[tuple[str, FloatArray], ...]

    @property
    def size_mm(self) -> FloatArray:
        """Edges of the box, shape (3,)."""
        return np.asarray(self.high_mm - self.low_mm)


def space_of(setup: Setup) -> Space:
    """Return the box around the field of view (about 30 cm wide), release and floor."""
    release = np.array(setup.tracer.release_position_m) * MM
    low, high = np.full(3, -_HALF_FIELD_MM), np.full(3, _HALF_FIELD_MM)
    floor = setup.floor.height_m * MM if setup.floor.height_m is not None else float(low[2])
    low[2] = min(floor, release[2] - _MARGIN_MM)
    high[2] = release[2]
    margin = np.array([0.0, 0.0, _MARGIN_MM])
    low = np.minimum(low, release) - margin
    high = np.maximum(high, release) + margin
    placed = place_antennas(setup)
    names = ["Tx", *(f"Rx {number + 1}" for number in range(placed.n_receivers))]
    places = np.vstack([placed.transmitter_m, placed.receivers_m])
    directions = places / np.linalg.norm(places, axis=1, keepdims=True)
    return Space(
        low_mm=low,
        high_mm=high,
        floor_mm=floor,
        antennas=tuple(zip(names, directions, strict=True)),
    )


_MOST_POINTS = 6000
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
        Parabola of the first fall in z, shape (n_fit,).
    zero
        What the times of a result count from.
    """

    time_s: FloatArray
    position_mm: FloatArray
    impact_time_s: FloatArray = field(default_factory=lambda: np.empty(0))
    impact_mm: FloatArray = field(default_factory=lambda: np.empty((3, 0)))
    fit_time_s: FloatArray = field(default_factory=lambda: np.empty(0))
    fit_mm: FloatArray = field(default_factory=lambda: np.empty(0))
    zero: str = ""


NO_TRACK = ShownTrack(np.empty(0), np.empty((3, 0)))


def result_track(result: RunResult) -> ShownTrack | None:
    """Return the track of a result for the screen; None where it has none."""
    track = result.track
    if track is None:
        return None
    zero, zero_words = result.zero
    known = np.flatnonzero(track.valid & np.isfinite(track.position_m).all(axis=0))
    if known.size == 0:
        return None
    step = max(1, -(-(known[-1] - known[0]) // _MOST_POINTS))
    chosen = np.arange(known[0], known[-1] + 1, step)
    position = np.where(track.valid[chosen], track.position_m[:, chosen], np.nan) * MM
    restarts = np.empty(0, dtype=np.intp) if result.paths is None else result.paths.restarts()
    inside = restarts[(restarts > known[0]) & (restarts <= known[-1])].repeat(_BREAK_POINTS)
    places = np.searchsorted(chosen, inside)
    impacts = np.array([bounce.time_s for bounce in result.bounces.impacts])
    at = np.clip(np.searchsorted(track.time_s, impacts), 0, track.time_s.size - 1)
    fall = result.bounces.free_fall
    fit_time: FloatArray = np.empty(0)
    fit: FloatArray = np.empty(0)
    if fall is not None:
        since = np.linspace(0.0, fall.last_time_s - fall.first_time_s, 120)
        fit_time = fall.first_time_s + since - zero
        fit = np.asarray(np.polynomial.polynomial.polyval(since, fall.parabola) * MM, dtype=np.float64)
    return ShownTrack(
        time_s=np.insert(track.time_s[chosen], places, track.time_s[inside]) - zero,
        position_mm=np.insert(position, places, np.nan, axis=1),
        impact_time_s=impacts - zero,
        impact_mm=track.position_m[:, at] * MM,
        fit_time_s=fit_time,
        fit_mm=fit,
        zero=zero_words,
    )
