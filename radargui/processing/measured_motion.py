"""What the way from conditioned signals to a track ends in, whatever the correction."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from radargui.conditioning.conditioned import Conditioned
from radargui.model.arrays import BoolArray
from radargui.model.finding import Finding
from radargui.model.front_end import FrontEndPrior
from radargui.model.result import Bounces, CorrectedIQ, Kinematics, PathLengths, Track
from radargui.model.setup_pool import SetupPrior
from radargui.model.setup_posterior import SetupLikelihood, SetupValue
from radargui.model.uncertainty_budget import InputChange
from radargui.model.unexplained_stretch import UnexplainedStretch
from radargui.restitution.flight_test import FlightTest

if TYPE_CHECKING:
    # only who asks for it pays for loading it
    from radargui.estimation.joint import JointEstimate


@dataclass(frozen=True, slots=True)
class MeasuredMotion:
    """Corrected IQ, path lengths and track of conditioned signals.

    Attributes
    ----------
    corrected, paths
        Of all receivers.
    track
        None with fewer than three receivers.
    bounces
        Where the estimate holds them itself; None: to be found from the track.
    changes
        What they change by with each uncertain input of the setup, where the estimate knows it itself.
    motion
        Velocities and accelerations, where the estimate knows them.
    front_end_prior
        What was known about the front ends, and whether it was used.
    setup_posterior
        What the recording says of the setup's values; empty where it says nothing.
    setup_likelihood, setup_prior
        What it says of them alone, and what other runs said of them and whether it was used; None: nothing.
    findings
        What was found on the way.
    estimate, flights
        The joint estimate, and what its flights say; None, and nothing, of other corrections.
    unexplained
        What no motion explains and has to be left out before anything of this counts.
    """

    corrected: CorrectedIQ
    paths: PathLengths
    track: Track | None
    bounces: Bounces | None = None
    changes: tuple[InputChange, ...] | None = None
    motion: Kinematics | None = None
    front_end_prior: FrontEndPrior | None = None
    setup_posterior: tuple[SetupValue, ...] = ()
    setup_likelihood: SetupLikelihood | None = None
    setup_prior: SetupPrior | None = None
    findings: tuple[Finding, ...] = ()
    estimate: JointEstimate | None = None
    flights: FlightTest = field(default_factory=FlightTest)
    unexplained: tuple[UnexplainedStretch, ...] = ()

    @property
    def rejected(self) -> BoolArray:
        """Which receivers are rejected, shape (n_receivers,)."""
        return np.array([channel.verdict == "rejected" for channel in self.corrected.channels], dtype=np.bool_)

    def said(self, *findings: Finding | None) -> MeasuredMotion:
        """Return it with what was found besides."""
        return replace(self, findings=(*self.findings, *(one for one in findings if one is not None)))

    def contradicted(self, cause: Finding | None) -> MeasuredMotion:
        """Return it with what of the setup is likely wrong; what was refused is by that. None: nothing is."""
        if cause is None:
            return self
        motion = self.refused(cause, self.rejected) if self.rejected.any() else self
        return replace(motion, flights=replace(self.flights, cause=cause))

    def blamed(self, codes: Sequence[str], cause: Finding) -> MeasuredMotion:
        """Return it with receivers that were rejected by some findings rejected by another one."""
        wrong = [one.finding is not None and one.finding.code in codes for one in self.corrected.channels]
        refused = [one.verdict == "rejected" for one in self.corrected.channels]
        return self.refused(cause, np.array(wrong, dtype=np.bool_) & refused) if any(wrong) else self

    def refused(self, finding: Finding, receivers: BoolArray | None = None) -> MeasuredMotion:
        """Return it with receivers, shape (n_receivers,), rejected by a finding; None: all of them."""
        finding = replace(finding, severity="refuse")
        wrong = np.ones(len(self.corrected.channels), dtype=np.bool_) if receivers is None else receivers
        rows = zip(self.corrected.channels, wrong, strict=True)
        channels = tuple(replace(own, finding=finding) if is_wrong else own for own, is_wrong in rows)
        return replace(self, corrected=replace(self.corrected, channels=channels))


def nothing_measured(conditioned: Conditioned, method: str) -> MeasuredMotion:
    """Return the motion of no receiver at all: every one has a fault."""
    nothing, never = np.empty((0, conditioned.n_samples)), np.empty((0, conditioned.n_samples), dtype=np.bool_)
    time_s = conditioned.time_s
    corrected = CorrectedIQ(time_s, nothing, nothing, never, nothing, method, ())
    return MeasuredMotion(corrected, PathLengths(time_s, nothing, nothing, nothing, never), None)
