"""The strip at the top of the window that shows notices; never a pop-up, text selectable and whole."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import Qt
from PySide6.QtGui import QGuiApplication
from PySide6.QtWidgets import QToolButton, QVBoxLayout, QWidget

from radargui.gui.layout import Strip, button, fill, take_out
from radargui.gui.notices import Notice, NoticeBoard
from radargui.gui.theme import Theme

_SHOWN = 3
"""Messages at a time; their place holds two of one line each, the third is scrolled to (chosen by hand)."""
_WORDS = {"error": "Error", "warning": "Warning", "info": "Note"}
_EDGES = {"error": "alarm", "warning": "mark", "info": "busy"}


class NoticeStrip(QWidget):
    """The worst notices, each with a word for its level, its whole text and a way to dismiss it."""

    def __init__(self, board: NoticeBoard, theme: Theme, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._board = board
        self._theme = theme
        self._rows = fill(QVBoxLayout(self), spacing=1)
        board.changed.connect(self.refresh)
        self.refresh()

    def texts(self) -> tuple[str, ...]:
        """Return what is shown, the worst first."""
        return tuple(notice.text for notice in self._shown())

    def _shown(self) -> tuple[Notice, ...]:
        return self._board.notices[:_SHOWN]

    def refresh(self) -> None:
        """Draw the notices anew."""
        take_out(self._rows, *self.findChildren(QWidget, options=Qt.FindChildOption.FindDirectChildrenOnly))
        for notice in self._shown():
            self._rows.addWidget(row := self._row(notice))
            row.show()
        hidden = len(self._board.notices) - _SHOWN
        if hidden > 0:
            clear = button(f"{hidden} more, none of them worse: dismiss all", self._board.clear)
            self._rows.addWidget(clear, alignment=Qt.AlignmentFlag.AlignRight)
        self.setVisible(bool(self._board.notices))

    def _row(self, notice: Notice) -> Strip:
        whole = "\n".join(filter(None, (notice.text, notice.details)))
        copy = _small("Copy", lambda: QGuiApplication.clipboard().setText(whole), "Copy the text with its details")
        row = Strip(self._theme, _EDGES[notice.level], copy, _small("Dismiss", lambda: self._board.dismiss(notice)))
        times = f" ({notice.count} times)" if notice.count > 1 else ""
        row.words.setText(f"{_WORDS[notice.level]}{times}: {notice.text}")
        row.words.setTextInteractionFlags(
            Qt.TextInteractionFlag.TextSelectableByMouse | Qt.TextInteractionFlag.TextSelectableByKeyboard
        )
        return row


def _small(words: str, does: Callable[[], None], tip: str = "") -> QToolButton:
    made = QToolButton()
    made.setText(words)
    made.setToolTip(tip)
    made.clicked.connect(does)
    return made
