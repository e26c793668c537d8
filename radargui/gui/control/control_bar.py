"""What never moves: start, record, stop, how many runs, the state in large letters, disk, messages, the health line."""

from collections.abc import Sequence

from PySide6 import QtWidgets
from PySide6.QtCore import QEvent, QObject, QPoint, QRect, QRectF, QSize, Qt
from PySide6.QtGui import QAction, QColor, QFont, QFontMetrics, QFontMetricsF, QPainter, QPaintEvent, QPen, QWheelEvent

from radargui.acquisition.health import Health, duration
from radargui.acquisition.run_output import LOW_S
from radargui.gui.control.state import LARGE_WORDS, AppState
from radargui.gui.layout import ALARM, TIPS, OneLine, Scroll, fill, having, labelled, menu_button, ticking
from radargui.gui.theme import Colours, Theme, fitting_font, scaled_font, write
from radargui.model.rounding import UNKNOWN

_WORD, _DETAIL = 0.42, 0.5
"""Share of the width that the longest state takes, and size of what stands behind it: two lines beside one word."""
_BADGE = 0.75
"""Size of the badge beside what stands behind the word."""
_POINTS = (11.0, 34.0)
"""The most is read across a room of five metres: letters of 8 mm on a usual screen (chosen by hand). Below the least
nothing is read across a room; where the words do not fit their end is told by the tool tip."""


def draw_badge(painter: QPainter, box: QRectF, words: str, font: QFont, colours: Colours) -> float:
    """Draw framed words at the right end of a box; return what they take of its width."""
    if not words:
        return 0.0
    metrics = QFontMetricsF(font)
    width, height = metrics.horizontalAdvance(words) + metrics.height(), 1.4 * metrics.height()
    frame = QRectF(box.right() - width, box.center().y() - 0.5 * height, width, height)
    colour = colours.text if words.startswith("NI ") else colours.mark
    painter.setPen(QPen(QColor(colour), 1.5))
    painter.setBrush(Qt.BrushStyle.NoBrush)
    painter.drawRoundedRect(frame, 4, 4)
    write(painter, frame, words, colour, font=font)
    return width + metrics.height()


_WIDE = QtWidgets.QSizePolicy(QtWidgets.QSizePolicy.Policy.Fixed, QtWidgets.QSizePolicy.Policy.Fixed)


class StateView(QtWidgets.QWidget):
    """A word for the state and what belongs to it, in letters that stay as large as they are."""

    def __init__(self, theme: Theme) -> None:
        super().__init__()
        self._theme, self._word, self._detail, self._role = theme, AppState.IDLE.value, "", AppState.IDLE.role
        self.badge = ""
        self.setSizePolicy(QtWidgets.QSizePolicy.Policy.Expanding, QtWidgets.QSizePolicy.Policy.Fixed)
        self.setMinimumSize(160, 58)

    @property
    def text(self) -> str:
        """What is shown."""
        return f"{self._word}   {self._detail}" if self._detail else self._word

    def show_state(self, word: str, detail: str, role: str, badge: str = "") -> None:
        """Show the word of a state, one of `LARGE_WORDS`, and what belongs to it, in the colour of a `role`.

        The `badge` at the end says where it comes from.
        """
        shown = word, detail, role, badge
        if shown != (self._word, self._detail, self._role, self.badge):
            self._word, self._detail, self._role, self.badge = shown
            whole = "   ".join(filter(None, (self.text, badge)))
            having(self, accessibleName=whole, toolTip=whole).update()

    def sizeHint(self) -> QSize:  # noqa: N802 - Qt's name
        """Return a size that fits most states."""
        return QSize(480, 60)

    def paintEvent(self, _event: QPaintEvent) -> None:  # noqa: N802 - Qt's name
        """Draw the word on its colour, the detail behind it."""
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        colours = self._theme.colours
        colour = colours.role(self._role)
        frame = QRectF(self.rect()).adjusted(2, 4, -2, -4)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(QColor(colours.base))
        painter.drawRoundedRect(frame, 6, 6)
        painter.setBrush(QColor(colour))
        painter.drawRoundedRect(frame.adjusted(0, 0, 10 - frame.width(), 0), 4, 4)
        inside = frame.adjusted(24, 0, -12, 0)
        large, left = self.word_font(), int(Qt.AlignmentFlag.AlignVCenter | Qt.AlignmentFlag.AlignLeft)
        write(painter, inside, self._word, colour, left, large)
        rest = inside.adjusted(QFontMetricsF(large).horizontalAdvance(self._word + "  "), 0, 0, 0)
        small = scaled_font(large, _DETAIL)
        rest.setRight(rest.right() - draw_badge(painter, rest, self.badge, scaled_font(small, _BADGE), colours))
        lines = wrapped(self._detail, QFontMetrics(small), int(rest.width()), int(rest.height()))
        write(painter, rest, lines, colours.text, left, small)

    def word_font(self) -> QFont:
        """Return the letters of the state: as large as the place lets the longest one be, whatever is shown now."""
        longest = max(LARGE_WORDS, key=self.fontMetrics().horizontalAdvance)
        return fitting_font(self.font(), longest, _WORD * self.width(), self.height() - 8, _POINTS)


