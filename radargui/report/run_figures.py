"""Figures of a run: IQ, the correction at work, phase and path length, the fall; on its page, alone, or in detail."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from radargui.model.arrays import FloatArray
from radargui.model.rounding import COVERAGE, plain
from radargui.report import plots
from radargui.report.curves import (
    Banded,
    CircleCurves,
    Curve,
    MotionFigures,
    ReceiverCurves,
    RunCurves,
    StepCurves,
    TrackFigures,
)
from radargui.report.plots import (
    BROAD,
    DASHED,
    FIT_COLOUR,
    I_COLOUR,
    Q_COLOUR,
    RAW_COLOUR,
    RECEIVER_COLOURS,
    TEXT_WIDTH_MM,
    THIN,
    curve,
    dots,
    frames,
    key,
    largest,
    say,
    scaled,
    span_of,
)

_LIMIT = 1.6
"""Amplitudes: where corrected IQ is cut (chosen by hand). The circle keeps 5/8 of the height, whatever samples do."""
_SIGNAL_MM, _PLANE_MM, _FALL_MM = 20.0, 27.0, 60.0
"""Heights on the page of a run: a signal against time, a plane, phase and fall (chosen by hand)."""
_GAP_MM, _NAMED_GAP_MM = 5.0, 12.0
"""Between rows of frames: room for a title; for numbers and name of the axis too."""
_DETAIL_MM = 75.0
"""Height of a row of a page of details at most (chosen by hand)."""
_Lines = Sequence[tuple[Curve, str, float]]
"""Curves with colour and width, the first on top."""


def over_time(axes: Axes, curves: RunCurves, title: str, *, bottom: bool = True) -> None:
    """Finish a frame against time: span, lost samples, restarts, impacts, title."""
    axes.set_xlim(*curves.span_s)
    axes.set_title(title)
    for first, last in curves.gaps_s:
        axes.axvspan(first, last, color=plots.GAP_COLOUR, linewidth=0.0)
    upright: dict[str, Any] = {"transform": axes.get_xaxis_transform()}
    if curves.restarts_s:
        axes.vlines(curves.restarts_s, 0.0, 1.0, plots.GAP_COLOUR, linewidth=1.0, **upright)
    if curves.impacts:
        at = [time_s for time_s, _ in curves.impacts]
        axes.vlines(at, 0.0, 1.0, plots.IMPACT_COLOUR, linewidth=THIN, zorder=0.5, **upright)
    if bottom:
        axes.set_xlabel(f"time after the {curves.since} / s")
    else:
        plots.without_numbers(axes)


def signals(axes: Axes, curves: RunCurves, receiver: ReceiverCurves, *, corrected: bool, bottom: bool = True) -> None:
    """Draw I and Q of a receiver, and of raw ones what the correction's model leaves of them."""
    i, q, _ = receiver.corrected if corrected else receiver.raw
    factor, unit = (1.0, "") if corrected else scaled(curves.unit, largest([i, q]))
    # in amplitudes, which have no unit
    low, high = span_of([i, q], factor)
    if corrected:
        high = min(_LIMIT, max(1.15, abs(low), abs(high)))
        low = -high
    drawn = [curve(axes, one, colour, THIN, factor=factor) for one, colour in ((i, I_COLOUR), (q, Q_COLOUR))]
    axes.set_ylim(low, high)
    names = [("I", I_COLOUR), ("Q", Q_COLOUR)]
    if not corrected and receiver.circles:
        for one in receiver.circles:
            curve(axes, one.rest, FIT_COLOUR, THIN, factor=factor)
        names.append((f"raw − {receiver.circles[0].kind}", FIT_COLOUR))
    if any(drawn):
        key(axes, names)
    else:
        say(axes, "not known")
    what = "corrected IQ" if corrected else f"raw IQ / {unit}"
    over_time(axes, curves, f"{receiver.name}: {what}", bottom=bottom)


