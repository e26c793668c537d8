"""What helps at first: the steps of a first drop, and the words in plots that are still empty."""

from collections.abc import Mapping

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QObject, QPoint, QRect, QSize, Qt
from PySide6.QtGui import QKeyEvent, QPalette
from PySide6.QtWidgets import QComboBox, QHBoxLayout, QLabel, QVBoxLayout, QWidget
from shiboken6 import isValid

from radargui.experiment.event import RecordedRun
from radargui.gui.bubble import Bubble, Side
from radargui.gui.control.run_control import RunControl
from radargui.gui.control.state import AppState
from radargui.gui.layout import PlainLabel, button, fill, having, ticking
from radargui.gui.panels import Panels
from radargui.gui.plots.plot import Plot
from radargui.gui.services import Services
from radargui.gui.theme import scaled_font
from radargui.system.resources import resource_table

_SEEN = "guide"
_WORDS_PX = 300
"""Of the lines that say what to do: about 48 letters of 9 points at 96 dots per inch (chosen by hand)."""
_SIDES: dict[str, tuple[Side, ...]] = {
    "right": ("right", "left", "below", "above"),
    "below": ("below", "above", "left", "right"),
    "left": ("left", "above", "right", "below"),
}
"""Where the bubble may lie about what it points at, by the side that suits it best."""


class Step:
    """One step: its title, what to do, in which panel, what it points at, and whether it has happened.

    Parameters
    ----------
    entry
        Of the table `steps` in `resources/window/guide.toml`.
    target
        What is to be used.
    """

    def __init__(self, entry: Mapping[str, str], target: QWidget) -> None:
        self.title, self.words, self.panel = entry["title"], entry["words"], entry["panel"]
        self.sides, self.target, self.done = _SIDES[entry["side"]], target, False


class FirstSteps(Bubble):
    """Points at what a first drop needs next, and follows what the operator really does; nothing waits for it.

    Where the thing is not seen, it points at the tab that leads there.

    Attributes
    ----------
    steps
        By their names, in their order; the last one, the end, is never done.
    """

    def __init__(self, targets: Mapping[str, QWidget], source: QComboBox, panels: Panels, services: Services) -> None:
        super().__init__(QPalette.ColorRole.Highlight, _SIDES["below"])
        self._panels, self._control, self._settings = panels, services.control, services.settings
        self._is_on = False
        entries = resource_table("window/guide")["steps"]
        self.steps = {one["name"]: Step(one, targets[one["name"]]) for one in entries}
        self.title, self.words = QLabel(), PlainLabel(selectable=False)
        having(self.title, font=scaled_font(self.font(), 1.0, bold=True))
        having(self.words, minimumWidth=_WORDS_PX)
        self.go = button("Show me", self._show_it, "Brings the panel to the front in which this happens")
        self.ends = button("Close", self.end, "Close the guide; Help → First steps shows it again")
        fill(QVBoxLayout(self), self.title, self.words, fill(QHBoxLayout(), 1, self.go, self.ends), spacing=4)
        source.activated.connect(lambda _index: self.tick("source"))
        for dock in panels.docks.values():
            dock.visibilityChanged.connect(lambda _seen: self.look_later())
        panels.tabs.currentChanged.connect(lambda _index: self.look_later())
        self._control.state_changed.connect(self._state_changed)
        self._control.run_recorded.connect(self._recorded)

    @property
    def upcoming(self) -> str:
        """Name of the step that comes next."""
        return next((name for name, step in self.steps.items() if not step.done), "")

    def show_at_first(self) -> None:
        """Show it where the program was never started before."""
        if not self._settings.text(_SEEN) and self._settings.blob("geometry").isEmpty():
            self.begin()
        self._settings.put(_SEEN, "seen")

    def begin(self) -> None:
        """Show it with nothing done."""
        for step in self.steps.values():
            step.done = False
        self._is_on = True
        self._state_changed()
        self.settle()

    def end(self) -> None:
        """Put it away."""
        self._is_on = False
        self.point_at(None)

    def keyPressEvent(self, event: QKeyEvent) -> None:  # noqa: N802 - Qt's name
        """Go away by Esc."""
        self.end() if event.key() == Qt.Key.Key_Escape else super().keyPressEvent(event)

    def tick(self, name: str) -> None:
        """Mark a step as done; without being looked at nothing counts."""
        if self._is_on and not self.steps[name].done:
            self.steps[name].done = True
            self.settle()

    def settle(self) -> None:
        """Say what comes next, and point at it or at the way there."""
        if not self._is_on:
            super().settle()
            return
        antennas = self.steps["antennas"]
        # who has the panel before him looks at it
        antennas.done |= self.steps["source"].done and antennas.target.isVisible()
        upcoming = self.upcoming
        step, count = self.steps[upcoming], len(self.steps) - 1
        number = list(self.steps).index(upcoming) + 1
        self.title.setText(f"{number} of {count}: {step.title}" if number <= count else step.title)
        self.words.setText(step.words)
        self.setAccessibleName(f"First steps. {self.title.text()}. {step.words}")
        seen = step.target.isVisible()
        self.go.setVisible(not seen)
        target, part = (step.target, None) if seen else self._panels.way_to(step.panel)
        self.lie_beside(target, part, step.sides if seen else _SIDES["below"])

    def _show_it(self) -> None:
        self._panels.go_to(self.steps[self.upcoming].panel)

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
