"""The data acquisition of the setup file: device, channels, rate; and when a run starts and ends."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from radargui.model.section import Real, Section, Text

Terminal = Literal["differential", "rse", "nrse", "pseudodifferential", "default"]


class Daq(Section):
    """How the NI device digitises the voltages."""

    device: Annotated[Text, Field(min_length=1)] = "Dev1"
    remote: Annotated[Text, Field(pattern=r"^[^\s:/]+:\d{1,5}$", description="a text HOST:PORT")] | None = None
    channels: Annotated[tuple[Text, ...], Field(min_length=2, max_length=8)] | None = None
    terminal: Terminal = "differential"
    range_v: Annotated[Real, Field(gt=0.0, le=60.0)] = 5.0
    rate_hz: Annotated[Real, Field(ge=10.0, le=10.0e6)] = 33333.0
    channel_skew_s: Annotated[Real, Field(ge=0.0, le=0.01)] = 0.0
    buffer_s: Annotated[Real, Field(ge=0.5, le=600.0)] = 10.0
    read_interval_s: Annotated[Real, Field(ge=0.005, le=1.0)] = 0.02


class RecordingLimits(Section):
    """When the recording of one drop starts and ends."""

    pretrigger_s: Annotated[Real, Field(ge=0.05, le=60.0)] = 0.5
    quiet_s: Annotated[Real, Field(ge=0.05, le=60.0)] = 0.4
    maximum_s: Annotated[Real, Field(ge=0.1, le=3600.0)] = 10.0
    threshold: Annotated[Real, Field(ge=3.0, le=1000.0)] = 8.0
    wait_s: Annotated[Real, Field(ge=0.1, le=86400.0)] = 600.0