def plane(axes: Axes, curves: RunCurves, receiver: ReceiverCurves, *, corrected: bool) -> None:
    """Draw Q against I: raw with the origin, corrected with the unit circle."""
    factor, limit, unit = _scale(curves, receiver, corrected=corrected)
    axes.set(xlim=(-limit, limit), ylim=(-limit, limit), aspect="equal")
    axes.set_title("Q against I" if corrected else f"Q against I / {unit}")
    axes.locator_params(nbins=3)
    _in_plane(axes, receiver, factor, limit, corrected=corrected)


def _scale(curves: RunCurves, receiver: ReceiverCurves, *, corrected: bool) -> tuple[float, float, str]:
    """Return what volts or amplitudes are multiplied by, how far the plane then reaches, and the unit."""
    if corrected:
        return 1.0, _LIMIT, ""
    factor, unit = scaled(curves.unit, largest(receiver.raw[:2]))
    return factor, max(map(abs, span_of(receiver.raw[:2], factor))), unit


def _in_plane(
    axes: Axes, receiver: ReceiverCurves, factor: float, arm: float, *, corrected: bool, x: float = 0.0, y: float = 0.0
) -> None:
    drawn = (receiver.corrected if corrected else receiver.raw).plane
    known = np.isfinite(drawn.y)
    across, up = x + factor * drawn.x[known], y + factor * drawn.y[known]
    dots(axes, across, up, I_COLOUR if corrected else RAW_COLOUR)
    turn = np.linspace(0.0, 2.0 * np.pi, 61)
    cross = np.array([[-0.06, 0.06, np.nan, 0.0, 0.0], [0.0, 0.0, np.nan, -0.06, 0.06]]) * arm
    shape = factor * np.stack([np.cos(turn), np.sin(turn)]) if corrected else cross
    curve(axes, Curve(x + shape[0], y + shape[1]), plots.FRAME_COLOUR, 0.4)


def planes(axes: Axes, curves: RunCurves, kinds: Sequence[bool]) -> None:
    """Draw the planes of all receivers beside each other in one frame, each with what half of its square is."""
    n = len(curves.receivers) * len(kinds)
    axes.set(xlim=(-1.0, 2.0 * n - 1.0), ylim=(-1.0, 1.0), aspect="equal", xticks=[], yticks=[], anchor="W")
    axes.vlines(
        2.0 * np.arange(1, n) - 1.0, 0.0, 1.0, plots.FRAME_COLOUR, linewidth=0.5, transform=axes.get_xaxis_transform()
    )
    for number, (receiver, corrected) in enumerate((one, kind) for one in curves.receivers for kind in kinds):
        factor, limit, unit = _scale(curves, receiver, corrected=corrected)
        _in_plane(axes, receiver, factor / limit, 1.0, corrected=corrected, x=2.0 * number)
        whose = f"{receiver.name}: " if len(curves.receivers) > 1 else ""
        said = f"{'corrected' if corrected else 'raw'}, ± {plain(limit, 2)} {unit}"
        axes.text(2.0 * number - 1.0, 1.03, f"{whose}{said}".rstrip())


def correction(
    axes: Axes, curves: RunCurves, of: StepCurves | CircleCurves, *, bottom: bool = True, detailed: bool = False
) -> None:
    """Draw one channel and what the correction makes of it."""
    factor, unit = scaled(curves.unit, of.signal.largest)
    colour = I_COLOUR if of.name.startswith("I") else Q_COLOUR
    lines: list[tuple[Curve, str, float]] = [(of.signal, RAW_COLOUR, THIN)]
    title, names = f"{of.name} / {unit}", [("raw", RAW_COLOUR)]
    if isinstance(of, StepCurves):
        lines += [(of.lower, colour, BROAD), (of.upper, colour, BROAD), (of.bias, FIT_COLOUR, BROAD)]
        lines.append((of.scale, plots.SCALE_COLOUR, BROAD))
        names += [("splines", colour), ("bias", FIT_COLOUR), ("scale", plots.SCALE_COLOUR)]
    else:
        lines += [(of.fitted, colour, THIN), (of.rest, FIT_COLOUR, THIN)]
        names += [(of.kind, colour), (f"raw − {of.kind}", FIT_COLOUR)]
    for one, looks, width in lines:
        curve(axes, one, looks, width, factor=factor)
    axes.set_xlim(*curves.span_s)
    if isinstance(of, StepCurves):
        places = {"peaks": of.peaks, "valleys": of.valleys}
        if detailed:
            places["zero crossings"] = of.zero_crossings
            title += ": " + ", ".join(f"{len(one.x)} {name}" for name, one in places.items())
            axes.axvspan(*of.segment_s, color="#eef3f8", linewidth=0.0)
        for one in places.values():
            dots(axes, one.x, one.y * factor, FIT_COLOUR if one is of.zero_crossings else "black", 1.2)
    axes.set_ylim(*span_of([of.signal, of.scale] if isinstance(of, StepCurves) and detailed else [of.signal], factor))
    key(axes, names)
    over_time(axes, curves, title, bottom=bottom)


