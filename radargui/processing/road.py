"""What both roads from samples to a track end in."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from radargui.model.arrays import FloatArray
from radargui.model.bounce import Bounces
from radargui.model.corrected import CorrectedIQ
from radargui.model.front_end import FrontEndPrior
from radargui.model.path import PathLengths
from radargui.model.track import Track


@dataclass(frozen=True, slots=True)
class Road:
    """Corrected IQ, path lengths and track of the samples of a gapless stretch.

    Attributes
    ----------
    corrected, paths
        Of all receivers.
    track
        None with fewer than three receivers.
    bounces
        Where the road found them itself; None: to be found from the track.
    shift
        Changes of the first e and of g where the track is shifted a little (times, shift of shape (3, n)), where the
        road knows them itself.
    front_end_prior
        What was known about the front ends, and whether it was used.
    warnings
        Sentences for the operator.
    """

    corrected: CorrectedIQ
    paths: PathLengths
    track: Track | None
    bounces: Bounces | None = None
    shift: Callable[[FloatArray, FloatArray], tuple[float, float]] | None = None
    front_end_prior: FrontEndPrior | None = None
    warnings: tuple[str, ...] = ()
