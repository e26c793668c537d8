"""Errors and messages to the operator, all in one place: kept, deduplicated, from any thread; and their strip."""

from __future__ import annotations

import logging
import sys
import threading
import traceback
import warnings
from dataclasses import dataclass, replace
from types import TracebackType
from typing import Any, Literal

from PySide6.QtCore import QMessageLogContext, QObject, Qt, QTimer, QtMsgType, Signal, qInstallMessageHandler
from PySide6.QtGui import QGuiApplication
from PySide6.QtWidgets import QVBoxLayout, QWidget

from radargui.gui.background import Mailbox
from radargui.gui.layout import Edge, Strip, button, fill, follow, take_out, ticking
from radargui.gui.setup_words import field_in, in_words
from radargui.model.errors import RadarGuiError

Level = Literal["error", "warning", "info"]
_WORDS: dict[Level, str] = {"error": "Error", "warning": "Warning", "info": "Note"}
"""The worst first."""
_EDGES: dict[Level, Edge] = {"error": "bright-text", "warning": "link-visited", "info": "link"}
_MOST = 50
"""Kept (chosen by hand): more than anybody scrolls through; the least grave and oldest go first."""
_EACH_SHOWN = 4
"""Times that the same is told as it comes; then only at each doubling of the count, and when it is over."""
_CALM_MS = 500
"""A storm is over after so long without another one (chosen by hand)."""
_INFO_MS = 20_000
"""What is only good to know goes away by itself; errors and warnings stay."""
_MAX_LOGGED = 1000
"""Different texts of libraries that are kept apart in the log (chosen by hand: a storm would fill it otherwise)."""
_DRIVER = "nidaqmx"
_LEVELS = {
    QtMsgType.QtDebugMsg: logging.DEBUG,
    QtMsgType.QtInfoMsg: logging.INFO,
    QtMsgType.QtCriticalMsg: logging.ERROR,
    QtMsgType.QtFatalMsg: logging.CRITICAL,
}
_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Notice:
    """One message; `count` says how often it came, or how many of its topic came: then `text` is the newest of them.

    `key` is that of the setup's value that it names first, whose field is a click away; empty where it names none.
    """

    level: Level
    text: str
    count: int = 1
    details: str = ""
    topic: str = ""
    key: str = ""

    def is_one_with(self, other: Notice) -> bool:
        """Return whether both are shown as one."""
        same = self.topic == other.topic if self.topic else self.text == other.text
        return self.level == other.level and same


class NoticeBoard(QObject):
    """Collects notices, the worst first and of those the newest; `changed` comes in the window's thread.

    `post` may be called from any thread. A full board lets go of the oldest of the least of them.
    """

    changed = Signal()

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.notices: tuple[Notice, ...] = ()
        self._soon = ticking(self, _CALM_MS, self.changed, once=True)
        self._mailbox = Mailbox(self)

    def post(self, level: Level, text: str, details: str = "", *, topic: str = "") -> None:
        """Show a message; those of one topic are shown as one, with their number."""
        self._mailbox.now_or_soon(self._receive, Notice(level, text, 1, details, topic))

    def post_of_setup(self, level: Level, text: str, *, topic: str = "") -> None:
        """Show what another part of the program says: it knows the setup file's keys, the window names and fields."""
        self._mailbox.now_or_soon(self._receive, Notice(level, in_words(text), 1, "", topic, field_in(text)))

    def post_once(self, level: Level, text: str) -> None:
        """Show a message that comes repeatedly, without counting."""
        if not any((old.level, old.text) == (level, text) for old in self.notices):
            self.post(level, text)

    def post_error(self, error: BaseException) -> None:
        """Show an error; one that is not ours is named as unexpected and logged with its traceback."""
        if isinstance(error, RadarGuiError):
            # of a device it says which value to set
            self.post_of_setup("error", str(error))
            return
        details = "".join(traceback.format_exception(error))
        text = (
            f"Unexpected error: {type(error).__name__}: {error} "
            "This is a fault of the program; what was recorded is kept. Please report it with the details."
        )
        # a fault of the timer comes thirty times a second: once is enough in the log
        if not any(notice.text == text for notice in self.notices):
            _log.error("unexpected error\n%s", details)
        self.post("error", text, details)

    def _receive(self, notice: Notice) -> None:
        same = next((old for old in self.notices if notice.is_one_with(old)), None)
        if same is not None:
            notice = replace(notice, count=same.count + 1)
        others = (old for old in self.notices if old is not same)
        # sorting keeps the order of equals: the newest of a level comes first
        self.notices = tuple(sorted((notice, *others), key=lambda one: list(_WORDS).index(one.level)))[:_MOST]
        if notice.count > _EACH_SHOWN and notice.count & (notice.count - 1):
            # a storm of the same must not redraw the strip under the operator's hand: its end is told
            self._soon.start()
            return
        self.changed.emit()
        if notice.level == "info":
            QTimer.singleShot(_INFO_MS, self, lambda: self.dismiss(notice))

    def dismiss(self, notice: Notice) -> None:
        """Take one notice away."""
        self.notices = tuple(old for old in self.notices if not notice.is_one_with(old))
        self.changed.emit()

    def clear(self) -> None:
        """Take all notices away."""
        self.notices = ()
        self.changed.emit()