def _coloured(curves: RunCurves) -> list[tuple[ReceiverCurves, str]]:
    return list(zip(curves.receivers, RECEIVER_COLOURS, strict=False))


def phase(axes: Axes, curves: RunCurves, *, bottom: bool = True) -> None:
    """Draw the phase of every receiver without (dashed) and with correction."""
    for receiver, colour in _coloured(curves):
        curve(axes, receiver.phase_raw, colour, BROAD, linestyle=DASHED)
        curve(axes, receiver.phase, colour)
    axes.set_ylim(*span_of([one.phase for one in curves.receivers]))
    key(axes, [(receiver.name, colour) for receiver, colour in _coloured(curves)])
    over_time(axes, curves, "Phase / rad (dashed: uncorrected)", bottom=bottom)


def paths(axes: Axes, curves: RunCurves) -> None:
    """Draw the change of the path length of every receiver over the whole recording."""
    whole = [one.whole_change for one in curves.receivers]
    factor, unit = scaled("m", largest(whole))
    for receiver, colour in _coloured(curves):
        curve(axes, receiver.whole_change, colour, factor=factor)
    axes.set_title(f"L / {unit}, whole recording")
    axes.set_xlabel(f"time after the {curves.since} / s")


def height(
    axes: Axes, curves: RunCurves, track: TrackFigures, *, bottom: bool = True, floor_m: float | None = None
) -> None:
    """Draw the height over the fitted parabola; in detail, where the floor's height is given, with that."""
    names = []
    if track.parabola is not None and curve(axes, track.parabola, FIT_COLOUR, 1.2, factor=1e3, linestyle=DASHED):
        names.append(("parabola", FIT_COLOUR))
    if curve(axes, track.height, RECEIVER_COLOURS[0], factor=1e3):
        names.append(("sphere", RECEIVER_COLOURS[0]))
    else:
        say(axes, "not known")
    if floor_m is not None and track.level:
        axes.axhline(1e3 * floor_m, color="#808080", linewidth=BROAD)
        names.append(("floor", "#808080"))
    axes.set_ylim(*span_of([track.height], 1e3))
    key(axes, names)
    over_time(axes, curves, f"Height{'' if track.level else ' along the normal'} / mm", bottom=bottom)


def residual(axes: Axes, curves: RunCurves, track: TrackFigures) -> None:
    """Draw what the fitted fall leaves of the height, over its own time: a small part of that of a run."""
    left = track.residual
    if left is None or not left.largest:
        say(axes, "no fall was fitted")
        axes.set_title("Residual")
        axes.set(xticks=[], yticks=[])
        return
    factor, unit = scaled("m", left.largest)
    curve(axes, left, FIT_COLOUR, 0.4, factor=factor)
    over_time(axes, curves, f"Residual of the fall / {unit}")
    axes.set(xlim=(float(left.x[0]), float(left.x[-1])), ylim=span_of([left], factor))


