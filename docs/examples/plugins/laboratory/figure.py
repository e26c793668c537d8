"""A figure of one's own in the report: the speed of the sphere against time."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
from matplotlib.figure import Figure

from radargui.model.arrays import FloatArray
from radargui.model.result import RunResult
from radargui.report.sheet import Paper, new_page

STEP = 20
"""Samples between two points: what is drawn is kept until the report is written, so it is kept small."""


def speed_over_time(result: RunResult) -> Callable[[Paper], Figure] | None:
    """Return what draws the page; None where there is no track."""
    if result.track is None:
        return None
    time_s, position_m = result.track.time_s[::STEP], result.track.position_m[:, ::STEP]
    speed_m_s = np.linalg.norm(np.gradient(position_m, time_s, axis=1), axis=0)
    return partial(draw, time_s - result.zero[0], speed_m_s)


def draw(time_s: FloatArray, speed_m_s: FloatArray, paper: Paper) -> Figure:
    """Return the page."""
    page = new_page(paper)
    axes = page.add_axes((0.12, 0.6, 0.8, 0.3))
    axes.plot(time_s, speed_m_s, linewidth=0.8)
    axes.set_xlabel("time / s")
    axes.set_ylabel("speed / (m/s)")
    return page
