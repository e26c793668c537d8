"""The key of a plot as words beside it, in the colours of the theme; which colour is which value."""

from html import escape

import numpy as np
from PySide6.QtCore import Qt
from PySide6.QtGui import QColor, QResizeEvent
from PySide6.QtWidgets import QHBoxLayout, QLabel, QSizePolicy, QWidget

from radargui.gui.layout import fill, follow, having
from radargui.gui.theme import Theme
from radargui.model.arrays import FloatArray

IQ_KEY = (("▬", "i", "I"), ("▬", "q", "Q"))


class Key(QLabel):
    """Signs in the colours of the theme, each with its words.

    Parameters
    ----------
    entries
        Sign, role of the theme's colours (`i`, `receivers.0`), words.
    """

    def __init__(self, theme: Theme, *entries: tuple[str, str, str]) -> None:
        super().__init__()
        self._theme = theme
        self._entries = entries
        self.setTextFormat(Qt.TextFormat.RichText)
        self.setContentsMargins(6, 0, 6, 0)
        self.setMinimumWidth(40)
        follow(theme.changed, self._write)

    def show_entries(self, *entries: tuple[str, str, str]) -> None:
        """Show another key."""
        if entries != self._entries:
            self._entries = entries
            self._write()

    def _write(self) -> None:
        parts = []
        for sign, role, words in self._entries:
            colour = self._theme.colours.role(role)
            parts.append(f'<span style="color:{colour}"><b>{escape(sign)}</b></span>&nbsp;{_unbroken(words)}')
        self.setText("&emsp;".join(parts))
        self._fit()

    def hasHeightForWidth(self) -> bool:  # noqa: N802 - Qt's name
        """Return no: else the panel is scrolled as soon as its plots are not as high as they would like."""
        return False

    def resizeEvent(self, event: QResizeEvent) -> None:  # noqa: N802 - Qt's name
        """Take the lines that a key that wraps needs."""
        super().resizeEvent(event)
        self._fit()

    def _fit(self) -> None:
        if self.wordWrap():
            self.setFixedHeight(max(0, self.heightForWidth(self.width())))


def _unbroken(words: str) -> str:
    return escape(words).replace(" ", "&nbsp;")


class ColourBar(QWidget):
    """From which to which value the colours go; as high as a line of words."""

    def __init__(self, tip: str) -> None:
        super().__init__()
        self.low, self.high = QLabel(), QLabel()
        self._bar = having(QWidget(), fixedHeight=self.fontMetrics().height() - 2)
        fill(QHBoxLayout(self), self.low, (self._bar, 1), self.high, margins=(2, 0, 2, 0), spacing=4)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        having(self, fixedHeight=self.fontMetrics().height() + 4, toolTip=tip)

    def show_ends(self, table: FloatArray, low: str, high: str) -> None:
        """Show colours, red, green, blue, alpha from 0 to 1, shape (n, 4), and what the first and the last mean."""
        stops = zip(np.linspace(0.0, 1.0, len(table)), table, strict=True)
        colours = ", ".join(f"stop:{stop:.4f} {QColor.fromRgbF(*colour).name()}" for stop, colour in stops)
        self._bar.setStyleSheet(f"background: qlineargradient(x1:0, x2:1, {colours});")
        self.low.setText(low)
        self.high.setText(high)
