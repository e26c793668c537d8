"""How panels, forms and dialogs are laid out: boxes, buttons, wrapped words, titled groups of labelled fields."""

from collections.abc import Callable, Iterable
from typing import Any, TypeVar

from PySide6.QtCore import QSize, Qt, SignalInstance
from PySide6.QtGui import QWheelEvent
from PySide6.QtWidgets import (
    QBoxLayout,
    QComboBox,
    QDialog,
    QFormLayout,
    QFrame,
    QGroupBox,
    QHBoxLayout,
    QLabel,
    QLayout,
    QPushButton,
    QScrollArea,
    QSizePolicy,
    QVBoxLayout,
    QWidget,
)

from radargui.gui.theme import Theme

Margins = tuple[int, int, int, int]
Part = QWidget | QLayout | int | tuple[QWidget | QLayout, int]
_FRAME = QSize(16, 40)
"""What the system draws around a window: edges and title (chosen by hand, the largest of usual systems)."""
_Box = TypeVar("_Box", bound=QBoxLayout)


def fill(box: _Box, *parts: Part, margins: Margins = (0, 0, 0, 0), spacing: int = 2) -> _Box:
    """Put parts into a box one after another.

    Parameters
    ----------
    parts
        Widgets and layouts, each alone or with its share of the room that is left; a number alone is empty room.
    margins, spacing
        Around and between them, in pixels.
    """
    box.setContentsMargins(*margins)
    box.setSpacing(spacing)
    for part in parts:
        if isinstance(part, int):
            box.addStretch(part)
            continue
        what, share = part if isinstance(part, tuple) else (part, 0)
        box.addLayout(what, share) if isinstance(what, QLayout) else box.addWidget(what, share)
    return box


def take_out(layout: QLayout, *widgets: QWidget) -> None:
    """Take widgets out of a layout for good; they are gone from the screen at once."""
    for widget in widgets:
        layout.removeWidget(widget)
        widget.hide()
        widget.deleteLater()


def button(
    words: str, does: Callable[..., Any] | SignalInstance, tip: str = "", *, default: bool = False
) -> QPushButton:
    """Return a button; in a dialog Enter presses the one that is the `default`."""
    made = QPushButton(words)
    made.setToolTip(tip)
    made.setAutoDefault(default)
    made.setDefault(default)
    made.clicked.connect(does)
    return made


def fit_screen(dialog: QWidget, width: int, height: int) -> None:
    """Give a dialog a size at first, no larger than the screen has room for."""
    dialog.resize(QSize(width, height).boundedTo(dialog.screen().availableSize() - _FRAME))


class Dialog(QDialog):
    """A window beside the main one; its size and columns are remembered where it has a name."""

    def __init__(self, title: str, size: tuple[int, int], parent: QWidget | None = None, name: str = "") -> None:
        super().__init__(parent)
        self.setWindowTitle(title)
        self.setObjectName(name)
        fit_screen(self, *size)

    def lay_out(self, *parts: Part, margins: Margins = (9, 9, 9, 9), spacing: int = 6) -> None:
        """Put the parts one beneath the other."""
        fill(QVBoxLayout(self), *parts, margins=margins, spacing=spacing)

    def come_up(self) -> None:
        """Stand before the other windows."""
        self.show()
        self.raise_()
        self.activateWindow()


class Group(QGroupBox):
    """A titled group of labelled fields."""

    def __init__(self, title: str = "") -> None:
        super().__init__(title)
        self.rows = QFormLayout(self)
        self.rows.setFieldGrowthPolicy(QFormLayout.FieldGrowthPolicy.AllNonFixedFieldsGrow)
        self.rows.setLabelAlignment(Qt.AlignmentFlag.AlignLeft)
        self.rows.setVerticalSpacing(4)
        self.rows.setContentsMargins(8, 6, 8, 8)

    def row(self, words: str, field: QWidget, tip: str = "", fault: QWidget | None = None) -> None:
        """Add a field; `words` names it with its unit, and what is wrong with it stands beneath."""
        label = QLabel(words)
        label.setBuddy(field)
        label.setToolTip(tip)
        field.setToolTip(tip)
        field.setAccessibleName(words)
        self.rows.addRow(label, field)
        if fault is not None:
            self.rows.addRow(fault)

    def whole(self, widget: QWidget) -> None:
        """Add a widget over the whole width."""
        self.rows.addRow(widget)


