"""The monitor: live view without recording."""

from __future__ import annotations

import threading
from collections.abc import Callable

from radargui.acquisition.acquisition import Acquisition
from radargui.model.setup import Setup
from radargui.sources.contract import Source


class Monitor:
    """Shows a source live; may be started and stopped again and again, each time with a new source.

    Parameters
    ----------
    setup
        What is acquired.
    source_factory
        Makes a source, not opened.
    ring_s
        Seconds that can be seen.
    on_end
        Called in a thread of the acquisition whenever it has ended, also by a failure.
    """

    def __init__(
        self,
        setup: Setup,
        source_factory: Callable[[], Source],
        *,
        ring_s: float = 10.0,
        on_end: Callable[[], None] | None = None,
    ) -> None:
        self._setup = setup
        self._source_factory = source_factory
        self._ring_s = ring_s
        self._on_end = on_end
        self._lock = threading.Lock()
        self._acquisition: Acquisition | None = None

    @property
    def acquisition(self) -> Acquisition | None:
        """The present acquisition, or the last one; None before the first start."""
        return self._acquisition

    @property
    def is_running(self) -> bool:
        """Whether an acquisition is under way."""
        acquisition = self._acquisition
        return acquisition is not None and not acquisition.state.is_final

    def start(self) -> None:
        """Begin, at once; idempotent. A source that cannot be opened shows in `acquisition.error`.

        Raises
        ------
        RadarGuiError
            The source cannot be made.
        """
        with self._lock:
            if self.is_running:
                return
            self._acquisition = Acquisition(
                self._source_factory(), self._setup, ring_s=self._ring_s, on_end=self._on_end
            )
            self._acquisition.start()

    def stop(self) -> None:
        """End, and wait until all threads are gone; idempotent."""
        acquisition = self._acquisition
        if acquisition is not None:
            acquisition.stop()
