"""Page of a run: phase uncorrected and corrected, and the change of path length with its uncertainty."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from radargui.report.curves import ReceiverCurves, RunCurves
from radargui.report.sheet import (
    HEIGHT_MM,
    add_axes,
    draw_curve,
    largest,
    legend,
    new_page,
    rows_mm,
    say_nothing_known,
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
    axes.set_title(f"Phase of receiver {receiver.name}")
    axes.set_ylabel("phase / rad")
    legend(axes)
    if not drawn:
        say_nothing_known(axes)


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
    axes.set_title(f"Change of path length L{receiver.name}")
    axes.set_ylabel(f"L{receiver.name} / {unit}")
    legend(axes)
    if not drawn:
        say_nothing_known(axes)


def _difference(figure: Figure, place: tuple[float, float], curves: RunCurves) -> None:
    axes = add_axes(figure, _LEFT[0], place[0], _LEFT[1], place[1])
    drawn = False
    for receiver, colour in zip(curves.receivers, RECEIVER_COLOURS, strict=False):
        drawn |= draw_curve(axes, receiver.phase_difference, color=colour, label=receiver.name)
    time_axis(axes, curves, labelled=True)
    axes.set_title("Change by the correction")
    axes.set_ylabel("uncorrected − corrected / rad")
    legend(axes)
    if not drawn:
        say_nothing_known(axes)


def _uncertainty(figure: Figure, place: tuple[float, float], curves: RunCurves) -> None:
    axes = add_axes(figure, _RIGHT[0], place[0], _RIGHT[1], place[1])
    factor, unit = scaled("m", largest([receiver.u_change for receiver in curves.receivers]))
    drawn = False
    for receiver, colour in zip(curves.receivers, RECEIVER_COLOURS, strict=False):
        drawn |= draw_curve(axes, receiver.u_change, factor, color=colour, label=f"L{receiver.name}")
    time_axis(axes, curves, labelled=True)
    axes.set_title("Standard uncertainty of L")
    axes.set_ylabel(f"u(L) / {unit}")
    legend(axes)
    if not drawn:
        say_nothing_known(axes)
    else:
        axes.set_ylim(bottom=0.0)
