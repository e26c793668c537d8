"""What channels answer in the wiring check: how hard, to which antenna, and which way the phase of a pair turns."""

from dataclasses import dataclass

import numpy as np

from radargui.conditioning.ellipse import fit_ellipse
from radargui.model.arrays import BoolArray, FloatArray, IntArray
from radargui.model.errors import ProcessingError

DEAD = 0.1
"""A channel that answers less than this share of the others, everywhere, is dead."""
LEAST = 3.0
"""A channel answers where it shakes this many times harder than in quiet."""

CLEAR_ANSWER = 1.4
"""A channel answers clearly to an antenna when it does so this many times more than to any other."""
CLEAR_TURN = 0.3
"""Least difference between the power that turns one way and the other, relative to their sum."""
SAME = 0.98
"""Correlation from which two channels carry the same signal."""
_FLOOR = 1e-3  # of the strongest answer: below, the logarithm of noise would decide (chosen by hand)
_SLOWEST_HZ, _FASTEST_HZ = 0.5, 200.0
"""Doppler of a hand at 10 GHz, 7 mm/s to 3 m/s: below lies drift, above noise. Chosen by hand."""


@dataclass(frozen=True, slots=True)
class WiringSamples:
    """What was measured; all arrays (n_channels, n), volts, at `rate_hz`; NaN where samples were lost.

    Attributes
    ----------
    rate_hz
        After averaging.
    quiet, away
        Nothing moves; the tracer moves away.
    waves
        A hand in front of each receiver.
    clipped
        Share of the samples that sat at an end of the range, over all steps, shape (n_channels,).
    """

    rate_hz: float
    quiet: FloatArray
    away: FloatArray
    waves: tuple[FloatArray, ...]
    clipped: FloatArray


def shake_v(volts: FloatArray) -> FloatArray:
    """Return the standard deviation of each channel in V, shape (n_channels,); 0 where there are no samples."""
    known = volts[:, np.isfinite(volts).all(axis=0)]
    return np.asarray(known.std(axis=1)) if known.shape[1] else np.zeros(volts.shape[0])


def responses_v(samples: WiringSamples) -> tuple[FloatArray, FloatArray]:
    """Return how hard each channel answers beyond its quiet level: sqrt(std^2 - quiet^2).

    Returns
    -------
    tuple
        When the tracer moves away, shape (n_channels,), and for each wave, shape (n_receivers, n_channels), in V.
    """
    quiet = shake_v(samples.quiet)
    steps = np.array([shake_v(step) for step in (samples.away, *samples.waves)])
    # noise and answer are independent: their variances add
    beyond = np.sqrt(np.clip(steps**2 - quiet**2, 0.0, None))
    beyond[steps < LEAST * quiet] = 0.0
    return beyond[0], beyond[1:]


def dead_channels(away_v: FloatArray, waves_v: FloatArray) -> BoolArray:
    """Return which channels answer to nothing, shape (n_channels,); parameters as `responses_v` returns them."""
    # a channel may be deaf to a wave at another antenna, a dead one to all
    strongest = waves_v.max(axis=0, initial=0.0)
    return np.asarray((away_v <= DEAD * _typical(away_v)) & (strongest <= DEAD * _typical(strongest)))