def wrapped(text: str, metrics: QFontMetrics, width: int, height: int) -> str:
    """Return a text in as many lines as there is room for; what does not fit is left out, and told by dots."""
    lines: list[str] = []
    most = max(1, height // metrics.height())
    # a driver tells an error in many lines, some of them empty
    text = " ".join(filter(None, map(str.strip, text.splitlines())))
    # a value and its uncertainty stay together
    for part in filter(None, text.replace(" ± ", "\u00a0±\u00a0").replace("   ", " · ").split(" ")):
        longer = f"{lines[-1]} {part}" if lines else part
        fits = metrics.horizontalAdvance(longer) <= width
        if not lines or (fits or len(lines) == most):
            lines[-1:] = [longer]
        else:
            lines.append(part)
    return "\n".join(metrics.elidedText(line, Qt.TextElideMode.ElideRight, width) for line in lines)


MAX_RUNS = 999
"""What is counted without a hand: more than a day of drops, one a minute and a half."""
_LOW_SCREEN = 560
"""Height below which every line is taken from the plots: 1920 x 1080 at scale 2 has 540."""


class Count(QtWidgets.QSpinBox):
    """A number that the wheel scrolls past, never changes."""

    def wheelEvent(self, event: QWheelEvent) -> None:  # noqa: N802 - Qt's name
        """Leave the wheel to what is around it."""
        event.ignore()


class ControlBar(QtWidgets.QWidget):
    """Large buttons for actions that the menu has as well."""

    def __init__(
        self, theme: Theme, tabs: QtWidgets.QTabBar, actions: Sequence[QAction], sounds: Sequence[QAction]
    ) -> None:
        super().__init__()
        count = Count(minimum=1, maximum=MAX_RUNS)
        self.runs = having(count, objectName="runs", accessibleName="Number of runs to record")
        self.runs.setToolTip("How many runs Record takes, one after the other without a hand")
        column = fill(QtWidgets.QVBoxLayout(), 1, labelled("Runs", self.runs), self.runs, 1, spacing=1)
        self.state, self.disk, self._sounds = StateView(theme), DiskLight(theme), sounds
        menu = QtWidgets.QMenu(self)
        menu.addActions(list(sounds))
        self.sound = having(menu_button("♪", menu), autoRaise=True, sizePolicy=_WIDE)
        self.buttons = [_button(action) for action in actions]
        lights = fill(QtWidgets.QVBoxLayout(), 1, self.sound, self.disk, 1, spacing=1)
        row = QtWidgets.QHBoxLayout(self)
        fill(row, tabs, *self.buttons, column, (self.state, 1), lights, margins=(6, 1, 6, 1), spacing=6)

    def show_sounds(self, words: str) -> None:
        """Show which sounds are on, in words and by a stroke through the sign where none is."""
        off = not any(one.isChecked() for one in self._sounds)
        font = having(scaled_font(QtWidgets.QApplication.font(), 1.3), strikeOut=off)
        having(self.sound, font=font, toolTip=words, accessibleName=words)


_DISK_LOW_S = 7200.0
"""Of recording are left: less than an afternoon (chosen by hand)."""


class DiskLight(QtWidgets.QWidget):
    """A traffic light of the disk that is recorded to, and the room on it."""

    def __init__(self, theme: Theme) -> None:
        super().__init__()
        self._theme, self.role, self.text = theme, "idle", UNKNOWN
        self.setSizePolicy(_WIDE)
        theme.changed.connect(self.update)
        self.show_room(None, None)

    def sizeHint(self) -> QSize:  # noqa: N802 - Qt's name
        """Return room for the light and the longest words."""
        metrics = self.fontMetrics()
        return QSize(metrics.horizontalAdvance("8888 GB") + metrics.height(), metrics.height() + 4)

    def show_room(self, free_bytes: float | None, left_s: float | None) -> None:
        """Show how much is free, and how long a recording could last; None: not known."""
        self.text = UNKNOWN if free_bytes is None else f"{free_bytes / 1e9:.0f} GB"
        left = "" if left_s is None else f", {duration(left_s)} of recording"
        self.role = "idle" if left_s is None else "good" if left_s > _DISK_LOW_S else "mark"
        if left_s is not None and left_s < LOW_S:
            self.role, self.text = "alarm", duration(left_s)
        words = f"Disk: {'not known' if free_bytes is None else f'{free_bytes / 1e9:.1f} GB free'}{left}"
        having(self, toolTip=words, accessibleName=words).update()

    def paintEvent(self, _event: QPaintEvent) -> None:  # noqa: N802 - Qt's name
        """Draw the light, the words behind it; what is bad is no circle."""
        painter, colours, line = QPainter(self), self._theme.colours, self.fontMetrics().height()
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(QColor(colours.role(self.role)))
        lamp = QRectF(2.0, 0.5 * self.height() - 0.35 * line, 0.7 * line, 0.7 * line)
        painter.drawRect(lamp) if self.role == "alarm" else painter.drawEllipse(lamp)
        left = int(Qt.AlignmentFlag.AlignVCenter | Qt.AlignmentFlag.AlignLeft)
        write(painter, QRectF(self.rect()).adjusted(line, 0.0, 0.0, 0.0), self.text, colours.text, left)


_MOVES = (
    QEvent.Type.LayoutRequest,
    QEvent.Type.Resize,
    QEvent.Type.Move,
    QEvent.Type.Show,
    QEvent.Type.Hide,
    QEvent.Type.ShowToParent,
    QEvent.Type.HideToParent,
)
"""After which messages may need another place: they came or went, or what is beneath moved."""


_OF_WORDS = (
    QtWidgets.QAbstractButton,
    QtWidgets.QAbstractItemView,
    QtWidgets.QTextEdit,
    QtWidgets.QPlainTextEdit,
)


class MessagePlace(Scroll):
    """Messages, offers and progress over the top of a plot: nothing moves, and empty they take no room.

    Where buttons or lines of a table stand at the top they lie over the foot.

    Parameters
    ----------
    before
        After which Tab enters them.
    under
        What they lie over where none of the plots is wide enough for them.
    plots
        They lie over the one that is seen: over no field, no list, no button.
    """

    def __init__(
        self,
        before: QtWidgets.QWidget,
        under: QtWidgets.QWidget,
        plots: Sequence[QtWidgets.QWidget],
        *parts: QtWidgets.QWidget,
    ) -> None:
        # looked at as soon as there is something to scroll
        self._before, self._under, self._plots, self._parts, self._most = before, under, plots, parts, 0
        self._column = fill(QtWidgets.QVBoxLayout(), *parts, 1, spacing=1)
        super().__init__(having(QtWidgets.QWidget(), layout=self._column))
        having(self, parent=under.parentWidget(), autoFillBackground=True)
        # three lines of messages, with the room around their words; one where the screen is low
        lines = 3 if self.screen().availableSize().height() >= _LOW_SCREEN else 1
        self._most = lines * (self.fontMetrics().height() + 16)
        for one in (under, *plots, *parts):
            one.installEventFilter(self)
        self._soon = ticking(self, 0, self._lie_over, once=True)
        self.hide()

    def look(self) -> None:
        """Look anew what they lie over, once that stands where it will."""
        self._soon.start()

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802 - Qt's name
        """Show what came on top, and let Tab enter it from the bar above."""
        if event.type() in _MOVES:
            self._lie_over()
        if watched is self.content and event.type() == QEvent.Type.LayoutRequest:
            self.verticalScrollBar().setValue(0)
            before = self._before
            for one in self.content.findChildren(QtWidgets.QWidget):
                if one.focusPolicy() & Qt.FocusPolicy.TabFocus:
                    QtWidgets.QWidget.setTabOrder(before, one)
                    before = one
        return super().eventFilter(watched, event)

    def _lie_over(self) -> None:
        """Be as wide as what is beneath, and as high as the words need."""
        self.setVisible(not all(part.isHidden() for part in self._parts))
        holder, column = self._under.parentWidget() or self._under, self._column
        # a panel that is torn off is no longer within the window
        seen = (one for one in self._plots if one.isVisible() and holder.isAncestorOf(one))
        under = next((one for one in seen if one.width() >= column.minimumSize().width()), self._under)
        wide, corner = under.width(), under.mapTo(holder, QPoint())
        needs = column.heightForWidth(wide) if column.hasHeightForWidth() else column.sizeHint().height()
        high = min(needs, self._most)
        down = under.height() - high if under in self._plots and _holds_words(under, QRect(0, 0, wide, high)) else 0
        self.setGeometry(corner.x(), corner.y() + down, wide, high)
        self.raise_()


def _holds_words(under: QtWidgets.QWidget, room: QRect) -> bool:
    """Return whether a button or a part of a table or text is seen in a room within a widget."""
    return any(
        one.isVisible() and room.intersects(QRect(one.mapTo(under, QPoint()), one.size()))
        for kind in _OF_WORDS
        for one in under.findChildren(kind)
    )


def _button(action: QAction) -> QtWidgets.QToolButton:
    button = QtWidgets.QToolButton(toolButtonStyle=Qt.ToolButtonStyle.ToolButtonTextOnly)
    button.setSizePolicy(QtWidgets.QSizePolicy.Policy.Fixed, QtWidgets.QSizePolicy.Policy.Preferred)
    font = scaled_font(button.font(), 1.25, bold=True)
    return having(button, defaultAction=action, font=font, minimumSize=QSize(92, 50))


class HealthLine(QtWidgets.QWidget):
    """One label a figure."""

    def __init__(self) -> None:
        super().__init__()
        selectable = Qt.TextInteractionFlag.TextSelectableByMouse
        self.labels = {
            name: having(QtWidgets.QLabel(textInteractionFlags=selectable), toolTip=tip)
            for name, tip in TIPS["health"].items()
        }
        # never makes the window wider
        self.run = having(OneLine(), toolTip="How the last run was recorded")
        fill(QtWidgets.QHBoxLayout(self), *self.labels.values(), (self.run, 1), margins=(6, 0, 6, 0), spacing=18)
        self.show_health(None)

    def show_health(self, health: Health | None) -> None:
        """Show a snapshot; None: nothing runs."""
        figures = health.figures if health is not None else {}
        for name, label in self.labels.items():
            words, bad = figures.get(name, ("", False))
            # what the last run says has the room that figures took
            having(label, text=words, visible=health is not None)
            style = ALARM if bad else ""
            if label.styleSheet() != style:
                label.setStyleSheet(style)
            # figures that get longer and shorter would push the others to and fro
            label.setMinimumWidth(max(label.minimumWidth(), label.sizeHint().width()))

    def show_run(self, text: str) -> None:
        """Show how the last run was recorded."""
        having(self.run, text=text, toolTip=f"How the last run was recorded. {text}".strip())
