"""Sentences for the operator about a recording that goes on, or has just ended."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from radargui.acquisition.health import Health
from radargui.acquisition.run_output import FinishedRun


class RunningWarnings:
    """Says once what the operator should do something about."""

    def __init__(self) -> None:
        self._said_low_disk = False

    def of(self, health: Health) -> Iterator[str]:
        """Yield what is new in a snapshot."""
        if health.disk_is_low and not self._said_low_disk:
            self._said_low_disk = True
            left_min = (health.disk_left_s or 0.0) / 60.0
            yield (
                f"The disk is filling up: about {left_min:.0f} minutes can still be recorded. "
                "Make room, or choose another folder after this run."
            )


def losses(health: Health) -> Iterator[str]:
    """Yield what was lost between source and file during an acquisition."""
    if health.samples_lost:
        gaps = f"{health.gaps} gap{'s' if health.gaps > 1 else ''}"
        yield f"{health.samples_lost} samples of each channel were lost by the source in {gaps}"
    if health.samples_not_written:
        yield f"{health.samples_not_written} samples of each channel could not be written in time and are lost"


def signal_warnings(run: FinishedRun) -> Iterator[str]:
    """Yield what is wrong with the voltages of a run."""
    channels = run.health.get("channels")
    for channel in channels if isinstance(channels, list) else ():
        if not isinstance(channel, Mapping):
            continue
        if channel["at_rail"]:
            yield (
                f"{channel['name']} sat at the end of its range in {_samples(channel['at_rail'])}: "
                "set a larger range (daq.range_v) or less gain"
            )
        if channel["not_a_number"]:
            yield f"{channel['name']} gave no number in {_samples(channel['not_a_number'])}"


def _samples(count: int) -> str:
    return f"{count} sample{'s' if count > 1 else ''}"