def iq_figure(curves: RunCurves) -> Figure:
    """Return the signals of every receiver, raw and corrected, against time and in the plane; one column each."""
    known = any(np.isfinite(one.corrected.i.y).any() for one in curves.receivers)
    n, kinds = len(curves.receivers), (False, True) if known else (False,)
    square = min(_PLANE_MM, (TEXT_WIDTH_MM - _GAP_MM) / (n * len(kinds)))
    high = len(kinds) * (_SIGNAL_MM + _GAP_MM) + _NAMED_GAP_MM
    figure, rows = frames((TEXT_WIDTH_MM, high + square), len(kinds), n, fixed_mm=_GAP_MM, below_mm=square + _GAP_MM)
    for number, receiver in enumerate(curves.receivers):
        for row, corrected in zip(rows, kinds, strict=False):
            signals(row[number], curves, receiver, corrected=corrected, bottom=corrected == kinds[-1])
    planes(figure.add_axes((0.005, 0.01, 0.99, square / (high + square))), curves, kinds)
    return figure


def fall_figure(curves: RunCurves) -> Figure:
    """Return phase and path lengths, beside them height and residual of the fall where there is a track."""
    columns = 1 if curves.track is None else 2
    size = TEXT_WIDTH_MM, _FALL_MM
    figure, rows = frames(size, 2, columns, fixed_mm=_NAMED_GAP_MM, heights=(1.6, 1.0))
    phase(rows[0, 0], curves)
    paths(rows[1, 0], curves)
    if curves.track is not None:
        height(rows[0, 1], curves, curves.track)
        residual(rows[1, 1], curves, curves.track)
    return figure


def single_figures(name: str, curves: RunCurves, width_mm: float) -> Iterator[tuple[str, Figure]]:
    """Yield every figure of a run alone, as wide as a column, with its name."""
    for one in curves.receivers:
        own = f"{name}-receiver-{one.name}"
        kinds = (False, True) if np.isfinite(one.corrected.i.y).any() else (False,)
        heights = [*[1.0] * len(kinds), 1.3]
        figure, rows = frames((width_mm, 0.36 * width_mm * len(heights)), len(heights), heights=heights)
        for row, corrected in zip(rows, kinds, strict=False):
            signals(row[0], curves, one, corrected=corrected, bottom=corrected == kinds[-1])
        planes(rows[-1, 0], replace(curves, receivers=(one,)), kinds)
        yield f"{own}-iq", figure
        parts: tuple[StepCurves | CircleCurves, ...] = one.steps or one.circles
        if parts:
            figure, rows = frames((width_mm, 0.8 * width_mm), len(parts))
            for row, part in zip(rows, parts, strict=True):
                correction(row[0], curves, part, bottom=part is parts[-1])
            yield f"{own}-correction", figure
    if curves.has_phase:
        figure, rows = frames((width_mm, 0.9 * width_mm), 2, heights=(1.6, 1.0))
        phase(rows[0, 0], curves)
        paths(rows[1, 0], curves)
        yield f"{name}-phase", figure
    if curves.track is not None:
        figure, rows = frames((width_mm, 0.9 * width_mm), 2, heights=(1.6, 1.0))
        height(rows[0, 0], curves, curves.track)
        residual(rows[1, 0], curves, curves.track)
        yield f"{name}-fall", figure


def _page(rows: int, columns: int, **ratios: Any) -> tuple[Figure, Any]:
    high = min(plots.PAGE_HEIGHT_MM, rows * _DETAIL_MM)
    return frames((TEXT_WIDTH_MM, high), rows, columns, fixed_mm=_NAMED_GAP_MM, **ratios)


def signals_page(curves: RunCurves) -> Figure:
    """Return the page: raw and, where there is any, corrected IQ of each receiver against time and in the plane."""
    known = any(np.isfinite(one.corrected.i.y).any() for one in curves.receivers)
    shown = [(one, corrected) for one in curves.receivers for corrected in ((False, True) if known else (False,))]
    figure, rows = _page(len(shown), 2, widths=(3.0, 1.0))
    for (receiver, corrected), row in zip(shown, rows, strict=True):
        signals(row[0], curves, receiver, corrected=corrected)
        plane(row[1], curves, receiver, corrected=corrected)
    return figure


