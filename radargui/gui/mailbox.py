"""From any thread to the window's: calls that wait in a queue until a timer of the window makes them."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable
from typing import Any

from PySide6.QtCore import QObject, QTimer

LOOK_MS = 25


class Mailbox(QObject):
    """Calls posted by workers are made in the thread that made the mailbox, in order.

    No Qt signal crosses a thread: emitting one takes locks of Qt while it holds Python's, which can stop both threads
    for ever when the window deletes an object at that moment.
    """

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._owner = threading.get_ident()
        self._calls: queue.SimpleQueue[tuple[Callable[..., None], tuple[Any, ...]]] = queue.SimpleQueue()
        self._timer = QTimer(self)
        self._timer.setInterval(LOOK_MS)
        self._timer.timeout.connect(self.deliver)
        self._timer.start()

    @property
    def at_home(self) -> bool:
        """Whether this is the thread that calls are made in."""
        return threading.get_ident() == self._owner

    def post(self, call: Callable[..., None], *arguments: Any) -> None:
        """Let a call be made soon; from any thread."""
        self._calls.put((call, arguments))

    def deliver(self) -> None:
        """Make the calls that wait now."""
        for _ in range(self._calls.qsize()):
            try:
                call, arguments = self._calls.get_nowait()
            except queue.Empty:
                return
            call(*arguments)
