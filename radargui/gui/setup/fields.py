"""Fields that stand for one key of the setup: a line, a choice, yes or no; and what is said of them."""

from collections.abc import Callable, Mapping, Sequence
from itertools import chain
from typing import TypeAlias

from PySide6 import QtWidgets
from PySide6.QtCore import QEvent, Qt
from PySide6.QtGui import QKeyEvent, QKeySequence

from radargui.gui.bubble import FaultBubble
from radargui.gui.layout import (
    FRAMED,
    Answer,
    Choice,
    FaultText,
    FormScroll,
    Group,
    PlainLabel,
    Sections,
    boxed,
    button,
    fill,
    follow,
    side_by_side,
)
from radargui.gui.setup.setup_model import SetupModel
from radargui.gui.setup_words import FORMS, READERS, called, entries_of, kind_of, show_number, words_of
from radargui.model.assumed import ASSUMED
from radargui.model.radar import MAX_RECEIVERS

_ARROW = 22
"""Width of the arrow of a list in the style Fusion, in pixels."""
_EDGE = 3
"""Between a field's edge and what stands in it, in pixels."""
_TAKEN_BACK = "background: palette(link-visited); color: palette(base); border: none; font-weight: bold;"
UNDO_KEY = QKeySequence("Ctrl+U")
"""In a field: takes its value back to what the file says."""
_MAX_NAMED = 3
"""Changes named in the line beneath a form; more would take the room of the form. All stand in its tool tip."""


class Changed(QtWidgets.QToolButton):
    """Stands in a field whose value is not the file's: says so, says what that was, and takes it back.

    A line whose value is wrong is framed.

    Parameters
    ----------
    field, model, key
        Where it stands, and for what.
    show
        Lets the field show what the draft says.
    beside
        Room that the field's own arrow takes at its right edge, in pixels.

    Attributes
    ----------
    field
        Where it stands.
    fault
        What is wrong with the value, with the field's name; empty where nothing is.
    """

    def __init__(
        self, field: QtWidgets.QWidget, model: SetupModel, key: str, show: Callable[[], None], beside: int = 0
    ) -> None:
        super().__init__(field)
        self.field, self._model, self.key = field, model, key
        self.fault = ""
        self.setStyleSheet(_TAKEN_BACK)
        field.setObjectName(key)
        self.setText("\u21b6")
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.setCursor(Qt.CursorShape.PointingHandCursor)
        self.clicked.connect(self._undo)
        action = field.addAction("Undo this value", UNDO_KEY, self._undo)
        action.setShortcutContext(Qt.ShortcutContext.WidgetShortcut)
        self.setFixedWidth(field.sizeHint().height() - 2 * _EDGE)
        self.setSizePolicy(QtWidgets.QSizePolicy.Policy.Fixed, QtWidgets.QSizePolicy.Policy.Expanding)
        fill(QtWidgets.QHBoxLayout(field), 1, self, margins=(0, _EDGE, _EDGE + beside, _EDGE))
        for refresh in (show, self._settle):
            follow(model.changed, refresh)

    def _undo(self) -> None:
        if self._model.differs(self.key):
            self._model.undo(self.key)

    def _settle(self) -> None:
        differs = self._model.differs(self.key)
        if isinstance(self.field, QtWidgets.QLineEdit):
            self.field.setTextMargins(0, 0, self.width() if differs else 0, 0)
        if differs:
            was = words_of(self.key).with_unit(self._model.saved_value(self.key))
            self.setToolTip(f"Changed. The file says {was}: click, or Ctrl+U in the field, takes it back")
        self.setVisible(differs)
        wrong = self._model.fault_of(self.key)
        self.fault = f"{words_of(self.key).name}: {wrong}" if wrong else ""
        said = self.fault, self.toolTip() if differs else ""
        self.field.setAccessibleDescription(". ".join(filter(None, said)))
        framed = FRAMED if wrong else ""
        # reading a sheet is slow, and each change of the setup comes to every field
        if isinstance(self.field, QtWidgets.QLineEdit) and self.field.styleSheet() != framed:
            self.field.setStyleSheet(framed)


