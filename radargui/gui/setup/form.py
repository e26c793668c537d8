"""How forms are laid out: narrow, labels with units, a title over each group."""

from __future__ import annotations

from PySide6.QtCore import QSize, Qt
from PySide6.QtGui import QWheelEvent
from PySide6.QtWidgets import (
    QComboBox,
    QFormLayout,
    QFrame,
    QGroupBox,
    QHBoxLayout,
    QLabel,
    QScrollArea,
    QSizePolicy,
    QWidget,
)


class Group(QGroupBox):
    """A titled group of labelled fields."""

    def __init__(self, title: str = "") -> None:
        super().__init__(title)
        self.rows = QFormLayout(self)
        self.rows.setFieldGrowthPolicy(QFormLayout.FieldGrowthPolicy.AllNonFixedFieldsGrow)
        self.rows.setLabelAlignment(Qt.AlignmentFlag.AlignLeft)
        self.rows.setVerticalSpacing(4)
        self.rows.setContentsMargins(8, 6, 8, 8)

    def row(self, words: str, field: QWidget, tip: str = "") -> None:
        """Add a field; `words` names it with its unit."""
        label = QLabel(words)
        label.setBuddy(field)
        label.setToolTip(tip)
        field.setToolTip(tip)
        field.setAccessibleName(words)
        self.rows.addRow(label, field)

    def whole(self, widget: QWidget) -> None:
        """Add a widget over the whole width."""
        self.rows.addRow(widget)


class Choice(QComboBox):
    """A list to choose from that the wheel scrolls past, never changes."""

    def wheelEvent(self, event: QWheelEvent) -> None:  # noqa: N802 - Qt's name
        """Leave the wheel to the form."""
        event.ignore()


def side_by_side(*widgets: QWidget) -> QWidget:
    """Return a box that holds widgets beside each other."""
    box = QWidget()
    layout = QHBoxLayout(box)
    layout.setContentsMargins(0, 0, 0, 0)
    layout.setSpacing(4)
    for widget in widgets:
        layout.addWidget(widget)
    return box


def plain_label(text: str = "", *, selectable: bool = True) -> QLabel:
    """Return a label that wraps and never takes its text for markup."""
    label = QLabel(text)
    label.setTextFormat(Qt.TextFormat.PlainText)
    label.setWordWrap(True)
    label.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Minimum)
    if selectable:
        label.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
    return label


def hint(text: str) -> QLabel:
    """Return a hidden line for beneath a form."""
    label = plain_label(text)
    label.setContentsMargins(8, 4, 8, 4)
    label.setVisible(False)
    return label


class FormScroll(QScrollArea):
    """Scrolls its content up and down, and is never narrower than it."""

    def __init__(self, content: QWidget) -> None:
        super().__init__()
        self._content = content
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
        width = self._content.minimumSizeHint().width() + self.verticalScrollBar().sizeHint().width()
        return QSize(width, 120)
