"""The live estimate of the newest samples."""

from dataclasses import dataclass, replace

import numpy as np

from radargui.model.arrays import FloatArray, IntArray


@dataclass(frozen=True, slots=True)
class LiveEstimate:
    """What the newest samples say; columns are block means.

    Attributes
    ----------
    index
        Absolute sample index of each column, shape (n,), ascending; samples of the first fringes come late, when the
        correction is known.
    i, q
        Corrected, in amplitudes, Q as it is wired, shape (n_receivers, n); NaN while the correction is not known.
    change_m
        Change of path length from the rest, shape (n_receivers, n); NaN while unknown.
    position_m
        Shape (3, n); the release position at rest, NaN while unknown or with fewer than three receivers.
    moving
        Whether the tracer moves now.
    began_anew
        Whether the track was lost, or samples were lost while the tracer may have moved. Later positions count from the
        following rest as if it were the release, until the tracer is known to hang there.
    doubt
        Why the place is unknown, in a few words; empty where it is known, where a new rest was found, or where there is
        nothing to say.
    shaken
        Absolute sample index up to which the trigger has looked, and how hard the voltages shook since it looked
        before (see `MotionTrigger.shaking`); None where nothing is new.
    """

    index: IntArray
    i: FloatArray
    q: FloatArray
    change_m: FloatArray
    position_m: FloatArray
    moving: bool
    began_anew: bool = False
    doubt: str = ""
    shaken: tuple[int, float] | None = None

    def without_place(self) -> "LiveEstimate":
        """Return the same estimate with the place unknown."""
        change, position = np.full(self.change_m.shape, np.nan), np.full(self.position_m.shape, np.nan)
        return replace(self, change_m=change, position_m=position)
