"""What an NI device can do, as the driver tells it."""

from dataclasses import dataclass
from typing import Literal, TypeAlias

TerminalChoice: TypeAlias = Literal["differential", "rse", "nrse", "pseudodifferential"]
TERMINALS: dict[TerminalChoice, str] = {
    "differential": "DIFF",
    "rse": "RSE",
    "nrse": "NRSE",
    "pseudodifferential": "PSEUDO_DIFF",
}
"""What NI-DAQmx calls them."""


@dataclass(frozen=True, slots=True)
class NiDevice:
    """One device known to NI-DAQmx.

    Attributes
    ----------
    name
        Name in NI-DAQmx: Dev1.
    product_type
        Product: DAQPad-6015; empty where the driver does not say.
    serial_number
        Hexadecimal, as printed on the device; empty where there is none.
    channels
        Analogue inputs without the device's name: ai0, ai1, ...
    terminals
        Terminal configurations of each of `channels`, in the same order.
    ranges_v
        Input ranges, (lowest, highest) in V.
    max_rate_single_hz
        Highest rate of a single channel in S/s; None where not known.
    max_rate_multi_hz
        Highest rate with several channels in S/s: of all channels together on a multiplexed device, of each channel on
        a simultaneous one; None where not known.
    min_rate_hz
        Lowest rate in S/s; None where not known.
    simultaneous
        True: all channels are sampled at the same instant. False: one after another.
    digital_trigger, analog_trigger
        A start on a digital or on an analogue edge is supported.
    reference_trigger
        Samples from before an edge can be kept by the device.
    trigger_lines
        Terminals that can take a digital edge, without the device's name: PFI0, ...
    simulated
        A device that NI-DAQmx simulates.
    connected
        False: configured in NI-DAQmx but not reachable now.
    """

    name: str
    product_type: str = ""
    serial_number: str = ""
    channels: tuple[str, ...] = ()
    terminals: tuple[tuple[TerminalChoice, ...], ...] = ()
    ranges_v: tuple[tuple[float, float], ...] = ()
    max_rate_single_hz: float | None = None
    max_rate_multi_hz: float | None = None
    min_rate_hz: float | None = None
    simultaneous: bool = False
    digital_trigger: bool = False
    analog_trigger: bool = False
    reference_trigger: bool = False
    trigger_lines: tuple[str, ...] = ()
    simulated: bool = False
    connected: bool = True

    @property
    def title(self) -> str:
        """Name and product for people: Dev1 (DAQPad-6015)."""
        return f"{self.name} ({self.product_type})" if self.product_type else self.name
