"""Pages of a run: IQ raw and corrected, the steps of the published correction, phase and path length."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from radargui.report.curves import Curve, ReceiverCurves, RunCurves, StepCurves
from radargui.report.sheet import (
    FIT_COLOUR,
    HEIGHT_MM,
    I_COLOUR,
    Q_COLOUR,
    RAW_COLOUR,
    RECEIVER_COLOURS,
    Place,
    add_axes,
    draw_curve,
    draw_panel,
    largest,
    legend,
    new_page,
    rows_mm,
    say_nothing_known,
    scaled,
    time_axis,
)

_CORRECTED_LIMIT = 1.6


def signals_page(curves: RunCurves) -> Figure:
    """Return the page: raw and, where there is any, corrected below; time at the left, the plane at the right."""
    figure = new_page()
    known = any(np.isfinite(receiver.corrected.i.y).any() for receiver in curves.receivers)
    shown = [
        (receiver, corrected) for receiver in curves.receivers for corrected in ((False, True) if known else (False,))
    ]
    rows = rows_mm(len(shown), 27.0, min(HEIGHT_MM - 26.0, 27.0 + 42.0 * len(shown)), 6.0)
    for number, ((receiver, corrected), place) in enumerate(zip(shown, rows, strict=True), 1):
        _pair(figure, place, curves, receiver, corrected=corrected, labelled=number == len(shown))
    return figure


def _pair(
    figure: Figure,
    place: tuple[float, float],
    curves: RunCurves,
    receiver: ReceiverCurves,
    *,
    corrected: bool,
    labelled: bool,
) -> None:
    top, height = place
    i, q, plane = receiver.corrected if corrected else receiver.raw
    lines = [(i, I_COLOUR, f"I{receiver.name}"), (q, Q_COLOUR, f"Q{receiver.name}")]
    factor, unit = (1.0, "amplitude") if corrected else scaled(curves.unit, largest([i, q]))
    against_time, _ = draw_panel(
        figure,
        (22.0, top, 124.0, height),
        curves,
        f"Receiver {receiver.name}, {'corrected' if corrected else 'raw'}",
        "I, Q / amplitude" if corrected else "I, Q",
        lines,
        unit="" if corrected else curves.unit,
        labelled=labelled,
    )
    if corrected and np.isfinite([*i.y, *q.y]).any():
        limit = min(_CORRECTED_LIMIT, max(1.15, 1.05 * largest([i, q])))
        against_time.set_ylim(-limit, limit)
    side = min(height - 4.0, 33.0)
    in_plane = add_axes(figure, 163.0, top, side, side)
    _plane(in_plane, plane, factor, corrected=corrected)
    in_plane.set_xlabel(f"I{receiver.name} / {unit}", labelpad=0.5)
    in_plane.set_ylabel(f"Q{receiver.name} / {unit}", labelpad=0.5)


def _plane(axes: Axes, plane: Curve, factor: float, *, corrected: bool) -> None:
    axes.set_aspect("equal", adjustable="datalim")
    known = np.isfinite(plane.x) & np.isfinite(plane.y)
    if not known.any():
        say_nothing_known(axes)
        axes.set_xticks([])
        return
    colour = I_COLOUR if corrected else RAW_COLOUR
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


def steps_page(curves: RunCurves) -> Figure:
    """Return the page: one row a channel; splines, bias and extremes over the signal, the scale beside."""
    figure = new_page()
    steps = [step for receiver in curves.receivers for step in receiver.steps]
    rows = rows_mm(len(steps), 33.0, min(HEIGHT_MM - 26.0, 33.0 + 42.0 * len(steps)), 7.0)
    for number, (step, place) in enumerate(zip(steps, rows, strict=True)):
        _step_row(figure, place, curves, step, first=number == 0, labelled=number == len(steps) - 1)
    return figure


def _step_row(
    figure: Figure, place: tuple[float, float], curves: RunCurves, step: StepCurves, *, first: bool, labelled: bool
) -> None:
    top, height = place
    factor, unit = scaled(curves.unit, step.signal.largest)
    axes = add_axes(figure, 22.0, top, 118.0, height)
    axes.axvspan(*step.segment_s, color="#eef3f8", linewidth=0, zorder=0)
    draw_curve(axes, step.signal, factor, color=RAW_COLOUR, linewidth=0.5, label="signal")
    colour = I_COLOUR if step.name.startswith("I") else Q_COLOUR
    draw_curve(axes, step.upper, factor, color=colour, linewidth=0.8, label="upper, lower spline")
    draw_curve(axes, step.lower, factor, color=colour, linewidth=0.8)
    draw_curve(axes, step.bias, factor, color=FIT_COLOUR, linewidth=0.8, label="bias")
    _marks(axes, step.peaks, factor, "^", "black", "peaks")
    _marks(axes, step.valleys, factor, "v", "black", "valleys")
    _marks(axes, step.zero_crossings, factor, "o", FIT_COLOUR, "zero crossings")
    time_axis(axes, curves, labelled=labelled)
    axes.set_ylabel(f"{step.name} / {unit}")
    if first:
        legend(axes, raised=True)
    counts = f"{len(step.peaks.x)} peaks, {len(step.valleys.x)} valleys, {len(step.zero_crossings.x)} zero crossings"
    axes.set_title(f"{step.name}: {counts}")
    beside = add_axes(figure, 154.0, top, 42.0, height)
    draw_curve(beside, step.scale, factor, color=colour)
    time_axis(beside, curves, labelled=labelled)
    beside.set_ylim(bottom=0.0)
    beside.set_title(f"scale of {step.name} / {unit}")


def _marks(axes: Axes, places: Curve, factor: float, marker: str, colour: str, label: str) -> None:
    size = 1.2 if marker == "o" else 2.4
    looks = {"linestyle": "", "color": colour, "marker": marker, "markersize": size, "markeredgewidth": 0.0}
    draw_curve(axes, places, factor, label=label, **looks)


def paths_page(curves: RunCurves) -> Figure:
    """Return the page: one row a receiver, phase left and path right; below what the correction changed, and u."""
    figure = new_page()
    count = len(curves.receivers) + 1
    *rows, last = rows_mm(count, 29.0, min(HEIGHT_MM - 26.0, 29.0 + 64.0 * count), 13.0)
    for receiver, row, colour in zip(curves.receivers, rows, RECEIVER_COLOURS, strict=False):
        phases = [(receiver.phase_raw, RAW_COLOUR, "uncorrected"), (receiver.phase, "black", "corrected")]
        title = f"Phase of receiver {receiver.name}"
        draw_panel(figure, _left(row), curves, title, "phase / rad", phases, first_width=1.8)
        _path(figure, _right(row), curves, receiver, colour)
    own = list(zip(curves.receivers, RECEIVER_COLOURS, strict=False))
    changed = [(receiver.phase_difference, colour, receiver.name) for receiver, colour in own]
    draw_panel(figure, _left(last), curves, "Change by the correction", "uncorrected − corrected / rad", changed)
    u = [(receiver.u_change, colour, f"L{receiver.name}") for receiver, colour in own]
    draw_panel(figure, _right(last), curves, "Standard uncertainty of L", "u(L)", u, unit="m", from_zero=True)
    return figure


def _left(row: tuple[float, float]) -> Place:
    return 22.0, row[0], 80.0, row[1]


def _right(row: tuple[float, float]) -> Place:
    return 118.0, row[0], 80.0, row[1]


def _path(figure: Figure, place: Place, curves: RunCurves, receiver: ReceiverCurves, colour: str) -> None:
    name, path, u_path = f"L{receiver.name}", receiver.change, receiver.u_change
    lines = [(path, colour, name)]
    axes, factor = draw_panel(figure, place, curves, f"Change of path length {name}", name, lines, unit="m")
    if curves.restarts_s:
        axes.set_xlabel("time / s (path lost at each yellow line: another zero)")
    if np.isfinite(path.y).any():
        u = np.interp(path.x, u_path.x, u_path.y) if len(u_path.x) else 0.0
        band = (path.y - 2 * u) * factor, (path.y + 2 * u) * factor
        axes.fill_between(path.x, *band, color=colour, alpha=0.25, linewidth=0, label="± 2 u")
        legend(axes)