class Choice(QComboBox):
    """A list to choose from that the wheel scrolls past, never changes.

    Parameters
    ----------
    items
        What may be chosen, each value with the words that show it.
    """

    def __init__(self, items: Iterable[tuple[Any, str]] = ()) -> None:
        super().__init__()
        for value, words in items:
            self.addItem(words, value)

    def wheelEvent(self, event: QWheelEvent) -> None:  # noqa: N802 - Qt's name
        """Leave the wheel to the form."""
        event.ignore()


def side_by_side(*widgets: QWidget) -> QWidget:
    """Return a box that holds widgets beside each other."""
    box = QWidget()
    # room for the frame around what has the keys: it is drawn within the box
    fill(QHBoxLayout(box), *widgets, margins=(3, 3, 3, 3), spacing=4)
    return box


class PlainLabel(QLabel):
    """Words that wrap and are never taken for markup."""

    def __init__(self, text: str = "", *, selectable: bool = True) -> None:
        super().__init__(text)
        self.setTextFormat(Qt.TextFormat.PlainText)
        self.setWordWrap(True)
        self.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Minimum)
        if selectable:
            self.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)


class Answer(PlainLabel):
    """Words that take no room while there are none."""

    def __init__(self) -> None:
        super().__init__()
        self.hide()

    def say(self, text: str) -> None:
        """Show words; an empty text: there are none."""
        self.setText(text)
        self.setVisible(bool(text))


class FaultText(Answer):
    """What is wrong with a field, beneath it; nothing while it is right."""

    def __init__(self, theme: Theme) -> None:
        super().__init__()
        self._theme = theme
        theme.changed.connect(self._paint)
        self._paint()

    def _paint(self) -> None:
        self.setStyleSheet(f"color: {self._theme.colours.alarm}; font-weight: bold;")


class Strip(QFrame):
    """A line of words with buttons behind, edged in a colour that says what kind it is; hidden until it is needed.

    Parameters
    ----------
    theme
        Gives the colours.
    role
        Colour of the edge.
    """

    def __init__(self, theme: Theme, role: str, *buttons: QWidget) -> None:
        super().__init__()
        self._theme, self._role = theme, role
        self.setObjectName("strip")
        self.words = PlainLabel()
        # as high as its words need at the width there is, not at the one that a label would like
        self.words.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Preferred)
        fill(QHBoxLayout(self), (self.words, 1), *buttons, margins=(8, 2, 4, 2), spacing=6)
        theme.changed.connect(self._paint)
        self._paint()
        self.hide()

    @property
    def text(self) -> str:
        """What is said."""
        return self.words.text()

    def _paint(self) -> None:
        colours = self._theme.colours
        edge = f"border: none; border-left: 6px solid {colours.role(self._role)};"
        self.setStyleSheet(f"QFrame#strip {{ background: {colours.raised}; {edge} }}")


class FormScroll(QScrollArea):
    """Scrolls a column of groups up and down, and is never narrower than it."""

    def __init__(self, *groups: QWidget) -> None:
        super().__init__()
        self.content = content = QWidget()
        fill(QVBoxLayout(content), *groups, 1, margins=(6, 6, 6, 6), spacing=6)
        content.setObjectName("form")
        self.setWidget(content)
        self.setWidgetResizable(True)
        self.setFrameShape(QFrame.Shape.NoFrame)
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        # plots take what room there is, forms only what they need
        self.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Expanding)

    def minimumSizeHint(self) -> QSize:  # noqa: N802 - Qt's name
        """Return the width of the content beside the scroll bar."""
        width = self.content.minimumSizeHint().width() + self.verticalScrollBar().sizeHint().width()
        return QSize(width, 120)
