"""Long work in the background with a bar, how far it is, and a button that cancels it."""

import threading
import weakref
from collections.abc import Callable
from typing import Any

from PySide6.QtCore import QTimer
from PySide6.QtWidgets import QHBoxLayout, QLabel, QProgressBar, QVBoxLayout, QWidget

from radargui.gui.background import Jobs
from radargui.gui.layout import button, fill, take_out
from radargui.model.errors import CancelledError

_LOOK_MS = 100
_STEPS = 1000


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
        self._timer = QTimer(self, interval=_LOOK_MS)
        self._timer.timeout.connect(self._look)
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
        otherwise: Callable[[BaseException], None] | None = None,
        cancelled: Callable[[], None] = lambda: None,
    ) -> None:
        """Run `work`; afterwards `then(result)`, `otherwise(error)` or `cancelled()`, in the window's thread."""
        task = Task()
        row = _Row(what, task)
        self._rows[task] = row
        self._column.addWidget(row)
        self.show()
        self._timer.start()

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
        if not self._rows:
            self._timer.stop()
            self.hide()

    def _look(self) -> None:
        for row in self._rows.values():
            row.look()


class _Row(QWidget):
    """Words, bar, button."""

    def __init__(self, what: str, task: Task) -> None:
        super().__init__()
        self._task = task
        self._bar = QProgressBar()
        self._bar.setRange(0, 0)
        self._bar.setMaximumWidth(320)
        self._cancel = button("Cancel", self._cancelled)
        self._cancel.setAccessibleName(f"Cancel: {what}")
        words = QLabel(f"{what[:1].upper()}{what[1:]} …")
        fill(QHBoxLayout(self), words, (self._bar, 1), self._cancel, 1, margins=(8, 2, 4, 2), spacing=6)

    def look(self) -> None:
        """Show how far it is."""
        share = self._task.share
        if share is not None:
            self._bar.setRange(0, _STEPS)
            self._bar.setValue(round(_STEPS * min(max(share, 0.0), 1.0)))

    def _cancelled(self) -> None:
        self._cancel.setEnabled(False)
        self._cancel.setText("Cancelling …")
        self._task.cancel()
