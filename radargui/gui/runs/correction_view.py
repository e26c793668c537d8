"""The correction of a run at work, receiver by receiver; and several corrections of it laid over each other."""

import math
from collections.abc import Callable, Sequence

from PySide6 import QtWidgets
from PySide6.QtCore import Qt

from radargui.experiment.compare import OverlaidMethod
from radargui.gui.layout import Choice, OneLine, button, fill, having, labelled
from radargui.gui.plots.key import IQ_KEY, Key
from radargui.gui.plots.plot import Plot
from radargui.gui.setup_words import words_of
from radargui.gui.table import RowModel, RowTable
from radargui.gui.theme import Theme
from radargui.model.drop import gravity_words, restitution_words
from radargui.model.result import RunResult
from radargui.model.rounding import UNKNOWN, plain
from radargui.report.curves import EMPTY, CircleCurves, Curve, ReceiverCurves, RunCurves, StepCurves, every
from radargui.signals.ellipse import Ellipse

_PUBLISHED = (
    ("▲", "text", "peaks"),
    ("▼", "text", "valleys"),
    ("▬", "fit", "splines"),
    ("╌", "text", "bias"),
    ("+", "faint", "zero crossings"),
)
_MADE = {"model": "the model that was fitted", "circle": "offset and circle at the phase found"}
_BELOW = {
    "scale": ("scale [V]", 1.0, "What the signal less its bias is divided by, piece by piece between its extremes"),
    "rest": ("Δ [mV]", 1e3, "Residual: what the samples have and the fit has not: noise, and what is not described"),
}
"""What is drawn below I and Q, by its name in what was found: words of the axis, scale, tip."""
_LEFT = 58
"""Width of the left axes in pixels (chosen by hand): in less the figures are cut, more is taken from the curves."""
_LINES = 3
"""Of the words about what was decided; more are scrolled."""
_DOTS, _OUTLINE = 3000, 181
"""Samples in the plane and points of an ellipse: more look the same."""


