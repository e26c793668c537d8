"""What is waited for while results are computed: which, how long, and two ways not to wait."""

from __future__ import annotations

import time
from collections.abc import Callable

from PySide6.QtWidgets import QFrame, QHBoxLayout, QPushButton

from radargui.gui.control.app_state import AppState
from radargui.gui.control.run_control import RunControl
from radargui.gui.setup.form import plain_label
from radargui.gui.theme import Theme


class StoppingStrip(QFrame):
    """Hidden unless nothing is recorded any more and results are still to come.

    Parameters
    ----------
    theme
        Gives the colours.
    control
        What is being done; asked by `look`.
    clock
        Seconds; injected by tests.
    """

    def __init__(self, theme: Theme, control: RunControl, clock: Callable[[], float] = time.monotonic) -> None:
        super().__init__()
        self._theme, self._control, self._clock = theme, control, clock
        self._began_s: float | None = None
        self.setObjectName("stopping")
        self._words = plain_label()
        self.quick = QPushButton("Use the quick result")
        self.quick.setToolTip("Keep the preliminary result, where the setup has one; it is marked as preliminary")
        self.quick.clicked.connect(control.cancel)
        self.later = QPushButton("Compute later")
        self.later.setToolTip("What was recorded is kept; offered at the next start, or: radargui batch")
        self.later.clicked.connect(control.leave)
        row = QHBoxLayout(self)
        row.setContentsMargins(8, 4, 4, 4)
        row.addWidget(self._words, 1)
        row.addWidget(self.quick)
        row.addWidget(self.later)
        theme.changed.connect(self._paint)
        self._paint()
        self.hide()

    @property
    def text(self) -> str:
        """What is said."""
        return self._words.text()

    def look(self, computed: str) -> None:
        """Say what is waited for; `computed`: what the run is called whose result is computed."""
        control = self._control
        waits = control.state in (AppState.STOPPING, AppState.PROCESSING) and len(control.backlog) > 0
        if not waits:
            self._began_s = None
            self.hide()
            return
        if self._began_s is None:
            self._began_s = self._clock()
        more = len(control.backlog) - 1
        after = f", {more} more after it" if more else ""
        share = f"{100.0 * control.progress:.0f} % computed"
        waited_s = self._clock() - self._began_s
        self._words.setText(
            f"Waiting for the result of {computed or 'a run'} ({share}{after}), {waited_s:.0f} s so far"
        )
        for button in (self.quick, self.later):
            button.setEnabled(not control.leaves)
        self.show()

    def _paint(self) -> None:
        colours = self._theme.colours
        self.setStyleSheet(
            f"QFrame#stopping {{ background: {colours.raised}; border: none; border-left: 6px solid {colours.busy}; }}"
        )
