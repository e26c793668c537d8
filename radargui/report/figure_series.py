"""Page of a session: coefficient of restitution of every impact against its speed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from matplotlib.figure import Figure

from radargui.report.run_facts import RunFacts
from radargui.report.sheet import add_axes, legend, new_page
from radargui.report.style import RECEIVER_COLOURS

_MOST_NAMED = 8
_MARKERS = "osD^v<>P"
_WORST_SHARE = 0.1


@dataclass(frozen=True, slots=True)
class RunPoints:
    """Valid impacts of one run: speeds before, e and its standard uncertainty."""

    name: str
    speed_m_s: tuple[float, ...]
    e: tuple[float, ...]
    u_e: tuple[float, ...]


def points_of(runs: Sequence[RunFacts]) -> tuple[RunPoints, ...]:
    """Return the points of the runs that have a valid impact; an e that is hardly known is left out."""
    found = []
    for run in runs:
        impacts = [
            impact
            for impact in run.bounces.impacts
            if impact.valid and math.isfinite(impact.e) and impact.u_e < _WORST_SHARE * impact.e
        ]
        if impacts:
            columns = zip(*((impact.speed_before_m_s, impact.e, impact.u_e) for impact in impacts), strict=True)
            found.append(RunPoints(run.name, *columns))
    return tuple(found)


def series_page(points: Sequence[RunPoints]) -> Figure:
    """Return the page: e with bars of two standard uncertainties against the speed before the impact."""
    figure = new_page()
    axes = add_axes(figure, 26.0, 32.0, 170.0, 100.0)
    axes.set_title("Coefficient of restitution of every valid impact, bars ± 2 u")
    axes.set_xlabel("speed before the impact / (m/s)")
    axes.set_ylabel("e")
    for number, run in enumerate(points):
        axes.errorbar(
            run.speed_m_s,
            run.e,
            yerr=[2.0 * u for u in run.u_e],
            fmt=_MARKERS[number % len(_MARKERS)],
            color=RECEIVER_COLOURS[number % len(RECEIVER_COLOURS)],
            markersize=3.0,
            elinewidth=0.6,
            capsize=1.5,
            capthick=0.6,
            label=run.name if number < _MOST_NAMED else None,
        )
    axes.margins(0.05, 0.1)
    axes.set_xlim(left=0.0)
    if len(points) <= _MOST_NAMED:
        legend(axes)
    return figure
