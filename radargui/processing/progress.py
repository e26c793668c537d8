"""How much of the work on a run is done: what begins anew goes on from where it was, and nothing runs back."""

from __future__ import annotations

from collections.abc import Callable

Report = Callable[[float], None]

_OF_REST = 0.8
"""Share of what is left of the bar that an attempt takes. Nobody knows whether one is the last: most runs need one."""


class Progress:
    """The share done of a run, which only grows.

    Parameters
    ----------
    report
        Called with the share done, 0 to 1, each time something is done, whether it grew or not: what it raises, as
        `CancelledError`, ends the work. None: nobody wants to know.
    """

    def __init__(self, report: Report | None) -> None:
        self._report = report or (lambda _: None)
        self._done = 0.0

    def reach(self, share: float) -> None:
        """Say that this share of all is done."""
        self._done = max(self._done, share)
        self._report(self._done)

    def attempt(self, share: float = _OF_REST) -> Report:
        """Return what is called with the share of an attempt that is done, 0 to 1.

        It begins where the last one has come to: an estimate that is made again, without a receiver or without some
        milliseconds, with a prior, or by a simpler method instead. It takes a share of what is left of the bar.
        """
        begin = self._done
        span = share * (1.0 - begin)
        return lambda share: self.reach(begin + span * share)
