"""The bar of what the operator does most: start, record, stop, how many runs; and the state beside it."""

from __future__ import annotations

from PySide6.QtCore import QSize, Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QHBoxLayout, QLabel, QSizePolicy, QSpinBox, QToolButton, QVBoxLayout, QWidget

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


def _button(action: QAction) -> QToolButton:
    button = QToolButton()
    button.setDefaultAction(action)
    button.setFont(scaled_font(button.font(), 1.25, bold=True))
    button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextOnly)
    button.setMinimumSize(QSize(92, 50))
    button.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Preferred)
    return button