def steps_page(curves: RunCurves) -> Figure:
    """Return the page: signal, splines, extremes, bias and scale of each channel."""
    steps = [step for receiver in curves.receivers for step in receiver.steps]
    figure, rows = _page(len(steps), 1)
    for step, row in zip(steps, rows, strict=True):
        correction(row[0], curves, step, detailed=True)
    return figure


def paths_page(curves: RunCurves) -> Figure:
    """Return the page: phase and path length of each receiver, what the correction changed, standard uncertainty."""
    own = _coloured(curves)
    figure, rows = _page(len(own) + 1, 2)
    lost = ", path lost at each yellow line: another zero" if curves.restarts_s else ""
    for (one, colour), (left, right) in zip(own, rows, strict=False):
        several(
            left,
            curves,
            f"Phase of receiver {one.name}",
            [(one.phase, "black", BROAD), (one.phase_raw, RAW_COLOUR, 1.5)],
        )
        key(left, [("uncorrected", RAW_COLOUR), ("corrected", "black")])
        u = np.interp(one.change.x, one.u_change.x, one.u_change.y) if len(one.u_change.x) else 0.0
        ends = [(Curve(one.change.x, one.change.y + sign * COVERAGE * u), colour, 0.2) for sign in (-1.0, 1.0)]
        several(right, curves, f"L{one.name} ± {COVERAGE:g} u{lost}", [(one.change, colour, BROAD), *ends], "m")
    names = [(one.name, colour) for one, colour in own]
    left, right = rows[-1]
    several(
        left, curves, "Uncorrected − corrected phase", [(one.phase_difference, colour, BROAD) for one, colour in own]
    )
    several(right, curves, "u(L)", [(one.u_change, colour, BROAD) for one, colour in own], "m", from_zero=True)
    for axes in (left, right):
        key(axes, names)
    return figure


def several(
    axes: Axes, curves: RunCurves, title: str, lines: _Lines, unit: str = "", *, from_zero: bool = False
) -> None:
    """Draw curves over time into one frame, the first on top."""
    drawn = [one for one, _, _ in lines]
    factor, prefixed = scaled(unit, largest(drawn)) if unit else (1.0, "rad")
    known = [curve(axes, one, colour, width, factor=factor) for one, colour, width in reversed(lines)]
    if not any(known):
        say(axes, "not known")
    low, high = span_of(drawn, factor)
    axes.set_ylim(0.0 if from_zero else low, high)
    over_time(axes, curves, f"{title} / {prefixed}")


_OF_AXES = dict(zip("xyz", (RECEIVER_COLOURS[1], RECEIVER_COLOURS[2], RECEIVER_COLOURS[0]), strict=True))
_MIN_HALF_SPAN_M = 0.005
"""A sphere at rest shall not fill the plane with its noise."""
_VIEW = {"azim": -60.0, "elev": 25.0}
"""Degrees, chosen by hand: x to the right, y away from the reader, a little from above."""


def track_page(curves: RunCurves, track: TrackFigures, floor_m: float | None) -> Figure:
    """Return the page: height and what the fall leaves of it, sideways, uncertainties, in projections and in space.

    `floor_m` is the height of the centre of the sphere at contact; None where the setup does not say.
    """
    figure = plots.new_figure()
    parts: Any = figure.subfigures(3, 1, height_ratios=(1.9, 1.0, 1.0))
    upper, middle, lower = parts
    above, below = upper.subplots(2, 1, height_ratios=(1.6, 1.0))
    height(above, curves, track, floor_m=floor_m)
    _name_impacts(above, curves)
    residual(below, curves, track)
    upper.subplots_adjust(0.06, 0.1, 0.99, 0.96, hspace=0.4)
    left, right = middle.subplots(1, 2)
    sideways = {"x": track.x, "y": track.y}
    several(left, curves, "Sideways: x, y", [(one, _OF_AXES[name], BROAD) for name, one in sideways.items()], "m")
    key(left, [(name, _OF_AXES[name]) for name in sideways])
    u = dict(zip("xyz", track.u, strict=True))
    several(right, curves, "u", [(one, _OF_AXES[name], BROAD) for name, one in u.items()], "m", from_zero=True)
    key(right, [(name, _OF_AXES[name]) for name in u])
    middle.subplots_adjust(0.06, 0.18, 0.99, 0.92, wspace=0.14)
    if np.isfinite(track.places_m).any():
        _places(lower, track.places_m)
        lower.subplots_adjust(0.06, 0.14, 0.96, 0.96, wspace=0.32)
    return figure


