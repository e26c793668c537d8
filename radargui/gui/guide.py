"""What helps at first: the steps of a first drop, and the words in plots that are still empty."""

from collections.abc import Callable
from functools import partial

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QObject, QPoint, QRect, QSize, Qt
from PySide6.QtWidgets import QFrame, QHBoxLayout, QLabel, QVBoxLayout, QWidget
from shiboken6 import isValid

from radargui.experiment.event import RecordedRun
from radargui.gui.control.run_control import RunControl
from radargui.gui.control.state import AppState
from radargui.gui.dialog import Dialog
from radargui.gui.layout import PlainLabel, button, fill, having, ticking
from radargui.gui.panels import Panels
from radargui.gui.plots.plot import Plot
from radargui.gui.services import Services
from radargui.gui.setup.hardware_panel import HardwarePanel
from radargui.gui.theme import scaled_font
from radargui.model.resources import resource_table

_SEEN = "guide"
_WORDS_PX = 280
"""Of the lines that say what to do: about 45 letters of 9 points at 96 dots per inch (chosen by hand)."""
_DONE, _NEXT, _LATER = "✓", "➔", "○"


class Step(QFrame):
    """One step: its sign, its title, what to do, and where."""

    def __init__(self, number: int, title: str, words: str, go: Callable[[], None]) -> None:
        super().__init__()
        self.done = False
        self._title = f"{number}. {title}"
        self.sign, self.title, self.words = QLabel(_LATER), QLabel(self._title), PlainLabel(words, selectable=False)
        having(self.sign, fixedWidth=2 * self.fontMetrics().averageCharWidth(), alignment=Qt.AlignmentFlag.AlignTop)
        self.go = button("Show me", go, f"Brings the panel to the front in which this happens: {title.lower()}")
        having(self.words, fixedWidth=_WORDS_PX, minimumHeight=self.words.heightForWidth(_WORDS_PX))
        column = fill(QVBoxLayout(), self.title, self.words, spacing=1)
        fill(QHBoxLayout(self), self.sign, (column, 1), self.go, spacing=6)

    def show_as(self, *, next_one: bool) -> None:
        """Show it as done, as the next one, or as one for later."""
        self.sign.setText(_DONE if self.done else _NEXT if next_one else _LATER)
        self.title.setFont(scaled_font(self.font(), 1.0, bold=next_one))
        self.title.setAccessibleName(f"{self._title}, {'done' if self.done else 'next' if next_one else 'later'}")
        self.words.setVisible(next_one)
        self.go.setVisible(next_one)


class FirstSteps(Dialog):
    """Follows what the operator really does; not modal, nothing waits for it.

    Attributes
    ----------
    steps
        By their names, in their order.
    """

    def __init__(self, hardware: HardwarePanel, panels: Panels, services: Services) -> None:
        super().__init__("First steps", (420, 300), services.parent, "first steps")
        # beside the main window, never in its way: the keys stay where they are
        self.setWindowFlag(Qt.WindowType.Tool)
        self.setAttribute(Qt.WidgetAttribute.WA_ShowWithoutActivating)
        self._control, self._settings, self._window = services.control, services.settings, services.parent
        self._antennas = panels.held["antennas"]
        table = resource_table("window/guide")["steps"]
        self.steps = {
            one["name"]: Step(number, one["title"], one["words"], partial(panels.go_to, one["panel"]))
            for number, one in enumerate(table, 1)
        }
        self.end = PlainLabel("That was all. Help → First steps shows this again.")
        closes = button("Close", self.reject, "Close the guide; Help → First steps shows it again")
        self.lay_out(*self.steps.values(), self.end, 1, fill(QHBoxLayout(), 1, closes), spacing=4)
        hardware.source.activated.connect(lambda _index: self.tick("source"))
        panels.docks["antennas"].visibilityChanged.connect(lambda seen: self.tick("antennas") if seen else None)
        self._control.state_changed.connect(self._state_changed)
        self._control.run_recorded.connect(self._recorded)
        self._show()

    def show_at_first(self) -> None:
        """Show it where the program was never started before."""
        if not self._settings.text(_SEEN) and self._settings.blob("geometry").isEmpty():
            self.begin()
        self._settings.put(_SEEN, "seen")

    def begin(self) -> None:
        """Show it with nothing done."""
        for step in self.steps.values():
            step.done = False
        self._show()
        main = self._window.frameGeometry()
        self.move(main.right() - self.width() - 24, main.bottom() - self.height() - 48)
        self.come_up()
        self._state_changed()

    def tick(self, name: str) -> None:
        """Mark a step as done; without being looked at nothing counts."""
        if self.isVisible() and not self.steps[name].done:
            self.steps[name].done = True
            self._show()

    def _show(self) -> None:
        antennas = self.steps["antennas"]
        # who has the panel before him looks at it
        antennas.done |= self.steps["source"].done and self._antennas.isVisible()
        upcoming = next((step for step in self.steps.values() if not step.done), None)
        for step in self.steps.values():
            step.show_as(next_one=step is upcoming)
        self.end.setVisible(upcoming is None)
        self.adjustSize()

    def _state_changed(self) -> None:
        state = self._control.state
        # who starts has chosen, be it what stood there; a short drop is seen only while it is processed: it was armed
        holds = state.holds_a_run
        armed = holds or state is AppState.ARMED
        does = {"source": state.running, "monitor": state is AppState.LIVE, "arm": armed, "drop": holds}
        for name, done in does.items():
            if done:
                self.tick(name)

    def _recorded(self, recorded: RecordedRun) -> None:
        if recorded.result is not None and recorded.result.bounces.impacts:
            self.tick("read")


