"""The key of a plot as words beside it, in the colours of the theme."""

from html import escape

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QLabel

from radargui.gui.layout import follow
from radargui.gui.theme import Theme

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
            parts.append(f'<span style="color:{colour}"><b>{escape(sign)}</b></span>&nbsp;{escape(words)}')
        self.setText("&emsp;".join(parts))
