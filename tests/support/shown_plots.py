"""What a plot of the window shows."""

from __future__ import annotations

import pyqtgraph as pg

from radargui.gui.plots.plot import Plot


def points_of(plot: Plot) -> int:
    """Return how many points each solid line of a plot is drawn with, at least."""
    lines = [item for item in plot.getPlotItem().items if isinstance(item, pg.PlotCurveItem)]
    drawn = [line for line in lines if line.opts["pen"].style() is pg.QtCore.Qt.PenStyle.SolidLine]
    return min(0 if line.xData is None else line.xData.size for line in drawn)


def shaded_of(plot: Plot) -> int:
    """Return how many spans of a plot are shaded."""
    return sum(len(item.opts["x0"]) for item in plot.getPlotItem().items if isinstance(item, pg.BarGraphItem))
