"""Work off the window's thread and the way back to it; long work with a bar and a button that cancels it."""

import sys
import threading
import weakref
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from functools import partial
from typing import Any

from PySide6.QtCore import QObject
from PySide6.QtWidgets import QHBoxLayout, QLabel, QProgressBar, QVBoxLayout, QWidget

from radargui.gui.layout import button, fill, having, take_out, ticking
from radargui.model.errors import CancelledError

Work = Callable[[], Any]
Then = Callable[[Any], None]
Otherwise = Callable[[BaseException], None] | None
Wanted = Callable[[], bool]
StartWork = Callable[..., object]
"""What starts work, see `Jobs.start`."""
LOOK_MS = 25
"""Calls wait so long at most: less than a frame of the window, nothing that a hand notices."""
TURN_S = 0.001
"""A thread that computes is asked so soon to hand Python's lock on. To draw one picture Qt asks Python dozens of times,
and each time may wait so long: with Python's own 5 ms for tenths of a second. Windows counts whole milliseconds."""


_MAX_AT_ONCE = 32
"""Work that is under way together; more waits for one of them. Nobody starts so much by hand."""


class Mailbox(QObject):
    """Calls posted by workers are made in the thread that made the mailbox, in order.

    No Qt signal crosses a thread: emitting one takes locks of Qt while it holds Python's, which can stop both threads
    for ever when the window deletes an object at that moment.
    """

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._owner = threading.get_ident()
        self._calls: deque[Callable[[], None]] = deque()
        ticking(self, LOOK_MS, self.deliver).start()

    def post(self, call: Callable[..., None], *arguments: Any) -> None:
        """Let a call be made soon; from any thread."""
        self._calls.append(partial(call, *arguments))

    def now_or_soon(self, call: Callable[..., None], *arguments: Any) -> None:
        """Make a call at once where this is the thread that calls are made in, else let it be made soon."""
        call(*arguments) if threading.get_ident() == self._owner else self.post(call, *arguments)

    def deliver(self) -> None:
        """Make the calls that wait now."""
        for _ in range(len(self._calls)):
            # a call that lets the window's events run, as a question does, has others delivered meanwhile
            if self._calls:
                self._calls.popleft()()


class Jobs(Mailbox):
    """Runs functions on threads of their own; the callbacks come in the window's thread, which has its turn soon.

    Threads that have ended their work wait for the next: on a busy computer a new one takes 10 ms until it runs, and so
    long it holds up who starts it.

    Parameters
    ----------
    show_error
        Takes the errors of work that nobody else looks after.
    """

    def __init__(self, show_error: Callable[[BaseException], None], parent: QObject | None = None) -> None:
        super().__init__(parent)
        sys.setswitchinterval(TURN_S)
        self.show_error = show_error
        self._pool = ThreadPoolExecutor(_MAX_AT_ONCE)
        self._running: dict[object, str] = {}

    @property
    def running(self) -> tuple[str, ...]:
        """What is being worked on, in words."""
        return tuple(self._running.values())

    def start(
        self,
        what: str,
        work: Work,
        then: Then = lambda _result: None,
        otherwise: Otherwise = None,
        wanted: Wanted = lambda: True,
    ) -> Future[None]:
        """Run `work`; afterwards `then(result)` or `otherwise(error)`, where left out it is shown to the operator.

        What is not `wanted` any more when the work has ended, because something else was chosen, is dropped. Other work
        may wait for the end of what was started before it: that is what is returned, without the result.
        """
        ticket = object()

        def run() -> None:
            callback: Callable[[Any], None] = then
            try:
                value: Any = work()
            except Exception as error:  # noqa: BLE001 - led to the operator by `otherwise`
                callback, value = otherwise or self.show_error, error
            self.post(ended, callback, value)

        def ended(callback: Then, value: Any) -> None:
            del self._running[ticket]
            if wanted():
                callback(value)

        self._running[ticket] = what
        return self._pool.submit(run)

    def rest(self) -> None:
        """Let the threads go that wait for work; one that works goes when it has ended."""
        self._pool.shutdown(wait=False)
        self._pool = ThreadPoolExecutor(_MAX_AT_ONCE)


