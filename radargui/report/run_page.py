"""Figures of a run as they are published: IQ, the correction at work, phase and path length, the fall."""

from collections.abc import Callable

import numpy as np
from matplotlib.figure import Figure

from radargui.report import sheet
from radargui.report.canvas import Canvas, Line
from radargui.report.curves import CircleCurves, ReceiverCurves, RunCurves, StepCurves, TrackCurves
from radargui.report.decimation import Curve
from radargui.report.panel import Panel, span_of
from radargui.report.sheet import Area

_GAP_MM, _LABELS_MM, _TICKS_MM = 4.5, 10.0, 9.0
_LIMIT = 1.6
_THIN = 0.3
_IMPACTS = Line("#808080", 0.25, (3.0, 2.5))
_SCALE_COLOUR = "#009e73"
_DASHES = (3.0, 2.0)
_MOST_HIGH_MM, _NARROW_MM = 30.0, 120.0

DrawPart = Callable[[Canvas, Area], None]


def run_figures(figure: Figure, area: Area, curves: RunCurves) -> None:
    """Draw all figures of a run into what its page has left."""
    every = curves.receivers
    parts: list[tuple[float, int, DrawPart]] = [(1.0, len(every), lambda on, where: iq_rows(on, where, curves, every))]
    if any(one.steps or one.circles for one in every):
        parts.append((0.7, 2, lambda on, where: correction(on, where, curves, every)))
    if any(one.phase.largest for one in every):
        parts.append((2.4, 1, lambda on, where: _phase_and_fall(on, where, curves)))
    gaps = sum((rows - 1) * _GAP_MM for _, rows, _ in parts) + (len(parts) - 1) * _LABELS_MM
    unit = min((area.height - gaps) / sum(share * rows for share, rows, _ in parts), _MOST_HIGH_MM)
    canvas, top = Canvas(figure), area.top
    for share, rows, draw in parts:
        height = share * rows * unit + (rows - 1) * _GAP_MM
        draw(canvas, area._replace(top=top, height=height))
        top += height + _LABELS_MM


def run_on_screen(figure: Figure, area: Area, curves: RunCurves) -> None:
    """Draw phase and fall of a run, or its signals where there are none."""
    if any(one.phase.largest for one in curves.receivers):
        _phase_and_fall(Canvas(figure), area, curves)
    else:
        iq_rows(Canvas(figure), area, curves, curves.receivers)


def _phase_and_fall(canvas: Canvas, area: Area, curves: RunCurves) -> None:
    left, right = _columns(area, 2)
    track = curves.track
    phase(canvas, left if track else area, curves)
    if track is not None:
        fall(canvas, right, curves, track)


def _rows(area: Area, count: int) -> list[Area]:
    height = (area.height - (count - 1) * _GAP_MM) / count
    return [area.inside(0.0, number * (height + _GAP_MM), area.width, height) for number in range(count)]


def _columns(area: Area, count: int) -> list[Area]:
    width = (area.width - (count - 1) * _TICKS_MM) / count
    return [area.inside(number * (width + _TICKS_MM), 0.0, width, area.height) for number in range(count)]


def _over_time(panel: Panel, curves: RunCurves, title: str, *, bottom: bool = True) -> None:
    """Finish a panel against time: lost samples, restarts, impacts, frame."""
    for first, last in curves.gaps_s:
        panel.shade(first, last, sheet.GAP_COLOUR)
    panel.upright(curves.restarts_s, Line(sheet.GAP_COLOUR, 1.0))
    panel.upright([time_s for time_s, _ in curves.impacts], _IMPACTS)
    panel.frame(title, f"time after the {curves.since} / s" if bottom else "", numbers=bottom)


