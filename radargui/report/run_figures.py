"""Pages of a run: IQ raw and corrected, the steps of the published correction, phase and path length, the track."""

import math
from itertools import combinations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from radargui.model.arrays import FloatArray
from radargui.report import sheet
from radargui.report.curves import ReceiverCurves, RunCurves, StepCurves, TrackCurves
from radargui.report.decimation import Curve
from radargui.report.sheet import Paper

_CORRECTED_LIMIT = 1.6


def signals_page(curves: RunCurves, paper: Paper) -> Figure:
    """Return the page: raw and, where there is any, corrected below; time at the left, the plane at the right."""
    figure = sheet.new_page(paper)
    known = any(np.isfinite(receiver.corrected.i.y).any() for receiver in curves.receivers)
    shown = [
        (receiver, corrected) for receiver in curves.receivers for corrected in ((False, True) if known else (False,))
    ]
    rows = sheet.add_rows(figure, len(shown), 27.0, 42.0, 6.0, (22.0, 124.0), (163.0, 33.0))
    for (receiver, corrected), (axes, plane) in zip(shown, rows, strict=True):
        _pair(axes, plane, curves, receiver, corrected=corrected, labelled=axes is rows[-1][0])
    return figure


def _pair(
    against_time: Axes, in_plane: Axes, curves: RunCurves, receiver: ReceiverCurves, *, corrected: bool, labelled: bool
) -> None:
    i, q, plane = receiver.corrected if corrected else receiver.raw
    lines = [(i, sheet.I_COLOUR, f"I{receiver.name}"), (q, sheet.Q_COLOUR, f"Q{receiver.name}")]
    factor, unit = (1.0, "amplitude") if corrected else sheet.scaled(curves.unit, sheet.largest([i, q]))
    title = f"Receiver {receiver.name}, {'corrected' if corrected else 'raw'}"
    of_axis, given = ("I, Q / amplitude", "") if corrected else ("I, Q", curves.unit)
    sheet.draw_panel(against_time, curves, title, of_axis, lines, unit=given, labelled=labelled)
    if corrected and np.isfinite([*i.y, *q.y]).any():
        limit = min(_CORRECTED_LIMIT, max(1.15, 1.05 * sheet.largest([i, q])))
        against_time.set_ylim(-limit, limit)
    (left, bottom), (right, top) = in_plane.get_position().get_points()
    # room for the words beneath
    room = 4.0 / sheet.size_mm(sheet.figure_of(in_plane))[1]
    in_plane.set_position((left, bottom + room, right - left, top - bottom - room))
    in_plane.set_box_aspect(1.0)
    in_plane.set_anchor("NW")
    _plane(in_plane, plane, factor, corrected=corrected)
    in_plane.set_xlabel(f"I{receiver.name} / {unit}", labelpad=0.5)
    in_plane.set_ylabel(f"Q{receiver.name} / {unit}", labelpad=0.5)


def _plane(axes: Axes, plane: Curve, factor: float, *, corrected: bool) -> None:
    axes.set_aspect("equal", adjustable="datalim")
    known = np.isfinite(plane.x) & np.isfinite(plane.y)
    if not known.any():
        sheet.say_nothing_known(axes)
        axes.set_xticks([])
        return
    colour = sheet.I_COLOUR if corrected else sheet.RAW_COLOUR
    axes.plot(plane.x * factor, plane.y * factor, ",", color=colour, rasterized=True)
    if corrected:
        turn = np.linspace(0.0, 2.0 * np.pi, 90)
        axes.plot(np.cos(turn), np.sin(turn), color="#404040", linewidth=0.5)
        axes.set_aspect("equal", adjustable="box")
        axes.set_xlim(-_CORRECTED_LIMIT, _CORRECTED_LIMIT)
        axes.set_ylim(-_CORRECTED_LIMIT, _CORRECTED_LIMIT)
    else:
        axes.plot(0.0, 0.0, "+", color="#404040", markersize=4.0, markeredgewidth=0.5)
        axes.margins(0.08)


def steps_page(curves: RunCurves, paper: Paper) -> Figure:
    """Return the page: one row a channel; splines, bias and extremes over the signal, the scale beside."""
    figure = sheet.new_page(paper)
    steps = [step for receiver in curves.receivers for step in receiver.steps]
    rows = sheet.add_rows(figure, len(steps), 33.0, 42.0, 7.0, (22.0, 118.0), (154.0, 42.0))
    for step, (axes, beside) in zip(steps, rows, strict=True):
        _step_row(axes, beside, curves, step, first=step is steps[0], labelled=step is steps[-1])
    return figure


