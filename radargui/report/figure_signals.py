"""Page of a run: raw and corrected IQ of each receiver against time and in the IQ plane."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from radargui.report.curves import ReceiverCurves, RunCurves
from radargui.report.decimation import Curve
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
from radargui.report.style import I_COLOUR, Q_COLOUR, RAW_COLOUR, scaled

_CORRECTED_LIMIT = 1.6


def signals_page(curves: RunCurves) -> Figure:
    """Return the page: raw and, where there is any, corrected below; time at the left, the plane at the right."""
    figure = new_page()
    known = any(np.isfinite(receiver.i.y).any() for receiver in curves.receivers)
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
    i, q, plane = (
        (receiver.i, receiver.q, receiver.plane) if corrected else (receiver.raw_i, receiver.raw_q, receiver.raw_plane)
    )
    factor, unit = (1.0, "amplitude") if corrected else scaled(curves.unit, largest([i, q]))
    what = "corrected" if corrected else "raw"
    against_time = add_axes(figure, 22.0, top, 124.0, height)
    drawn = draw_curve(against_time, i, factor, color=I_COLOUR, label=f"I{receiver.name}")
    drawn |= draw_curve(against_time, q, factor, color=Q_COLOUR, label=f"Q{receiver.name}")
    time_axis(against_time, curves, labelled=labelled)
    against_time.set_title(f"Receiver {receiver.name}, {what}")
    if not drawn:
        say_nothing_known(against_time)
    else:
        against_time.set_ylabel(f"I, Q / {unit}")
        legend(against_time)
    if corrected and drawn:
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
