"""The lines beneath a form that say what is wrong with the setup, and what is another than at the last run."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QLabel, QSizePolicy, QWidget

from radargui.gui.setup.setup_model import SetupModel
from radargui.gui.theme import Theme

_MOST_NAMED = 3


class ChangeLine(QLabel):
    """Tells what changed since the last run, nothing where that is nothing."""

    def __init__(self, model: SetupModel) -> None:
        super().__init__()
        self._model = model
        self.setTextFormat(Qt.TextFormat.PlainText)
        self.setWordWrap(True)
        self.setContentsMargins(8, 4, 8, 4)
        model.changed.connect(self._refresh)
        self._refresh()

    def _refresh(self) -> None:
        changes = self._model.since_last_run
        more = f" and {len(changes) - _MOST_NAMED} more" if len(changes) > _MOST_NAMED else ""
        self.setText(f"Changed since the last run: {', '.join(changes[:_MOST_NAMED])}{more}")
        self.setToolTip("\n".join(changes))
        self.setVisible(bool(changes))


class ErrorLine(QLabel):
    """Shows the fault of the draft, nothing while there is none."""

    def __init__(self, model: SetupModel, theme: Theme, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._model = model
        self._theme = theme
        self.setTextFormat(Qt.TextFormat.PlainText)
        self.setWordWrap(True)
        self.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Minimum)
        model.changed.connect(self.refresh)
        theme.changed.connect(self.refresh)
        self.refresh()

    def refresh(self) -> None:
        """Show what the draft's fault is now."""
        # in one piece: a line broken at a dot inside a key is hard to read
        self.setText(self._model.error)
        self.setVisible(bool(self._model.error))
        self.setStyleSheet(f"color: {self._theme.colours.alarm}; font-weight: bold; padding: 4px;")
