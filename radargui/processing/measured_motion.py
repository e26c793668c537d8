"""What the way from conditioned signals to a track ends in, whatever the correction."""

from dataclasses import dataclass

import numpy as np

from radargui.conditioning.conditioned import Conditioned
from radargui.model.front_end import FrontEndPrior
from radargui.model.result import Bounces, CorrectedIQ, PathLengths, Track
from radargui.model.uncertainty_budget import InputChange


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
    front_end_prior
        What was known about the front ends, and whether it was used.
    warnings
        Sentences for the operator.
    """

    corrected: CorrectedIQ
    paths: PathLengths
    track: Track | None
    bounces: Bounces | None = None
    changes: tuple[InputChange, ...] | None = None
    front_end_prior: FrontEndPrior | None = None
    warnings: tuple[str, ...] = ()


def nothing_measured(conditioned: Conditioned, method: str) -> MeasuredMotion:
    """Return the motion of no receiver at all: every one has a fault."""
    nothing, never = np.empty((0, conditioned.n_samples)), np.empty((0, conditioned.n_samples), dtype=np.bool_)
    time_s = conditioned.time_s
    corrected = CorrectedIQ(time_s, nothing, nothing, never, nothing, method, ())
    return MeasuredMotion(corrected, PathLengths(time_s, nothing, nothing, nothing, never), None)
