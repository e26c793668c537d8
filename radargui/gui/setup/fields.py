"""Fields of a form that stand for one key of the setup: a number with its unit, a text, a choice."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from PySide6.QtCore import QEvent, QObject, Qt
from PySide6.QtGui import QAction, QKeySequence
from PySide6.QtWidgets import QComboBox, QLineEdit, QToolButton, QWidget

from radargui.gui.setup.form import Choice
from radargui.gui.setup.setup_model import SetupModel
from radargui.gui.theme import Theme

_ARROW = 22
"""Width of the arrow of a list in the style Fusion, in pixels."""


def parse_number(text: str, scale: float = 1.0) -> float | str | None:
    """Return the number that a text means, the text itself where it means none, None where it is empty.

    A decimal comma is understood. `scale` is shown value per stored value.
    """
    cleaned = text.strip().replace("\u2212", "-")
    if not cleaned:
        return None
    try:
        value = float(cleaned.replace(",", ".") if cleaned.count(",") == 1 and "." not in cleaned else cleaned)
    except ValueError:
        return cleaned
    return float(f"{value / scale:.12g}")


def show_number(value: object, scale: float = 1.0) -> str:
    """Return a stored number as the operator reads it."""
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return "" if value is None else str(value)
    return f"{value * scale:.10g}"


class Changed(QToolButton):
    """Stands in a field whose value is not the file's: says so, says what that was, and takes it back.

    Parameters
    ----------
    field, model, theme, key
        Where it stands, and for what.
    words
        Gives the file's value as the field shows it.
    beside
        Room that the field's own arrow takes at its right edge, in pixels.
    """

    def __init__(
        self,
        field: QWidget,
        model: SetupModel,
        theme: Theme,
        key: str,
        words: Callable[[Any], str],
        beside: int = 0,
    ) -> None:
        super().__init__(field)
        self._field, self._model, self._theme, self._key = field, model, theme, key
        self._words, self._beside = words, beside
        self.setText("\u21b6")
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.setCursor(Qt.CursorShape.PointingHandCursor)
        self.clicked.connect(self._undo)
        action = QAction("Undo this value", field)
        action.setShortcut(QKeySequence("Ctrl+U"))
        action.setShortcutContext(Qt.ShortcutContext.WidgetShortcut)
        action.triggered.connect(self._undo)
        field.addAction(action)
        field.installEventFilter(self)
        model.changed.connect(self._settle)
        theme.changed.connect(self._settle)
        self._settle()

    def eventFilter(self, field: QObject, event: QEvent) -> bool:  # noqa: N802 - Qt's name
        """Stay at the right edge."""
        if event.type() == QEvent.Type.Resize:
            self._settle()
        return super().eventFilter(field, event)

    def _undo(self) -> None:
        if self._model.differs(self._key):
            self._model.undo(self._key)

    def _settle(self) -> None:
        differs = self._model.differs(self._key)
        height = self._field.height() - 6
        self.setGeometry(self._field.width() - height - 3 - self._beside, 3, height, height)
        if isinstance(self._field, QLineEdit):
            self._field.setTextMargins(0, 0, height if differs else 0, 0)
        if differs:
            was = self._words(self._model.saved_value(self._key)) or "not set"
            self.setToolTip(f"Changed. The file says {was}: click, or Ctrl+U in the field, takes it back")
            colours = self._theme.colours
            self.setStyleSheet(
                f"QToolButton {{ background: {colours.mark}; color: {colours.base}; border: none; font-weight: bold; }}"
            )
        self._field.setAccessibleDescription(self.toolTip() if differs else "")
        self.setVisible(differs)


class _Line(QLineEdit):
    """A line that stands for a key: writes when editing ends, is edged where the value is wrong."""

    takes = Qt.InputMethodHint.ImhFormattedNumbersOnly

    def __init__(self, model: SetupModel, theme: Theme, key: str, *, optional: bool, hint: str) -> None:
        super().__init__()
        self.key = key
        self._model = model
        self._theme = theme
        self._optional = optional
        self.setObjectName(key)
        self.setPlaceholderText(hint)
        self.setMinimumWidth(56)
        self.setInputMethodHints(self.takes)
        self.textEdited.connect(self._edited)
        model.changed.connect(self.refresh)
        theme.changed.connect(self._edge)
        self.refresh()
        self.changed = Changed(self, model, theme, key, self._shown)

    def _parsed(self) -> object:
        raise NotImplementedError

    def _shown(self, value: object) -> str:
        raise NotImplementedError

    def _edited(self) -> None:
        value = self._parsed()
        self._model.assign(self.key, "" if value is None and not self._optional else value)

    def refresh(self) -> None:
        """Show what the draft says, unless the operator is typing here."""
        value = self._model.value(self.key)
        if not self.hasFocus() or self._parsed() != value:
            text = self._shown(value)
            if text != self.text():
                self.setText(text)
        self._edge()

    def _edge(self) -> None:
        wrong = any(self.key == one or self.key.startswith(f"{one}[") for one in self._model.faulty)
        self.setStyleSheet(f"QLineEdit {{ border: 2px solid {self._theme.colours.alarm}; }}" if wrong else "")


class NumberField(_Line):
    """A number; `scale` is shown value per stored value (1000 for a metre shown in mm)."""

    def __init__(
        self,
        model: SetupModel,
        theme: Theme,
        key: str,
        *,
        scale: float = 1.0,
        whole: bool = False,
        optional: bool = False,
        hint: str = "",
    ) -> None:
        self._scale = scale
        self._whole = whole
        super().__init__(model, theme, key, optional=optional, hint=hint)

    def _parsed(self) -> object:
        value = parse_number(self.text(), self._scale)
        return int(value) if self._whole and isinstance(value, float) and value.is_integer() else value

    def _shown(self, value: object) -> str:
        return show_number(value, self._scale)


class TextField(_Line):
    """A text."""

    takes = Qt.InputMethodHint.ImhNone

    def __init__(self, model: SetupModel, theme: Theme, key: str, *, optional: bool = False, hint: str = "") -> None:
        super().__init__(model, theme, key, optional=optional, hint=hint)

    def _parsed(self) -> object:
        return self.text().strip() or None

    def _shown(self, value: object) -> str:
        return "" if value is None else str(value)


class ListField(TextField):
    """Texts separated by commas."""

    def _parsed(self) -> object:
        return [part.strip() for part in self.text().split(",") if part.strip()] or None

    def _shown(self, value: object) -> str:
        return ", ".join(str(part) for part in value) if isinstance(value, (list, tuple)) else ""

    def refresh(self) -> None:
        """Show what the draft says, unless the operator is typing here."""
        if self.hasFocus():
            self._edge()
        else:
            super().refresh()


class VectorField(NumberField):
    """One coordinate of a place, stored in m and shown in mm; `axis` counts from 0."""

    def __init__(self, model: SetupModel, theme: Theme, key: str, axis: int) -> None:
        super().__init__(model, theme, f"{key}[{axis + 1}]", scale=1000.0)
        self.setObjectName(f"{key}[{axis}]")
        self.setAccessibleName(f"{key.partition('.')[2].partition('_')[0].capitalize()} {'xyz'[axis]} [mm]")


class ChoiceField(Choice):
    """One of some values, each with the words that show it."""

    def __init__(self, model: SetupModel, theme: Theme, key: str, choices: dict[Any, str]) -> None:
        super().__init__()
        self.key = key
        self._model = model
        self.setObjectName(key)
        for value, words in choices.items():
            self.addItem(words, value)
        # grows with its form, but never makes the form wider than its panel
        self.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon)
        self.setMinimumContentsLength(8)
        self.activated.connect(lambda _index: model.assign(key, self.currentData()))
        model.changed.connect(self.refresh)
        self.refresh()
        self.changed = Changed(self, model, theme, key, lambda value: choices.get(value, str(value)), beside=_ARROW)

    def refresh(self) -> None:
        """Show what the draft says."""
        self.setCurrentIndex(self.findData(self._model.value(self.key)))
