"""Page of a run: phase uncorrected and corrected, and the change of path length with its uncertainty."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from radargui.report.curves import Curve, ReceiverCurves, RunCurves
from radargui.report.sheet import (
    HEIGHT_MM,
    add_axes,
    draw_curve,
    label,
    largest,
    new_page,
    rows_mm,
    time_axis,
)
from radargui.report.style import RAW_COLOUR, RECEIVER_COLOURS, scaled

_LEFT = (22.0, 80.0)
_RIGHT = (118.0, 80.0)


def paths_page(curves: RunCurves) -> Figure:
    """Return the page: one row a receiver, phase left and path right; below what the correction changed, and u."""
    figure = new_page()
    count = len(curves.receivers) + 1
    rows = rows_mm(count, 29.0, min(HEIGHT_MM - 26.0, 29.0 + 64.0 * count), 13.0)
    for number, receiver in enumerate(curves.receivers):
        _phase(figure, rows[number], curves, receiver)
        _path(figure, rows[number], curves, receiver, RECEIVER_COLOURS[number])
    _difference(figure, rows[-1], curves)
    _uncertainty(figure, rows[-1], curves)
    return figure


def _phase(figure: Figure, place: tuple[float, float], curves: RunCurves, receiver: ReceiverCurves) -> None:
    axes = add_axes(figure, _LEFT[0], place[0], _LEFT[1], place[1])
    drawn = draw_curve(axes, receiver.phase_raw, color=RAW_COLOUR, linewidth=1.8, label="uncorrected")
    drawn |= draw_curve(axes, receiver.phase, color="black", label="corrected")
    time_axis(axes, curves, labelled=True)
    label(axes, f"Phase of receiver {receiver.name}", "phase / rad", drawn=drawn)


def _path(figure: Figure, place: tuple[float, float], curves: RunCurves, receiver: ReceiverCurves, colour: str) -> None:
    axes = add_axes(figure, _RIGHT[0], place[0], _RIGHT[1], place[1])
    factor, unit = scaled("m", receiver.change.largest)
    drawn = draw_curve(axes, receiver.change, factor, color=colour, label=f"L{receiver.name}")
    if drawn:
        u = np.interp(receiver.change.x, receiver.u_change.x, receiver.u_change.y) if len(receiver.u_change.x) else 0.0
        y = receiver.change.y
        axes.fill_between(
            receiver.change.x,
            (y - 2 * u) * factor,
            (y + 2 * u) * factor,
            color=colour,
            alpha=0.25,
            linewidth=0,
            label="± 2 u",
        )
    time_axis(axes, curves, labelled=True)
    if curves.restarts_s:
        axes.set_xlabel("time / s (path lost at each yellow line: another zero)")
    label(axes, f"Change of path length L{receiver.name}", f"L{receiver.name} / {unit}", drawn=drawn)


def _difference(figure: Figure, place: tuple[float, float], curves: RunCurves) -> None:
    axes = add_axes(figure, _LEFT[0], place[0], _LEFT[1], place[1])
    drawn = _draw_all(axes, curves, [receiver.phase_difference for receiver in curves.receivers])
    label(axes, "Change by the correction", "uncorrected − corrected / rad", drawn=drawn)


def _uncertainty(figure: Figure, place: tuple[float, float], curves: RunCurves) -> None:
    axes = add_axes(figure, _RIGHT[0], place[0], _RIGHT[1], place[1])
    us = [receiver.u_change for receiver in curves.receivers]
    factor, unit = scaled("m", largest(us))
    if drawn := _draw_all(axes, curves, us, "L", factor):
        axes.set_ylim(bottom=0.0)
    label(axes, "Standard uncertainty of L", f"u(L) / {unit}", drawn=drawn)


def _draw_all(axes: Axes, curves: RunCurves, own: Sequence[Curve], letter: str = "", factor: float = 1.0) -> bool:
    """Draw a curve of each receiver and return whether any is known."""
    drawn = [
        draw_curve(axes, curve, factor, color=colour, label=letter + receiver.name)
        for curve, receiver, colour in zip(own, curves.receivers, RECEIVER_COLOURS, strict=False)
    ]
    time_axis(axes, curves, labelled=True)
    return any(drawn)
