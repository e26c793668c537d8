"""A figure of one's own in the report: the speed of the sphere against time."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
from matplotlib.figure import Figure

from radargui.model.arrays import FloatArray
from radargui.model.result import RunResult
from radargui.report.plots import new_figure

STEP = 20
"""Samples between two points: what is drawn is kept until the report is written, so it is kept small."""


def speed_over_time(result: RunResult) -> Callable[[], Figure] | None:
    """Return what draws the figure; None where there is no track."""
    if result.track is None:
        return None
    time_s, position_m = result.track.time_s[::STEP], result.track.position_m[:, ::STEP]
    speed_m_s = np.linalg.norm(np.gradient(position_m, time_s, axis=1), axis=0)
    return partial(draw, time_s - result.zero[0], speed_m_s)


def draw(time_s: FloatArray, speed_m_s: FloatArray) -> Figure:
    """Return the figure, as wide as the text of the report; it gets a page of its own."""
    figure = new_figure(height_mm=90.0, layout="constrained")
    axes = figure.subplots()
    axes.plot(time_s, speed_m_s, linewidth=0.8)
    axes.set_xlabel("time / s")
    axes.set_ylabel("speed / (m/s)")
    return figure