def _typical(values: FloatArray) -> float:
    """Return the upper median: with half of the channels dead it is still one that lives."""
    return float(np.sort(values)[values.size // 2])


def owners(waves_v: FloatArray, dead: BoolArray) -> tuple[IntArray, BoolArray]:
    """Return the antenna of each channel, two channels an antenna, and whether that is clear.

    Neither the gain of a channel nor how hard the hand was waved matters: the logarithms of the answers are freed of
    the mean of each channel and of each wave before channels are given to antennas (the assignment with the largest
    sum). A channel that is dead or not clear keeps the place that it should have, where that is left.

    Parameters
    ----------
    waves_v
        Answers, shape (n_receivers, n_channels).
    dead
        Which channels answer to nothing, shape (n_channels,).

    Returns
    -------
    tuple
        Receivers counted from 0, shape (n_channels,), and True where it is clear.
    """
    n_receivers, n_channels = waves_v.shape
    expected = np.arange(n_channels) // 2
    if n_receivers == 1:
        return expected, ~dead
    score = _contrast(waves_v, ~dead)
    score[:, dead] = 0.0
    channels = np.arange(n_channels)
    # in doubt as the setup has it: half of what counts as clear
    biased = score.copy()
    biased[expected, channels] += 0.5 * np.log(CLEAR_ANSWER)
    # two channels an antenna, all at once: greedy choices strand the last one
    # a quarter of a second to load, for who checks wires
    from scipy.optimize import linear_sum_assignment

    rows, columns = linear_sum_assignment(np.repeat(biased, 2, axis=0), maximize=True)
    owner = np.empty(n_channels, dtype=np.intp)
    owner[columns] = rows // 2
    # clear is what the second best antenna leaves
    others = score.copy()
    others[owner, channels] = -np.inf
    clear = score[owner, channels] - others.max(axis=0) >= np.log(CLEAR_ANSWER)
    return owner, clear & ~dead


def _contrast(waves_v: FloatArray, alive: BoolArray) -> FloatArray:
    """Return log answers without the means of channels and of waves, shape (n_receivers, n_channels)."""
    scale = waves_v.max(initial=0.0) or 1.0
    score = np.log(np.maximum(waves_v / scale, _FLOOR))
    if alive.any():
        # gain of the channel, then vigour of the wave: the vigours then add up to nothing, and one round is enough
        score -= score.mean(axis=0)
        score -= score[:, alive].mean(axis=1, keepdims=True)
    return score


def turning(pair_v: FloatArray, rate_hz: float) -> float:
    """Return the power of I + jQ at positive minus that at negative frequencies over their sum, -1 to 1.

    A phase that rises turns the positive way. Offset, unequal gains and a quadrature error only add an image of less
    power on the other side. 0 where there is nothing.

    Parameters
    ----------
    pair_v
        I and Q in volts, shape (2, n_samples), lost samples left out.
    rate_hz
        Samples per second.
    """
    if pair_v.shape[1] < 8:
        return 0.0
    # offsets are no rotation
    signal = pair_v - pair_v.mean(axis=1, keepdims=True)
    # of I + jQ: a complex signal has its two directions at plus and minus f
    spectrum = np.abs(np.fft.fft((signal[0] + 1j * signal[1]) * np.hanning(signal.shape[1]))) ** 2
    frequency = np.fft.fftfreq(signal.shape[1], 1.0 / rate_hz)
    wanted = (np.abs(frequency) >= _SLOWEST_HZ) & (np.abs(frequency) <= _FASTEST_HZ)
    up, down = spectrum[wanted & (frequency > 0)].sum(), spectrum[wanted & (frequency < 0)].sum()
    return float((up - down) / (up + down)) if up + down > 0.0 else 0.0


def is_same_signal(pair_v: FloatArray) -> bool:
    """Return whether two channels, shape (2, n_samples), carry the same signal, be it with the other sign."""
    if pair_v.shape[1] < 8 or (pair_v.std(axis=1) == 0.0).any():
        return False
    return bool(abs(float(np.asarray(np.corrcoef(pair_v))[0, 1])) >= SAME)


def turns(pair_v: FloatArray) -> float | None:
    """Return by how many turns the phase of a pair, shape (2, n_samples), went on; None where it is no ellipse."""
    try:
        x, y = fit_ellipse(pair_v).apply(pair_v)
    except ProcessingError:
        return None
    phase = np.unwrap(np.arctan2(y, x))
    return float((phase[-1] - phase[0]) / (2.0 * np.pi)) if np.isfinite(phase).all() else None
