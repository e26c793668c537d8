"""Work off the window's thread, a report, a search for devices, the loading of a run; and the way back to it."""

import queue
import threading
from collections.abc import Callable
from typing import Any

from PySide6.QtCore import QObject, QTimer

Work = Callable[[], Any]
Then = Callable[[Any], None]
LOOK_MS = 25
"""Calls wait so long at most: less than a frame of the window, nothing that a hand notices."""


class Mailbox(QObject):
    """Calls posted by workers are made in the thread that made the mailbox, in order.

    No Qt signal crosses a thread: emitting one takes locks of Qt while it holds Python's, which can stop both threads
    for ever when the window deletes an object at that moment.
    """

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._owner = threading.get_ident()
        self._calls: queue.SimpleQueue[tuple[Callable[..., None], tuple[Any, ...]]] = queue.SimpleQueue()
        self._timer = QTimer(self, interval=LOOK_MS)
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


class Jobs(QObject):
    """Runs functions on threads of their own; the callbacks come in the window's thread.

    Parameters
    ----------
    show_error
        Takes the errors of work that nobody else looks after.
    """

    def __init__(self, show_error: Callable[[BaseException], None], parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.show_error = show_error
        self._threads: dict[threading.Thread, str] = {}
        self._mailbox = Mailbox(self)

    @property
    def running(self) -> tuple[str, ...]:
        """What is being worked on, in words."""
        return tuple(self._threads.values())

    def start(
        self,
        what: str,
        work: Work,
        then: Then = lambda _result: None,
        otherwise: Callable[[BaseException], None] | None = None,
    ) -> None:
        """Run `work`; afterwards `then(result)` or `otherwise(error)`, where left out it is shown to the operator."""

        def run() -> None:
            callback: Callable[[Any], None] = then
            try:
                value: Any = work()
            except Exception as error:  # noqa: BLE001 - led to the operator by `otherwise`
                callback, value = otherwise or self.show_error, error
            self._mailbox.post(self._deliver, thread, callback, value)

        thread = threading.Thread(target=run, name=f"gui {what}", daemon=True)
        self._threads[thread] = what
        thread.start()

    def report(self, call: Then, value: Any) -> None:
        """Let `call(value)` be made in the window's thread, ahead of the end of the work that reports it."""
        self._mailbox.post(call, value)

    def _deliver(self, thread: threading.Thread, callback: Callable[[Any], None], value: Any) -> None:
        thread.join()
        self._threads.pop(thread, None)
        callback(value)
