"""What never moves: start, record, stop, how many runs, the state beside them, and the place of messages beneath."""

from __future__ import annotations

from PySide6.QtCore import QEvent, QObject, QSize, Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import (
    QFrame,
    QHBoxLayout,
    QLabel,
    QScrollArea,
    QSizePolicy,
    QSpinBox,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from radargui.gui.control.state_view import StateView
from radargui.gui.theme import Theme, scaled_font

MOST_RUNS = 999


class ControlBar(QWidget):
    """Large buttons for actions that the menu has as well."""

    def __init__(self, theme: Theme, start: QAction, record: QAction, stop: QAction) -> None:
        super().__init__()
        layout = QHBoxLayout(self)
        layout.setContentsMargins(6, 2, 6, 2)
        layout.setSpacing(6)
        for action in (start, record, stop):
            layout.addWidget(_button(action))
        self.runs = QSpinBox()
        self.runs.setObjectName("runs")
        self.runs.setRange(1, MOST_RUNS)
        self.runs.setAccessibleName("Number of runs to record")
        self.runs.setToolTip("How many runs Record takes, one after the other without a hand")
        column = QVBoxLayout()
        column.setSpacing(1)
        column.addStretch(1)
        label = QLabel("Runs")
        label.setBuddy(self.runs)
        column.addWidget(label)
        column.addWidget(self.runs)
        column.addStretch(1)
        layout.addLayout(column)
        self.state = StateView(theme)
        layout.addWidget(self.state, 1)


class MessagePlace(QScrollArea):
    """Room for messages, offers and progress that is the same whether there are any or not, so that nothing moves."""

    def __init__(self, before: QWidget, *parts: QWidget) -> None:
        super().__init__()
        self._before = before
        self._content = QWidget()
        column = QVBoxLayout(self._content)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(1)
        self._parts = parts
        self._quiet = QLabel("No messages")
        self._quiet.setContentsMargins(8, 4, 8, 4)
        self._quiet.setEnabled(False)
        for part in (*parts, self._quiet):
            column.addWidget(part)
        column.addStretch(1)
        self.setWidget(self._content)
        self.setWidgetResizable(True)
        self.setFrameShape(QFrame.Shape.NoFrame)
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        # two messages of one line, with the room around their words
        self.setFixedHeight(2 * (self.fontMetrics().height() + 16))

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802 - Qt's name
        """Show what came on top, and let Tab enter it from the bar above."""
        if event.type() == QEvent.Type.LayoutRequest:
            self.verticalScrollBar().setValue(0)
            self._quiet.setVisible(all(part.isHidden() for part in self._parts))
            before = self._before
            for one in self._content.findChildren(QWidget):
                if one.focusPolicy() & Qt.FocusPolicy.TabFocus:
                    QWidget.setTabOrder(before, one)
                    before = one
        return super().eventFilter(watched, event)


def _button(action: QAction) -> QToolButton:
    button = QToolButton()
    button.setDefaultAction(action)
    button.setFont(scaled_font(button.font(), 1.25, bold=True))
    button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextOnly)
    button.setMinimumSize(QSize(92, 50))
    button.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Preferred)
    return button
