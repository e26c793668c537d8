"""The first steps: a window beside the main one whose steps tick themselves off when they have happened."""

from collections.abc import Callable
from functools import partial

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QFrame, QHBoxLayout, QLabel, QVBoxLayout

from radargui.experiment.event import RecordedRun
from radargui.gui.control.run_control import RunControl
from radargui.gui.control.state import AppState
from radargui.gui.layout import Dialog, PlainLabel, button, fill
from radargui.gui.panels import Panels
from radargui.gui.services import Services
from radargui.gui.setup.hardware_panel import HardwarePanel
from radargui.gui.theme import scaled_font
from radargui.model.resources import resource_table

_SEEN = "guide"
_WORDS_PX = 280
_DONE, _NEXT, _LATER = "✓", "➔", "○"


class Step(QFrame):
    """One step: its sign, its title, what to do, and where."""

    def __init__(self, number: int, title: str, words: str, go: Callable[[], None]) -> None:
        super().__init__()
        self.done = False
        self._title = f"{number}. {title}"
        self.sign, self.title, self.words = QLabel(_LATER), QLabel(self._title), PlainLabel(words, selectable=False)
        self.sign.setFixedWidth(2 * self.fontMetrics().averageCharWidth())
        self.sign.setAlignment(Qt.AlignmentFlag.AlignTop)
        self.go = button("Show me", go, f"Brings the panel to the front in which this happens: {title.lower()}")
        self.words.setFixedWidth(_WORDS_PX)
        self.words.setMinimumHeight(self.words.heightForWidth(_WORDS_PX))
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

    def __init__(self, control: RunControl, hardware: HardwarePanel, panels: Panels, services: Services) -> None:
        super().__init__("First steps", (420, 300), services.parent, "first steps")
        # beside the main window, never in its way: the keys stay where they are
        self.setWindowFlag(Qt.WindowType.Tool)
        self.setAttribute(Qt.WidgetAttribute.WA_ShowWithoutActivating)
        self._control, self._settings, self._window = control, services.settings, services.parent
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
        control.state_changed.connect(self._state_changed)
        control.run_recorded.connect(self._recorded)
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
        if state.running:
            # who starts has chosen, be it what stood there
            self.tick("source")
        if state is AppState.LIVE:
            self.tick("monitor")
        if state is AppState.ARMED:
            self.tick("arm")
        if state.holds_a_run:
            # a short one is seen only while it is processed
            self.tick("drop")

    def _recorded(self, recorded: RecordedRun) -> None:
        if recorded.result is not None and recorded.result.bounces.impacts:
            self.tick("read")
