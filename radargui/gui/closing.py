"""The end of the window: it says what it waits for, keeps drawing, and can be told not to wait."""

from __future__ import annotations

import time
from collections.abc import Callable

from PySide6.QtCore import QTimer, Signal
from PySide6.QtWidgets import QFrame, QHBoxLayout, QPushButton

from radargui.gui.setup.form import plain_label
from radargui.gui.theme import Theme

_LOOK_MS = 50
GRACE_S = 3.0
"""What is told to leave now has so long to put its files in order: a block is written every half a second, and a
device answers within two (chosen by hand; nothing is lost after it, samples are flushed as they come)."""


class ClosingStrip(QFrame):
    """Hidden until the window is to close; `over` comes when nothing is waited for any more.

    Parameters
    ----------
    theme
        Gives the colours.
    unfinished
        Returns what has still to end, in words.
    hurry
        Asked to end everything at once.
    clock
        Seconds; injected by tests.
    """

    over = Signal()

    def __init__(
        self,
        theme: Theme,
        unfinished: Callable[[], tuple[str, ...]],
        hurry: Callable[[], None],
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        super().__init__()
        self._theme, self._unfinished, self._hurry, self._clock = theme, unfinished, hurry, clock
        self._began_s = 0.0
        self._hurried_s: float | None = None
        self.setObjectName("closing")
        self._words = plain_label()
        self.leave = QPushButton("Leave now")
        self.leave.setToolTip(
            "What was recorded is kept. Runs that are still to be computed can be computed later: radargui batch"
        )
        self.leave.clicked.connect(self.leave_now)
        row = QHBoxLayout(self)
        row.setContentsMargins(8, 4, 4, 4)
        row.addWidget(self._words, 1)
        row.addWidget(self.leave)
        self._timer = QTimer(self)
        self._timer.setInterval(_LOOK_MS)
        self._timer.timeout.connect(self._look)
        theme.changed.connect(self._paint)
        self._paint()
        self.hide()

    @property
    def active(self) -> bool:
        """Whether the window is closing."""
        return self._timer.isActive()

    @property
    def text(self) -> str:
        """What is said."""
        return self._words.text()

    def begin(self) -> None:
        """Wait for what has still to end."""
        self._began_s = self._clock()
        self._timer.start()
        self.show()
        self._look()

    def leave_now(self) -> None:
        """Wait no longer than what runs needs to put its files in order."""
        if self._hurried_s is None:
            self._hurried_s = self._clock()
            self.leave.setEnabled(False)
            self._hurry()

    def _look(self) -> None:
        unfinished, now = self._unfinished(), self._clock()
        if not unfinished or (self._hurried_s is not None and now - self._hurried_s > GRACE_S):
            self._timer.stop()
            self.over.emit()
            return
        does = "Closing" if self._hurried_s is None else "Leaving"
        self._words.setText(f"{does}: waiting for {', '.join(unfinished)} ({now - self._began_s:.0f} s)")

    def _paint(self) -> None:
        colours = self._theme.colours
        self.setStyleSheet(
            f"QFrame#closing {{ background: {colours.raised}; border: none; border-left: 6px solid {colours.busy}; }}"
        )
