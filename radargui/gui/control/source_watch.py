"""What the operator wants to know of the source itself: whether it waits for an edge, whether it was restarted."""

from __future__ import annotations

from radargui.acquisition.health import Health
from radargui.model.daq import Daq
from radargui.sources.contract import Source


class SourceWatch:
    """Looks at a source that runs; asks it nothing that could wait.

    Parameters
    ----------
    source
        As it was made.
    daq
        What it was made from.
    is_device
        Whether it can wait for an edge.
    """

    def __init__(self, source: Source, daq: Daq, *, is_device: bool) -> None:
        self._source = source
        self._daq = daq
        self._is_device = is_device
        self._told = 0

    def waits_for(self, health: Health | None) -> str:
        """Return the edge that sampling waits for, in words; empty where it waits for none."""
        if not self._is_device or self._daq.start == "now":
            return ""
        waiting = getattr(self._source, "is_waiting", None)
        if waiting is None:
            # a source around the device does not tell: before the edge there are no samples
            waiting = health is None or not (health.samples_read or self._restarts)
        return edge_words(self._daq) if waiting else ""

    def news(self) -> str:
        """Return what is to be told about restarts since the last call; empty where there was none."""
        count = self._restarts
        if count <= self._told:
            return ""
        self._told = count
        times = "once" if count == 1 else f"{count} times"
        return f"The device failed and was started again, {times} so far. What was lost meanwhile is a gap in the run."

    @property
    def _restarts(self) -> int:
        return int(getattr(self._source, "restarts", 0))


def edge_words(daq: Daq) -> str:
    """Return the edge that a run starts at: `rising edge at PFI0`."""
    level = f" through {daq.start_level_v:g} V" if daq.start == "analog" else ""
    return f"{daq.start_edge} edge{level} at {daq.start_source or 'the start terminal'}"
