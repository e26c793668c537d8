"""The one road of errors and messages to the operator: kept, deduplicated, from any thread."""

from __future__ import annotations

import logging
import sys
import threading
import traceback
from dataclasses import dataclass, replace
from types import TracebackType
from typing import Literal

from PySide6.QtCore import QObject, QTimer, Signal

from radargui.gui.mailbox import Mailbox
from radargui.model.errors import RadarGuiError

Level = Literal["error", "warning", "info"]
_MOST = 50
_EACH_SHOWN = 4
_INFO_MS = 20_000
"""What is only good to know goes away by itself; errors and warnings stay."""
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

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.notices: tuple[Notice, ...] = ()
        self._mailbox = Mailbox(self)

    def post(self, level: Level, text: str, details: str = "") -> None:
        """Show a message."""
        notice = Notice(level, text, 1, details)
        if self._mailbox.at_home:
            self._receive(notice)
        else:
            self._mailbox.post(self._receive, notice)

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
        text = (
            f"Unexpected error: {type(error).__name__}: {error} "
            "This is a fault of the program; what was recorded is kept. Please report it with the details."
        )
        # a fault of the timer comes thirty times a second: once is enough in the log
        if not any(notice.text == text for notice in self.notices):
            _log.error("unexpected error\n%s", details)
        self.post("error", text, details)

    def _receive(self, notice: Notice) -> None:
        same = next((old for old in self.notices if (old.level, old.text) == (notice.level, notice.text)), None)
        if same is not None:
            notice = replace(notice, count=same.count + 1)
        others = tuple(old for old in self.notices if old is not same)
        self.notices = (*others, notice)[-_MOST:]
        if notice.count > _EACH_SHOWN and notice.count & (notice.count - 1):
            # a storm of the same must not redraw the strip under the operator's hand
            return
        self.changed.emit()
        if notice.level == "info":
            QTimer.singleShot(_INFO_MS, self, lambda: self.dismiss(notice))

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