class LineField(QtWidgets.QLineEdit):
    """What is typed, a number in the unit of its words, a text, texts between commas; edged where it is wrong."""

    def __init__(self, model: SetupModel, key: str) -> None:
        super().__init__()
        self.key, self._model, self._words, kind = key, model, words_of(key), kind_of(key)
        self._read = READERS[kind]
        assumed = show_number(ASSUMED.get(key.rpartition(".")[2]), self._words.scale)
        self.setPlaceholderText((self._words.empty or "").format(assumed=assumed))
        self.setMinimumWidth(56)
        hints = Qt.InputMethodHint
        self.setInputMethodHints(hints.ImhNone if kind in ("string", "array") else hints.ImhFormattedNumbersOnly)
        self.textEdited.connect(self._edited)
        self.changed = Changed(self, model, key, self._show_draft)

    def event(self, event: QEvent) -> bool:
        """Leave the key that undoes the value to its action: on Linux Qt would empty the field instead."""
        if event.type() == QEvent.Type.ShortcutOverride and isinstance(event, QKeyEvent):
            keys = QKeySequence.StandardKey
            # what was typed here is taken back here; once it is gone, what was edited before
            done = (event.matches(keys.Undo) and not self.isUndoAvailable()) or (
                event.matches(keys.Redo) and not self.isRedoAvailable()
            )
            if done or QKeySequence(event.keyCombination()) == UNDO_KEY:
                event.ignore()
                return True
        return bool(super().event(event))

    def _edited(self, text: str) -> None:
        value = self._read(text, self._words.scale)
        self._model.assign(self.key, "" if value is None and self._words.empty is None else value)

    def _show_draft(self) -> None:
        """Show what the draft says, unless the operator is typing here."""
        value = self._model.value(self.key)
        if not self.hasFocus() or self._read(self.text(), self._words.scale) != value:
            text = "" if value is None else self._words.shown(value)
            if text != self.text():
                self.setText(text)


class ChoiceField(Choice):
    """One of some values, each with the words that show it."""

    def __init__(self, model: SetupModel, key: str) -> None:
        super().__init__(words_of(key).choices.items())
        # grows with its form, but never makes the form wider than its panel
        self.setSizeAdjustPolicy(QtWidgets.QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon)
        self.setMinimumContentsLength(8)
        # what is chosen as an empty text is left out of the file
        self.activated.connect(
            lambda _index: model.assign(key, None if self.currentData() == "" else self.currentData())
        )

        def show() -> None:
            value = model.value(key)
            self.setCurrentIndex(self.findData("" if value is None else value))

        self.changed = Changed(self, model, key, show, _ARROW)


class CheckField(QtWidgets.QCheckBox):
    """Yes or no."""

    def __init__(self, model: SetupModel, key: str) -> None:
        words = words_of(key)
        super().__init__(words.name)
        self.setToolTip(words.tip)
        self.clicked.connect(lambda checked: model.assign(key, checked))
        self.changed = Changed(self, model, key, lambda: self.setChecked(model.value(key) is True))


Field: TypeAlias = LineField | ChoiceField | CheckField


class ModelGroup(Group):
    """A titled group that shows what follows from the setup, and follows its changes."""

    def __init__(self, title: str, model: SetupModel, *parts: QtWidgets.QWidget) -> None:
        super().__init__(title, *parts)
        self._model = model
        follow(model.changed, self.refresh)

    def refresh(self) -> None:
        """Show what holds for the setup now."""
        raise NotImplementedError


class SetupForm(Group):
    """A titled group of fields of the setup, each with its words.

    Parameters
    ----------
    name
        Of the form among `FORMS`, which says its title and the keys that it begins with.
    """

    def __init__(self, name: str, model: SetupModel) -> None:
        super().__init__(FORMS[name]["title"])
        self._model = model
        self.fields: dict[str, Field] = {}
        self.add(*FORMS[name]["keys"])

    def add(self, *keys: str, beside: Sequence[QtWidgets.QWidget] = ()) -> None:
        """Add the fields of some keys, each as its kind wants it, with what helps to fill them `beside`."""
        for key in keys:
            words, kind = words_of(key), kind_of(key)
            made: type[Field] = CheckField if kind == "boolean" else ChoiceField if words.choices else LineField
            parts = [f"{key}[{axis}]" for axis in range(1, 1 + entries_of(key))] if kind == "place" else [key]
            fields = {part: made(self._model, part) for part in parts}
            self.fields |= fields
            box = side_by_side(*fields.values(), *beside) if len(parts) > 1 or beside else fields[key]
            self.whole(box) if kind == "boolean" else self.row(words.label, box, words.tip)
            for part, field in fields.items():
                field.setAccessibleName(words_of(part).label)


