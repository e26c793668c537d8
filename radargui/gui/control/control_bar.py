"""What never moves: start, record, stop, how many runs, the state beside them, and the place of messages beneath."""

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

from radargui.gui.control.banner import StateView
from radargui.gui.layout import fill
from radargui.gui.theme import Theme, scaled_font

MOST_RUNS = 999
"""What is counted without a hand: more than a day of drops, one a minute and a half."""
_LOW_SCREEN = 560
"""Height below which every line is taken from the plots: 1920 x 1080 at scale 2 has 540."""


class ControlBar(QWidget):
    """Large buttons for actions that the menu has as well."""

    def __init__(self, theme: Theme, start: QAction, record: QAction, stop: QAction) -> None:
        super().__init__()
        self.runs = QSpinBox()
        self.runs.setObjectName("runs")
        self.runs.setRange(1, MOST_RUNS)
        self.runs.setAccessibleName("Number of runs to record")
        self.runs.setToolTip("How many runs Record takes, one after the other without a hand")
        label = QLabel("Runs")
        label.setBuddy(self.runs)
        column = fill(QVBoxLayout(), 1, label, self.runs, 1, spacing=1)
        self.state = StateView(theme)
        buttons = (_button(action) for action in (start, record, stop))
        fill(QHBoxLayout(self), *buttons, column, (self.state, 1), margins=(6, 2, 6, 2), spacing=6)


class MessagePlace(QScrollArea):
    """Room for messages, offers and progress that is the same whether there are any or not, so that nothing moves."""

    def __init__(self, before: QWidget, *parts: QWidget) -> None:
        super().__init__()
        self._before = before
        self._content = QWidget()
        self._parts = parts
        self._quiet = QLabel("No messages")
        self._quiet.setContentsMargins(8, 4, 8, 4)
        self._quiet.setEnabled(False)
        fill(QVBoxLayout(self._content), *parts, self._quiet, 1, spacing=1)
        self.setWidget(self._content)
        self.setWidgetResizable(True)
        self.setFrameShape(QFrame.Shape.NoFrame)
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        # two messages of one line, with the room around their words; one where the screen is low
        lines = 2 if self.screen().availableSize().height() >= _LOW_SCREEN else 1
        self.setFixedHeight(lines * (self.fontMetrics().height() + 16))

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
