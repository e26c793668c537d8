"""Page of a run: the steps of the published correction in each channel."""

from __future__ import annotations

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from radargui.report.curves import RunCurves, StepCurves
from radargui.report.decimation import Curve
from radargui.report.sheet import HEIGHT_MM, add_axes, draw_curve, legend, new_page, rows_mm, time_axis
from radargui.report.style import FIT_COLOUR, I_COLOUR, Q_COLOUR, RAW_COLOUR, scaled


def steps_page(curves: RunCurves) -> Figure:
    """Return the page: one row a channel; splines, bias and extremes over the signal, the scale beside."""
    figure = new_page()
    steps = [step for receiver in curves.receivers for step in receiver.steps]
    rows = rows_mm(len(steps), 33.0, min(HEIGHT_MM - 26.0, 33.0 + 42.0 * len(steps)), 7.0)
    for number, (step, place) in enumerate(zip(steps, rows, strict=True)):
        _channel(figure, place, curves, step, first=number == 0, labelled=number == len(steps) - 1)
    return figure


def _channel(
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
