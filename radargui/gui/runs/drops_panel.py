"""The last drops of the session as dots with their uncertainty, what they give together, and who measures what."""

from collections.abc import Sequence

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import Signal
from PySide6.QtWidgets import QHBoxLayout, QVBoxLayout, QWidget

from radargui.gui.layout import TIPS, OneLine, button, fill, having
from radargui.gui.plots.plot import Plot
from radargui.gui.runs.run_model import RunEntry, RunModel
from radargui.gui.theme import Theme
from radargui.model.drop import figure_in
from radargui.model.rounding import COVERAGE, plain
from radargui.restitution.series import Series

N_SHOWN = 10
"""A hand's breadth tells so many apart, and whether they drift (the operators asked for ten)."""
_LEFT = 72
"""Width of the left axis in pixels: e with four digits beside its name."""
_ALONE = 1e-3
"""Half of the axis at the least: what is less than a thousandth of e is not read off a plot so low (by hand)."""


class DropsPanel(QWidget):
    """Follows the list of runs; a dot that is clicked asks for its run, *Change* for the fields of the session.

    Attributes
    ----------
    words, session
        n, mean and s of all drops that count; operator, sample, target and session on one line.
    """

    run_asked = Signal(object)
    change_asked = Signal()

    def __init__(self, theme: Theme, model: RunModel) -> None:
        super().__init__()
        self._model, self._shown = model, list[RunEntry]()
        self.plot = Plot(theme, "", "e", left_px=_LEFT, density=0.6)
        self.plot.setToolTip(TIPS["plots"]["Last drops"])
        self._spread, self._mean = self.plot.band("fit"), self.plot.rule("fit", 0.0, angle=0)
        self._bars = self.plot.fast_line("text", f"± {COVERAGE:g} u")
        self._counts = self.plot.marker("track", size=8, name="counts")
        self._others = self.plot.marker("mark", symbol="d", size=9, name="preliminary, or left out")
        for dots in (self._counts, self._others):
            dots.sigPointsClicked.connect(self._clicked)
        self.words, self.session = OneLine(), OneLine()
        change = button("Change", self.change_asked, TIPS["buttons"]["Change the session"])
        foot = fill(QHBoxLayout(), (self.session, 1), change, margins=(6, 0, 2, 0), spacing=6)
        fill(QVBoxLayout(self), having(self.words, contentsMargins=foot.contentsMargins()), (self.plot, 1), foot)
        for changed in (model.rowsInserted, model.dataChanged, model.modelReset):
            changed.connect(lambda *_: self.refresh())
        self._draw()

    def show_session(self, *parts: str) -> None:
        """Say operator, sample, target and session, as far as they are known."""
        self.session.setText(" · ".join(filter(None, parts)) or "nothing typed yet")

    def refresh(self) -> None:
        """Draw the last drops, and say what all that count give."""
        shown = [one for one in self._model.entries if one.has_e and not one.rejected][-N_SHOWN:]
        if shown != self._shown:
            self._shown = shown
            self._draw()

    def _draw(self) -> None:
        shown, series = self._shown, self._model.series
        self.words.setText(words_of(series))
        x = np.arange(len(shown), dtype=float)
        e = np.array([figure_in(one.summary, "e") or np.nan for one in shown])
        u = np.array([_u(one) for one in shown])
        counts = np.array([not one.left_out for one in shown], dtype=bool)
        self._counts.setData(x[counts], e[counts])
        self._others.setData(x[~counts], e[~counts])
        low, high = e - COVERAGE * u, e + COVERAGE * u
        self._bars.setData(np.repeat(x, 3), np.stack([low, high, np.full(x.size, np.nan)], axis=1).ravel())
        mean, s = series.e.mean, series.e.standard_deviation or 0.0
        self._mean.setVisible(mean is not None)
        ends = np.array([-0.6, max(x.size, 2) - 0.4])
        around = np.empty(0) if mean is None else np.full(2, mean)
        self._spread.show_band(ends[: around.size], around - s, around + s)
        self._mean.setValue(mean or 0.0)
        self.plot.getPlotItem().getAxis("bottom").setTicks([[(at, one.label) for at, one in enumerate(shown)]])
        self.plot.setXRange(*ends, padding=0)
        if shown:
            seen = np.concatenate([e, low[np.isfinite(low)], high[np.isfinite(high)], around - s, around + s])
            middle, half = 0.5 * (seen.min() + seen.max()), max(_ALONE, 0.55 * np.ptp(seen))
            self.plot.setYRange(middle - half, middle + half, padding=0)
        else:
            self.plot.setYRange(0.0, 1.0, padding=0)

    def _clicked(self, _item: object, points: Sequence[pg.SpotItem]) -> None:
        self.run_asked.emit(self._shown[round(points[0].pos().x())].path)


def words_of(series: Series) -> str:
    """Return n, mean and standard deviation of e in words; empty without any."""
    of = series.e
    s = "" if of.standard_deviation is None else f"s = {plain(of.standard_deviation, 2)}"
    return "   ".join(filter(None, (f"n = {of.n}", f"mean {of.words()}", s))) if of.n else ""


def _u(one: RunEntry) -> float:
    """Return the combined standard uncertainty of e, else the statistical one; NaN where none is known."""
    found = (figure_in(one.summary, key) for key in ("u_e_combined", "u_e"))
    return next((u for u in found if u is not None), np.nan)
