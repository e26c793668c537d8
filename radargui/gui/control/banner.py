"""The state in letters that are read across the room; beside it of which run, how far, what is known of the others."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from PySide6.QtCore import QObject, QSize, Qt
from PySide6.QtGui import QColor, QFont, QFontMetricsF, QPainter, QPaintEvent
from PySide6.QtWidgets import QSizePolicy, QWidget

from radargui.gui.control.app_state import AppState
from radargui.gui.control.run_control import RunControl
from radargui.gui.control.waiting import StoppingStrip
from radargui.gui.notices import NoticeBoard, NoticeStrip
from radargui.gui.theme import Theme

_MOST_POINTS = 34.0
"""Read across a room of five metres: letters of 8 mm on a usual screen (chosen by hand)."""
_LEAST_POINTS = 11.0
"""Where even these are too large the end is cut, and told by the tool tip."""

_ROLES = {
    AppState.DONE: "good",
    AppState.RECORDING: "alarm",
    AppState.FAILED: "alarm",
    AppState.ARMED: "mark",
    AppState.IDLE: "idle",
}
"""Colours of the states; all others are busy."""


@dataclass(frozen=True, slots=True)
class RunWords:
    """What the armed or recorded run is called, what the one that is computed, and what is new of the others."""

    coming: str
    computed: str
    news: str


def detail_of(control: RunControl, words: RunWords, failure: str) -> str:
    """Return what belongs to the present state.

    Parameters
    ----------
    control
        What is being done.
    words
        What the runs are called.
    failure
        Where the reason of a failure is to be read, or the reason itself.
    """
    of = f" ({control.run_number} of {control.n_runs})" if control.n_runs > 1 else ""
    news = f"   {words.news}" if words.news else ""
    match control.state:
        case AppState.DONE:
            return f"{control.kept} drops{news}" if control.kept > 1 else words.news
        case AppState.ARMED:
            return f"{words.coming}{of}, waiting for {control.waits_for or 'motion'}{news}"
        case AppState.RECORDING:
            return f"{words.coming}{of}, {control.recorded_s:.1f} s{news}"
        case AppState.SETTLING:
            return f"{words.coming}{of}, waiting until nothing moves{news}"
        case AppState.PROCESSING:
            waiting = f", {len(control.backlog) - 1} more wait" if len(control.backlog) > 1 else ""
            return f"{words.computed} {100.0 * control.progress:.0f} %{waiting}{news}".strip()
        case AppState.FAILED:
            return failure
        case _:
            return ""


class Banner(QObject):
    """Keeps the state view and the strip of what is waited for up to date.

    Parameters
    ----------
    control
        What is being done.
    view, stopping
        Where it is said.
    board, strip
        Where the reason of a failure is said, until it is dismissed there.
    words
        Returns what the runs are called.
    """

    def __init__(
        self,
        control: RunControl,
        view: StateView,
        stopping: StoppingStrip,
        board: NoticeBoard,
        strip: NoticeStrip,
        words: Callable[[], RunWords],
    ) -> None:
        # the board may outlive the window: what is deleted with the view hears no more of it
        super().__init__(view)
        self._control, self._view, self._stopping = control, view, stopping
        self._board, self._strip, self._words = board, strip, words
        self._failure = ""
        control.failed.connect(self._fail)
        board.changed.connect(self.look)

    def look(self) -> None:
        """Say what is being done now."""
        words = self._words()
        # where the reason was dismissed it stands here
        failure = "see the message below" if self._failure in self._strip.texts() else self._failure
        self._view.show_state(self._control.state, detail_of(self._control, words, failure))
        self._stopping.look(words.computed)

    def _fail(self, error: BaseException) -> None:
        self._board.post_error(error)
        # the newest error stands first
        self._failure = self._board.notices[0].text
        self.look()


class StateView(QWidget):
    """A word for the state and what belongs to it, as large as fits."""

    def __init__(self, theme: Theme) -> None:
        super().__init__()
        self._theme = theme
        self._state = AppState.IDLE
        self._detail = ""
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        self.setMinimumHeight(58)
        self.setMinimumWidth(160)
        theme.changed.connect(self.update)

    @property
    def text(self) -> str:
        """What is shown."""
        return f"{self._state.value}   {self._detail}" if self._detail else self._state.value

    def show_state(self, state: AppState, detail: str = "") -> None:
        """Show a state and what belongs to it."""
        if (state, detail) != (self._state, self._detail):
            self._state, self._detail = state, detail
            self.setAccessibleName(self.text)
            self.setToolTip(self.text)
            self.update()

    def sizeHint(self) -> QSize:  # noqa: N802 - Qt's name
        """Return a size that fits most states."""
        return QSize(480, 60)

    def paintEvent(self, _event: QPaintEvent) -> None:  # noqa: N802 - Qt's name
        """Draw the word on its colour, the detail behind it."""
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        colours = self._theme.colours
        colour = QColor(colours.role(_ROLES.get(self._state, "busy")))
        frame = self.rect().adjusted(2, 4, -2, -4)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(QColor(colours.base))
        painter.drawRoundedRect(frame, 6, 6)
        painter.setBrush(colour)
        painter.drawRoundedRect(frame.adjusted(0, 0, 10 - frame.width(), 0), 4, 4)
        inside = frame.adjusted(24, 0, -12, 0)
        painter.setFont(self._fitting(inside.width(), inside.height()))
        painter.setPen(colour)
        painter.drawText(inside, Qt.AlignmentFlag.AlignVCenter | Qt.AlignmentFlag.AlignLeft, self._state.value)
        if self._detail:
            word = QFontMetricsF(painter.font()).horizontalAdvance(self._state.value + "  ")
            painter.setPen(QColor(colours.text))
            font = painter.font()
            font.setBold(False)
            painter.setFont(font)
            rest = inside.adjusted(int(word), 0, 0, 0)
            shown = painter.fontMetrics().elidedText(self._detail, Qt.TextElideMode.ElideRight, rest.width())
            painter.drawText(rest, Qt.AlignmentFlag.AlignVCenter | Qt.AlignmentFlag.AlignLeft, shown)
        painter.end()

    def _fitting(self, width: int, height: int) -> QFont:
        font = QFont(self.font())
        font.setBold(True)
        points = _MOST_POINTS
        while points > _LEAST_POINTS:
            font.setPointSizeF(points)
            metrics = QFontMetricsF(font)
            if metrics.horizontalAdvance(self.text) <= width and metrics.height() <= height:
                break
            points -= 1.0
        return font
