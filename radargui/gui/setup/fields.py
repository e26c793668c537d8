"""Fields that stand for one key of the setup: a number with its unit, a text, a choice; and what is said of them."""

from collections.abc import Sequence
from typing import Any, TypeVar

from PySide6.QtCore import QEvent, QObject, Qt
from PySide6.QtGui import QAction, QKeySequence
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QGridLayout,
    QLabel,
    QLineEdit,
    QPushButton,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from radargui.gui.layout import Choice, FaultText, FormScroll, Group, PlainLabel, fill, side_by_side
from radargui.gui.setup.setup_model import SetupModel
from radargui.gui.setup.words import called, parse_number, show_number, words_of
from radargui.gui.theme import Theme

_ARROW = 22
"""Width of the arrow of a list in the style Fusion, in pixels."""
_MOST_NAMED = 3
"""Changes named in the line beneath a form; more would take the room of the form. All stand in its tool tip."""


class Changed(QToolButton):
    """Stands in a field whose value is not the file's: says so, says what that was, and takes it back.

    `fault` is for beneath the field: what is wrong with the value; a line with such a value is framed.

    Parameters
    ----------
    field, model, theme, key
        Where it stands, and for what.
    beside
        Room that the field's own arrow takes at its right edge, in pixels.
    """

    def __init__(self, field: QWidget, model: SetupModel, theme: Theme, key: str, beside: int = 0) -> None:
        super().__init__(field)
        self._field, self._model, self._theme, self.key, self._beside = field, model, theme, key, beside
        self.fault = FaultText(theme)
        field.setObjectName(key)
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
        if self._model.differs(self.key):
            self._model.undo(self.key)

    def _settle(self) -> None:
        differs = self._model.differs(self.key)
        height = self._field.height() - 6
        self.setGeometry(self._field.width() - height - 3 - self._beside, 3, height, height)
        if isinstance(self._field, QLineEdit):
            self._field.setTextMargins(0, 0, height if differs else 0, 0)
        if differs:
            was = words_of(self.key).with_unit(self._model.saved_value(self.key))
            self.setToolTip(f"Changed. The file says {was}: click, or Ctrl+U in the field, takes it back")
            colours = self._theme.colours
            self.setStyleSheet(
                f"QToolButton {{ background: {colours.mark}; color: {colours.base}; border: none; font-weight: bold; }}"
            )
        self._field.setAccessibleDescription(self.toolTip() if differs else "")
        self.setVisible(differs)
        wrong = self._model.fault_of(self.key)
        self.fault.say(f"{words_of(self.key).name}: {wrong}" if wrong else "")
        if isinstance(self._field, QLineEdit):
            frame = f"QLineEdit {{ border: 2px solid {self._theme.colours.alarm}; }}"
            self._field.setStyleSheet(frame if wrong else "")


class _Line(QLineEdit):
    """A line that stands for a key: writes when editing ends, is edged where the value is wrong."""

    takes = Qt.InputMethodHint.ImhFormattedNumbersOnly

    def __init__(
        self, model: SetupModel, theme: Theme, key: str, *, whole: bool = False, optional: bool = False, hint: str = ""
    ) -> None:
        super().__init__()
        self.key, self._model = key, model
        self._optional, self._whole, self._scale = optional, whole, words_of(key).scale
        self.setPlaceholderText(hint)
        self.setMinimumWidth(56)
        self.setInputMethodHints(self.takes)
        self.textEdited.connect(self._edited)
        model.changed.connect(self.refresh)
        self.refresh()
        self.changed = Changed(self, model, theme, key)

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


class NumberField(_Line):
    """A number, shown in the unit of its words."""

    def _parsed(self) -> object:
        value = parse_number(self.text(), self._scale)
        return int(value) if self._whole and isinstance(value, float) and value.is_integer() else value

    def _shown(self, value: object) -> str:
        return show_number(value, self._scale)


class TextField(_Line):
    """A text."""

    takes = Qt.InputMethodHint.ImhNone

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
        if not self.hasFocus():
            super().refresh()


class ChoiceField(Choice):
    """One of some values, each with the words that show it."""

    def __init__(self, model: SetupModel, theme: Theme, key: str) -> None:
        super().__init__(words_of(key).choices.items())
        self.key, self._model = key, model
        # grows with its form, but never makes the form wider than its panel
        self.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon)
        self.setMinimumContentsLength(8)
        self.activated.connect(lambda _index: model.assign(key, self.currentData()))
        model.changed.connect(self.refresh)
        self.refresh()
        self.changed = Changed(self, model, theme, key, _ARROW)

    def refresh(self) -> None:
        """Show what the draft says."""
        self.setCurrentIndex(self.findData(self._model.value(self.key)))


class CheckField(QCheckBox):
    """Yes or no."""

    def __init__(self, model: SetupModel, theme: Theme, key: str) -> None:
        words = words_of(key)
        super().__init__(words.name)
        self.key, self._model = key, model
        self.setToolTip(words.tip)
        self.clicked.connect(lambda checked: model.assign(key, checked))
        model.changed.connect(self.refresh)
        self.refresh()
        self.changed = Changed(self, model, theme, key)

    def refresh(self) -> None:
        """Show what the draft says."""
        self.setChecked(self._model.value(self.key) is True)


