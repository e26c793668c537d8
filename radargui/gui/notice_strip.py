"""The strip at the top of the window that shows notices; never a pop-up, text selectable and whole."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtGui import QGuiApplication
from PySide6.QtWidgets import QFrame, QHBoxLayout, QLabel, QPushButton, QSizePolicy, QToolButton, QVBoxLayout, QWidget

from radargui.gui.notices import Notice, NoticeBoard
from radargui.gui.theme import Theme

_SHOWN = 3
_WORDS = {"error": "Error", "warning": "Warning", "info": "Note"}


class NoticeStrip(QWidget):
    """The worst notices, each with a word for its level, its whole text and a way to dismiss it."""

    def __init__(self, board: NoticeBoard, theme: Theme, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._board = board
        self._theme = theme
        self._rows = QVBoxLayout(self)
        self._rows.setContentsMargins(0, 0, 0, 0)
        self._rows.setSpacing(1)
        board.changed.connect(self.refresh)
        theme.changed.connect(self.refresh)
        self.refresh()

    def texts(self) -> tuple[str, ...]:
        """Return what is shown, the worst first."""
        return tuple(notice.text for notice in self._shown())

    def _shown(self) -> tuple[Notice, ...]:
        return self._board.notices[:_SHOWN]

    def refresh(self) -> None:
        """Draw the notices anew."""
        while item := self._rows.takeAt(0):
            if widget := item.widget():
                widget.deleteLater()
        for notice in self._shown():
            self._rows.addWidget(self._row(notice))
        hidden = len(self._board.notices) - _SHOWN
        if hidden > 0:
            clear = QPushButton(f"{hidden} more, none of them worse: dismiss all")
            clear.clicked.connect(self._board.clear)
            self._rows.addWidget(clear, alignment=Qt.AlignmentFlag.AlignRight)
        self.setVisible(bool(self._board.notices))

    def _row(self, notice: Notice) -> QFrame:
        colours = self._theme.colours
        edge = {"error": colours.alarm, "warning": colours.mark, "info": colours.busy}[notice.level]
        row = QFrame()
        row.setObjectName("notice")
        row.setStyleSheet(
            f"QFrame#notice {{ background: {colours.raised}; border: none; border-left: 6px solid {edge}; }}"
        )
        layout = QHBoxLayout(row)
        layout.setContentsMargins(8, 4, 4, 4)
        times = f" ({notice.count} times)" if notice.count > 1 else ""
        label = QLabel(f"{_WORDS[notice.level]}{times}: {notice.text}")
        label.setTextFormat(Qt.TextFormat.PlainText)
        label.setWordWrap(True)
        label.setTextInteractionFlags(
            Qt.TextInteractionFlag.TextSelectableByMouse | Qt.TextInteractionFlag.TextSelectableByKeyboard
        )
        label.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Preferred)
        layout.addWidget(label, 1)
        copy = QToolButton()
        copy.setText("Copy")
        copy.setToolTip("Copy the text with its details")
        copy.clicked.connect(
            lambda: QGuiApplication.clipboard().setText("\n".join(filter(None, (notice.text, notice.details))))
        )
        layout.addWidget(copy)
        close = QToolButton()
        close.setText("Dismiss")
        close.clicked.connect(lambda: self._board.dismiss(notice))
        layout.addWidget(close)
        return row
