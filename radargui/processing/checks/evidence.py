"""What findings are drawn from: all that is known of a run once it is measured."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from radargui.model.channel_quality import ChannelQuality
from radargui.model.finding import Finding
from radargui.model.recording import Recording
from radargui.model.result import Bounces, Segment, Track
from radargui.model.setup import Setup
from radargui.model.uncertainty_budget import UncertaintyBudget
from radargui.processing.measured_motion import MeasuredMotion
from radargui.processing.part import Part


@dataclass(frozen=True, slots=True)
class Evidence:
    """A measured run.

    Attributes
    ----------
    recording
        What was processed.
    part
        The receivers that can be used, their setup and signals.
    motion
        As measured.
    channels
        Quality of all receivers.
    track
        Without what is not known, and with combined uncertainties; None with fewer than three receivers.
    bounces, budget
        Of the track; empty and None where there is none, or the run is refused.
    floor
        What was found of the floor while impacts were judged by it.
    """

    recording: Recording
    part: Part
    motion: MeasuredMotion
    channels: tuple[ChannelQuality, ...]
    track: Track | None
    bounces: Bounces = field(default_factory=Bounces)
    budget: UncertaintyBudget | None = None
    floor: Sequence[Finding] = ()

    @property
    def setup(self) -> Setup:
        """Of the receivers that can be used."""
        return self.part.setup

    @property
    def segment(self) -> Segment:
        """The motion and the rest before it."""
        return self.part.conditioned.segment

    @property
    def is_refused(self) -> bool:
        """Whether a receiver that the run cannot go on without is rejected."""
        left_out = self.part.faults if self.part.goes_on_without else (None,) * len(self.channels)
        return any(one.verdict == "rejected" for one, why in zip(self.channels, left_out, strict=True) if why is None)

    @property
    def measured(self) -> Track | None:
        """The track of a run that is not refused."""
        return None if self.is_refused else self.track

    @property
    def exact_track(self) -> Track | None:
        """The same where its uncertainty is known: the far field makes g wrong by percents, and says so."""
        track = self.measured
        return track if track is not None and track.geometry == "exact" and self.budget is not None else None
