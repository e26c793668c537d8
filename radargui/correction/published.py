"""The published correction of IQ mismatch (Rech & Huang 2019, section III), one function for each step.

Find the extremes of a wave that exceed its noise, and draw the cubic spline through them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from radargui.model.arrays import BoolArray, FloatArray, IntArray
from radargui.model.errors import ProcessingError
from radargui.model.finding import error_of
from radargui.model.result import Segment
from radargui.motion.smoothing import savitzky_golay
from radargui.signals.rows import held_beyond, order_statistics


def turning_points(x: FloatArray) -> tuple[IntArray, BoolArray]:
    """Return the local extremes of a curve (n,) in order, a plateau's in its middle, and which are maxima."""
    step = np.diff(x)
    moving = np.flatnonzero(step)
    rising = step[moving] > 0.0
    turn = np.flatnonzero(rising[1:] != rising[:-1])
    # from the first sample of a plateau to its last
    return (moving[turn] + 1 + moving[turn + 1]) // 2, rising[turn]


def prominent(x: FloatArray, place: IntArray, least: FloatArray | float) -> IntArray:
    """Return which extremes have a prominence above their limit, in order.

    Two neighbouring extremes that differ by less are a wiggle. The smallest wiggles are removed first, until none is
    left. Towards an end of the curve an extreme must exceed what lies before the end.

    Parameters
    ----------
    x
        The curve, shape (n,).
    place
        All its turning points, shape (m,).
    least
        Least prominence of each, shape (m,) or one for all.

    Returns
    -------
    IntArray
        Numbers of the turning points.
    """
    # with both ends, which are never taken out
    number = np.arange(-1, place.size + 1)
    value = np.concatenate([x[:1], x[place], x[-1:]])
    enough = np.zeros(number.size)
    enough[1:-1] = least
    while True:
        swing = np.abs(value[1:] - value[:-1])
        small = np.flatnonzero(swing < np.minimum(enough[1:], enough[:-1]))
        first = small[(swing[small] <= swing[small - 1]) & (swing[small] < swing[small + 1])]
        if first.size == 0:
            break
        keep = np.ones(number.size, dtype=np.bool_)
        keep[first] = keep[first + 1] = False
        number, value, enough = number[keep], value[keep], enough[keep]
    # at an end, or where its neighbour needs less, what an extreme stands out of lies farther away
    keep = np.asarray(np.minimum(swing[:-1], swing[1:]) >= enough[1:-1])
    values = value.tolist()
    for k in np.flatnonzero(~keep):
        keep[k] = _prominence(values, int(k) + 1) >= enough[k + 1]
    return np.asarray(number[1:-1][keep])


def _prominence(value: list[float], at: int) -> float:
    """Return the prominence of an extreme; each side reaches to what exceeds it, or to the end."""
    sign = 1.0 if value[at] >= value[at - 1] else -1.0
    own, out = sign * value[at], float("inf")
    for side in (range(at - 1, -1, -1), range(at + 1, len(value))):
        lowest = own
        for place in side:
            one = sign * value[place]
            if one > own:
                break
            lowest = min(lowest, one)
        out = min(out, own - lowest)
    return out


def spline_through(place: IntArray, value: FloatArray) -> FloatArray:
    """Return the cubic spline through values (n,) at sample numbers, at every sample from the first to the last.

    Not-a-knot at both ends (de Boor 1978, ch. IV); four values at least.
    """
    dx = np.diff(place).astype(np.float64)
    mean = np.diff(value) / dx
    slope = _slopes(dx, mean)
    bend = (slope[:-1] + slope[1:] - 2.0 * mean) / dx
    # of each piece, in powers of the distance from its beginning
    powers = np.stack([value[:-1], slope[:-1], (mean - slope[:-1]) / dx - bend, bend / dx])
    count = np.diff(place)
    level, linear, square, cube = np.repeat(powers, count, axis=1)
    away = np.arange(place[0], place[-1]) - np.repeat(place[:-1], count)
    return np.append(level + away * (linear + away * (square + away * cube)), value[-1])


