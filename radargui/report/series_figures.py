"""Draw the figures of a series: e against the impact speed and other variables, its distribution, all falls."""

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from radargui.model.arrays import FloatArray
from radargui.model.rounding import COVERAGE, plain
from radargui.report import sheet
from radargui.report.canvas import Canvas, Line, Panel, Span, span_of
from radargui.report.decimation import Curve
from radargui.report.facts import (
    MOST_LOOKS,
    WORST_SHARE,
    ReportFacts,
    dependences_on,
    e_label,
    e_span,
    histogram_of,
    mean_gravity,
    points_of,
    session_look,
    shown_fits,
    speed_points,
)
from radargui.report.run_facts import RunFacts
from radargui.report.sheet import Area
from radargui.restitution.dependence import COVARIATES
from radargui.restitution.speed_models import SpeedFit, title_of

_LARGE = 7.0
"""Of text in these panels, in points; in those of a run it is `canvas.SIZE`, for there are more on a page."""
_DASHES = (4.0, 2.0)
_DOTS = (1.0, 1.5)
"""Line and gap in points."""
_FALLS_SHARE = 0.62
"""Of the height: the falls, above what their fits leave (chosen by hand)."""
_BESIDE_MM = 13.0
"""Between panels side by side: the numbers of the right one (chosen by hand)."""
_BETWEEN_MM = 5.0
"""Between both: the title of the lower one (the upper one has no numbers beneath)."""


def draw_speeds(figure: Figure, area: Area, facts: ReportFacts) -> None:
    """Draw e against the impact speed with bars, one colour a session, and the model of each sample."""
    groups = [speed_points(one.runs) for one in facts.sessions]
    every = np.concatenate(groups, axis=1)
    canvas = Canvas(figure)
    if not every.size:
        panel = Panel(canvas, area, (0.0, 1.0), (0.0, 1.0), _LARGE)
        panel.say("no valid impact")
        panel.frame("e", ticks=False)
        return
    low, high = e_span(every)
    n_outside = int(np.count_nonzero((every[1] < low) | (every[1] > high)))
    panel = Panel(canvas, area, (0.0, 1.08 * float(every[0].max())), (low, high), _LARGE)
    n_valid = sum(impact.valid for one in facts.sessions for run in one.runs for impact in run.bounces.impacts)
    names = [one.name for one in facts.findings.sessions]
    named = 1 < len(groups) <= MOST_LOOKS
    for fit in shown_fits(facts):
        _draw_fit(panel, fit)
    # the last name stands at the left
    for number in reversed(range(len(groups))):
        mark = session_look(number)[1]
        _draw_points(panel, groups[number], _colour(number), mark)
        if named:
            panel.key(sheet.printable(names[number])[:24], Line(_colour(number), 1.0), mark)
    unnamed = f"; {len(groups)} sessions" if len(groups) > MOST_LOOKS else ""
    outside = f"; {n_outside} outside" if n_outside else ""
    n_vague = n_valid - every.shape[1]
    vague = f"; {n_vague} with u > {100.0 * WORST_SHARE:g} % of e left out" if n_vague else ""
    title = f"e of valid impacts, bars ± {COVERAGE:g} statistical u{unnamed}{outside}{vague}"
    panel.frame(title, "speed before the impact / (m/s)")


def _draw_points(panel: Panel, points: FloatArray, colour: str, mark: int) -> None:
    speed, e, u = points
    x = np.repeat(speed, 3)
    y = np.stack([e - COVERAGE * u, e + COVERAGE * u, np.full_like(e, np.nan)], axis=1).ravel()
    panel.curve(Curve(x, y), Line(colour, 0.6))
    panel.dots(speed, e, colour, 3.0, mark)


def _draw_fit(panel: Panel, fit: SpeedFit) -> None:
    speed = np.linspace(max(fit.speed_low_m_s, 1e-3), fit.speed_high_m_s, 80)
    e, u = fit.e(speed)
    line = Line(sheet.FIT_COLOUR, 0.9, _DASHES)
    panel.curve(Curve(speed, e), line)
    for sign in (-1.0, 1.0):
        panel.curve(Curve(speed, e + sign * COVERAGE * u), Line(sheet.FIT_COLOUR, 0.3))
        panel.curve(Curve(speed, e + sign * fit.prediction(speed)), Line(sheet.FIT_COLOUR, 0.3, _DOTS))
    panel.key("one more impact, 95 %", Line(sheet.FIT_COLOUR, 0.3, _DOTS))
    panel.key(f"{title_of(fit.model)} ± {COVERAGE:g} u", line)