def _name_impacts(axes: Axes, curves: RunCurves) -> None:
    """Write number and e beside each impact, as much as there is room for before the next."""
    begin, end = curves.span_s
    ends = [time_s for time_s, _ in curves.impacts[1:]] + [end]
    for number, ((time_s, e), until) in enumerate(zip(curves.impacts, ends, strict=False), 1):
        letters = 120.0 * (min(until, end) - time_s) / (end - begin)
        texts = [f"{number}: e = {e}", f"{number}", ""] if e else [f"{number}", ""]
        if begin <= time_s <= end:
            text = next(text for text in texts if len(text) <= max(letters - 1.0, 0.0))
            axes.annotate(text, (time_s, 1.0), (2.0, -2.0), ("data", "axes fraction"), "offset points", va="top")


def motion_page(curves: RunCurves, motion: MotionFigures) -> Figure:
    """Return the page: velocity and acceleration against time, and speed against height, each with its band."""
    figure, rows = _page(3, 1)
    for (axes,), title, unit, three in zip(
        rows, ("Velocity", "Acceleration"), ("m/s", "m/s²"), (motion.velocity, motion.acceleration), strict=False
    ):
        lines = [line for name, own in zip("xyz", three, strict=True) for line in _banded(own, _OF_AXES[name])]
        several(axes, curves, f"{title} ± {COVERAGE:g} u", lines, unit)
        key(axes, list(_OF_AXES.items()))
    (axes,) = rows[-1]
    for one, colour, width in _banded(motion.speed, _OF_AXES["z"]):
        axes.plot(1e3 * one.x, one.y, color=colour, linewidth=width)
    axes.set(title="Speed / (m/s)", xlabel="z / mm", ylim=(0.0, span_of([motion.speed.high])[1]))
    return figure


def _banded(of: Banded, colour: str) -> _Lines:
    return (of.value, colour, BROAD), (of.low, colour, THIN), (of.high, colour, THIN)


def _places(figure: Figure, places_m: FloatArray) -> None:
    """Draw the track in three planes and in space."""
    half = 1e3 * _half_span(places_m)
    line: dict[str, Any] = {"color": RECEIVER_COLOURS[0], "linewidth": BROAD}
    places = 1e3 * places_m
    middle = 0.5 * (np.nanmin(places, axis=1) + np.nanmax(places, axis=1))
    for number, (across, up) in enumerate(((0, 2), (1, 2), (0, 1)), 1):
        axes = figure.add_subplot(1, 4, number)
        axes.plot(places[across], places[up], **line)
        own = half if up == 2 else 1e3 * _half_span(places_m[:2])
        axes.set(xlim=(middle[across] - own, middle[across] + own), ylim=(middle[up] - own, middle[up] + own))
        axes.set(title=f"{'xyz'[up]} / mm", xlabel=f"{'xyz'[across]} / mm", aspect="equal")
    space = figure.add_subplot(1, 4, 4, projection="3d", **_VIEW)
    space.plot(*places, **line)
    limits = {f"{name}lim": (centre - half, centre + half) for name, centre in zip("xyz", middle, strict=True)}
    space.set(**limits, xlabel="x", ylabel="y", zlabel="z", xticks=[], yticks=[], zticks=[])
    for axis in (space.xaxis, space.yaxis, space.zaxis):
        axis.labelpad = -15.0
    space.set_title(f"In space, cube of {2.0 * half:.0f} mm")


def _half_span(places_m: FloatArray) -> float:
    """Return half of the side of a cube, in m, that holds all places."""
    return max(_MIN_HALF_SPAN_M, 0.55 * float(np.nanmax(np.nanmax(places_m, axis=1) - np.nanmin(places_m, axis=1))))