class CorrectionView(QtWidgets.QWidget):
    """I and Q as recorded with what the method made of them; what it left, or the plane; corrected below.

    All but the plane share the time axis.
    """

    def __init__(self, theme: Theme) -> None:
        super().__init__()
        self._shown: tuple[RunResult, RunCurves] | None = None
        self.receiver = having(Choice(), accessibleName="Receiver")
        self.receiver.currentIndexChanged.connect(self._draw)
        # never makes the panel wider than its dock
        self._words = OneLine()
        above = (labelled("Receiver", self.receiver), self.receiver, (self._words, 1))
        top = fill(QtWidgets.QHBoxLayout(), *above, margins=(6, 3, 6, 0), spacing=6)
        self.key = Key(theme)
        self.raw = tuple(RawPlot(theme, part) for part in "IQ")
        self.rest = Plot(theme, left_px=_LEFT, figures_below=False)
        self.rest_lines = tuple(self.rest.still_line(part.lower(), part) for part in "IQ")
        self.plane = Plot(theme, "I raw [V]", "Q raw [V]", left_px=_LEFT, equal=True)
        self.dots = self.plane.marker("i", size=2, name="as recorded")
        self.outline = self.plane.still_line("fit", "fit")
        self.corrected = Plot(theme, "time [s]", "I, Q / A", left_px=_LEFT)
        self._curves = tuple(self.corrected.still_line(part.lower(), part) for part in "IQ")
        self.decided = having(QtWidgets.QPlainTextEdit(readOnly=True), accessibleName="What was found and decided")
        having(self.decided, frameShape=QtWidgets.QFrame.Shape.NoFrame, focusPolicy=Qt.FocusPolicy.NoFocus)
        # words are wrapped; at every fourth width Qt showed a bar all the same, which took the last line
        self.decided.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        # as many lines, and nothing of the next one
        self.decided.document().setDocumentMargin(0.0)
        self.decided.setViewportMargins(6, 0, 0, 0)
        self.decided.setFixedHeight(_LINES * self.fontMetrics().lineSpacing() + 2)
        self._plots = (*self.raw, self.rest, self.plane, self.corrected)
        shares = ((plot, 2 if plot is self.plane else 1) for plot in self._plots)
        fill(QtWidgets.QVBoxLayout(self), top, self.decided, self.key, *shares, spacing=1)
        for plot in (*self.raw, self.rest):
            plot.setXLink(self.corrected)
        self._clear_plots()

    def show_curves(self, result: RunResult, curves: RunCurves) -> None:
        """Show a result, the same receiver as before."""
        self._shown = result, curves
        names = [one.name for one in curves.receivers]
        self.receiver.offer(zip(names, names, strict=True), self.receiver.currentData())
        self._draw()

    def clear(self) -> None:
        """Forget the result."""
        self._shown = None
        self._words.setText("")
        self.decided.clear()
        self.key.show_entries()
        self._clear_plots()

    def _clear_plots(self) -> None:
        for plot in self._plots:
            plot.show_nothing()
        for widget in (self.rest, self.plane, self.decided):
            widget.hide()

    def _draw(self, _index: int = 0) -> None:
        number = self.receiver.currentIndex()
        if self._shown is None or number < 0:
            return
        (result, curves), key = self._shown, [*IQ_KEY]
        receiver, corrected = curves.receivers[number], result.corrected
        self._clear_plots()
        for plot, curve in zip(self.raw, receiver.raw, strict=False):
            plot.raw.setData(curve.x, curve.y)
        for line, curve in zip(self._curves, receiver.corrected, strict=False):
            line.setData(curve.x, curve.y)
        found = corrected.steps[number] if corrected and number < len(corrected.steps) else None
        if receiver.steps:
            key += _PUBLISHED
            self._draw_found(receiver.steps, "scale")
        elif receiver.circles:
            key.append(("▬", "fit", _MADE[receiver.circles[0].kind]))
            self._draw_found(receiver.circles, "rest")
        elif isinstance(found, Ellipse):
            key.append(("▬", "fit", "ellipse through the samples of the motion"))
            self._draw_ellipse(receiver, found)
        self.key.show_entries(*key)
        method = corrected.method if corrected else ""
        self._words.setText(f"correction: {method}" if method else "nothing was corrected")
        decided = " ".join(corrected.decisions) if corrected else ""
        said = decided or _ellipse_words(found)
        having(self.decided, plainText=said, visible=bool(said))
        self.corrected.relabel(f"time after the {curves.since} [s]")
        self.corrected.setXRange(*curves.span_s, padding=0.02)
        for plot in (*self.raw, self.rest, self.corrected):
            plot.enableAutoRange(axis="y")

    def _draw_found(self, found: Sequence[StepCurves | CircleCurves], below: str) -> None:
        """Draw what a method found in I and Q, and what of it stands below them, see `_BELOW`."""
        words, scale, tip = _BELOW[below]
        for plot, line, one in zip(self.raw, self.rest_lines, found, strict=True):
            for name, item in plot.found.items():
                curve: Curve = getattr(one, name, EMPTY)
                item.setData(curve.x, curve.y)
            left: Curve = getattr(one, below)
            line.setData(left.x, scale * left.y)
        self.rest.relabel("", words)
        having(self.rest, toolTip=tip).show()

    def _draw_ellipse(self, receiver: ReceiverCurves, found: Ellipse) -> None:
        plane = receiver.raw.plane
        kept = every(plane.x.size, _DOTS)
        self.dots.setData(plane.x[kept], plane.y[kept])
        self.outline.setData(*found.outline_v(_OUTLINE))
        self.plane.enableAutoRange()
        self.plane.show()


class RawPlot(Plot):
    """A channel as recorded, with what a method found in it."""

    def __init__(self, theme: Theme, part: str) -> None:
        super().__init__(theme, "", f"{part} raw [V]", left_px=_LEFT, figures_below=False)
        self.raw = self.still_line(part.lower(), part)
        self.found = {
            "upper": self.still_line("fit", "spline through the peaks"),
            "lower": self.still_line("fit", "spline through the valleys"),
            "fitted": self.still_line("fit", "model"),
            "bias": self.still_line("text", "bias", dashed=True),
            # told apart by their shape: all hues mean something else
            "peaks": self.marker("text", "t1", 7, "peaks"),
            "valleys": self.marker("text", "t", 7, "valleys"),
            "zero_crossings": self.marker("faint", "+", 6, "zero crossings"),
        }


def _ellipse_words(found: object) -> str:
    if not isinstance(found, Ellipse):
        return ""
    centre = f"offset of I {1e3 * found.i0_v:.4g} mV, of Q {1e3 * found.q0_v:.4g} mV"
    shape = f"amplitude {found.amplitude_v:.4g} V, gain Q/I {found.gain_ratio:.4f}"
    return f"Ellipse: {centre}, {shape}, quadrature error {math.degrees(found.quadrature_error_rad):.2f}°."


# title of a column, and what stands in it; 1e3: from m to mm
_COLUMNS: dict[str, Callable[[OverlaidMethod], str]] = {
    "Method": lambda one: one.method,
    "e": lambda one: restitution_words(one.summary),
    "g [m/s²]": lambda one: gravity_words(one.summary),
    "Largest Δz [mm]": lambda one: UNKNOWN if one.largest_m is None else plain(one.largest_m, 3, scale=1e3),
    "Verdict": lambda one: one.problem or str(one.summary.get("verdict") or ""),
}


