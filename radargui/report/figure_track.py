"""Page of a run: height with the fitted fall and the impacts, residual, x and y, the track in space."""

import math
from itertools import combinations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from radargui.model.arrays import FloatArray
from radargui.report.curves import RunCurves, TrackCurves
from radargui.report.sheet import (
    FIT_COLOUR,
    IMPACT_COLOUR,
    RECEIVER_COLOURS,
    add_axes,
    draw_curve,
    draw_panel,
    legend,
    new_page,
    say_nothing_known,
    scaled,
    time_axis,
    width_mm,
)

_LEFT, _WIDTH = 22.0, 176.0
_VIEW_AZIMUTH_DEG, _VIEW_ELEVATION_DEG = -60.0, 25.0
_LEAST_HALF_SPAN_M = 0.005
"""The cube is never smaller than 1 cm: the noise of a sphere at rest would look like a motion."""
_SMALL = 6.0


def track_page(curves: RunCurves, track: TrackCurves, floor_m: float | None) -> Figure:
    """Return the page of a track.

    Parameters
    ----------
    curves
        Of the run.
    track
        Its track.
    floor_m
        Height of the sphere's centre when it touches the floor, where the setup says it.
    """
    figure = new_page()
    _height(add_axes(figure, _LEFT, 30.0, _WIDTH, 70.0), curves, track, floor_m)
    _residual(add_axes(figure, _LEFT, 115.0, 80.0, 36.0), curves, track)
    of_z, *colours = RECEIVER_COLOURS[:3]
    sideways = [(track.x, colours[0], "x"), (track.y, colours[1], "y")]
    draw_panel(figure, (118.0, 115.0, 80.0, 36.0), curves, "Sideways", "x, y", sideways, unit="m")
    u = list(zip(track.u, (*colours, of_z), "xyz", strict=True))
    title = "Standard uncertainty of the position"
    draw_panel(figure, (_LEFT, 167.0, 80.0, 36.0), curves, title, "u", u, unit="m", from_zero=True)
    _in_space(add_axes(figure, 118.0, 166.0, 80.0, 40.0), track)
    for number, (across, up) in enumerate(((0, 2), (1, 2), (0, 1))):
        _projection(add_axes(figure, _LEFT + 64.5 * number, 220.0, 47.0, 47.0), track, across, up)
    return figure


def _height(axes: Axes, curves: RunCurves, track: TrackCurves, floor_m: float | None) -> None:
    time_axis(axes, curves)
    along = "" if track.level else " along the floor's normal"
    name = "z" if track.level else "height"
    axes.set_title(f"Height of the centre of the sphere{along}")
    axes.set_ylabel(f"{name} / mm")
    if not draw_curve(axes, track.height, 1e3, color=RECEIVER_COLOURS[0], linewidth=0.9, label=name):
        say_nothing_known(axes)
        return
    if track.parabola is not None:
        draw_curve(
            axes, track.parabola, 1e3, color=FIT_COLOUR, linewidth=0.9, linestyle=(0, (5, 2)), label="fitted fall"
        )
    if floor_m is not None and track.level:
        axes.axhline(floor_m * 1e3, color="#808080", linewidth=0.6, label="floor")
    low, high = axes.get_ylim()
    axes.set_ylim(low - 0.03 * (high - low), high + 0.12 * (high - low))
    _name_impacts(axes, curves)
    legend(axes)


def _name_impacts(axes: Axes, curves: RunCurves) -> None:
    """Write number and e beside each impact, as far as there is room before the next one."""
    begin, end = curves.span_s
    for number, (time_s, e) in enumerate(curves.impacts, 1):
        following = curves.impacts[number][0] if number < len(curves.impacts) else end
        room_mm = (min(following, end) - time_s) / (end - begin) * _WIDTH - 1.5
        texts = [f"{number}: e = {e}", f"{number}", ""] if e else [f"{number}", ""]
        text = next(text for text in texts if width_mm(text, _SMALL) <= max(room_mm, 0.0))
        if begin <= time_s <= end:
            axes.annotate(
                text,
                (time_s, 1.0),
                xycoords=("data", "axes fraction"),
                xytext=(2.0, -8.0),
                textcoords="offset points",
                color=IMPACT_COLOUR,
                fontsize=_SMALL,
            )