def iq_rows(canvas: Canvas, area: Area, curves: RunCurves, receivers: tuple[ReceiverCurves, ...]) -> None:
    """Draw one row a receiver: raw and corrected IQ, each against time and in the plane."""
    known = any(np.isfinite(one.corrected.i.y).any() for one in receivers)
    shown = [(one, corrected) for one in receivers for corrected in ((False, True) if known else (False,))]
    # in the column of a journal they stand below each other
    beside = 1 if area.width < _NARROW_MM else 1 + known
    rows = _rows(area, len(shown) // beside)
    places = [column for row in rows for column in _columns(row, beside)]
    for (receiver, corrected), place in zip(shown, places, strict=True):
        _pair(canvas, place, curves, receiver, corrected=corrected, bottom=place.top == rows[-1].top)


def _pair(
    canvas: Canvas, area: Area, curves: RunCurves, receiver: ReceiverCurves, *, corrected: bool, bottom: bool
) -> None:
    i, q, plane = receiver.corrected if corrected else receiver.raw
    side = min(area.height, 0.35 * area.width)
    # in amplitudes, which have no unit
    factor, unit = (1.0, "") if corrected else sheet.scaled(curves.unit, sheet.largest([i, q]))
    span = span_of([i, q], factor)
    if corrected:
        limit = min(_LIMIT, max(1.15, *map(abs, span)))
        span = -limit, limit
    panel = Panel(canvas, area._replace(width=area.width - side - _TICKS_MM), curves.span_s, span)
    drawn = [panel.curve(i, Line(sheet.I_COLOUR, _THIN), factor, "I")]
    drawn.append(panel.curve(q, Line(sheet.Q_COLOUR, _THIN), factor, "Q"))
    what = "corrected IQ" if corrected else f"raw IQ / {unit}"
    _over_time(panel, curves, f"Receiver {receiver.name}: {what}", bottom=bottom)
    beside = area.inside(area.width - side, area.height - side, side, side)
    limit = _LIMIT if corrected else max(map(abs, span))
    in_plane = Panel(canvas, beside, (-limit, limit), (-limit, limit))
    if any(drawn):
        _plane(in_plane, plane, factor, corrected=corrected)
    else:
        panel.say("not known")
    in_plane.frame("Q against I", numbers=bottom)


def _plane(panel: Panel, plane: Curve, factor: float, *, corrected: bool) -> None:
    panel.dots(plane.x * factor, plane.y * factor, sheet.I_COLOUR if corrected else sheet.RAW_COLOUR)
    turn = np.linspace(0.0, 2.0 * np.pi, 61)
    cross = Curve(np.array([-0.08, 0.08, np.nan, 0.0, 0.0]), np.array([0.0, 0.0, np.nan, -0.08, 0.08]))
    panel.curve(Curve(np.cos(turn), np.sin(turn)) if corrected else cross, Line("#404040", 0.4))


def correction(canvas: Canvas, area: Area, curves: RunCurves, receivers: tuple[ReceiverCurves, ...]) -> None:
    """Draw the correction at work: I above Q, one column a receiver."""
    rows = _rows(area, 2)
    for number, (receiver, column) in enumerate(zip(receivers, _columns(area, len(receivers)), strict=True)):
        parts: tuple[StepCurves | CircleCurves, ...] = receiver.steps or receiver.circles
        for place, part in enumerate(parts):
            where = column._replace(top=rows[place].top, height=rows[place].height)
            _part(canvas, where, curves, part, bottom=place == 1, key=number == place == 0)


def _part(
    canvas: Canvas, area: Area, curves: RunCurves, part: StepCurves | CircleCurves, *, bottom: bool, key: bool
) -> None:
    factor, unit = sheet.scaled(curves.unit, part.signal.largest)
    colour = sheet.I_COLOUR if part.name.startswith("I") else sheet.Q_COLOUR
    panel = Panel(canvas, area, curves.span_s, span_of([part.signal], factor))
    lines: list[tuple[Curve, Line, str]] = []
    if isinstance(part, StepCurves):
        spline = Line(colour, 0.6)
        lines += [(part.scale, Line(_SCALE_COLOUR, 0.6), "scale"), (part.bias, Line(sheet.FIT_COLOUR, 0.6), "bias")]
        lines += [(part.upper, spline, "splines"), (part.lower, spline, "")]
    else:
        lines += [
            (part.rest, Line(sheet.FIT_COLOUR, _THIN), f"raw − {part.kind}"),
            (part.fitted, Line(colour, _THIN), part.kind),
        ]
    lines.append((part.signal, Line(sheet.RAW_COLOUR, _THIN), "raw"))
    # the names stand from the right, the lines lie on each other from below
    for _, line, name in lines if key else ():
        if name:
            panel.key(name, line)
    for curve, line, _ in reversed(lines):
        panel.curve(curve, line, factor)
    if isinstance(part, StepCurves):
        for extremes in (part.peaks, part.valleys):
            panel.dots(extremes.x, extremes.y * factor, "black", 1.0)
    _over_time(panel, curves, f"{part.name} / {unit}", bottom=bottom)


def phase(canvas: Canvas, area: Area, curves: RunCurves) -> None:
    """Draw the phase of every receiver without (dashed) and with correction; L over the whole recording as inset."""
    own = list(zip(curves.receivers, sheet.RECEIVER_COLOURS, strict=False))
    low, high = span_of([one.phase for one in curves.receivers])
    known = np.concatenate([one.phase.y[np.isfinite(one.phase.y)] for one in curves.receivers])
    # the inset lies above or below the curves, where it hides none of them
    above = float(np.median(known)) < 0.5 * (low + high)
    room = 0.6 * (high - low)
    panel = Panel(canvas, area, curves.span_s, (low, high + room) if above else (low - room, high))
    for receiver, colour in reversed(own):
        panel.curve(receiver.phase_raw, Line(colour, 0.8, _DASHES))
        panel.curve(receiver.phase, Line(colour, 0.5), name=receiver.name)
    _over_time(panel, curves, "Phase / rad (dashed: uncorrected)")
    factor, unit = sheet.scaled("m", sheet.largest([one.whole_change for one in curves.receivers]))
    whole = [one.whole_change for one in curves.receivers]
    times = np.concatenate([one.x for one in whole])
    width, height = 0.62 * area.width, 0.22 * area.height
    inside = area.inside(0.97 * area.width - width, 4.0 if above else area.height - height - 4.5, width, height)
    inset = Panel(canvas, inside, (float(times.min()), float(times.max())), span_of(whole, factor), 5.0)
    inset.clear(5.5)
    for receiver, colour in own:
        inset.curve(receiver.whole_change, Line(colour, 0.4), factor)
    inset.frame(f"L / {unit}, whole recording")


def fall(canvas: Canvas, area: Area, curves: RunCurves, track: TrackCurves) -> None:
    """Draw the height over the fitted parabola, and below it what the fit leaves."""
    upper = 0.6 * (area.height - _LABELS_MM)
    panel = Panel(canvas, area._replace(height=upper), curves.span_s, span_of([track.height], 1e3))
    if track.parabola is not None:
        panel.curve(track.parabola, Line(sheet.FIT_COLOUR, 1.2, _DASHES), 1e3, "parabola")
    if not panel.curve(track.height, Line(sheet.RECEIVER_COLOURS[0], 0.6), 1e3, "sphere"):
        panel.say("not known")
    _over_time(panel, curves, "Height / mm")
    below = area.inside(0.0, upper + _LABELS_MM, area.width, area.height - upper - _LABELS_MM)
    residual = track.residual
    if residual is None or not residual.largest:
        panel = Panel(canvas, below, curves.span_s, (-1.0, 1.0))
        panel.say("no fall was fitted")
        panel.frame("Residual", ticks=False)
        return
    factor, unit = sheet.scaled("m", residual.largest)
    # drawn over its own time: a fall is a small part of what a sphere does that bounces
    panel = Panel(canvas, below, (float(residual.x[0]), float(residual.x[-1])), span_of([residual], factor))
    panel.curve(residual, Line(sheet.FIT_COLOUR, 0.4), factor)
    _over_time(panel, curves, f"Residual of the fall / {unit}")