_LOOK_MS = 300
"""Chosen by hand: later the words are seen on a plot that has data; each look asks all curves of the plots in sight."""
_EDGE = QSize(8, 4)
"""Pixels left free about the words, both sides together (chosen by hand)."""
_ALIKE = 0.75
"""Share of the largest area in sight from which a plot counts as large (chosen by hand): axes take from some."""
_DRAWN_ALWAYS = ("line", "faint", "text")
"""Roles of what stands in a plot without data: floor, unit circle, the place of the last point."""


def is_empty(plot: Plot) -> bool:
    """Return whether no curve of a plot has anything to show."""
    images = any(isinstance(item, pg.ImageItem) and item.image is not None for item in plot.getPlotItem().items)
    return not images and not any(
        role not in _DRAWN_ALWAYS and _has_data(item)
        for item, role, *_ in plot._pens  # noqa: SLF001
    )


def _has_data(item: object) -> bool:
    x, y = getattr(item, "getData", lambda: (None, None))()
    return x is not None and y is not None and bool(np.isfinite(y).any())


class EmptyPlots(QObject):
    """Looks at the plots some times a second, and says one sentence in each panel that shows nothing.

    Attributes
    ----------
    labels
        What is said, by the panel's name; stands in the largest of its plots, of equals in the middle one.
    """

    def __init__(self, panels: dict[str, QWidget], control: RunControl, parent: QObject) -> None:
        super().__init__(parent)
        self._control = control
        self._words: dict[str, tuple[str, str]] = resource_table("window/guide")["empty"]
        self._panels = {name: panels[name] for name in self._words}
        self.labels: dict[str, QLabel] = {}
        ticking(self, _LOOK_MS, self.refresh).start()

    def refresh(self) -> None:
        """Say what to do, or take it away."""
        for name, panel in self._panels.items():
            if not panel.isVisible():
                continue
            plots = [plot for plot in panel.findChildren(Plot) if plot.isVisible()]
            if plots and all(map(is_empty, plots)):
                own = next(filter(None, (plot.when_empty for plot in plots)), "")
                words = own or self._words[name][self._control.state.running]
                self._say(name, words, _best([one for one in plots if _needed(one, words)] or plots))
            elif (label := self.labels.pop(name, None)) is not None and isValid(label):
                label.deleteLater()

    def _say(self, name: str, words: str, plot: Plot) -> None:
        label = self.labels.get(name)
        if label is None or not isValid(label) or label.parentWidget() is not plot:
            if label is not None and isValid(label):
                label.deleteLater()
            label = self.labels[name] = QLabel(plot, wordWrap=True, alignment=Qt.AlignmentFlag.AlignCenter)
            label.setStyleSheet("background: palette(base);")
            label.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
            label.show()
        label.setText(words)
        room = _room(plot)
        place = QRect(room.topLeft(), _needed(plot, words) or room.size())
        place.moveCenter(room.center())
        label.setGeometry(place)


def _room(plot: Plot) -> QRect:
    """Return what a plot's axes enclose below the words inside, in its pixels."""
    room = QRect(plot.getPlotItem().vb.sceneBoundingRect().toRect())
    return room.adjusted(0, plot.height_inside, 0, 0)


def _needed(plot: Plot, words: str) -> QSize | None:
    """Return the room that words take within a plot's axes; None where there is not so much."""
    room = _room(plot).size() - _EDGE
    wanted = plot.fontMetrics().boundingRect(QRect(QPoint(), room), Qt.TextFlag.TextWordWrap, words).size()
    return wanted + _EDGE if wanted.width() <= room.width() and wanted.height() <= room.height() else None


def _best(plots: list[Plot]) -> Plot:
    """Return the plot of which most is in sight, of equals the middle one, of two rows in the upper one."""
    seen = [plot.viewport().visibleRegion().boundingRect().size() for plot in plots]
    areas = [one.width() * one.height() for one in seen]
    equals = [plot for plot, area in zip(plots, areas, strict=True) if area >= _ALIKE * max(areas)]
    equals.sort(key=lambda plot: plot.mapToGlobal(QPoint()).toTuple())
    return equals[(len(equals) - 1) // 2]