_F = TypeVar("_F", NumberField, TextField, ListField, ChoiceField)


class SetupForm(Group):
    """A titled group of fields of the setup, each with its words; what is wrong with one stands beneath it."""

    def __init__(self, title: str, model: SetupModel, theme: Theme) -> None:
        super().__init__(title)
        self._of = (model, theme)

    def number(self, key: str, **options: Any) -> NumberField:
        """Add a number; for the options see `NumberField`."""
        return self._add(NumberField(*self._of, key, **options))

    def numbers(self, table: str, *names: str, **options: Any) -> None:
        """Add several numbers of one table of the setup."""
        for name in names:
            self.number(f"{table}.{name}", **options)

    def text(self, key: str, *beside: QPushButton, **options: Any) -> TextField:
        """Add a text with what helps to fill it beside it."""
        return self._add(TextField(*self._of, key, **options), *beside)

    def texts(self, key: str, **options: Any) -> ListField:
        """Add a list of texts."""
        return self._add(ListField(*self._of, key, **options))

    def choice(self, key: str) -> ChoiceField:
        """Add a choice."""
        return self._add(ChoiceField(*self._of, key))

    def yes_no(self, key: str) -> CheckField:
        """Add a yes or no over the whole width."""
        field = CheckField(*self._of, key)
        self.whole(field)
        self.whole(field.changed.fault)
        return field

    def vector(self, key: str) -> None:
        """Add the three coordinates of a place."""
        words = words_of(key)
        fields = [NumberField(*self._of, f"{key}[{axis}]") for axis in (1, 2, 3)]
        self.row(words.label, side_by_side(*fields), words.tip)
        for axis, field in enumerate(fields):
            field.setObjectName(f"{key}[{axis}]")
            field.setAccessibleName(words_of(f"{key}[{axis + 1}]").label)
            self.whole(field.changed.fault)

    def _add(self, field: _F, *beside: QWidget) -> _F:
        words = words_of(field.key)
        self.row(words.label, side_by_side(field, *beside) if beside else field, words.tip, field.changed.fault)
        field.setAccessibleName(words.label)
        return field


class FieldGrid(QWidget):
    """Rows of numbers under common titles; what is wrong with one stands beneath its row."""

    def __init__(self, *titles: str) -> None:
        super().__init__()
        self._grid = grid = QGridLayout(self)
        grid.setContentsMargins(0, 0, 0, 0)
        grid.setSpacing(4)
        for column, title in enumerate(titles, start=1):
            grid.addWidget(QLabel(title), 0, column)

    def add_row(self, name: str, fields: Sequence[NumberField], *more: QWidget) -> list[QWidget]:
        """Add a row; return its widgets from the left."""
        line, row = self._grid.rowCount(), [QLabel(name), *fields, *more]
        for place, field in enumerate(fields, start=line):
            words = words_of(field.key)
            field.setAccessibleName(f"{name} {words.label}")
            field.setToolTip(words.tip)
            # beneath the row: a column is too narrow for a sentence
            self._grid.addWidget(field.changed.fault, place + 1, 0, 1, len(row))
        for column, widget in enumerate(row):
            self._grid.addWidget(widget, line, column)
        return row


class FormPanel(QWidget):
    """Groups of fields that scroll; beneath them what changed since the last run, and what is wrong out of sight."""

    def __init__(self, model: SetupModel, theme: Theme) -> None:
        super().__init__()
        self._model = model
        self._closed = PlainLabel("Stop to change this.")
        self._closed.hide()
        self.changes, self.elsewhere = PlainLabel(), FaultText(theme)

    def lay_out(self, *groups: QWidget) -> None:
        """Put the groups into the panel."""
        self._form = FormScroll(*groups)
        foot = fill(QVBoxLayout(), self._closed, self.changes, self.elsewhere, margins=(8, 0, 8, 0), spacing=4)
        fill(QVBoxLayout(self), (self._form, 1), foot)
        self._model.changed.connect(self.refresh)
        self.refresh()

    def set_running(self, running: bool) -> None:
        """Close or open the form for changes."""
        self._form.content.setEnabled(not running)
        self._closed.setVisible(running)

    def refresh(self) -> None:
        """Show what the draft is now."""
        changes = [
            f"{called(key)} (was {words_of(key).with_unit(was)})" for key, was in self._model.since_last_run.items()
        ]
        more = f" and {len(changes) - _MOST_NAMED} more" if len(changes) > _MOST_NAMED else ""
        self.changes.setText(f"Changed since the last run: {', '.join(changes[:_MOST_NAMED])}{more}")
        self.changes.setToolTip("\n".join(changes))
        self.changes.setVisible(bool(changes))
        faults = (mark.fault for mark in self.findChildren(Changed))
        self.elsewhere.say("" if any(one.isVisibleTo(self) for one in faults) else self._model.error)
