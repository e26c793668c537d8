"""Across the room: state, result, run and what to do next over the whole screen, for hands that hold the sphere."""

from __future__ import annotations

from dataclasses import dataclass

from PySide6.QtCore import QEvent, QRectF, Qt
from PySide6.QtGui import QCloseEvent, QColor, QFont, QFontMetrics, QFontMetricsF, QKeyEvent, QPainter, QPaintEvent
from PySide6.QtWidgets import QWidget

from radargui.gui.control.control_bar import wrapped
from radargui.gui.control.state import AppState
from radargui.gui.layout import having
from radargui.gui.runs.run_keeping import RunKeeping
from radargui.gui.theme import write
from radargui.model.words import counted, percent, sentence

_WIDEST = {
    "state": "PROCESSING",
    "result": "e = 0.88888 ± 0.88888",
    "run": "drop 888 (888 of 888)",
    "next": "m" * 34,
    "keys": "m" * 66,
}
"""Longest that each line holds in letters as large as fit; fonts follow these and the screen, never what is shown."""
_SHARES = {"state": 0.26, "result": 0.26, "run": 0.14, "next": 0.22, "keys": 0.06}
"""Of the height of the screen; what is left holds the keys."""
_KEYS = "Space  start      R  record      F5  stop      Del  reject      F11 or Esc  back to the window"
_WITHOUT_RESULT = (AppState.IDLE, AppState.STARTING, AppState.LIVE, AppState.STOPPING, AppState.FAILED)
"""States in which none is made: what is shown is that of an earlier run, and said to be."""
_MARGIN = 0.03
"""Of the width of the screen, left free at either side (chosen by hand)."""


@dataclass(frozen=True, slots=True)
class Situation:
    """What is shown.

    Attributes
    ----------
    state
        In one word.
    result
        e with its combined uncertainty, or why there is none; empty: none yet.
    run
        Which run that is, or which comes.
    next
        What the operator does now.
    role
        The colour of the state, where it is not its own.
    """

    state: AppState = AppState.IDLE
    result: str = ""
    run: str = ""
    next: str = ""
    role: str = ""


