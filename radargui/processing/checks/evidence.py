"""What findings are drawn from: all that is known of a run once it is measured.

The part of a radar that can be used: its sound receivers, and the setup that belongs to them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from radargui.model.channel_quality import ChannelQuality, UnexplainedStretch
from radargui.model.finding import Finding
from radargui.model.front_end import FrontEndPrior
from radargui.model.recording import Recording
from radargui.model.result import Bounces, Segment, Track
from radargui.model.setup import Setup
from radargui.model.uncertainty_budget import UncertaintyBudget
from radargui.physics.path_length import MIN_RECEIVERS
from radargui.processing.measured_motion import MeasuredMotion
from radargui.signals.conditioned import Conditioned


@dataclass(frozen=True, slots=True)
class Part:
    """Some receivers of a recording.

    Attributes
    ----------
    whole_setup
        Of all receivers.
    whole
        Signals of all receivers.
    faults
        Why a receiver is left out, one a receiver; None where it is not.
    left_out
        What was left out since no motion explains it; receivers are numbered from 0 among all.
    """

    whole_setup: Setup
    whole: Conditioned
    faults: tuple[Finding | None, ...]
    left_out: tuple[UnexplainedStretch, ...] = ()

    @property
    def receivers(self) -> tuple[int, ...]:
        """Numbers of the receivers, from 0."""
        return tuple(number for number, fault in enumerate(self.faults) if not fault)

    @property
    def conditioned(self) -> Conditioned:
        """Their signals."""
        # the same object: what was found once is not copied
        return self.whole if not any(self.faults) else self.whole.of_receivers(self.receivers)

    @property
    def setup(self) -> Setup:
        """The setup with these receivers alone."""
        if not any(self.faults):
            return self.whole_setup
        receivers = tuple(self.whole_setup.receiver[number] for number in self.receivers)
        return self.whole_setup.model_copy(update={"receiver": receivers})

    @property
    def has_room(self) -> bool:
        """Whether the delays between channels fit into a sample."""
        # a multiplexer is through with a sample before the next one begins
        return bool(self.whole.delay_s[-1] * self.whole.sample_rate_hz * self.whole.size < 1.0)

    @property
    def begins_after_gap(self) -> bool:
        """Whether samples were lost right before those that are used."""
        return int(self.whole.samples.start) > 0

    @property
    def goes_on_without(self) -> bool:
        """Whether there is a track although receivers are left out."""
        return any(self.faults) and len(self.receivers) >= MIN_RECEIVERS

    @property
    def is_too_small(self) -> bool:
        """Whether faults leave too few receivers for the track that all would have given."""
        # two of three give no track: a run that lost one is refused, one that never had more is not
        return len(self.receivers) < MIN_RECEIVERS <= len(self.faults)

    @property
    def closed(self) -> Part:
        """The same with nothing taken for an open channel."""
        faults = tuple(None if fault and fault.code == "channel_open" else fault for fault in self.faults)
        return replace(self, whole=self.whole.closed, faults=faults)

    def without(self, faults: dict[int, Finding]) -> Part:
        """Return what is left without further receivers, by number, each with its reason."""
        return replace(self, faults=tuple(faults.get(number, fault) for number, fault in enumerate(self.faults)))

    def without_stretches(self, stretches: Sequence[UnexplainedStretch]) -> Part:
        """Return the same with stretches left out, whose receivers are numbered among those that can be used."""
        whole, left_out = self.whole, self.left_out
        for one in stretches:
            numbered = replace(one, receiver=self.receivers[one.receiver])
            whole, left_out = whole.without(numbered.receiver, one.begin_s, one.end_s), (*left_out, numbered)
        return replace(self, whole=whole, left_out=left_out)

    def with_correction(self, name: str) -> Part:
        """Return the same for another correction."""
        processing = self.whole_setup.processing.model_copy(update={"correction": name})
        return replace(self, whole_setup=self.whole_setup.model_copy(update={"processing": processing}))

    def prior(self, known: FrontEndPrior) -> FrontEndPrior:
        """Return what is known about the front ends of these receivers."""
        return replace(known, front_ends=tuple(known.front_ends[number] for number in self.receivers))


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