class AntennaGrid(QtWidgets.QWidget):
    """Rows of numbers, one an antenna, under common titles.

    Parameters
    ----------
    names
        Of the values, one a column.
    first
        Number of the first receiver that has a row; 0: the transmitter has one too.
    """

    def __init__(self, model: SetupModel, names: Sequence[str], first: int = 1) -> None:
        super().__init__()
        self._model = model
        self._grid = QtWidgets.QGridLayout(self)
        self._grid.setContentsMargins(0, 0, 0, 0)
        self._grid.setSpacing(4)
        for column, name in enumerate(names, start=1):
            self._grid.addWidget(QtWidgets.QLabel(words_of(f"receiver.{name}").label), 0, column)
            # all as wide, whatever stands in them
            self._grid.setColumnStretch(column, 1)
        self.rows: dict[int, list[QtWidgets.QWidget]] = {}
        self.fields: dict[int, list[LineField]] = {}
        for number in range(first, MAX_RECEIVERS + 1):
            antenna, table = (f"Rx {number}", f"receiver[{number}]") if number else ("Tx", "transmitter")
            self.fields[number] = fields = [LineField(model, f"{table}.{name}") for name in names]
            self.rows[number] = row = [QtWidgets.QLabel(antenna), *fields, *self.beside(number)]
            line = self._grid.rowCount()
            for field in fields:
                words = words_of(field.key)
                field.setAccessibleName(f"{antenna} {words.label}")
                field.setToolTip(words.tip)
            for column, widget in enumerate(row):
                self._grid.addWidget(widget, line, column)
        follow(model.changed, self.refresh)

    def beside(self, number: int) -> list[QtWidgets.QWidget]:
        """Return what stands at the end of the row of an antenna."""
        return []

    def refresh(self) -> None:
        """Show the rows of the antennas that are there."""
        for number, row in self.rows.items():
            for widget in row:
                widget.setVisible(number <= self._model.n_receivers)


class FormPanel(QtWidgets.QWidget):
    """Groups of fields in sections of which one is open; beneath them what changed since the last run.

    What is wrong stands in a bubble at its field, and beneath the sections where that field is not seen or the bubble
    would lie over what has the keys: no field moves when something is wrong.

    Attributes
    ----------
    fault, elsewhere
        The bubble, and the line beneath; one of them says what is wrong.
    only_shows, no_setup
        Groups that stay open while samples come in, and while the setup of a session is reviewed.
    """

    def __init__(self, model: SetupModel, take_over: Callable[[], object]) -> None:
        super().__init__()
        self._model = model
        self._running, self._closed = False, Answer()
        self.take_over = button("Take it over", take_over)
        self.only_shows: tuple[QtWidgets.QWidget, ...] = ()
        self.no_setup: tuple[QtWidgets.QWidget, ...] = ()
        self.changes, self.elsewhere, self.fault = PlainLabel(), FaultText(), FaultBubble()
        self.fault.settled.connect(self._say_elsewhere)

    def lay_out(self, always: Group, sections: Mapping[str, Sequence[Group]], *, last: bool = False) -> None:
        """Put groups into the panel in sections by their titles, and one that is always open above or `last`."""
        for groups in sections.values():
            if len(groups) == 1:
                # the section says it
                groups[0].setTitle("")
        parts = {title: boxed(QtWidgets.QVBoxLayout(), *groups, spacing=6) for title, groups in sections.items()}
        self.sections, self._groups = Sections(parts), (always, *chain(*sections.values()))
        self._form = FormScroll(*((self.sections, always) if last else (always, self.sections)))
        foot = fill(
            QtWidgets.QVBoxLayout(),
            self._closed,
            self.take_over,
            self.changes,
            self.elsewhere,
            margins=(8, 0, 8, 0),
            spacing=4,
        )
        fill(QtWidgets.QVBoxLayout(self), (self._form, 1), foot)
        follow(self._model.changed, self.refresh)

    def set_running(self, running: bool) -> None:
        """Close or open the form for changes; what only shows stays as it is."""
        self._running = running
        self._close_what_must_not_change()

    def _close_what_must_not_change(self) -> None:
        running, session = self._running, self._model.reviewed
        for group in self._groups:
            stays = group in self.only_shows or (not running and group in self.no_setup)
            group.setEnabled(stays or not (running or session))
        self._closed.say("Stop to change this." if running else f"Setup of {session}, read only." if session else "")
        self.take_over.setVisible(bool(session) and not running)

    def refresh(self) -> None:
        """Show what the draft is now."""
        self._close_what_must_not_change()
        changes = [
            f"{called(key)} (was {words_of(key).with_unit(was)})" for key, was in self._model.since_last_run.items()
        ]
        more = f" and {len(changes) - _MAX_NAMED} more" if len(changes) > _MAX_NAMED else ""
        self.changes.setText(f"Changed since the last run: {', '.join(changes[:_MAX_NAMED])}{more}")
        self.changes.setToolTip("\n".join(changes))
        self.changes.setVisible(bool(changes))
        wrong = [mark for mark in self.findChildren(Changed) if mark.fault]
        at = next((mark for mark in wrong if mark.field.isVisibleTo(self)), None) or next(iter(wrong), None)
        self.fault.say(at.fault if at else "", at.field if at else None)

    def _say_elsewhere(self) -> None:
        self.elsewhere.say("" if self.fault.isVisibleTo(self) else self._model.error)
