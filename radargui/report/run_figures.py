"""Draw the figures of a run: IQ, the correction, phase and path length, the fall."""

import math
from collections.abc import Callable, Sequence
from functools import partial
from itertools import combinations

import numpy as np
from matplotlib.figure import Figure

from radargui.model.arrays import FloatArray
from radargui.model.rounding import COVERAGE
from radargui.report import sheet
from radargui.report.canvas import SIZE, Canvas, Line, Panel, span_of
from radargui.report.curves import CircleCurves, MotionFigures, ReceiverCurves, RunCurves, StepCurves, TrackFigures
from radargui.report.decimation import Curve
from radargui.report.sheet import Area, Paper

_GAP_MM, _LABELS_MM, _TICKS_MM = 4.5, 10.0, 9.0
"""Between frames: room for a title; for title, numbers and name of the axis; for the numbers of the right one."""
_LIMIT = 1.6
"""Amplitudes: where corrected IQ is cut (chosen by hand). The circle keeps 5/8 of the height, whatever samples do."""
_THIN = 0.3
"""Points, of lines that fill their frame (chosen by hand): in a thicker one turns run together."""
_IMPACTS = Line("#808080", 0.25, (3.0, 2.5))
_SCALE_COLOUR = "#009e73"
_DASHES = (3.0, 2.0)
"""Line and gap in points."""
_MOST_HIGH_MM, _NARROW_MM = 30.0, 120.0
"""Height of a row of IQ at most; width from which raw and corrected stand side by side (chosen by hand)."""

_Lines = Sequence[tuple[Curve, Line, str]]


def _rows(area: Area, count: int) -> list[Area]:
    height = (area.height - (count - 1) * _GAP_MM) / count
    return [area.inside(0.0, number * (height + _GAP_MM), area.width, height) for number in range(count)]


def _columns(area: Area, count: int) -> list[Area]:
    width = (area.width - (count - 1) * _TICKS_MM) / count
    return [area.inside(number * (width + _TICKS_MM), 0.0, width, area.height) for number in range(count)]


