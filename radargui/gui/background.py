"""Work off the window's thread: a report, a search for devices, the loading of a run."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

from PySide6.QtCore import QObject

from radargui.gui.mailbox import Mailbox

Work = Callable[[], Any]
Then = Callable[[Any], None]


class Jobs(QObject):
    """Runs functions on threads of their own; the callbacks come in the window's thread."""

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._threads: dict[threading.Thread, str] = {}
        self._mailbox = Mailbox(self)

    @property
    def running(self) -> tuple[str, ...]:
        """What is being worked on, in words."""
        return tuple(self._threads.values())

    def start(self, what: str, work: Work, then: Then, otherwise: Callable[[BaseException], None]) -> None:
        """Run `work`; afterwards `then(result)` or `otherwise(error)`."""

        def run() -> None:
            callback: Callable[[Any], None] = then
            try:
                value: Any = work()
            except Exception as error:  # noqa: BLE001 - led to the operator by `otherwise`
                callback, value = otherwise, error
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