def _slopes(dx: FloatArray, mean: FloatArray) -> FloatArray:
    """Return the slopes at the knots from the distances and mean slopes of the pieces between them."""
    n = dx.size + 1
    # dx_i s_(i-1) + 2 (dx_(i-1) + dx_i) s_i + dx_(i-1) s_(i+1) = 3 (dx_i m_(i-1) + dx_(i-1) m_i)
    lower, middle, upper, right = (np.empty(n) for _ in range(4))
    lower[1:-1], middle[1:-1], upper[1:-1] = dx[1:], 2.0 * (dx[:-1] + dx[1:]), dx[:-1]
    right[1:-1] = 3.0 * (dx[1:] * mean[:-1] + dx[:-1] * mean[1:])
    begin, end = dx[0] + dx[1], dx[-1] + dx[-2]
    middle[0], upper[0], lower[-1], middle[-1] = dx[1], begin, end, dx[-2]
    right[0] = ((dx[0] + 2.0 * begin) * dx[1] * mean[0] + dx[0] ** 2 * mean[1]) / begin
    right[-1] = (dx[-1] ** 2 * mean[-2] + (2.0 * end + dx[-1]) * dx[-2] * mean[-1]) / end
    a, b, c, d = (row.tolist() for row in (lower, middle, upper, right))
    for k in range(1, n):
        share = a[k] / b[k - 1]
        b[k] -= share * c[k - 1]
        d[k] -= share * d[k - 1]
    d[-1] /= b[-1]
    for k in range(n - 2, -1, -1):
        d[k] = (d[k] - c[k] * d[k + 1]) / b[k]
    return np.array(d)


PROMINENCE = 0.3
"""An extreme stands out of its surroundings by this share of the local swing, or it is noise."""
TYPICAL_PROMINENCE, MIN_SWINGS = 0.15, 5
"""The same of the typical swing, for those between which the local swing is taken; fewer swings do not tell it."""
MIN_EXTREMES = 2
"""Peaks, and as many valleys, of a channel: two of each are one and a half fringes."""
TURN_S = 0.0008
"""Before and after an instant that is looked at for a turn of the motion: a bounce is over within it."""
REACH_S = 0.003
"""Beside the motion, more than smoothing, its slope and a turn look at together."""
PART_OF_PERIOD = 0.2
"""Of the fastest Doppler period that smoothing may reach over: a parabola through a fifth of a wave is 1 % off."""


@dataclass(frozen=True, slots=True)
class ChannelSteps:
    """The intermediate results of the procedure in one channel (I or Q).

    Attributes
    ----------
    segment
        Samples first:last of the motion.
    peaks, valleys
        Sample indices of the extremes used.
    upper, lower
        Splines through peaks and valleys, volts, one value a sample of the segment.
    bias
        Mean of both splines, constant before the first and after the last extreme, volts, one value a sample of the
        record.
    zero_crossings
        Sample indices at which the channel less its bias changes sign.
    scale
        Local extreme by which each sample is divided, volts, one value a sample of the record.
    """

    segment: Segment
    peaks: IntArray
    valleys: IntArray
    upper: FloatArray
    lower: FloatArray
    bias: FloatArray
    zero_crossings: IntArray
    scale: FloatArray

    def laid_out(self, start: int, n_samples: int) -> ChannelSteps:
        """Return the same of a record of which this one begins at sample `start`; bias and scale are held beyond."""
        segment = replace(self.segment, first=self.segment.first + start, last=self.segment.last + start)
        bias, scale = (held_beyond(values, start, n_samples) for values in (self.bias, self.scale))
        peaks, valleys, crossings = (place + start for place in (self.peaks, self.valleys, self.zero_crossings))
        return ChannelSteps(segment, peaks, valleys, self.upper, self.lower, bias, crossings, scale)


@dataclass(frozen=True, slots=True)
class PublishedSteps:
    """The steps of both channels of one receiver."""

    i: ChannelSteps
    q: ChannelSteps


def correct_published(
    pair_v: FloatArray, sample_rate_hz: float, segment: Segment, highest_hz: float | None = None, blurred: int = 0
) -> tuple[FloatArray, PublishedSteps]:
    """Correct one receiver: extremes, bias, zero crossings, local rescaling.

    Parameters
    ----------
    pair_v
        I and Q in volts, finite, shape (2, n_samples).
    sample_rate_hz
        Rate of each channel.
    segment
        The segment with motion.
    highest_hz
        Highest Doppler frequency, where it is known: smoothing and the search for turns use a part of its period.
    blurred
        Number of samples beside a turn that belong to it: where a sample is a mean of several, a turn falls between
        samples.

    Returns
    -------
    tuple
        I and Q in amplitudes, shape (2, n_samples), and the steps.

    Raises
    ------
    ProcessingError
        Too few extremes: the motion turns the phase by less than about one and a half fringes.
    """
    period_s = np.inf if not highest_hz else 1.0 / highest_hz
    # farther from the motion than windows reach nothing is said about it
    reach, n_samples = round(REACH_S * sample_rate_hz) + 8, pair_v.shape[1]
    near = slice(max(0, segment.first - reach), min(n_samples, segment.last + reach))
    moving = Segment(segment.first - near.start, segment.last - near.start, 0, 0)
    smoothed = smooth(pair_v[:, near], sample_rate_hz, window_s=min(SMOOTHING_S, PART_OF_PERIOD * period_s))
    turning = motion_turns(smoothed, sample_rate_hz, moving, min(TURN_S, 0.5 * PART_OF_PERIOD * period_s))
    # of 60 drops at 33 kS/s two were rejected that were not at the full rate; with this one more is good than there
    for _ in range(blurred):
        turning[1:-1] = turning[:-2] | turning[1:-1] | turning[2:]
    steps = tuple(_correct_channel(smoothed[k], moving, turning).laid_out(near.start, n_samples) for k in (0, 1))
    corrected = np.stack([(channel - step.bias) / step.scale for channel, step in zip(pair_v, steps, strict=True)])
    return corrected, PublishedSteps(*steps)