def draw_spread(figure: Figure, area: Area, facts: ReportFacts) -> None:
    """Draw how e is distributed, p(e) one colour a session, and e against what it depends on besides the speed."""
    spreads = [(number, one.distribution) for number, one in enumerate(facts.findings.sessions)]
    shown = [(number, one) for number, one in spreads if one is not None]
    drawn = {on: known for on in COVARIATES if (known := dependences_on(facts, on))}
    n = bool(shown) + len(drawn)
    width = (area.width - (n - 1) * _BESIDE_MM) / max(n, 1)
    places = iter(area.inside(k * (width + _BESIDE_MM), 0.0, width, area.height) for k in range(n))
    canvas = Canvas(figure)
    if shown:
        ends = [end for _, one in shown for end in (one.at[0], one.at[-1])]
        tops = [max(one.density) for _, one in shown] + [max(histogram_of(one)[1]) for _, one in shown[:1]]
        panel = Panel(canvas, next(places), (min(ends), max(ends)), (0.0, 1.1 * max(tops)), _LARGE)
        for number, one in shown:
            panel.curve(Curve(np.array(one.at), np.array(one.density)), Line(_colour(number), 0.9))
        if len(shown) == 1:
            panel.curve(Curve(*histogram_of(shown[0][1])), Line(_colour(shown[0][0]), 0.5))
        panel.frame("p(e), first impacts", "e")
    for on, found in drawn.items():
        covariate = COVARIATES[on]
        x, e, u = np.concatenate([points_of(one) for one in found], axis=1)
        low, high = float(x.min()) * covariate.scale, float(x.max()) * covariate.scale
        room = 0.06 * (high - low)
        panel = Panel(canvas, next(places), (low - room, high + room), e_span(np.stack([x, e, u])), _LARGE)
        for number, dependence in enumerate(found):
            x, e, u = points_of(dependence)
            _draw_points(panel, np.stack([covariate.scale * x, e, u]), _colour(number), session_look(number)[1])
            ends_x = np.array([x.min(), x.max()])
            panel.curve(Curve(covariate.scale * ends_x, dependence.line(ends_x)), Line(sheet.FIT_COLOUR, 0.9, _DASHES))
        panel.frame(f"{e_label(found)}, bars ± {COVERAGE:g} u", covariate.label.replace("[", "/ ").replace("]", ""))


def draw_falls(figure: Figure, area: Area, sessions: Sequence[Sequence[RunFacts]]) -> None:
    """Draw the way fallen of every run against the time from its vertex on over g t² / 2, and what the fits leave.

    Of several sessions each has one colour, which is that of `draw_speeds`.
    """
    runs = [run for session in sessions for run in session]
    falls = [run.falls for run in runs if run.falls is not None]
    of = [number for number, session in enumerate(sessions) for run in session if run.falls is not None]
    colours = [_colour(number) for number in (of if len(sessions) > 1 else range(len(falls)))]
    upper = area._replace(height=_FALLS_SHARE * area.height)
    lower = area.inside(0.0, upper.height + _BETWEEN_MM, area.width, area.height - upper.height - _BETWEEN_MM)
    canvas = Canvas(figure)
    end = max(float(np.nanmax(fallen.x)) for fallen, _ in falls)
    span: Span = (0.0, 1.05 * end)
    panel = Panel(canvas, upper, span, span_of([fallen for fallen, _ in falls], 1e3), _LARGE)
    t = np.linspace(0.0, end, 100)
    mean = mean_gravity(runs)
    line = Line("#404040", 1.4, _DASHES)
    panel.curve(Curve(t, 0.5 * mean * t**2), line, 1e3, f"g t² / 2, g = {plain(mean, 5)} m/s²")
    for colour, (fallen, _) in zip(colours, falls, strict=True):
        panel.curve(fallen, Line(colour, 0.6), 1e3)
    panel.frame(f"Way fallen / mm, {len(falls)} fall{'s' * (len(falls) > 1)}", numbers=False)
    factor, unit = sheet.scaled("m", sheet.largest([residual for _, residual in falls]))
    panel = Panel(canvas, lower, span, span_of([residual for _, residual in falls], factor), _LARGE)
    for colour, (_, residual) in zip(colours, falls, strict=True):
        panel.curve(residual, Line(colour, 0.3), factor)
    panel.frame(f"Residual of each fit / {unit}", "time from the vertex / s")


def _colour(number: int) -> str:
    return sheet.RECEIVER_COLOURS[session_look(number)[0]]
