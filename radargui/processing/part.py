"""The part of a radar that can be used: its sound receivers, and the setup that belongs to them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from radargui.conditioning.conditioned import Conditioned
from radargui.geometry.path_length import LEAST_RECEIVERS
from radargui.model.finding import Finding
from radargui.model.front_end import FrontEndPrior
from radargui.model.setup import Setup
from radargui.model.unexplained_stretch import UnexplainedStretch


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
    clock
        That all phases turn too fast or too slow for a fall.
    left_out
        What was left out since no motion explains it; receivers are numbered from 0 among all.
    further
        When each other motion of the recording begins and ends, in s: these signals are those of one of several.
    """

    whole_setup: Setup
    whole: Conditioned
    faults: tuple[Finding | None, ...]
    clock: Finding | None = None
    left_out: tuple[UnexplainedStretch, ...] = ()
    further: tuple[tuple[float, float], ...] = ()

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
        return any(self.faults) and len(self.receivers) >= LEAST_RECEIVERS

    @property
    def is_too_small(self) -> bool:
        """Whether faults leave too few receivers for the track that all would have given."""
        # two of three give no track: a run that lost one is refused, one that never had more is not
        return len(self.receivers) < LEAST_RECEIVERS <= len(self.faults)

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