def _correct_channel(smoothed_v: FloatArray, segment: Segment, turning: BoolArray) -> ChannelSteps:
    peaks, valleys = find_extremes(smoothed_v, segment)
    # where the motion turns round I stands still at any value: no crest of the circle
    peaks, valleys = peaks[~turning[peaks]], valleys[~turning[valleys]]
    if min(peaks.size, valleys.size) < MIN_EXTREMES:
        raise error_of(
            ProcessingError,
            "few_extremes",
            reasons=["the tracer moves less than about two fringes", "the signal is too weak"],
            remedy="Use a longer drop or a stronger signal.",
            peaks=peaks.size,
            valleys=valleys.size,
        )
    upper, lower = envelope(smoothed_v, peaks, segment), envelope(smoothed_v, valleys, segment)
    bias = find_bias(upper, lower, peaks, valleys, segment, smoothed_v.size)
    # scaled between crossings, not between extremes: there an error of the scale would be a step
    centred = smoothed_v - bias
    crossings = find_zero_crossings(centred, peaks, valleys)
    scale = local_scale(centred, crossings, np.sort(np.concatenate([peaks, valleys])))
    return ChannelSteps(segment, peaks, valleys, upper, lower, bias, crossings, scale)


def motion_turns(smoothed_v: FloatArray, sample_rate_hz: float, segment: Segment, turn_s: float = TURN_S) -> BoolArray:
    """Return where an extreme would come from the motion turning round, not from the circle.

    At an extreme of the circle one of I and Q stands still and the other runs at full speed through its middle; where
    the tracer turns round (a bounce, an apex) both stand still or change direction together.

    Parameters
    ----------
    smoothed_v
        I and Q, shape (2, n_samples).
    sample_rate_hz
        Rate of each channel.
    segment
        The segment with motion.
    turn_s
        Time before and after an instant within which it is judged.

    Returns
    -------
    BoolArray
        Shape (n_samples,).
    """
    # noise must not turn a slope at a bounce: smoothed once more, over as much as is looked at
    slope = smooth(smoothed_v, sample_rate_hz, window_s=max(turn_s, SMOOTHING_S * turn_s / TURN_S), slope=True)
    first, last = segment.first, segment.last
    amplitude = 0.5 * np.ptp(smoothed_v[:, first:last], axis=1)
    square = np.square(slope[0] / max(amplitude[0], 1e-300)) + np.square(slope[1] / max(amplitude[1], 1e-300))
    reach = max(1, round(turn_s * sample_rate_hz))
    turning = np.zeros(smoothed_v.shape[1], dtype=np.bool_)
    before, after = slope[:, : -2 * reach], slope[:, 2 * reach :]
    reversed_both = (before * after < 0).all(axis=0)
    turning[reach:-reach] = reversed_both
    cycle = 2.0 * np.pi * reach / sample_rate_hz
    return np.asarray(turning | (square < (0.05 / cycle * np.pi) ** 2))


def find_extremes(smoothed_v: FloatArray, segment: Segment) -> tuple[IntArray, IntArray]:
    """Find peaks and valleys of one channel in the segment (Rech & Huang 2019, section III, step 2).

    An extreme counts where it stands out by a share of the local swing, so that noise makes none and a slow change
    of amplitude loses none.

    Returns
    -------
    tuple
        Sample indices of peaks and of valleys.
    """
    x = smoothed_v[segment.first : segment.last]
    place, peak = turning_points(x)
    number = prominent(x, place, PROMINENCE * local_swing(x, place))
    found, peak = place[number] + segment.first, peak[number]
    return found[peak], found[~peak]


def local_swing(x: FloatArray, turning: IntArray) -> FloatArray:
    """Return the peak-to-valley swing around each turning point, shape (n_turning,).

    Half of the typical swing is taken first to find the alternating extremes; the swing between neighbours of these,
    median over five, then follows a change of amplitude.
    """
    # every eighth sample tells it as well
    lowest, highest = order_statistics(x[::8], 0.02, 0.98)
    typical = float(highest - lowest)
    both = turning[prominent(x, turning, TYPICAL_PROMINENCE * typical)]
    if both.size <= MIN_SWINGS:
        return np.full(turning.size, typical)
    swing = np.abs(np.diff(x[both]))
    middle = 0.5 * (both[1:] + both[:-1])
    around = np.clip(np.arange(swing.size) + np.arange(-2, 3)[:, None], 0, swing.size - 1)
    return np.asarray(np.interp(turning, middle, np.sort(swing[around], axis=0)[2]))


