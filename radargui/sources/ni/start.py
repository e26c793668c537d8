"""The start of sampling on an edge, checked against the device."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from radargui.model.daq import Edge
from radargui.model.errors import DeviceError
from radargui.model.setup import Setup
from radargui.sources.ni.device import NiDevice

_NO_PRETRIGGER = (
    "Set daq.start_pretrigger = false to begin at the edge; or set daq.start = 'now': a run then begins "
    "recording.pretrigger_s before the motion, from the samples kept in memory."
)


@dataclass(frozen=True, slots=True)
class StartEdge:
    """The edge that a task waits for.

    Attributes
    ----------
    kind
        digital or analog.
    source
        As NI-DAQmx wants it: a terminal, /Dev1/PFI0, or the name of a channel in the task, I1.
    edge
        rising or falling.
    level_v
        Where an analogue edge is, in V.
    pretrigger_samples
        Samples of each channel before the edge; 0: sampling begins at the edge.
    posttrigger_samples
        Samples of each channel from the edge on; 0: until it is stopped.
    """

    kind: Literal["digital", "analog"]
    source: str
    edge: Edge
    level_v: float = 0.0
    pretrigger_samples: int = 0
    posttrigger_samples: int = 0

    @property
    def total_samples(self) -> int | None:
        """Samples of each channel in all; None: until it is stopped."""
        return self.pretrigger_samples + self.posttrigger_samples if self.pretrigger_samples else None

    def title(self) -> str:
        """Return the edge for people: a rising edge at /Dev1/PFI0."""
        level = f" through {self.level_v:g} V" if self.kind == "analog" else ""
        return f"a {self.edge} edge{level} at {self.source}"


def checked_start(setup: Setup, device: NiDevice) -> StartEdge | None:
    """Return the edge that the setup wants to start at; None: at once.

    Raises
    ------
    DeviceError
        The device has no such trigger, or not at this terminal; the error says what it has.
    """
    daq = setup.daq
    if daq.start == "now":
        return None
    digital = daq.start == "digital"
    source = _terminal(setup, device) if digital else _analog_source(setup, device)
    if not daq.start_pretrigger:
        return StartEdge(daq.start, source, daq.start_edge, daq.start_level_v)
    if not device.reference_trigger:
        raise DeviceError(
            f"{device.title} cannot keep samples from before an edge: it has no reference trigger.",
            remedy=_NO_PRETRIGGER,
        )
    return StartEdge(
        daq.start,
        source,
        daq.start_edge,
        daq.start_level_v,
        # NI-DAQmx wants two at least
        pretrigger_samples=max(2, round(setup.recording.pretrigger_s * daq.rate_hz)),
        posttrigger_samples=max(2, round(setup.recording.maximum_s * daq.rate_hz)),
    )


def _terminal(setup: Setup, device: NiDevice) -> str:
    if not device.digital_trigger:
        raise DeviceError(
            f"{device.title} cannot start on a digital edge.",
            remedy="Set daq.start = 'now': each run then waits for motion.",
        )
    wanted = (setup.daq.start_source or "").rpartition("/")[2]
    known = {line.casefold(): line for line in device.trigger_lines}
    if known and wanted.casefold() not in known:
        raise DeviceError(
            f"{device.title} has no trigger line {wanted}; it has {', '.join(device.trigger_lines)}.",
            remedy="Set daq.start_source to one of these.",
        )
    return f"/{device.name}/{known.get(wanted.casefold(), wanted)}"


def _analog_source(setup: Setup, device: NiDevice) -> str:
    if not device.analog_trigger:
        raise DeviceError(
            f"{device.title} cannot start on an analogue edge.",
            remedy="Set daq.start = 'now': each run then waits for motion; or 'digital' with a PFI line.",
        )
    wanted = setup.daq.start_source or ""
    bare = wanted.rpartition("/")[2]
    if bare.casefold().startswith("apfi"):
        return f"/{device.name}/{bare.upper()}"
    inputs = [channel.rpartition("/")[2].casefold() for channel in setup.physical_channels]
    for name, channel in zip(setup.channel_names, inputs, strict=True):
        if bare.casefold() in (name.casefold(), channel):
            _check_level(setup, device)
            return name
    raise DeviceError(
        f"{wanted} is no analogue trigger source of {device.title}.",
        remedy=f"Set daq.start_source to APFI0 or to one of the recorded channels {', '.join(setup.channel_names)}.",
    )


def _check_level(setup: Setup, device: NiDevice) -> None:
    daq = setup.daq
    if abs(daq.start_level_v) >= daq.range_v:
        raise DeviceError(
            f"The start level {daq.start_level_v:g} V is outside the range +-{daq.range_v:g} V of {device.title}.",
            remedy="Set daq.start_level_v inside the range, or raise daq.range_v.",
        )
