"""What sessions are looked for by: text, days, operator, sample, range of e."""

from __future__ import annotations

from collections.abc import Callable
from datetime import date
from typing import Any

from PySide6.QtCore import QTimer, Signal
from PySide6.QtWidgets import QGridLayout, QLabel, QLineEdit, QWidget

from radargui.gui.layout import FaultText
from radargui.gui.theme import Theme
from radargui.session.catalogue import Query

_WAIT_MS = 250
"""Between two keys of somebody who types: nothing is searched for half a word."""
_FIELDS: tuple[tuple[str, str, str, Callable[[str], Any]], ...] = (
    ("text", "Text", "words in notes, markers, names", str),
    ("operator", "Operator", "any", str),
    ("sample", "Sample or target", "any", str),
    ("since", "From day", "2026-01-31", date.fromisoformat),
    ("until", "To day", "2026-12-31", date.fromisoformat),
    ("e_min", "e from", "0", lambda text: float(text.replace(",", "."))),
    ("e_max", "e to", "1", lambda text: float(text.replace(",", "."))),
)
_PLACES = {"text": (0, 0), "operator": (0, 2), "sample": (0, 4)}
_PLACES |= {"since": (2, 0), "until": (2, 2), "e_min": (2, 4), "e_max": (2, 6)}


class SearchForm(QWidget):
    """Fields that may be left empty; what cannot be read is marked and left out."""

    changed = Signal()

    def __init__(self, theme: Theme) -> None:
        super().__init__()
        self._theme = theme
        self.fields: dict[str, QLineEdit] = {}
        self.faults: dict[str, FaultText] = {}
        self._wait = QTimer(self, singleShot=True, interval=_WAIT_MS)
        self._wait.timeout.connect(self.changed)
        grid = QGridLayout(self)
        grid.setContentsMargins(0, 0, 0, 0)
        for name, words, example, _ in _FIELDS:
            field = QLineEdit()
            field.setObjectName(f"search.{name}")
            field.setPlaceholderText(example)
            field.setClearButtonEnabled(True)
            field.setAccessibleName(words)
            field.textChanged.connect(self._typed)
            self.fields[name] = field
            label = QLabel(words)
            label.setBuddy(field)
            self.faults[name] = FaultText(theme)
            row, column = _PLACES[name]
            grid.addWidget(label, row, column)
            grid.addWidget(field, row, column + 1, 1, 3 if name == "sample" else 1)
            grid.addWidget(self.faults[name], row + 1, column, 1, 2)
        for column in (1, 3):
            grid.setColumnStretch(column, 2)
        for column in (5, 7):
            grid.setColumnStretch(column, 1)

    @property
    def query(self) -> Query:
        """What is asked for."""
        return Query(**{name: value for name, value in self._values().items() if value is not None})

    @property
    def faulty(self) -> tuple[str, ...]:
        """Fields whose text cannot be read."""
        return tuple(name for name, value in self._values().items() if value is None)

    def _values(self) -> dict[str, Any]:
        values: dict[str, Any] = {}
        for name, _, _, read in _FIELDS:
            text = self.fields[name].text().strip()
            if text:
                try:
                    values[name] = read(text)
                except ValueError:
                    values[name] = None
        return values

    def _typed(self) -> None:
        faulty = self.faulty
        for name, field in self.fields.items():
            field.setStyleSheet(f"border: 2px solid {self._theme.colours.alarm};" if name in faulty else "")
            self.faults[name].say(f"Write it as {field.placeholderText()}" if name in faulty else "")
        self._wait.start()
