"""Two or more corrections of one run laid over each other, and what they differ by; computed when asked for."""

from collections.abc import Callable

from PySide6.QtCore import QSignalBlocker, Signal
from PySide6.QtWidgets import QCheckBox, QHBoxLayout, QLabel, QSizePolicy, QVBoxLayout, QWidget

from radargui.experiment.overlaid import OverlaidMethod
from radargui.gui.layout import Choice, button, fill
from radargui.gui.plots.key import Key
from radargui.gui.plots.plot import Plot
from radargui.gui.setup.words import words_of
from radargui.gui.table import RowModel, RowTable
from radargui.gui.theme import Theme
from radargui.model.drop import gravity_words, restitution_words
from radargui.model.result import RunResult
from radargui.model.rounding import UNKNOWN, plain

_LEFT = 58
_COLUMNS: dict[str, Callable[[OverlaidMethod], str]] = {
    "Method": lambda one: one.method,
    "e": lambda one: restitution_words(one.summary),
    "g [m/s²]": lambda one: gravity_words(one.summary),
    "Largest Δz [mm]": lambda one: UNKNOWN if one.largest_m is None else plain(one.largest_m, 3, scale=1e3),
    "Said": lambda one: one.problem or str(one.summary.get("verdict") or ""),
}


class MethodsView(QWidget):
    """Boxes to choose methods, a table of what each gave, curves above, differences below."""

    asked = Signal(object)

    def __init__(self, theme: Theme) -> None:
        super().__init__()
        self._all: list[OverlaidMethod] = []
        self._own = ""
        self._is_busy = False
        self._since = "time [s]"
        self.boxes: dict[str, QCheckBox] = {}
        for method, words in words_of("processing.correction").choices.items():
            box = self.boxes[method] = QCheckBox(method)
            box.setToolTip(words)
            box.toggled.connect(lambda _on: self._show_buttons())
        self.compute = button("Compute", self._ask, "Corrects the samples by the methods chosen; nothing is stored")
        self.quantity = Choice()
        self.quantity.setAccessibleName("Quantity")
        self.quantity.currentIndexChanged.connect(self._draw)
        self.words = QLabel()
        self.words.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Fixed)
        self.rows = RowModel(_COLUMNS)
        self.table = RowTable(self.rows, "methods")
        self.curves = Plot(theme, "", "z [mm]", left_px=_LEFT)
        self.curves.getPlotItem().getAxis("bottom").setStyle(showValues=False)
        self.differences = Plot(theme, "time [s]", "Δz [mm]", left_px=_LEFT)
        self.curves.setXLink(self.differences)
        self.key = Key(theme)
        chosen = fill(QHBoxLayout(), *self.boxes.values(), 1, margins=(6, 3, 6, 0), spacing=8)
        below = fill(QHBoxLayout(), self.compute, self.quantity, (self.words, 1), margins=(6, 0, 6, 0), spacing=6)
        plots = ((self.curves, 3), (self.differences, 2))
        fill(QVBoxLayout(self), chosen, below, (self.table, 2), self.key, *plots, spacing=1)
        # three methods and the titles
        self.table.setMinimumHeight(5 * self.fontMetrics().height())
        self.clear()

    def show_result(self, result: RunResult) -> None:
        """Begin anew with the result that the others are laid over."""
        self.clear()
        quality = result.quality
        self._own = quality.method if quality else ""
        for method, box in self.boxes.items():
            box.setChecked(method == self._own)
            box.setEnabled(bool(self._own) and method != self._own)
        self._since = f"time after {result.zero[1]} [s]"
        said = f"Tick what is to be laid over {self._own}." if self._own else "Nothing was corrected."
        self.words.setText(said)
        self.curves.when_empty = said

    def clear(self) -> None:
        """Forget the run."""
        self._all, self._own = [], ""
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

    def _ask(self) -> None:
        self.asked.emit(self._missing)

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
        before = self.quantity.currentData()
        with QSignalBlocker(self.quantity):
            self.quantity.clear()
            for name in names:
                self.quantity.addItem(name, name)
            self.quantity.setCurrentIndex(max(0, self.quantity.findData(before)))
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