class RunDrawing:
    """Draws the curves of a run into areas of a figure."""

    def __init__(self, figure: Figure, curves: RunCurves) -> None:
        self.canvas, self.curves = Canvas(figure), curves

    def iq_rows(self, area: Area, receivers: tuple[ReceiverCurves, ...], *, stacked: bool = False) -> None:
        """Draw one row a receiver: raw and corrected IQ, each against time and in the plane."""
        known = any(np.isfinite(one.corrected.i.y).any() for one in receivers)
        shown = [(one, corrected) for one in receivers for corrected in ((False, True) if known else (False,))]
        # in the column of a journal they stand below each other
        beside = 1 if stacked or area.width < _NARROW_MM else 1 + known
        rows = _rows(area, len(shown) // beside)
        places = [column for row in rows for column in _columns(row, beside)]
        for (receiver, corrected), place in zip(shown, places, strict=True):
            self._pair(place, receiver, corrected=corrected, bottom=place.top == rows[-1].top)

    def _pair(self, area: Area, receiver: ReceiverCurves, *, corrected: bool, bottom: bool) -> None:
        i, q, plane = receiver.corrected if corrected else receiver.raw
        side = min(area.height, 0.35 * area.width)
        # in amplitudes, which have no unit
        factor, unit = (1.0, "") if corrected else sheet.scaled(self.curves.unit, sheet.largest([i, q]))
        span = span_of([i, q], factor)
        if corrected:
            limit = min(_LIMIT, max(1.15, *map(abs, span)))
            span = -limit, limit
        panel = Panel(self.canvas, area._replace(width=area.width - side - _TICKS_MM), self.curves.span_s, span)
        drawn = [panel.curve(i, Line(sheet.I_COLOUR, _THIN), factor, "I")]
        drawn.append(panel.curve(q, Line(sheet.Q_COLOUR, _THIN), factor, "Q"))
        if not any(drawn):
            panel.say("not known")
        what = "corrected IQ" if corrected else f"raw IQ / {unit}"
        self._over_time(panel, f"Receiver {receiver.name}: {what}", bottom=bottom)
        beside = area.inside(area.width - side, area.height - side, side, side)
        limit = _LIMIT if corrected else max(map(abs, span))
        in_plane = Panel(self.canvas, beside, (-limit, limit), (-limit, limit))
        if any(drawn):
            _plane(in_plane, plane, factor, corrected=corrected)
        in_plane.frame("Q against I", numbers=bottom)

    def correction(self, area: Area, receivers: tuple[ReceiverCurves, ...]) -> None:
        """Draw the correction at work: I above Q, one column a receiver."""
        rows = _rows(area, 2)
        for number, (receiver, column) in enumerate(zip(receivers, _columns(area, len(receivers)), strict=True)):
            parts: tuple[StepCurves | CircleCurves, ...] = receiver.steps or receiver.circles
            for place, part in enumerate(parts):
                where = column._replace(top=rows[place].top, height=rows[place].height)
                self.part(where, part, bottom=place == 1, key=number == place == 0)

    def part(
        self, area: Area, part: StepCurves | CircleCurves, *, bottom: bool, key: bool, detailed: bool = False
    ) -> None:
        """Draw one channel and what the correction makes of it; its names where `key` says so."""
        factor, unit = sheet.scaled(self.curves.unit, part.signal.largest)
        colour = sheet.I_COLOUR if part.name.startswith("I") else sheet.Q_COLOUR
        spanned = [part.signal, part.scale] if detailed and isinstance(part, StepCurves) else [part.signal]
        panel = Panel(self.canvas, area, self.curves.span_s, span_of(spanned, factor))
        lines: list[tuple[Curve, Line, str]] = []
        if isinstance(part, StepCurves):
            if detailed:
                panel.shade(*part.segment_s, "#eef3f8")
            spline = Line(colour, 0.6)
            lines += [(part.scale, Line(_SCALE_COLOUR, 0.6), "scale"), (part.bias, Line(sheet.FIT_COLOUR, 0.6), "bias")]
            lines += [(part.upper, spline, "splines"), (part.lower, spline, "")]
        else:
            lines.append((part.rest, Line(sheet.FIT_COLOUR, _THIN), f"raw − {part.kind}"))
            lines.append((part.fitted, Line(colour, _THIN), part.kind))
        lines.append((part.signal, Line(sheet.RAW_COLOUR, _THIN), "raw"))
        # the names stand from the right, the lines lie on each other from below
        for _, line, name in lines if key else ():
            if name:
                panel.key(name, line)
        for curve, line, _ in reversed(lines):
            panel.curve(curve, line, factor)
        title = f"{part.name} / {unit}"
        if isinstance(part, StepCurves):
            places = {"peaks": part.peaks, "valleys": part.valleys}
            if detailed:
                places["zero crossings"] = part.zero_crossings
                title += ": " + ", ".join(f"{len(one.x)} {name}" for name, one in places.items())
            for one in places.values():
                panel.dots(one.x, one.y * factor, sheet.FIT_COLOUR if one is part.zero_crossings else "black", 1.0)
        self._over_time(panel, title, bottom=bottom)

    def phase(self, area: Area) -> None:
        """Draw the phase of every receiver without (dashed) and with correction; L over the whole recording inset."""
        own = list(zip(self.curves.receivers, sheet.RECEIVER_COLOURS, strict=False))
        low, high = span_of([one.phase for one in self.curves.receivers])
        known = np.concatenate([one.phase.y[np.isfinite(one.phase.y)] for one in self.curves.receivers])
        # the inset lies above or below the curves, where it hides none of them
        above = float(np.median(known)) < 0.5 * (low + high)
        room = 0.6 * (high - low)
        panel = Panel(self.canvas, area, self.curves.span_s, (low, high + room) if above else (low - room, high))
        for receiver, colour in reversed(own):
            panel.curve(receiver.phase_raw, Line(colour, 0.8, _DASHES))
            panel.curve(receiver.phase, Line(colour, 0.5), name=receiver.name)
        self._over_time(panel, "Phase / rad (dashed: uncorrected)")
        whole = [one.whole_change for one in self.curves.receivers]
        factor, unit = sheet.scaled("m", sheet.largest(whole))
        times = np.concatenate([one.x for one in whole])
        width, height = 0.62 * area.width, 0.22 * area.height
        inside = area.inside(0.97 * area.width - width, 4.0 if above else area.height - height - 4.5, width, height)
        inset = Panel(self.canvas, inside, (float(times.min()), float(times.max())), span_of(whole, factor), 5.0)
        inset.clear(5.5)
        for receiver, colour in own:
            inset.curve(receiver.whole_change, Line(colour, 0.4), factor)
        inset.frame(f"L / {unit}, whole recording")

    def fall(self, area: Area, track: TrackFigures, *, detailed: bool = False, floor_m: float | None = None) -> None:
        """Draw the height over the fitted parabola, below it what the fit leaves; in detail with impacts and floor."""
        upper = 0.6 * (area.height - _LABELS_MM)
        panel = Panel(self.canvas, area._replace(height=upper), self.curves.span_s, span_of([track.height], 1e3))
        if track.parabola is not None:
            panel.curve(track.parabola, Line(sheet.FIT_COLOUR, 1.2, _DASHES), 1e3, "parabola")
        if not panel.curve(track.height, Line(sheet.RECEIVER_COLOURS[0], 0.6), 1e3, "sphere"):
            panel.say("not known")
        if detailed:
            self._name_impacts(panel)
        if floor_m is not None and track.level:
            panel.curve(Curve(np.array(panel.x), np.full(2, floor_m)), Line("#808080", 0.6), 1e3, "floor")
        along = " along the floor's normal" if detailed and not track.level else ""
        self._over_time(panel, f"Height{along} / mm")
        below = area.inside(0.0, upper + _LABELS_MM, area.width, area.height - upper - _LABELS_MM)
        residual = track.residual
        if residual is None or not residual.largest:
            panel = Panel(self.canvas, below, self.curves.span_s, (-1.0, 1.0))
            panel.say("no fall was fitted")
            panel.frame("Residual", ticks=False)
            return
        factor, unit = sheet.scaled("m", residual.largest)
        # drawn over its own time: a fall is a small part of what a sphere does that bounces
        panel = Panel(self.canvas, below, (float(residual.x[0]), float(residual.x[-1])), span_of([residual], factor))
        panel.curve(residual, Line(sheet.FIT_COLOUR, 0.4), factor)
        self._over_time(panel, f"Residual of the fall / {unit}")

    def phase_and_fall(self, area: Area) -> None:
        """Draw both beside each other, or the phase alone where there is no track."""
        left, right = _columns(area, 2)
        track = self.curves.track
        self.phase(left if track else area)
        if track is not None:
            self.fall(right, track)

    def _over_time(self, panel: Panel, title: str, *, bottom: bool = True) -> None:
        """Finish a panel against time: lost samples, restarts, impacts, frame."""
        for first, last in self.curves.gaps_s:
            panel.shade(first, last, sheet.GAP_COLOUR)
        panel.upright(self.curves.restarts_s, Line(sheet.GAP_COLOUR, 1.0))
        panel.upright([time_s for time_s, _ in self.curves.impacts], _IMPACTS)
        panel.frame(title, f"time after the {self.curves.since} / s" if bottom else "", numbers=bottom)

    def _name_impacts(self, panel: Panel) -> None:
        """Write number and e beside each impact, as much as there is room for before the next."""
        begin, end = self.curves.span_s
        for number, (time_s, e) in enumerate(self.curves.impacts, 1):
            following = self.curves.impacts[number][0] if number < len(self.curves.impacts) else end
            room_mm = (min(following, end) - time_s) / (end - begin) * panel.area.width - 1.5
            texts = [f"{number}: e = {e}", f"{number}", ""] if e else [f"{number}", ""]
            text = next(text for text in texts if sheet.width_mm(text, SIZE) <= max(room_mm, 0.0))
            if begin <= time_s <= end:
                at_mm = panel.place([time_s], [0.0])[0, 0] + 0.7
                panel.later(partial(self._below_top, panel, at_mm, text))

    @staticmethod
    def _below_top(panel: Panel, x: float, text: str) -> None:
        panel.canvas.write(x, panel.area.top + 2.5, text, SIZE)

    def several(self, area: Area, title: str, lines: _Lines, unit: str = "", *, from_zero: bool = False) -> None:
        """Draw curves over time into one panel, the first on top."""
        drawn = [curve for curve, _, _ in lines]
        factor, prefixed = sheet.scaled(unit, sheet.largest(drawn)) if unit else (1.0, "rad")
        low, high = span_of(drawn, factor)
        panel = Panel(self.canvas, area, self.curves.span_s, (0.0 if from_zero else low, high))
        known = [panel.curve(curve, line, factor, name) for curve, line, name in reversed(lines)]
        if not any(known):
            panel.say("not known")
        self._over_time(panel, f"{title} / {prefixed}")


def _plane(panel: Panel, plane: Curve, factor: float, *, corrected: bool) -> None:
    panel.dots(plane.x * factor, plane.y * factor, sheet.I_COLOUR if corrected else sheet.RAW_COLOUR)
    turn = np.linspace(0.0, 2.0 * np.pi, 61)
    arm = 0.06 * panel.x[1]
    cross = Curve(np.array([-arm, arm, np.nan, 0.0, 0.0]), np.array([0.0, 0.0, np.nan, -arm, arm]))
    panel.curve(Curve(np.cos(turn), np.sin(turn)) if corrected else cross, Line("#404040", 0.4))


def run_figures(figure: Figure, area: Area, curves: RunCurves) -> None:
    """Draw all figures of a run into what its page has left."""
    drawing, every = RunDrawing(figure, curves), curves.receivers
    parts: list[tuple[float, int, Callable[[Area], None]]]
    parts = [(1.0, len(every), lambda where: drawing.iq_rows(where, every))]
    if any(one.steps or one.circles for one in every):
        parts.append((0.7, 2, lambda where: drawing.correction(where, every)))
    if curves.has_phase:
        parts.append((2.4, 1, drawing.phase_and_fall))
    gaps = sum((rows - 1) * _GAP_MM for _, rows, _ in parts) + (len(parts) - 1) * _LABELS_MM
    unit = min((area.height - gaps) / sum(share * rows for share, rows, _ in parts), _MOST_HIGH_MM)
    top = area.top
    for share, rows, draw in parts:
        height = share * rows * unit + (rows - 1) * _GAP_MM
        draw(area._replace(top=top, height=height))
        top += height + _LABELS_MM


def run_on_screen(figure: Figure, area: Area, curves: RunCurves) -> None:
    """Draw phase and fall of a run, or its signals where there are none."""
    if curves.has_phase:
        RunDrawing(figure, curves).phase_and_fall(area)
    else:
        RunDrawing(figure, curves).iq_rows(area, curves.receivers)


_PAGE_LEFT_MM, _PAGE_TOP_MM, _PAGE_BELOW_MM = 28.0, 30.0, 26.0
"""From the edges of the paper to the frames: the text's margins, and room for numbers, title and name of the axis."""
_LEAST_HALF_SPAN_M = 0.005
"""A sphere at rest shall not fill the plane with its noise."""
_VIEW_AZIMUTH_DEG, _VIEW_ELEVATION_DEG = -60.0, 25.0
"""Chosen by hand, near those of matplotlib (−60, 30): x to the right, y away from the reader, a little from above."""


def _new_page(curves: RunCurves, paper: Paper) -> tuple[Figure, RunDrawing, Area]:
    figure = sheet.new_page(paper)
    width, height = sheet.size_mm(figure)
    room = width - _PAGE_LEFT_MM - sheet.RIGHT_MM, height - _PAGE_TOP_MM - _PAGE_BELOW_MM
    return figure, RunDrawing(figure, curves), Area(_PAGE_LEFT_MM, _PAGE_TOP_MM, *room)


def signals_page(curves: RunCurves, paper: Paper) -> Figure:
    """Return the page: raw and, where there is any, corrected below; time at the left, the plane at the right."""
    figure, drawing, area = _new_page(curves, paper)
    area = area._replace(height=min(area.height, 90.0 * len(curves.receivers)))
    drawing.iq_rows(area, curves.receivers, stacked=True)
    return figure


def steps_page(curves: RunCurves, paper: Paper) -> Figure:
    """Return the page: signal, splines, extremes, bias and scale of each channel."""
    figure, drawing, area = _new_page(curves, paper)
    steps = [step for receiver in curves.receivers for step in receiver.steps]
    area = area._replace(height=min(area.height, 45.0 * len(steps)))
    for step, row in zip(steps, _rows(area, len(steps)), strict=True):
        drawing.part(row, step, bottom=step is steps[-1], key=step is steps[0], detailed=True)
    return figure


def paths_page(curves: RunCurves, paper: Paper) -> Figure:
    """Return the page: phase and path length of each receiver, what the correction changed, standard uncertainty."""
    figure, drawing, area = _new_page(curves, paper)
    own = list(zip(curves.receivers, sheet.RECEIVER_COLOURS, strict=False))
    spaced = area.height - len(own) * (_LABELS_MM - _GAP_MM)
    rows = _rows(area._replace(height=min(spaced, 60.0 * (len(own) + 1))), len(own) + 1)
    rows = [row._replace(top=row.top + number * (_LABELS_MM - _GAP_MM)) for number, row in enumerate(rows)]
    lost = ", path lost at each yellow line: another zero" if curves.restarts_s else ""
    for (one, colour), row in zip(own, rows, strict=False):
        left, right = _columns(row, 2)
        phases = ((one.phase, Line("black"), "corrected"), (one.phase_raw, Line(sheet.RAW_COLOUR, 1.5), "uncorrected"))
        drawing.several(left, f"Phase of receiver {one.name}", phases)
        u = np.interp(one.change.x, one.u_change.x, one.u_change.y) if len(one.u_change.x) else 0.0
        ends = [Curve(one.change.x, one.change.y + sign * COVERAGE * u) for sign in (-1.0, 1.0)]
        band = [(end, Line(colour, 0.2), name) for end, name in zip(ends, (f"± {COVERAGE:g} u", ""), strict=True)]
        lines = [(one.change, Line(colour, 0.6), ""), *band]
        drawing.several(right, f"Change of path length L{one.name}{lost}", lines, "m")
    left, right = _columns(rows[-1], 2)
    changed = [(one.phase_difference, Line(colour), one.name) for one, colour in own]
    drawing.several(left, "Uncorrected − corrected phase", changed)
    u_lines = [(one.u_change, Line(colour), f"L{one.name}") for one, colour in own]
    drawing.several(right, "u(L)", u_lines, "m", from_zero=True)
    return figure


def track_page(curves: RunCurves, track: TrackFigures, floor_m: float | None, paper: Paper) -> Figure:
    """Return the page: height and what the fall leaves of it, sideways, uncertainties, in space and in projections.

    `floor_m` is the height of the centre of the sphere at contact; None where the setup does not say.
    """
    figure, drawing, area = _new_page(curves, paper)
    drawing.fall(area._replace(height=0.5 * area.height), track, detailed=True, floor_m=floor_m)
    left, right = _columns(area.inside(0.0, 0.5 * area.height + _LABELS_MM, area.width, 0.2 * area.height), 2)
    of_z, *colours = sheet.RECEIVER_COLOURS[:3]
    sideways = [(one, Line(colour), name) for one, colour, name in zip((track.x, track.y), colours, "xy", strict=True)]
    drawing.several(left, "Sideways: x, y", sideways, "m")
    u = [(one, Line(colour), name) for one, colour, name in zip(track.u, (*colours, of_z), "xyz", strict=True)]
    drawing.several(right, "u of the position", u, "m", from_zero=True)
    if np.isfinite(track.places_m).any():
        below = area.inside(0.0, 0.7 * area.height + 2.0 * _LABELS_MM, area.width, 0.0)
        _places(drawing.canvas, [one._replace(height=one.width) for one in _columns(below, 4)], track.places_m)
    return figure


def motion_page(curves: RunCurves, motion: MotionFigures, paper: Paper) -> Figure:
    """Return the page: velocity and acceleration against time, and speed against height, each with its band."""
    figure, drawing, area = _new_page(curves, paper)
    rows = _rows(area._replace(height=0.8 * area.height), 3)
    rows = [row._replace(top=row.top + number * (_LABELS_MM - _GAP_MM)) for number, row in enumerate(rows)]
    of_z, *colours = sheet.RECEIVER_COLOURS[:3]
    for row, title, unit, three in (
        (rows[0], "Velocity", "m/s", motion.velocity),
        (rows[1], "Acceleration", "m/s²", motion.acceleration),
    ):
        lines: list[tuple[Curve, Line, str]] = []
        for name, own, colour in zip("zxy", (three[2], three[0], three[1]), (of_z, *colours), strict=True):
            lines += [
                (own.value, Line(colour), name),
                (own.low, Line(colour, _THIN), ""),
                (own.high, Line(colour, _THIN), ""),
            ]
        drawing.several(row, f"{title} ± {COVERAGE:g} u", lines, unit)
    speed = motion.speed
    panel = Panel(
        drawing.canvas, rows[2], span_of([Curve(speed.value.y, 1e3 * speed.value.x)]), (0.0, span_of([speed.high])[1])
    )
    for curve, width in ((speed.value, 1.0), (speed.low, _THIN), (speed.high, _THIN)):
        panel.curve(Curve(1e3 * curve.x, curve.y), Line(of_z, width))
    panel.frame("Speed / (m/s)", "z / mm")
    return figure


def _places(canvas: Canvas, squares: list[Area], places_m: FloatArray) -> None:
    """Draw the track in three planes and in a cube seen from the side."""
    line = Line(sheet.RECEIVER_COLOURS[0], 0.6)
    for square, (across, up) in zip(squares, ((0, 2), (1, 2), (0, 1)), strict=False):
        middle, half = _cube(places_m if up == 2 else places_m[:2])
        x, y = ((1e3 * (middle[axis] - half), 1e3 * (middle[axis] + half)) for axis in (across, up))
        panel = Panel(canvas, square, x, y)
        panel.curve(Curve(1e3 * places_m[across], 1e3 * places_m[up]), line)
        panel.frame(f"{'xyz'[up]} / mm", f"{'xyz'[across]} / mm")
    middle, half = _cube(places_m)
    grey, edge = Line("#b0b0b0", 0.4), (-1.6 * half, 1.6 * half)
    panel = Panel(canvas, squares[-1], edge, edge)
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=np.float64) * half
    for ends in combinations(corners, 2):
        if np.count_nonzero(ends[0] != ends[1]) == 1:
            panel.curve(_seen(np.stack(ends, axis=1)), grey)
    x, y, z = places_m - middle[:, None]
    panel.curve(_seen(np.stack([x, y, np.full_like(z, -half)])), Line("#b0b0b0", 0.8))
    panel.curve(_seen(np.stack([x, y, z])), line)
    panel.draw(f"In space, cube of {2e3 * half:.0f} mm")
    for name, end in (("x", (0.0, -1.3, -1.0)), ("y", (1.3, 0.0, -1.0)), ("z", (-1.2, -1.2, 0.0))):
        at = _seen(np.array([end]).T * half)
        ((across_mm, down_mm),) = panel.place(at.x, at.y)
        canvas.write(across_mm, down_mm, name, SIZE, 0.5)


def _cube(places_m: FloatArray) -> tuple[FloatArray, float]:
    """Return middle and half of the side of a cube that holds all places."""
    low, high = np.nanmin(places_m, axis=1), np.nanmax(places_m, axis=1)
    return 0.5 * (low + high), max(_LEAST_HALF_SPAN_M, 0.55 * float((high - low).max()))


def _seen(places: FloatArray) -> Curve:
    """Return places as they are seen from the side and a little above."""
    azimuth, elevation = math.radians(_VIEW_AZIMUTH_DEG), math.radians(_VIEW_ELEVATION_DEG)
    right = np.array([-math.sin(azimuth), math.cos(azimuth), 0.0])
    across = math.sin(elevation)
    up = np.array([-across * math.cos(azimuth), -across * math.sin(azimuth), math.cos(elevation)])
    return Curve(right @ places, up @ places)
