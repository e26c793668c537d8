"""Fields of a form that stand for one key of the setup: a number with its unit, a text, a choice."""

from __future__ import annotations

from typing import Any

from PySide6.QtWidgets import QComboBox, QLineEdit, QWidget

from radargui.gui.setup.setup_model import SetupModel
from radargui.gui.theme import Theme


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


class _Line(QLineEdit):
    """A line that stands for a key: writes when editing ends, is edged where the value is wrong."""

    def __init__(self, model: SetupModel, theme: Theme, key: str, *, optional: bool, hint: str) -> None:
        super().__init__()
        self.key = key
        self._model = model
        self._theme = theme
        self._optional = optional
        self.setObjectName(key)
        self.setPlaceholderText(hint)
        self.setMinimumWidth(56)
        self.textEdited.connect(self._edited)
        model.changed.connect(self.refresh)
        theme.changed.connect(self._edge)
        self.refresh()

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
        wrong = self.key in self._model.faulty
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


class VectorField(_Line):
    """One coordinate of a place, stored in m and shown in mm."""

    def __init__(self, model: SetupModel, theme: Theme, key: str, axis: int) -> None:
        self._axis = axis
        self._vector_key = key
        super().__init__(model, theme, key, optional=False, hint="")
        self.setObjectName(f"{key}[{axis}]")

    def _parsed(self) -> object:
        return parse_number(self.text(), 1000.0)

    def _shown(self, value: object) -> str:
        return show_number(value, 1000.0)

    def _edited(self) -> None:
        place: list[Any] = list(self._model.value(self.key))
        parsed = self._parsed()
        place[self._axis] = "" if parsed is None else parsed
        self._model.assign(self.key, place)

    def refresh(self) -> None:
        """Show what the draft says, unless the operator is typing here."""
        place = self._model.value(self.key)
        value = place[self._axis]
        if not self.hasFocus() or (self._parsed() != value and value != ""):
            text = self._shown(value)
            if text != self.text():
                self.setText(text)
        self._edge()


class ChoiceField(QComboBox):
    """One of some values, each with the words that show it."""

    def __init__(self, model: SetupModel, key: str, choices: dict[Any, str], parent: QWidget | None = None) -> None:
        super().__init__(parent)
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

    def refresh(self) -> None:
        """Show what the draft says."""
        self.setCurrentIndex(self.findData(self._model.value(self.key)))
