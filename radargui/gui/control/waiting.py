"""What is waited for, how long, and how not to wait: at the end of a recording, and at the end of the window."""

import time
from collections.abc import Callable

from PySide6.QtCore import Signal

from radargui.gui.control.run_control import RunControl
from radargui.gui.control.state import AppState, Asked
from radargui.gui.layout import Strip, button, ticking
from radargui.model.words import percent

_LOOK_MS = 50
"""Whether all has ended is looked at so often: soon enough to seem at once."""
GRACE_S = 3.0
"""What is told to leave now has so long to put its files in order: a block is written every half a second, and a
device answers within two (chosen by hand; nothing is lost after it, samples are flushed as they come)."""


_FORETELLS_AFTER = 0.05
"""Share of a result after which its remaining time is foretold: the first steps say little (chosen by hand)."""


class ClosingStrip(Strip):
    """Hidden until the window is to close; `over` comes when nothing is waited for any more.

    Parameters
    ----------
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
        unfinished: Callable[[], tuple[str, ...]],
        hurry: Callable[[], None],
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.leave = button("Leave now", self.leave_now)
        super().__init__("link", self.leave)
        self._unfinished, self._hurry, self._clock = unfinished, hurry, clock
        self._began_s = 0.0
        self._hurried_s: float | None = None
        self._timer = ticking(self, _LOOK_MS, self._look)

    @property
    def active(self) -> bool:
        """Whether the window is closing."""
        return self._timer.isActive()

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
        self.words.setText(f"{does}: waiting for {', '.join(unfinished)} ({now - self._began_s:.0f} s)")


class StoppingStrip(Strip):
    """Hidden unless nothing is recorded any more and results are still to come.

    Parameters
    ----------
    control
        What is being done; asked by `look`.
    clock
        Seconds; injected by tests.
    """

    def __init__(self, control: RunControl, clock: Callable[[], float] = time.monotonic) -> None:
        self.quick = button("Use the quick result", lambda: control.end(Asked.CANCEL))
        self.later = button("Compute later", lambda: control.end(Asked.LEAVE))
        super().__init__("link", self.quick, self.later)
        self._control, self._clock = control, clock
        self._began_s: float | None = None
        self._run, self._run_began_s, self._run_share = "", 0.0, 0.0
        self._share, self._ends_s = 0.0, float("inf")

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
        share = f"{percent(control.progress)} computed"
        waited_s = self._clock() - self._began_s
        left = "" if (left_s := self._left_s(computed)) is None else f", about {left_s:.0f} s left"
        self.words.setText(
            f"Waiting for the result of {computed or 'a run'} ({share}{left}{after}), {waited_s:.0f} s so far"
        )
        for one in (self.quick, self.later):
            one.setEnabled(control.reached.asked is not Asked.LEAVE)
        self.show()

    def _left_s(self, run: str) -> float | None:
        """Return how long the run's result will take if it goes on as since it was first seen, never more than before.

        None: it is too early to tell, or it takes longer than was foretold.
        """
        now, share = self._clock(), self._control.progress
        if run != self._run or share < self._run_share:
            self._run, self._run_began_s, self._run_share = run, now, share
            self._share, self._ends_s = share, float("inf")
        done = share - self._run_share
        if share > self._share and done >= _FORETELLS_AFTER:
            # where nothing is new the time goes on: what is left would grow
            self._share = share
            self._ends_s = min(self._ends_s, now + (1.0 - share) / done * (now - self._run_began_s))
        left_s = self._ends_s - now
        return left_s if 0.0 < left_s < float("inf") else None