def _step_row(axes: Axes, beside: Axes, curves: RunCurves, step: StepCurves, *, first: bool, labelled: bool) -> None:
    factor, unit = sheet.scaled(curves.unit, step.signal.largest)
    axes.axvspan(*step.segment_s, color="#eef3f8", linewidth=0, zorder=0)
    sheet.draw_curve(axes, step.signal, factor, color=sheet.RAW_COLOUR, linewidth=0.5, label="signal")
    colour = sheet.I_COLOUR if step.name.startswith("I") else sheet.Q_COLOUR
    sheet.draw_curve(axes, step.upper, factor, color=colour, linewidth=0.8, label="upper, lower spline")
    sheet.draw_curve(axes, step.lower, factor, color=colour, linewidth=0.8)
    sheet.draw_curve(axes, step.bias, factor, color=sheet.FIT_COLOUR, linewidth=0.8, label="bias")
    _marks(axes, step.peaks, factor, "^", "black", "peaks")
    _marks(axes, step.valleys, factor, "v", "black", "valleys")
    _marks(axes, step.zero_crossings, factor, "o", sheet.FIT_COLOUR, "zero crossings")
    sheet.time_axis(axes, curves, labelled=labelled)
    axes.set_ylabel(f"{step.name} / {unit}")
    if first:
        sheet.legend(axes, raised=True)
    counts = f"{len(step.peaks.x)} peaks, {len(step.valleys.x)} valleys, {len(step.zero_crossings.x)} zero crossings"
    axes.set_title(f"{step.name}: {counts}")
    sheet.draw_curve(beside, step.scale, factor, color=colour)
    sheet.time_axis(beside, curves, labelled=labelled)
    beside.set_ylim(bottom=0.0)
    beside.set_title(f"scale of {step.name} / {unit}")


def _marks(axes: Axes, places: Curve, factor: float, marker: str, colour: str, label: str) -> None:
    size = 1.2 if marker == "o" else 2.4
    looks = {"linestyle": "", "color": colour, "marker": marker, "markersize": size, "markeredgewidth": 0.0}
    sheet.draw_curve(axes, places, factor, label=label, **looks)


def paths_page(curves: RunCurves, paper: Paper) -> Figure:
    """Return the page: one row a receiver, phase left and path right; below what the correction changed, and u."""
    figure = sheet.new_page(paper)
    columns = (22.0, 80.0), (118.0, 80.0)
    *rows, (change, below) = sheet.add_rows(figure, len(curves.receivers) + 1, 29.0, 64.0, 13.0, *columns)
    for receiver, (left, right), colour in zip(curves.receivers, rows, sheet.RECEIVER_COLOURS, strict=False):
        phases = [(receiver.phase_raw, sheet.RAW_COLOUR, "uncorrected"), (receiver.phase, "black", "corrected")]
        sheet.draw_panel(left, curves, f"Phase of receiver {receiver.name}", "phase / rad", phases, first_width=1.8)
        _path(right, curves, receiver, colour)
    own = list(zip(curves.receivers, sheet.RECEIVER_COLOURS, strict=False))
    changed = [(receiver.phase_difference, colour, receiver.name) for receiver, colour in own]
    sheet.draw_panel(change, curves, "Change by the correction", "uncorrected − corrected / rad", changed)
    u = [(receiver.u_change, colour, f"L{receiver.name}") for receiver, colour in own]
    sheet.draw_panel(below, curves, "Standard uncertainty of L", "u(L)", u, unit="m", from_zero=True)
    return figure


def _path(axes: Axes, curves: RunCurves, receiver: ReceiverCurves, colour: str) -> None:
    name, path, u_path = f"L{receiver.name}", receiver.change, receiver.u_change
    lines = [(path, colour, name)]
    factor = sheet.draw_panel(axes, curves, f"Change of path length {name}", name, lines, unit="m")
    if curves.restarts_s:
        axes.set_xlabel("time / s (path lost at each yellow line: another zero)")
    if np.isfinite(path.y).any():
        u = np.interp(path.x, u_path.x, u_path.y) if len(u_path.x) else 0.0
        band = (path.y - 2 * u) * factor, (path.y + 2 * u) * factor
        axes.fill_between(path.x, *band, color=colour, alpha=0.25, linewidth=0, label="± 2 u")
        sheet.legend(axes)


_LEFT, _WIDTH = 22.0, 176.0
_VIEW_AZIMUTH_DEG, _VIEW_ELEVATION_DEG = -60.0, 25.0
_LEAST_HALF_SPAN_M = 0.005
"""The cube is never smaller than 1 cm: the noise of a sphere at rest would look like a motion."""
_SMALL = 6.0


