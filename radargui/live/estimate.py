"""What the live track says of the newest samples."""

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
        Whether the track was lost, or samples while the tracer may have moved: positions since then count from the
        rest after that as if it were the release, until the tracer is known to hang there.
    doubt
        Why the place is not known, in a few words, while it is not; empty where a new rest was found, or there is
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
        """Return the same where nobody knows the place."""
        change, position = np.full(self.change_m.shape, np.nan), np.full(self.position_m.shape, np.nan)
        return replace(self, change_m=change, position_m=position)
