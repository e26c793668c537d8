"""The whole setup: what the setup file says, validated."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import ConfigDict, Field, model_validator

from radargui.model.daq import Daq, RecordingLimits
from radargui.model.digitisation import iq_names
from radargui.model.polarization import LEAST_SHARE, ReceivedField, received_fields
from radargui.model.radar import Floor, Radar, Receiver, Site, Tracer, Transmitter
from radargui.model.section import ExactWhole, Section
from radargui.model.simulation import Simulation

SCHEMA = 1
Correction = Literal["joint", "adaptive", "published", "ellipse", "none"]
Geometry = Literal["exact", "plane"]


class Processing(Section):
    """How samples become a track.

    Attributes
    ----------
    correction
        See method.md.
    geometry
        plane: the antennas taken as infinitely far away.
    """

    correction: Correction = "joint"
    geometry: Geometry = "exact"


class Setup(Section):
    """Geometry of the antennas, tracer, floor, acquisition, simulation and processing."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, populate_by_name=True)

    schema_version: Annotated[Literal[1], ExactWhole, Field(alias="schema", description="1 in this version")]
    radar: Radar
    transmitter: Transmitter
    receiver: Annotated[tuple[Receiver, ...], Field(min_length=1, max_length=4)]
    tracer: Tracer = Tracer()
    floor: Floor = Floor()
    site: Site = Site()
    daq: Daq = Daq()
    recording: RecordingLimits = RecordingLimits()
    simulation: Simulation = Simulation()
    processing: Processing = Processing()

    @model_validator(mode="after")
    def _channels_match_receivers(self) -> Setup:
        channels = self.daq.channels
        if channels is not None and len(channels) != 2 * len(self.receiver):
            wanted = ", ".join(iq_names(len(self.receiver)))
            raise ValueError(
                f"daq.channels names {len(channels)} channels: allowed {2 * len(self.receiver)} "
                f"for {len(self.receiver)} [[receiver]] ({wanted})"
            )
        if channels is not None and len(set(channels)) != len(channels):
            raise ValueError(f"daq.channels = {list(channels)}: allowed are different channels, one is named twice")
        return self

    @model_validator(mode="after")
    def _start_has_a_source(self) -> Setup:
        daq = self.daq
        if daq.start != "now" and daq.start_source is None:
            example = "PFI0" if daq.start == "digital" else "APFI0 or I1"
            raise ValueError(f'daq.start = "{daq.start}", allowed: with daq.start_source, for example {example}')
        if daq.start == "now" and daq.start_pretrigger:
            raise ValueError('daq.start_pretrigger = true, allowed: with daq.start = "digital" or "analog"')
        if daq.remote_certificate is not None and daq.remote is None:
            raise ValueError("daq.remote_certificate is given, allowed: together with daq.remote")
        return self

    @model_validator(mode="after")
    def _every_receiver_gets_a_signal(self) -> Setup:
        turned = [n for n, one in enumerate(self.receiver, 1) if one.polarization_deg is not None]
        # only the angle between both fields says what a receiver gets
        if turned and self.transmitter.polarization_deg is None:
            raise ValueError(
                f"receiver[{turned[0]}].polarization_deg = {self.receiver[turned[0] - 1].polarization_deg:g}, allowed: "
                "together with transmitter.polarization_deg"
            )
        for n, field in enumerate(self.received_fields() if turned else (), 1):
            # nearly crossed: a degree of error in an angle changes such a signal by a third
            if field.share < LEAST_SHARE:
                raise ValueError(
                    f"receiver[{n}].polarization_deg = {field.angle_deg:g} gets {100.0 * field.share:.1f} % of the "
                    f"strongest signal from the centre, allowed: {100.0 * LEAST_SHARE:g} % and more; "
                    f"{field.strongest_deg:.1f} gives the strongest"
                )
        return self

    def received_fields(self) -> tuple[ReceivedField, ...]:
        """Return what each receiver gets from a metal sphere in the centre; no polarisation given counts as 0."""
        polarization_deg = self.transmitter.polarization_deg or 0.0
        return received_fields(self.radar, self.transmitter, self.receiver, self.tracer, polarization_deg)

    @property
    def n_receivers(self) -> int:
        """Number of receivers."""
        return len(self.receiver)

    @property
    def channel_names(self) -> tuple[str, ...]:
        """Canonical names of the voltages: I1, Q1, ..."""
        return iq_names(self.n_receivers)

    @property
    def physical_channels(self) -> tuple[str, ...]:
        """Device channels in the order of `channel_names`."""
        if self.daq.channels is not None:
            return self.daq.channels
        return tuple(f"ai{number}" for number in range(2 * self.n_receivers))