def envelope(smoothed_v: FloatArray, extremes: IntArray, segment: Segment) -> FloatArray:
    """Return the spline through the extremes, held beyond the first and the last (section III, step 3).

    Returns
    -------
    FloatArray
        Volts, one value a sample of the segment.
    """
    if extremes.size < 4:
        # seldom, and a tenth of a second to load
        from scipy.interpolate import PchipInterpolator

        inner = PchipInterpolator(extremes, smoothed_v[extremes])(np.arange(extremes[0], extremes[-1] + 1))
    else:
        inner = spline_through(extremes, smoothed_v[extremes])
    return held_beyond(inner, int(extremes[0]) - segment.first, segment.last - segment.first)


def find_bias(
    upper: FloatArray, lower: FloatArray, peaks: IntArray, valleys: IntArray, segment: Segment, n_samples: int
) -> FloatArray:
    """Return the bias: mean of both splines, held before the first and after the last extreme (section III, step 4).

    Returns
    -------
    FloatArray
        Volts, one value a sample of the record.
    """
    # before both have begun one of the splines is only held: their mean would be no centre
    first = max(int(peaks[0]), int(valleys[0]))
    last = max(first, min(int(peaks[-1]), int(valleys[-1])))
    both = slice(first - segment.first, last + 1 - segment.first)
    return held_beyond(0.5 * (upper[both] + lower[both]), first, n_samples)


def find_zero_crossings(centred_v: FloatArray, peaks: IntArray, valleys: IntArray) -> IntArray:
    """Return where the channel less its bias changes sign between a peak and a valley (section III, step 5).

    Between two neighbouring extremes of different kind the crossing nearest to the middle is taken, so that noise
    around zero makes one crossing, not many.

    Returns
    -------
    IntArray
        Sample indices of the first sample after each crossing, shape (n_crossings,).
    """
    place = np.concatenate([peaks, valleys])
    order = np.argsort(place)
    place, falls = place[order], order < peaks.size
    # from a peak on the channel falls to a valley, and rises to the next peak
    alternate = falls[:-1] != falls[1:]
    begin, end, falls = place[:-1][alternate], place[1:][alternate], falls[:-1][alternate]
    above, below = centred_v > 0.0, centred_v < 0.0
    out = np.full(begin.size, -1, dtype=np.intp)
    for down, there in ((True, above), (False, below)):
        change = np.flatnonzero(there[:-1] & ~there[1:])
        own = np.flatnonzero(falls == down)
        first, last = np.searchsorted(change, [begin[own], end[own] - 1])
        some = last > first
        out[own[some]] = change[((first + last) // 2)[some]] + 1
    return out[out >= 0]


def local_scale(centred_v: FloatArray, crossings: IntArray, extremes: IntArray) -> FloatArray:
    """Return what each piece between zero crossings is divided by: its local extreme (section III, step 6).

    A piece without an extreme of the circle takes the scale between its neighbours.

    Returns
    -------
    FloatArray
        Volts, above zero, one value a sample of the record.
    """
    edges = np.concatenate([[0], crossings, [centred_v.size]]).astype(np.intp)
    piece = np.searchsorted(crossings, extremes, side="right")
    height = np.full(edges.size - 1, np.nan)
    # of several extremes in a piece the largest is the circle's
    np.fmax.at(height, piece, np.abs(centred_v[extremes]))
    known = np.flatnonzero(np.isfinite(height))
    height = np.interp(np.arange(height.size), known, height[known])
    return np.repeat(np.maximum(height, 1e-300), np.diff(edges))


SMOOTHING_S = 0.001
"""Of the parabola, less of a fast Doppler. Chosen by hand: shorter, noise makes extremes; longer, bounces blur."""


def smooth(x: FloatArray, sample_rate_hz: float, *, window_s: float = SMOOTHING_S, slope: bool = False) -> FloatArray:
    """Return a least-squares parabola's value (or slope per second) around each sample (Savitzky & Golay 1964).

    Parameters
    ----------
    x
        Shape (..., n_samples).
    sample_rate_hz
        Rate of the samples.
    window_s
        Width of the window; a window of under five samples leaves `x` as it is.
    slope
        Give the first derivative per second instead.
    """
    window = min(2 * round(0.5 * window_s * sample_rate_hz) + 1, 2 * ((x.shape[-1] - 1) // 2) + 1)
    # too few samples for a parabola that smooths
    if window < 5:
        return np.gradient(x, 1.0 / sample_rate_hz, axis=-1) if slope else x
    return savitzky_golay(x, window, derivative=int(slope), spacing=1.0 / sample_rate_hz)
