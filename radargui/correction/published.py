"""The published correction of IQ mismatch (Rech & Huang 2019, section III), one function a step."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline, PchipInterpolator
from scipy.signal import find_peaks

from radargui.correction.smooth import SMOOTHING_S, smooth
from radargui.model.arrays import BoolArray, FloatArray, IntArray
from radargui.model.errors import ProcessingError
from radargui.model.segment import Segment

PROMINENCE = 0.3
"""An extreme stands out of its surroundings by this share of the local swing, or it is noise."""
LEAST_EXTREMES = 2
TURN_S = 0.0008
"""Before and after an instant that is looked at for a turn of the motion: a bounce is over within it."""
PART_OF_PERIOD = 0.2
"""Of the fastest Doppler period that smoothing may reach over: a parabola through a fifth of a wave is 1 % off."""


@dataclass(frozen=True, slots=True)
class ChannelSteps:
    """What the procedure found on its way in one channel (I or Q).

    Attributes
    ----------
    segment
        Samples first:last of the motion.
    peaks, valleys
        Sample indices of the extremes used.
    upper, lower
        Splines through peaks and valleys, volts, one value a sample of the segment.
    bias
        Mean of both, held before the first and after the last extreme, volts, one value a sample of the record.
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


@dataclass(frozen=True, slots=True)
class PublishedSteps:
    """The steps of both channels of one receiver."""

    i: ChannelSteps
    q: ChannelSteps


