"""The result of one run: everything the tables, the report and the window show."""

from dataclasses import dataclass, field
from typing import Literal

from radargui.model.bounce import Bounces
from radargui.model.corrected import CorrectedIQ
from radargui.model.front_end import FrontEndPrior
from radargui.model.path import PathLengths
from radargui.model.recording import Recording
from radargui.model.segment import Segment
from radargui.model.setup import Setup
from radargui.model.track import Track
from radargui.model.uncertainty_budget import UncertaintyBudget

Status = Literal["ok", "no_motion", "rejected"]


@dataclass(frozen=True, slots=True)
class RunResult:
    """What one recording gave under one setup.

    Attributes
    ----------
    recording, setup
        What went in.
    status, reason
        ok; no_motion (an answer, not an error); rejected, with the reason.
    segment
        The motion and the rest before it; None without motion.
    corrected, paths, track
        The values on the way; None where the flow ended before. `track` is None with fewer than 3 receivers.
    bounces
        Impacts and first fall.
    uncertainty_budget
        Whose share of the uncertainty is how large; None without a track.
    warnings
        Sentences for the operator.
    preliminary
        Whether the correction that the setup asks for is still being computed, or was stopped before it ended: then a
        simpler one stands here.
    front_end_prior
        What earlier runs of the session said about the front ends, and whether it was used; None where nothing was
        known or asked.
    """

    recording: Recording = field(repr=False)
    setup: Setup = field(repr=False)
    status: Status
    reason: str = ""
    segment: Segment | None = None
    corrected: CorrectedIQ | None = field(default=None, repr=False)
    paths: PathLengths | None = field(default=None, repr=False)
    track: Track | None = field(default=None, repr=False)
    bounces: Bounces = field(default_factory=Bounces)
    uncertainty_budget: UncertaintyBudget | None = None
    warnings: tuple[str, ...] = ()
    preliminary: bool = False
    front_end_prior: FrontEndPrior | None = None

    @property
    def zero(self) -> tuple[float, str]:
        """The instant that counts as t = 0 for people, in s of the recording, and what it is.

        The trigger, else the first motion, else the first sample. Tables for programs keep the recording's own time.
        """
        recording = self.recording
        time_s = recording.time_s()
        if time_s.size == 0:
            return 0.0, "the first sample"
        # what the operator set goes before what was found
        if recording.trigger_index is not None:
            return float(recording.trigger_index / recording.digitisation.sample_rate_hz), "the trigger"
        if self.segment is not None:
            return float(time_s[min(self.segment.first, time_s.size - 1)]), "the first motion"
        return float(time_s[0]), "the first sample"