class Hooks:
    """Leads what nobody caught to the board and the log; `remove` gives the old hooks back.

    Exceptions of any thread come to the board. Warnings of libraries and messages of Qt come to the log, each text
    once; to the board come those that the operator can do something about: what the driver of a device warns of, and
    what Qt calls critical.
    """

    def __init__(self, board: NoticeBoard) -> None:
        self._board = board
        self._logged: set[str] = set()
        self._old = (sys.excepthook, threading.excepthook, warnings.showwarning)
        sys.excepthook = self._of_main
        threading.excepthook = self._of_thread
        warnings.showwarning = self._of_library
        self._old_of_qt = qInstallMessageHandler(self._of_qt)

    def _of_main(self, kind: type[BaseException], error: BaseException, trace: TracebackType | None) -> None:
        self._old[0](kind, error, trace) if issubclass(kind, KeyboardInterrupt) else self._board.post_error(error)

    def _of_thread(self, arguments: threading.ExceptHookArgs) -> None:
        if arguments.exc_value is not None and not issubclass(arguments.exc_type, SystemExit):
            self._board.post_error(arguments.exc_value)

    def _of_library(
        self, message: Warning | str, category: type[Warning], filename: str, lineno: int, *_more: Any, **_named: Any
    ) -> None:
        text = " ".join(str(message).split())
        if self._is_new(f"{category.__name__}: {text}"):
            _log.warning("%s:%d: %s: %s", filename, lineno, category.__name__, text)
        if category.__module__.partition(".")[0] == _DRIVER:
            self._board.post_once("warning", f"The driver of the device warns: {text}")

    def _of_qt(self, kind: QtMsgType, context: QMessageLogContext, message: str) -> None:
        if self._is_new(message):
            _log.log(_LEVELS.get(kind, logging.WARNING), "Qt, %s: %s", context.category, message)
        if kind in (QtMsgType.QtCriticalMsg, QtMsgType.QtFatalMsg):
            self._board.post_once("error", f"The window's library reports: {message}")

    def _is_new(self, text: str) -> bool:
        """Return whether a text was not logged yet; of very many different ones the rest is dropped."""
        new = text not in self._logged and len(self._logged) < _MAX_LOGGED
        if new:
            self._logged.add(text)
        return new

    def remove(self) -> None:
        """Put the hooks that were there before back."""
        sys.excepthook, threading.excepthook, warnings.showwarning = self._old
        qInstallMessageHandler(self._old_of_qt)


_SHOWN = 3
"""Messages at a time; their place holds two of one line each, the third is scrolled to (chosen by hand)."""


class NoticeStrip(QWidget):
    """The worst notices, each with a word for its level, its whole text and a way to dismiss it."""

    field_asked = Signal(str)
    """The key of the value whose field is to be shown."""

    def __init__(self, board: NoticeBoard) -> None:
        super().__init__()
        self._board = board
        self._rows = fill(QVBoxLayout(self), spacing=1)
        follow(board.changed, self.refresh)

    def texts(self) -> tuple[str, ...]:
        """Return what is shown, the worst first."""
        return tuple(notice.text for notice in self._board.notices[:_SHOWN])

    def refresh(self) -> None:
        """Draw the notices anew."""
        take_out(self._rows, *self.findChildren(QWidget, options=Qt.FindChildOption.FindDirectChildrenOnly))
        for notice in self._board.notices[:_SHOWN]:
            self._rows.addWidget(row := self._row(notice))
            row.show()
        hidden = len(self._board.notices) - _SHOWN
        if hidden > 0:
            clear = button(f"{hidden} more, none of them worse: dismiss all", self._board.clear)
            self._rows.addWidget(clear, alignment=Qt.AlignmentFlag.AlignRight)
        self.setVisible(bool(self._board.notices))

    def _row(self, notice: Notice) -> Strip:
        whole = "\n".join(filter(None, (notice.text, notice.details)))
        copy = button("Copy", lambda: QGuiApplication.clipboard().setText(whole))
        there = [button("Go there", lambda: self.field_asked.emit(notice.key))] if notice.key else []
        row = Strip(_EDGES[notice.level], *there, copy, button("Dismiss", lambda: self._board.dismiss(notice)))
        times = f" ({notice.count} times)" if notice.count > 1 else ""
        # a driver tells an error in many lines, some of them empty; the whole as it came is copied
        row.words.setText(f"{_WORDS[notice.level]}{times}: {' '.join(notice.text.split())}")
        row.words.setTextInteractionFlags(
            Qt.TextInteractionFlag.TextSelectableByMouse | Qt.TextInteractionFlag.TextSelectableByKeyboard
        )
        return row
