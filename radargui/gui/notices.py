"""The one road of errors and messages to the operator: kept, deduplicated, from any thread."""

from __future__ import annotations

import logging
import sys
import threading
import traceback
from dataclasses import dataclass, replace
from types import TracebackType
from typing import Literal

from PySide6.QtCore import QObject, Qt, Signal, Slot

from radargui.model.errors import RadarGuiError

Level = Literal["error", "warning", "info"]
_MOST = 50
_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Notice:
    """One message; `count` says how often it came."""

    level: Level
    text: str
    count: int = 1
    details: str = ""


class NoticeBoard(QObject):
    """Collects notices; `post` may be called from any thread, `changed` comes in the window's thread."""

    changed = Signal()
    _posted = Signal(object)

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.notices: tuple[Notice, ...] = ()
        self._posted.connect(self._receive, Qt.ConnectionType.AutoConnection)

    def post(self, level: Level, text: str, details: str = "") -> None:
        """Show a message."""
        self._posted.emit(Notice(level, text, 1, details))

    def post_once(self, level: Level, text: str) -> None:
        """Show a message that is told again and again, without counting."""
        if not any((old.level, old.text) == (level, text) for old in self.notices):
            self.post(level, text)

    def post_error(self, error: BaseException) -> None:
        """Show an error; one that is not ours is named as unexpected and logged with its traceback."""
        if isinstance(error, RadarGuiError):
            self.post("error", str(error))
            return
        details = "".join(traceback.format_exception(error))
        _log.error("unexpected error\n%s", details)
        self.post(
            "error",
            f"Unexpected error: {type(error).__name__}: {error} "
            "This is a fault of the program; what was recorded is kept. Please report it with the details.",
            details,
        )

    @Slot(object)
    def _receive(self, notice: Notice) -> None:
        same = next((old for old in self.notices if (old.level, old.text) == (notice.level, notice.text)), None)
        if same is not None:
            notice = replace(notice, count=same.count + 1)
        others = tuple(old for old in self.notices if old is not same)
        self.notices = (*others, notice)[-_MOST:]
        self.changed.emit()

    def dismiss(self, notice: Notice) -> None:
        """Take one notice away."""
        self.notices = tuple(old for old in self.notices if (old.level, old.text) != (notice.level, notice.text))
        self.changed.emit()

    def clear(self) -> None:
        """Take all notices away."""
        self.notices = ()
        self.changed.emit()


class Hooks:
    """Leads exceptions that nobody caught, of any thread, to the board; `remove` gives the old hooks back."""

    def __init__(self, board: NoticeBoard) -> None:
        self._board = board
        self._old = (sys.excepthook, threading.excepthook)
        sys.excepthook = self._of_main
        threading.excepthook = self._of_thread

    def _of_main(self, kind: type[BaseException], error: BaseException, trace: TracebackType | None) -> None:
        if issubclass(kind, KeyboardInterrupt):
            self._old[0](kind, error, trace)
            return
        self._board.post_error(error)

    def _of_thread(self, arguments: threading.ExceptHookArgs) -> None:
        if arguments.exc_value is not None and not issubclass(arguments.exc_type, SystemExit):
            self._board.post_error(arguments.exc_value)

    def remove(self) -> None:
        """Put the hooks that were there before back."""
        sys.excepthook, threading.excepthook = self._old