def correct_published(
    pair_v: FloatArray, sample_rate_hz: float, segment: Segment, highest_hz: float | None = None
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
        Fastest Doppler frequency, where it is known: smoothing and turns are looked at within a part of its period.

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
    smoothed = smooth(pair_v, sample_rate_hz, window_s=min(SMOOTHING_S, PART_OF_PERIOD * period_s))
    turning = motion_turns(smoothed, sample_rate_hz, segment, min(TURN_S, 0.5 * PART_OF_PERIOD * period_s))
    steps = tuple(_correct_channel(smoothed[k], segment, turning) for k in (0, 1))
    corrected = np.stack([(pair_v[k] - step.bias) / step.scale for k, step in enumerate(steps)])
    return corrected, PublishedSteps(*steps)


def _correct_channel(smoothed_v: FloatArray, segment: Segment, turning: BoolArray) -> ChannelSteps:
    peaks, valleys = find_extremes(smoothed_v, segment)
    # where the motion turns round I stands still at any value: no crest of the circle
    peaks, valleys = peaks[~turning[peaks]], valleys[~turning[valleys]]
    if min(peaks.size, valleys.size) < LEAST_EXTREMES:
        raise ProcessingError(
            f"only {peaks.size} peaks and {valleys.size} valleys in the motion",
            reasons=["the tracer moves less than about two fringes", "the signal is too weak"],
            remedy="Use a longer drop or a stronger signal.",
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
        Before and after an instant that is looked at.

    Returns
    -------
    BoolArray
        Shape (n_samples,).
    """
    slope = smooth(smoothed_v, sample_rate_hz, window_s=max(turn_s, SMOOTHING_S * turn_s / TURN_S), slope=True)
    first, last = segment.first, segment.last
    amplitude = 0.5 * np.ptp(smoothed_v[:, first:last], axis=1)
    rate = np.hypot(slope[0] / max(amplitude[0], 1e-300), slope[1] / max(amplitude[1], 1e-300))
    reach = max(1, round(turn_s * sample_rate_hz))
    turning = np.zeros(smoothed_v.shape[1], dtype=np.bool_)
    before, after = slope[:, : -2 * reach], slope[:, 2 * reach :]
    reversed_both = (before * after < 0).all(axis=0)
    turning[reach:-reach] = reversed_both
    cycle = 2.0 * np.pi * reach / sample_rate_hz
    return np.asarray(turning | (rate < 0.05 / cycle * np.pi))


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
    swing = local_swing(x)
    peaks, valleys = (_prominent(sign * x, swing) for sign in (1.0, -1.0))
    return peaks + segment.first, valleys + segment.first


def _prominent(x: FloatArray, swing: FloatArray) -> IntArray:
    found, properties = find_peaks(x, prominence=0.5 * PROMINENCE * float(swing.min()))
    return np.asarray(found[properties["prominences"] > PROMINENCE * swing[found]], dtype=np.intp)


def local_swing(x: FloatArray) -> FloatArray:
    """Return the peak-to-valley swing around each sample, shape (n_samples,).

    Half of the typical swing is taken first to find the alternating extremes; the swing between neighbours of these,
    median over five, then follows a change of amplitude.
    """
    typical = float(np.percentile(x, 98.0) - np.percentile(x, 2.0))
    peaks = find_peaks(x, prominence=0.15 * typical)[0]
    valleys = find_peaks(-x, prominence=0.15 * typical)[0]
    both = np.sort(np.concatenate([peaks, valleys]))
    if both.size < 6:
        return np.full(x.size, typical)
    swing = np.abs(np.diff(x[both]))
    middle = 0.5 * (both[1:] + both[:-1])
    padded = np.pad(swing, 2, mode="edge")
    median = np.median(np.lib.stride_tricks.sliding_window_view(padded, 5), axis=1)
    return np.asarray(np.interp(np.arange(x.size), middle, median))


def envelope(smoothed_v: FloatArray, extremes: IntArray, segment: Segment) -> FloatArray:
    """Return the spline through the extremes, held beyond the first and the last (section III, step 3).

    Returns
    -------
    FloatArray
        Volts, one value a sample of the segment.
    """
    place = np.clip(np.arange(segment.first, segment.last), extremes[0], extremes[-1])
    if extremes.size < 4:
        return np.asarray(PchipInterpolator(extremes, smoothed_v[extremes])(place))
    return np.asarray(CubicSpline(extremes, smoothed_v[extremes])(place))


def find_bias(
    upper: FloatArray, lower: FloatArray, peaks: IntArray, valleys: IntArray, segment: Segment, n_samples: int
) -> FloatArray:
    """Return the bias: mean of both splines, held before the first and after the last extreme (section III, step 4).

    Returns
    -------
    FloatArray
        Volts, one value a sample of the record.
    """
    mean = 0.5 * (upper + lower)
    first = max(int(peaks[0]), int(valleys[0]))
    last = min(int(peaks[-1]), int(valleys[-1]))
    place = np.clip(np.arange(n_samples), first, max(first, last)) - segment.first
    return np.asarray(mean[place])


def find_zero_crossings(centred_v: FloatArray, peaks: IntArray, valleys: IntArray) -> IntArray:
    """Return where the channel less its bias changes sign between a peak and a valley (section III, step 5).

    Between two neighbouring extremes of different kind the crossing nearest to the middle is taken, so that noise
    around zero makes one crossing, not many.

    Returns
    -------
    IntArray
        Sample indices of the first sample after each crossing.
    """
    place = np.concatenate([peaks, valleys])
    kind = np.concatenate([np.ones(peaks.size), -np.ones(valleys.size)])
    order = np.argsort(place)
    place, kind = place[order], kind[order]
    crossings = []
    for begin, end, a, b in zip(place[:-1], place[1:], kind[:-1], kind[1:], strict=True):
        if a == b:
            continue
        sign = centred_v[begin:end] * a > 0
        change = np.flatnonzero(sign[:-1] & ~sign[1:])
        if change.size:
            crossings.append(begin + 1 + int(change[change.size // 2]))
    return np.asarray(crossings, dtype=np.intp)


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
    for index, value in zip(piece, np.abs(centred_v[extremes]), strict=True):
        height[index] = np.fmax(height[index], value)
    known = np.flatnonzero(np.isfinite(height))
    height = np.interp(np.arange(height.size), known, height[known])
    return np.repeat(np.maximum(height, 1e-300), np.diff(edges))