class AcrossView(QWidget):
    """A window over the whole screen; the keys of the main window work in it.

    Parameters
    ----------
    keeping
        Knows the runs and what the next one is called; its action shows and hides this view, and goes off with it.
    """

    def __init__(self, keeping: RunKeeping) -> None:
        self._keeping, self._main, self._theme = keeping, keeping.services.parent, keeping.services.theme
        super().__init__(self._main, Qt.WindowType.Window)
        self.setWindowTitle("RadarGUI across the room")
        self._switch = keeping.does.across
        self.situation = Situation()
        self.addActions(self._main.actions())
        self._switch.toggled.connect(self._show)
        self._theme.changed.connect(self.update)
        control = keeping.control
        for changed in (control.run_preliminary, control.run_recorded, control.state_changed):
            changed.connect(lambda *_: self.look())

    def show_situation(self, situation: Situation) -> None:
        """Show another situation."""
        if situation != self.situation:
            self.situation = situation
            self.setAccessibleName(", ".join(filter(None, (situation.state.value, situation.result, situation.next))))
            self.update()

    def fonts(self) -> dict[str, QFont]:
        """Return the font of each line: as large as its longest words allow on this screen."""
        made = {}
        for name, widest in _WIDEST.items():
            font = having(QFont(self.font()), bold=name in ("state", "result"), pixelSize=100)
            metrics = QFontMetricsF(font)
            lines = 2 if name == "next" else 1
            width = (1.0 - 2.0 * _MARGIN) * self.width() / metrics.horizontalAdvance(widest)
            height = _SHARES[name] * self.height() / (lines * metrics.lineSpacing())
            font.setPixelSize(max(1, int(100 * min(width, height))))
            made[name] = font
        return made

    def paintEvent(self, _event: QPaintEvent) -> None:  # noqa: N802 - Qt's name
        """Draw the lines one beneath another, the state on its colour."""
        painter = QPainter(self)
        colours, shown = self._theme.colours, self.situation
        painter.fillRect(self.rect(), QColor(colours.base))
        fonts, margin, top = self.fonts(), _MARGIN * self.width(), 0.0
        lines = {"state": shown.state.value, "result": shown.result, "run": shown.run, "next": shown.next}
        for name, words in lines.items():
            box = QRectF(margin, top, self.width() - 2.0 * margin, _SHARES[name] * self.height())
            if name == "state":
                band = QRectF(0.0, 0.0, self.width(), box.height())
                painter.fillRect(band, QColor(colours.role(shown.role or shown.state.role)))
            height = box.height() if name == "next" else 0.0
            fitting = wrapped(words, QFontMetrics(fonts[name]), int(box.width()), int(height))
            colour = colours.base if name == "state" else colours.text
            write(painter, box, fitting, colour, font=fonts[name])
            top += box.height()
        keys = QRectF(0.0, top, self.width(), self.height() - top)
        write(painter, keys, _KEYS, colours.faint, font=fonts["keys"])

    def event(self, event: QEvent) -> bool:
        """Keep Esc, which stops a recording elsewhere."""
        asks = event.type() == QEvent.Type.ShortcutOverride and isinstance(event, QKeyEvent)
        if asks and event.key() == Qt.Key.Key_Escape:  # type: ignore[attr-defined]
            event.accept()
            return True
        return bool(super().event(event))

    def keyPressEvent(self, event: QKeyEvent) -> None:  # noqa: N802 - Qt's name
        """Leave by Esc."""
        if event.key() == Qt.Key.Key_Escape:
            self._switch.setChecked(False)

    def closeEvent(self, event: QCloseEvent) -> None:  # noqa: N802 - Qt's name
        """Leave, however the window is closed."""
        self._switch.setChecked(False)
        event.accept()

    def _show(self, wanted: bool) -> None:
        if wanted:
            if (screen := self._main.screen()) is not None:
                self.setGeometry(screen.geometry())
            self.showFullScreen()
            self.activateWindow()
            self.setFocus()
            self.look()
        else:
            self.hide()
            self._main.activateWindow()

    def look(self) -> None:
        """Show the situation now; asked as often as the health line."""
        if self.isVisible():
            self.show_situation(self._present())

    def _present(self) -> Situation:
        state = self._keeping.control.state
        entry = self._keeping.runs.model.entry_of(self._keeping.of_result)
        coming = self._keeping.coming if state in (AppState.ARMED, AppState.RECORDING, AppState.SETTLING) else ""
        computed = self._keeping.runs.model.entry_of(self._keeping.control.backlog.computed)
        if state is AppState.PROCESSING and computed is not None and (entry is None or computed.path != entry.path):
            coming = computed.called
        if entry is None:
            return Situation(state, "", coming, self._next(state, ""))
        run = entry.called
        if coming or state in _WITHOUT_RESULT:
            run = "; ".join(filter(None, (coming, f"e of {entry.called}")))
        result = f"e = {entry.restitution()}" if entry.has_e else "no e"
        why = entry.reserve if entry.has_e else entry.objection
        if entry.has_e and entry.warnings:
            # that there is one helps nobody who stands too far away to look for it
            why = why.replace(counted(len(entry.warnings), "warning"), entry.warnings[0])
        return Situation(state, result, run, self._next(state, why), self._keeping.role)

    def _next(self, state: AppState, why: str) -> str:
        control, notices = self._keeping.control, self._keeping.services.board.notices
        if state is AppState.FAILED and notices:
            return notices[0].text
        if state is AppState.ARMED and control.waits_for:
            return f"Waiting for {control.waits_for}"
        if state is AppState.ARMED and self._keeping.hardly_seen:
            return self._keeping.hardly_seen
        if state is AppState.PROCESSING:
            return f"{state.next}: {percent(control.reached.progress)}"
        # what to do stands first: of a long reason the end has no room
        return f"{state.next}. {sentence(why)}" if why and state is AppState.DONE else state.next
