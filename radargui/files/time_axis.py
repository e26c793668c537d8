"""The time axis: sample rate and lost samples from the times that a file gives."""

import math

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.model.block import Gap
from radargui.model.errors import FileError

LARGEST_DEPARTURE = 0.6
"""In samples: how far a time may lie from where uniform sampling puts it: rounding reaches 0.5, the rate's own error a
little more."""


def uniform(time_s: FloatArray, where: str) -> tuple[float, tuple[Gap, ...]]:
    """Return sample rate in Hz and gaps from times that may be rounded.

    The step is the median difference; a difference near k steps means k - 1 lost samples. The rate then is the number
    of steps over the whole span, so that rounding of the times cancels out, and a rate within rounding of a whole
    number is that number.

    Parameters
    ----------
    time_s
        Shape (n_samples,), at least 2.
    where
        Where the times are, for messages.

    Raises
    ------
    FileError
        Not finite, not increasing, or not uniform.
    """
    if time_s.size < 2:
        raise FileError(f"{where}: one time is not enough for a sample rate.", remedy="Give --rate-hz.")
    finite = np.isfinite(time_s)
    if not finite.all():
        raise FileError(f"{where}: the time of sample {int(np.argmin(finite)) + 1} is not a number.")
    steps = np.diff(time_s)
    if steps.min() <= 0.0:
        late = int(np.argmax(steps <= 0.0)) + 2
        raise FileError(
            f"{where}: times do not increase at sample {late}.",
            reasons=("they were written with too few digits",),
            remedy="Write more digits, or leave the times out and give --rate-hz.",
        )
    step = float(np.median(steps))
    counts = np.maximum(np.rint(steps / step), 1.0)
    index = np.concatenate([[0.0], np.cumsum(counts)])
    span = float(time_s[-1] - time_s[0])
    rate_hz = float(index[-1]) / span
    departure = np.abs((time_s - time_s[0]) * rate_hz - index)
    if not math.isfinite(rate_hz) or departure.max() > LARGEST_DEPARTURE:
        far = int(np.argmax(departure)) + 1
        raise FileError(
            f"{where}: times are not uniform: sample {far} lies {departure.max():.3g} samples off.",
            reasons=("the sample rate changed", "the file holds several recordings"),
            remedy="Resample it, or leave the times out and give --rate-hz.",
        )
    whole = round(rate_hz)
    if whole >= 1 and abs(whole - rate_hz) <= rate_hz * min(1e-4, 2.0 * departure.max() / index[-1] + 1e-12):
        rate_hz = float(whole)
    return rate_hz, _gaps(counts)


def rate_of_step(step_s: float) -> float | None:
    """Return the sample rate in Hz of a sampling interval, None where it is not one; 2e-5 s is 50 kHz exactly."""
    if not math.isfinite(step_s) or step_s <= 0.0 or not math.isfinite(1.0 / step_s):
        return None
    rate_hz = 1.0 / step_s
    whole = float(round(rate_hz))
    return whole if whole and abs(whole - rate_hz) <= 1e-9 * rate_hz else rate_hz


def _gaps(counts: FloatArray) -> tuple[Gap, ...]:
    lost, gaps = 0, []
    for place in np.flatnonzero(counts > 1.0):
        count = int(counts[place]) - 1
        gaps.append(Gap(int(place) + 1 + lost, count, "times jump"))
        lost += count
    return tuple(gaps)