class OneAtATime:
    """Reads in the background what may change meanwhile: one reading at a time, the next where it was asked for since.

    Parameters
    ----------
    again
        Asks anew, with what holds by then.
    """

    def __init__(self, jobs: Jobs, what: str, again: Callable[[], None]) -> None:
        self._jobs, self._what, self._again = jobs, what, again
        self.busy = self._is_outdated = False

    def start(self, work: Work, then: Then, otherwise: Callable[[BaseException], None]) -> None:
        """Run `work` as `Jobs.start` does, or note that what is being read is out of date."""
        self._is_outdated = self.busy
        if self.busy:
            return
        self.busy = True

        def ended(follows: Then, value: Any) -> None:
            self.busy = False
            # the fault of what nobody wants any more is none; what is wanted now says its own
            self._again() if self._is_outdated else follows(value)

        self._jobs.start(self._what, work, partial(ended, then), partial(ended, otherwise))

    def outdate(self) -> None:
        """Drop what is being read: it is not wanted any more, and nothing else can be read now."""
        self._is_outdated = self.busy


_LOOK_MS = 100
"""Chosen by hand: a bar that moves less often goes in jerks."""
_STEPS = 1000
"""Of a whole bar, which is 320 pixels wide at most: a step is not seen."""


class Task:
    """What the work and the window know of each other; `report` is called by the work, in its thread."""

    def __init__(self) -> None:
        self.share: float | None = None
        self._cancelled = threading.Event()

    def report(self, share: float) -> None:
        """Take the share done, 0 to 1.

        Raises
        ------
        CancelledError
            The work shall end.
        """
        if self._cancelled.is_set():
            raise CancelledError
        self.share = share

    def cancel(self) -> None:
        """Let the work end the next time it reports."""
        self._cancelled.set()


class WorkStrip(QWidget):
    """One line for each piece of work; takes no room where there is none."""

    def __init__(self, jobs: Jobs) -> None:
        super().__init__()
        self._jobs = jobs
        self._rows: dict[Task, _Row] = {}
        self._quiet: weakref.WeakSet[Task] = weakref.WeakSet()
        self._column = fill(QVBoxLayout(self), spacing=1)
        self.hide()

    @property
    def busy(self) -> bool:
        """Whether something is worked on."""
        return bool(self._rows)

    def start(
        self,
        what: str,
        work: Callable[[Task], Any],
        then: Callable[[Any], None],
        otherwise: Otherwise = None,
        cancelled: Callable[[], None] = lambda: None,
    ) -> None:
        """Run `work`; afterwards `then(result)`, `otherwise(error)` or `cancelled()`, in the window's thread."""
        task = Task()
        row = _Row(what, task)
        self._rows[task] = row
        self._column.addWidget(row)
        self.show()

        def ended(value: Any) -> None:
            self._remove(task)
            then(value)

        def failed(error: BaseException) -> None:
            self._remove(task)
            cancelled() if isinstance(error, CancelledError) else (otherwise or self._jobs.show_error)(error)

        self._jobs.start(what, lambda: work(task), ended, failed)

    def quiet(self) -> Task:
        """Return a task without a line of its own, which ends with the others."""
        task = Task()
        self._quiet.add(task)
        return task

    def cancel(self) -> None:
        """Cancel all work, without waiting."""
        for task in (*self._rows, *self._quiet):
            task.cancel()

    def _remove(self, task: Task) -> None:
        take_out(self._column, self._rows.pop(task))
        self.setVisible(self.busy)


class _Row(QWidget):
    """Words, bar, button."""

    def __init__(self, what: str, task: Task) -> None:
        super().__init__()
        self._task = task
        # without a range it says only that something is done
        self._bar = having(QProgressBar(minimum=0, maximum=0, format="%p %"), maximumWidth=320)
        self._cancel = having(button("Cancel", self._cancelled), accessibleName=f"Cancel: {what}")
        words = QLabel(f"{what[:1].upper()}{what[1:]} …")
        fill(QHBoxLayout(self), words, (self._bar, 1), self._cancel, 1, margins=(8, 2, 4, 2), spacing=6)
        ticking(self, _LOOK_MS, self._look).start()

    def _look(self) -> None:
        """Show how far it is."""
        share = self._task.share
        if share is not None:
            having(self._bar, maximum=_STEPS, value=round(_STEPS * min(max(share, 0.0), 1.0)))

    def _cancelled(self) -> None:
        having(self._cancel, enabled=False, text="Cancelling …")
        self._task.cancel()
