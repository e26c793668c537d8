"""The data acquisition of the setup file: device, channels, rate, and when a run starts and ends."""

from typing import Annotated, Literal

from pydantic import Field

from radargui.model.radar import MAX_RECEIVERS
from radargui.model.section import Flag, Real, Section, Text

Terminal = Literal["differential", "rse", "nrse", "pseudodifferential", "default"]
Start = Literal["now", "digital", "analog"]
Edge = Literal["rising", "falling"]

_HOST = r"(?:[^\s:/\[\]]+|\[[0-9A-Fa-f:.]+\])"
_PORT = r"(?:[1-9]\d{0,3}|[1-5]\d{4}|6[0-4]\d{3}|65[0-4]\d{2}|655[0-2]\d|6553[0-5])"


class Daq(Section):
    """How the NI device digitises the voltages.

    Attributes
    ----------
    device
        Name in NI-DAQmx.
    remote
        Address of an NI gRPC device server; left out: the driver of this computer.
    remote_certificate
        File with the certificate (PEM) that a device server with encryption is known by; left out: no encryption.
    channels
        Inputs for I1, Q1, I2, ...; left out: ai0, ai1, ...
    terminal
        Terminal configuration of all channels.
    range_v
        The smallest input range of the device that covers +- this is used.
    rate_hz
        Of each channel.
    u_clock_ppm
        Standard uncertainty of the device's clock, in millionths; left out: see `model.assumed`.
    convert_rate_hz
        Conversions per second of a multiplexed device, all channels together; left out: the driver's choice. The skew
        between neighbouring channels is its inverse.
    channel_skew_s
        Delay of channel k against channel k-1, where the device, or the file that is processed, does not tell it.
    buffer_s
        How long the driver keeps samples that were not read yet.
    read_interval_s
        Length of the blocks that are read.
    start
        now: at once; digital, analog: at an edge of `start_source`, which is t = 0 of the run.
    start_source
        digital: a terminal, PFI0; analog: a terminal, APFI0, or one of the channels, I1 or ai0.
    start_edge, start_level_v
        Which edge; for an analog one also where.
    start_pretrigger
        True: the device samples before the edge too (a reference trigger): the run begins `recording.pretrigger_s`
        before the edge and lasts until `recording.maximum_s` after it.
    """

    device: Annotated[Text, Field(min_length=1)] = "Dev1"
    remote: (
        Annotated[Text, Field(pattern=rf"^{_HOST}:{_PORT}$", description="a text HOST:PORT with a port of 1 to 65535")]
        | None
    ) = None
    remote_certificate: Annotated[Text, Field(min_length=1)] | None = None
    channels: Annotated[tuple[Text, ...], Field(min_length=2, max_length=2 * MAX_RECEIVERS)] | None = None
    terminal: Terminal = "differential"
    range_v: Annotated[Real, Field(gt=0.0, le=60.0)] = 5.0
    rate_hz: Annotated[Real, Field(ge=10.0, le=10.0e6)] = 33333.0
    u_clock_ppm: Annotated[Real, Field(ge=0.0, le=10000.0)] | None = None
    convert_rate_hz: Annotated[Real, Field(ge=20.0, le=100.0e6)] | None = None
    channel_skew_s: Annotated[Real, Field(ge=0.0, le=0.01)] = 0.0
    buffer_s: Annotated[Real, Field(ge=0.5, le=600.0)] = 10.0
    read_interval_s: Annotated[Real, Field(ge=0.005, le=1.0)] = 0.02
    start: Start = "now"
    start_source: Annotated[Text, Field(min_length=1)] | None = None
    start_edge: Edge = "rising"
    start_level_v: Annotated[Real, Field(ge=-60.0, le=60.0)] = 1.0
    start_pretrigger: Flag = False


class RecordingLimits(Section):
    """When the recording of one drop starts and ends, and what happens when the device fails meanwhile.

    Attributes
    ----------
    pretrigger_s
        Recorded before the trigger.
    quiet_s
        The run ends when nothing has moved for so long.
    maximum_s
        Longest recording after the trigger.
    threshold
        Motion is this many times the quiet level.
    wait_s
        Longest wait for the trigger.
    falls_only
        In a hands-free series, whether runs in which nothing falls freely are set aside: a hand that puts the sphere
        back. They are kept, hidden, and can be taken back.
    restart_after_error
        Whether a device that failed is started again within a run; the samples lost meanwhile are a gap.
    restart_within_s
        How long that is tried.
    """

    pretrigger_s: Annotated[Real, Field(ge=0.05, le=60.0)] = 0.5
    quiet_s: Annotated[Real, Field(ge=0.05, le=60.0)] = 0.4
    maximum_s: Annotated[Real, Field(ge=0.1, le=3600.0)] = 10.0
    threshold: Annotated[Real, Field(ge=3.0, le=1000.0)] = 8.0
    wait_s: Annotated[Real, Field(ge=0.1, le=86400.0)] = 600.0
    falls_only: Flag = True
    restart_after_error: Flag = False
    restart_within_s: Annotated[Real, Field(ge=0.1, le=3600.0)] = 30.0