class MethodsView(QtWidgets.QWidget):
    """Boxes to choose methods, a table of what each gave, curves above, differences below.

    Parameters
    ----------
    ask
        Takes the names of the corrections that shall be computed.
    """

    def __init__(self, theme: Theme, ask: Callable[[tuple[str, ...]], object]) -> None:
        super().__init__()
        self._all: list[OverlaidMethod] = []
        self._own = ""
        self._is_busy = False
        self._since = "time [s]"
        self.boxes: dict[str, QtWidgets.QCheckBox] = {}
        for method, words in words_of("processing.correction").choices.items():
            box = self.boxes[method] = having(QtWidgets.QCheckBox(method), toolTip=words)
            box.toggled.connect(self._show_buttons)
        self.compute = button("Compute", lambda: ask(self._missing))
        self.quantity = having(Choice(), accessibleName="Quantity")
        self.quantity.currentIndexChanged.connect(self._draw)
        self.words = OneLine()
        self.table = RowTable(RowModel(_COLUMNS), "methods")
        self.curves = Plot(theme, "", "z [mm]", left_px=_LEFT, figures_below=False)
        self.differences = Plot(theme, "time [s]", "Δz [mm]", left_px=_LEFT)
        self.curves.setXLink(self.differences)
        self.key = Key(theme)
        chosen = fill(QtWidgets.QHBoxLayout(), *self.boxes.values(), 1, margins=(6, 3, 6, 0), spacing=8)
        asked = (self.compute, self.quantity, (self.words, 1))
        below = fill(QtWidgets.QHBoxLayout(), *asked, margins=(6, 0, 6, 0), spacing=6)
        plots = ((self.curves, 3), (self.differences, 2))
        fill(QtWidgets.QVBoxLayout(self), chosen, below, (self.table, 2), self.key, *plots, spacing=1)
        # three methods and the titles
        self.table.setMinimumHeight(5 * self.fontMetrics().height())
        self.clear()

    def show_result(self, result: RunResult) -> None:
        """Begin anew with the result that the others are laid over."""
        self.clear()
        quality = result.quality
        self._own = quality.method if quality else ""
        for method, box in self.boxes.items():
            having(box, checked=method == self._own, enabled=bool(self._own) and method != self._own)
        self._since = f"time after {result.zero[1]} [s]"
        said = f"Tick what is to be laid over “{self._own}”." if self._own else "Nothing was corrected."
        self.words.setText(said)
        self.curves.when_empty = said

    def clear(self) -> None:
        """Forget the run."""
        self._all, self._own = [], ""
        for box in self.boxes.values():
            having(box, checked=False, enabled=False)
        self.show_busy(busy=False)
        self.words.setText("")
        self.curves.when_empty = ""
        self._refresh()

    def show_busy(self, *, busy: bool) -> None:
        """Say that methods are being computed, or no more."""
        self._is_busy = busy
        self._show_buttons()

    def add(self, one: OverlaidMethod) -> None:
        """Lay one more method over the others; the first is what they differ from."""
        self._all = [known for known in self._all if known.method != one.method] + [one]
        self.words.setText("")
        self._refresh()

    @property
    def _missing(self) -> tuple[str, ...]:
        known = {one.method for one in self._all}
        ticked = (method for method, box in self.boxes.items() if box.isChecked())
        return tuple(method for method in ticked if method not in known and method != self._own)

    def _show_buttons(self) -> None:
        self.compute.setEnabled(bool(self._missing) and not self._is_busy)

    def _refresh(self) -> None:
        self.table.show_rows(self._all)
        names = dict.fromkeys(name for one in self._all for name in one.curves)
        self.quantity.offer(((name, name) for name in names), self.quantity.currentData())
        # an empty list is no question
        self.quantity.setVisible(bool(names))
        self._show_buttons()
        self._draw()

    def _draw(self, _index: int = 0) -> None:
        name = self.quantity.currentData() or "z"
        for plot in (self.curves, self.differences):
            plot.take_all_out()
        entries = []
        for number, one in enumerate(self._all):
            # the first lies beneath the others
            role = "text" if number == 0 else f"compared.{number - 1}"
            for plot, curves in ((self.curves, one.curves), (self.differences, one.differences)):
                if name in curves:
                    plot.still_line(role, one.method).setData(curves[name].x, 1e3 * curves[name].y)
            if name in one.curves:
                entries.append(("▬", role, one.method))
        self.key.show_entries(*entries)
        first = self._all[0].method if self._all else ""
        self.curves.relabel("", f"{name} [mm]")
        self.differences.relabel(self._since, f"Δ{name} [mm]")
        self.differences.setToolTip(f"{name} of each method less that of {first}" if first else "")
        for plot in (self.curves, self.differences):
            plot.enableAutoRange()