def _residual(axes: Axes, curves: RunCurves, track: TrackCurves) -> None:
    axes.set_title("Height less the fitted fall")
    axes.set_xlabel(f"time after the {curves.since} / s")
    if track.residual is None or not track.residual.largest:
        say_nothing_known(axes, "no fall was fitted")
        return
    factor, unit = scaled("m", track.residual.largest)
    draw_curve(axes, track.residual, factor, color=FIT_COLOUR)
    axes.axhline(0.0, color="#404040", linewidth=0.4)
    axes.set_ylabel(f"residual / {unit}")


def _projection(axes: Axes, track: TrackCurves, across: int, up: int) -> None:
    axes.set_title(f"{'xyz'[across]}-{'xyz'[up]} plane")
    axes.set_xlabel(f"{'xyz'[across]} / mm")
    axes.set_ylabel(f"{'xyz'[up]} / mm")
    if not np.isfinite(track.places_m).any():
        say_nothing_known(axes)
        return
    axes.plot(track.places_m[across] * 1e3, track.places_m[up] * 1e3, color=RECEIVER_COLOURS[0])
    middle, half = _cube(track.places_m if up == 2 else track.places_m[:2])
    axes.set_xlim(*1e3 * (middle[across] + np.array([-half, half])))
    axes.set_ylim(*1e3 * (middle[up] + np.array([-half, half])))


def _cube(places_m: FloatArray) -> tuple[FloatArray, float]:
    """Return middle and half the side of the cube around the track: the views from the side share one scale."""
    low, high = np.nanmin(places_m, axis=1), np.nanmax(places_m, axis=1)
    return 0.5 * (low + high), max(_LEAST_HALF_SPAN_M, 0.55 * float((high - low).max()))


def _in_space(axes: Axes, track: TrackCurves) -> None:
    """Draw the track from the side and above, in a wire cube: parallel projection."""
    axes.set_axis_off()
    axes.set_aspect("equal")
    axes.set_title("Track in space")
    if not np.isfinite(track.places_m).any():
        say_nothing_known(axes)
        return
    middle, half = _cube(track.places_m)
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=np.float64) * half
    for edge in combinations(corners, 2):
        if np.count_nonzero(edge[0] != edge[1]) == 1:
            axes.plot(*_seen(np.stack(edge, axis=1)), color="#b0b0b0", linewidth=0.4)
    x, y, z = track.places_m - middle[:, None]
    axes.plot(*_seen(np.stack([x, y, np.full_like(z, -half)])), color="#b0b0b0", linewidth=0.8)
    axes.plot(*_seen(np.stack([x, y, z])), color=RECEIVER_COLOURS[0], linewidth=0.9)
    for name, end in (("x", (0.0, -1.3, -1)), ("y", (1.3, 0.0, -1)), ("z", (-1.2, -1.2, 0.0))):
        place = _seen(np.array([end], dtype=np.float64).T * half)
        axes.text(float(place[0, 0]), float(place[1, 0]), name, ha="center", va="center", fontsize=7.0)
    axes.text(1.0, 0.0, f"cube of {2e3 * half:.0f} mm", transform=axes.transAxes, ha="right", va="top", fontsize=6.0)


def _seen(places: FloatArray) -> FloatArray:
    """Return right and up on the paper of places, shape (2, n)."""
    azimuth, elevation = math.radians(_VIEW_AZIMUTH_DEG), math.radians(_VIEW_ELEVATION_DEG)
    right = np.array([-math.sin(azimuth), math.cos(azimuth), 0.0])
    across = math.sin(elevation)
    up = np.array([-across * math.cos(azimuth), -across * math.sin(azimuth), math.cos(elevation)])
    return np.stack([right, up]) @ places
