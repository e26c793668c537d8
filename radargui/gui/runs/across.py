"""Across the room: state, result, run and what to do next over the whole screen, for hands that hold the sphere."""

from __future__ import annotations

from PySide6.QtCore import QEvent, QRectF, Qt
from PySide6.QtGui import (
    QAction,
    QCloseEvent,
    QColor,
    QFont,
    QFontMetrics,
    QFontMetricsF,
    QKeyEvent,
    QPainter,
    QPaintEvent,
)
from PySide6.QtWidgets import QWidget

from radargui.gui.control.control_bar import draw_badge, wrapped
from radargui.gui.control.state import LARGE_WORDS
from radargui.gui.layout import having
from radargui.gui.runs.situation import Situation, SituationModel
from radargui.gui.services import Services
from radargui.gui.theme import write

WIDEST = {
    "state": max(LARGE_WORDS, key=len),
    "result": "live e = 0.88888 ± 0.88888",
    "run": "drop 888 (888 of 888)",
    "next": "m" * 34,
    "why": "m" * 66,
    "keys": "m" * 66,
}
"""Longest that each line holds in letters as large as fit; fonts follow these and the screen, never what is shown."""
_SHARES = {"state": 0.26, "result": 0.24, "run": 0.12, "next": 0.12, "why": 0.16, "keys": 0.05}
"""Of the height of the screen; what is left holds the keys."""
LINES = {"next": 2, "why": 5}
"""That a sentence may take: the longest reason stands there whole."""
_KEYS = "Space  start      R  record      F5  stop      Del  reject      F11 or Esc  back to the window"
_BADGE_SIZE = 0.5
"""Size of the letters that say where the run comes from beside those of the run."""
_MARGIN = 0.03
"""Of the width of the screen, left free at either side (chosen by hand)."""


class AcrossView(QWidget):
    """A window over the whole screen; the keys of the main window work in it.

    Parameters
    ----------
    model
        Of the situation that is shown.
    switch
        The action that shows and hides this view, and goes off with it.
    """

    def __init__(self, model: SituationModel, switch: QAction, services: Services) -> None:
        self._model, self._main, self._theme, self._switch = model, services.parent, services.theme, switch
        super().__init__(self._main, Qt.WindowType.Window)
        self.setWindowTitle("RadarGUI across the room")
        self.situation = Situation()
        self.addActions(self._main.actions())
        self._switch.toggled.connect(self._show)
        self._theme.changed.connect(self.update)
        model.changed.connect(lambda: self.show_situation(model.now))

    def show_situation(self, situation: Situation) -> None:
        """Show another situation."""
        if situation != self.situation:
            self.situation = situation
            self.setAccessibleName(
                ", ".join(filter(None, (situation.word, situation.result, situation.badge, situation.next)))
            )
            self.update()

    def fonts(self) -> dict[str, QFont]:
        """Return the font of each line: as large as its longest words allow on this screen."""
        made = {}
        for name, widest in WIDEST.items():
            font = having(QFont(self.font()), bold=name in ("state", "result"), pixelSize=100)
            metrics = QFontMetricsF(font)
            lines = LINES.get(name, 1)
            width = (1.0 - 2.0 * _MARGIN) * self.width() / metrics.horizontalAdvance(widest)
            height = _SHARES[name] * self.height() / (lines * metrics.lineSpacing())
            font.setPixelSize(max(1, int(100 * min(width, height))))
            made[name] = font
        return made

    def room_of(self, name: str) -> tuple[int, int]:
        """Return width and height in pixels of what stands on several lines."""
        return int((1.0 - 2.0 * _MARGIN) * self.width()), int(_SHARES[name] * self.height())

    def paintEvent(self, _event: QPaintEvent) -> None:  # noqa: N802 - Qt's name
        """Draw the lines one beneath another, the state on its colour."""
        painter = QPainter(self)
        colours, shown = self._theme.colours, self.situation
        painter.fillRect(self.rect(), QColor(colours.base))
        fonts, margin, top = self.fonts(), _MARGIN * self.width(), 0.0
        lines = {"state": shown.word, "result": shown.result, "run": shown.run, "next": shown.next, "why": shown.why}
        for name, words in lines.items():
            box = QRectF(margin, top, self.width() - 2.0 * margin, _SHARES[name] * self.height())
            if name == "run":
                font = having(QFont(fonts["run"]), pixelSize=max(1, int(_BADGE_SIZE * fonts["run"].pixelSize())))
                box.setRight(box.right() - draw_badge(painter, box, shown.badge, font, colours))
            if name == "state":
                band = QRectF(0.0, 0.0, self.width(), box.height())
                painter.fillRect(band, QColor(colours.role(shown.role)))
            height = box.height() if name in LINES else 0.0
            fitting = wrapped(words, QFontMetrics(fonts[name]), int(box.width()), int(height))
            colour = colours.base if name == "state" else colours.text
            write(painter, box, fitting, colour, font=fonts[name])
            top += box.height()
        keys = QRectF(0.0, top, self.width(), self.height() - top)
        write(painter, keys, f"{_KEYS}\n{shown.sound}", colours.faint, font=fonts["keys"])

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
            self.show_situation(self._model.now)
        else:
            self.hide()
            self._main.activateWindow()