def track_page(curves: RunCurves, track: TrackCurves, floor_m: float | None, paper: Paper) -> Figure:
    """Return the page of a track.

    Parameters
    ----------
    curves
        Of the run.
    track
        Its track.
    floor_m
        Height of the sphere's centre when it touches the floor, where the setup says it.
    paper
        To draw on.
    """
    figure = sheet.new_page(paper)
    # on paper that is less high everything moves up and shrinks
    high = sheet.size_mm(figure)[1] / sheet.PAPERS_MM["a4"][1]

    def axes(left: float, top: float, width: float, height: float) -> Axes:
        return sheet.add_axes(figure, left, 24.0 + (top - 24.0) * high, width, height * high)

    _height(axes(_LEFT, 30.0, _WIDTH, 70.0), curves, track, floor_m)
    _residual(axes(_LEFT, 115.0, 80.0, 36.0), curves, track)
    of_z, *colours = sheet.RECEIVER_COLOURS[:3]
    sideways = [(track.x, colours[0], "x"), (track.y, colours[1], "y")]
    sheet.draw_panel(axes(118.0, 115.0, 80.0, 36.0), curves, "Sideways", "x, y", sideways, unit="m")
    u = list(zip(track.u, (*colours, of_z), "xyz", strict=True))
    title = "Standard uncertainty of the position"
    sheet.draw_panel(axes(_LEFT, 167.0, 80.0, 36.0), curves, title, "u", u, unit="m", from_zero=True)
    _in_space(axes(118.0, 166.0, 80.0, 40.0), track)
    for number, (across, up) in enumerate(((0, 2), (1, 2), (0, 1))):
        _projection(axes(_LEFT + 64.5 * number, 218.0, 47.0 * high, 47.0), track, across, up)
    return figure


def _height(axes: Axes, curves: RunCurves, track: TrackCurves, floor_m: float | None) -> None:
    sheet.time_axis(axes, curves)
    along = "" if track.level else " along the floor's normal"
    name = "z" if track.level else "height"
    axes.set_title(f"Height of the centre of the sphere{along}")
    axes.set_ylabel(f"{name} / mm")
    if not sheet.draw_curve(axes, track.height, 1e3, color=sheet.RECEIVER_COLOURS[0], linewidth=0.9, label=name):
        sheet.say_nothing_known(axes)
        return
    if track.parabola is not None:
        sheet.draw_curve(
            axes, track.parabola, 1e3, color=sheet.FIT_COLOUR, linewidth=0.9, linestyle=(0, (5, 2)), label="fitted fall"
        )
    if floor_m is not None and track.level:
        axes.axhline(floor_m * 1e3, color="#808080", linewidth=0.6, label="floor")
    low, high = axes.get_ylim()
    axes.set_ylim(low - 0.03 * (high - low), high + 0.12 * (high - low))
    _name_impacts(axes, curves)
    sheet.legend(axes)


def _name_impacts(axes: Axes, curves: RunCurves) -> None:
    """Write number and e beside each impact, as far as there is room before the next one."""
    begin, end = curves.span_s
    for number, (time_s, e) in enumerate(curves.impacts, 1):
        following = curves.impacts[number][0] if number < len(curves.impacts) else end
        room_mm = (min(following, end) - time_s) / (end - begin) * _WIDTH - 1.5
        texts = [f"{number}: e = {e}", f"{number}", ""] if e else [f"{number}", ""]
        text = next(text for text in texts if sheet.width_mm(text, _SMALL) <= max(room_mm, 0.0))
        if begin <= time_s <= end:
            axes.annotate(
                text,
                (time_s, 1.0),
                xycoords=("data", "axes fraction"),
                xytext=(2.0, -8.0),
                textcoords="offset points",
                color=sheet.IMPACT_COLOUR,
                fontsize=_SMALL,
            )


def _residual(axes: Axes, curves: RunCurves, track: TrackCurves) -> None:
    axes.set_title("Height less the fitted fall")
    axes.set_xlabel(f"time after the {curves.since} / s")
    if track.residual is None or not track.residual.largest:
        sheet.say_nothing_known(axes, "no fall was fitted")
        return
    factor, unit = sheet.scaled("m", track.residual.largest)
    sheet.draw_curve(axes, track.residual, factor, color=sheet.FIT_COLOUR)
    axes.axhline(0.0, color="#404040", linewidth=0.4)
    axes.set_ylabel(f"residual / {unit}")


def _projection(axes: Axes, track: TrackCurves, across: int, up: int) -> None:
    axes.set_title(f"{'xyz'[across]}-{'xyz'[up]} plane")
    axes.set_xlabel(f"{'xyz'[across]} / mm")
    axes.set_ylabel(f"{'xyz'[up]} / mm")
    if not np.isfinite(track.places_m).any():
        sheet.say_nothing_known(axes)
        return
    axes.plot(track.places_m[across] * 1e3, track.places_m[up] * 1e3, color=sheet.RECEIVER_COLOURS[0])
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
        sheet.say_nothing_known(axes)
        return
    middle, half = _cube(track.places_m)
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=np.float64) * half
    for edge in combinations(corners, 2):
        if np.count_nonzero(edge[0] != edge[1]) == 1:
            axes.plot(*_seen(np.stack(edge, axis=1)), color="#b0b0b0", linewidth=0.4)
    x, y, z = track.places_m - middle[:, None]
    axes.plot(*_seen(np.stack([x, y, np.full_like(z, -half)])), color="#b0b0b0", linewidth=0.8)
    axes.plot(*_seen(np.stack([x, y, z])), color=sheet.RECEIVER_COLOURS[0], linewidth=0.9)
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
