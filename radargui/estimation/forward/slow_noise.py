"""Slow noise: 1/f noise measured on the rest, and the functions of time for its slow part (method 4, Slow noise)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import minimize_scalar

from radargui.estimation.forward.bins import Bins
from radargui.estimation.signals import ScaledSignals
from radargui.model.arrays import BoolArray, FloatArray

_ROOT_12 = 3.4641  # width of a bin over the standard deviation of its times


@dataclass(frozen=True, slots=True)
class SlowNoiseSettings:
    """When slow noise counts and what carries it.

    Attributes
    ----------
    cycles
        Of the fastest Fourier function over the record; above it 1/f noise counts as white. Chosen by hand: 4 x 20
        columns a channel.
    drift_half_cycles
        Slowest functions that carry a drift: 6 half cycles follow a bend within the record. Chosen by hand.
    drift_sigmas
        A slope of the rest counts as drift where it stands out by this many deviations in some channel. Chosen by
        hand.
    spectrum_hz
        Rate to which samples are pooled before their periodogram: 1/f noise of interest lies far below.
    gain_a_channel
        Twice what ln likelihood must gain a channel by white + a/f over white: one more parameter gains 2 by chance
        once in twenty.
    white_share
        a/f must exceed this share of the white density at the fastest function: else the functions would fit noise.
    variance_a_bin
        1/f noise of density a/f at the Doppler frequency f, one-sided, in bins of 1/24 fringe: the white variance
        a/f x rate/2 = 12 a (derivation).
    min_samples
        Of the pooled rest: fewer make no spectrum.
    min_variance
        What a function must carry, summed over the bins in units of their variance, to be an unknown: the others say
        5e-5 each in ln E, and 80 functions of half cycles over one record are 50 that differ.
    """

    cycles: int = 20
    drift_half_cycles: int = 6
    drift_sigmas: float = 6.0
    spectrum_hz: float = 2000.0
    gain_a_channel: float = 4.0
    white_share: float = 0.5
    variance_a_bin: float = 12.0
    min_samples: int = 32
    min_variance: float = 1e-4


SLOW_NOISE = SlowNoiseSettings()


@dataclass(frozen=True, slots=True)
class Drift:
    """Fourier functions over the record with the deviations that 1/f noise gives them.

    Attributes
    ----------
    first_s, length_s
        Span of the record.
    count
        Number of functions; 0 where the noise is white.
    sd
        Deviations of the coefficients, shape (n_channels, count).
    level
        a of the spectral density a / f, in amplitudes^2, shape (n_channels,).
    """

    first_s: float
    length_s: float
    count: int
    sd: FloatArray
    level: FloatArray

    def functions(self, time_s: FloatArray) -> FloatArray:
        """Return the functions at times, shape (n, count): cosines and sines of whole and half cycles."""
        # half cycles too: a drift does not end where it began
        turn = np.pi * (time_s - self.first_s) / self.length_s
        order = np.arange(1, self.count // 2 + 1)
        angle = turn[:, None] * order
        return np.concatenate([np.cos(angle), np.sin(angle)], axis=1)

    def uncorrelated(self, bins: Bins) -> FloatArray:
        """Return each channel's functions at the bins with coefficients N(0, 1), shape (n_channels, n_bins, n).

        The same Gaussian process as `functions` with `sd`, by its uncorrelated parts (Karhunen-Loeve); those that no
        bin would feel are left out.
        """
        if self.count == 0:
            return np.zeros((len(bins.sigma), bins.n_bins, 0))
        functions, out, n = self.functions(bins.time_s), [], 0
        for sd, sigma in zip(self.sd, bins.sigma, strict=True):
            prior = functions * sd
            # in variances of the bins: what a coefficient of one deviation makes of all of them together
            felt, turned = np.linalg.eigh((prior / sigma[:, None] ** 2).T @ prior)
            out.append(prior @ turned[:, ::-1])
            n = max(n, int((felt > SLOW_NOISE.min_variance).sum()))
        return np.array(out)[:, :, :n]

    def widen(self, bins: Bins) -> Bins:
        """Return the bins with the part of 1/f noise that the functions cannot follow added to their variance.

        A bin is 1/24 fringe: noise of density a / f at the Doppler frequency f counts like white noise of variance
        12 a in each bin.
        """
        if self.count == 0:
            return bins
        level = self.level[:, None]
        variance = bins.sigma**2 + SLOW_NOISE.variance_a_bin * level
        # a bin's mean keeps what is slower than itself, and the functions have taken what is slower than they
        highest = self.count / 4.0 / self.length_s
        seen = bins.sigma**2 + level * np.log(np.maximum(1.0 / (2.0 * _ROOT_12 * bins.node_s * highest + 1e-12), 1.5))
        return replace(bins, sigma=np.sqrt(variance), expected=np.minimum(seen / variance, 1.0))


NO_DRIFT = Drift(0.0, 1.0, 0, np.zeros((0, 0)), np.zeros(0))
"""Where nothing is asked of it."""


def measure_drift(signals: ScaledSignals, onset_s: float, settings: SlowNoiseSettings = SLOW_NOISE) -> Drift:
    """Fit white + a / f to the periodogram of the rest (Whittle's likelihood) and decide whether 1/f noise matters.

    It does where ln likelihood gains more than 2 a channel in the mean, and a / f exceeds half of the white density at
    20 cycles over the record in the median channel.

    Parameters
    ----------
    signals
        Samples.
    onset_s
        End of the rest.
    settings
        Limits.
    """
    rest = signals.time_s < onset_s
    length = float(signals.time_s[-1] - signals.time_s[0])
    n_channels = signals.value.shape[0]
    level, gained = np.zeros(n_channels), 0.0
    pooled = max(1, int(signals.rate_hz / settings.spectrum_hz))
    count = int(rest.sum()) // pooled
    # one-sided: all of the variance lies below half the rate
    white = 2.0 * signals.sigma**2 / signals.rate_hz
    # no spectrum, no drift that anybody could tell
    if count < settings.min_samples:
        return Drift(float(signals.time_s[0]), length, 0, np.zeros((n_channels, 0)), level)
    slow = _slow_deviation(signals, rest, length, settings)
    rate = signals.rate_hz / pooled
    for channel in range(n_channels):
        # pooled: a spectrum to 2 kHz tells white from a / f, and the offset at zero frequency says nothing
        samples = signals.value[channel, : count * pooled].reshape(count, pooled).mean(axis=1)
        level[channel], gain = _whittle(samples - samples.mean(), rate, float(white[channel]))
        gained += gain
    highest = settings.cycles / length
    needed = settings.gain_a_channel * n_channels / 2.0
    if gained < needed or np.median(level / highest / white) < settings.white_share:
        return Drift(float(signals.time_s[0]), length, slow.shape[1], slow, np.zeros(n_channels))
    # density times the distance of the functions' frequencies: what noise has in each
    order = np.arange(1, 2 * settings.cycles + 1)
    variance = level[:, None] / (order / (2.0 * length)) / (2.0 * length)
    sd = np.sqrt(np.concatenate([variance, variance], axis=1))
    half = slow.shape[1] // 2
    for part in (slice(0, half), slice(2 * settings.cycles, 2 * settings.cycles + half)):
        sd[:, part] = np.hypot(sd[:, part], slow[:, :half])
    return Drift(float(signals.time_s[0]), length, 4 * settings.cycles, np.maximum(sd, 1e-7), level)


def _slow_deviation(
    signals: ScaledSignals, rest: BoolArray, length_s: float, settings: SlowNoiseSettings
) -> FloatArray:
    """Return deviations of the slowest functions from how fast the offsets drift at rest, shape (n_channels, n).

    A drift shows as a slope of the rest, root mean square over the channels s. A function of k half cycles has slopes
    up to pi k / length: with deviation 2 s length / (pi k^2) the slow ones can carry it. None where no slope stands
    out.
    """
    time = signals.time_s[rest] - signals.time_s[rest].mean()
    slopes = (signals.value[:, rest] @ time) / (time @ time)
    # less what white noise alone gives a slope
    excess = slopes**2 - signals.sigma**2 / (time @ time)
    if (slopes**2 * (time @ time) < settings.drift_sigmas**2 * signals.sigma**2).all() or excess.mean() <= 0.0:
        return np.zeros((slopes.size, 0))
    order = np.arange(1, settings.drift_half_cycles + 1)
    sd = 2.0 * np.sqrt(excess.mean()) * length_s / (np.pi * order**2)
    return np.tile(np.concatenate([sd, sd]), (slopes.size, 1))


def _whittle(samples: FloatArray, rate_hz: float, white: float) -> tuple[float, float]:
    """Return a of white + a / f for a periodogram and what it gains in log likelihood over white alone."""
    n = samples.size
    # without a window a drift leaks into every frequency, and all noise looks like 1/f
    window = np.hanning(n)
    # one-sided density, what the window took off put back
    power = 2.0 * np.abs(np.fft.rfft(samples * window)) ** 2 / (rate_hz * (window**2).sum())
    frequency = np.fft.rfftfreq(n, 1.0 / rate_hz)
    # not the highest: there the mixer's filter may have taken noise away
    use = slice(2, max(4, int(0.8 * frequency.size)))
    power, frequency = power[use], frequency[use]

    def loss(log_level: float) -> float:
        density = white + np.exp(log_level) / frequency
        return float((np.log(density) + power / density).sum()) * 0.5

    starts = np.log(white * np.array([1.0, 100.0]))
    best = min((minimize_scalar(loss, (one, one + 1.0)) for one in starts), key=lambda result: float(result.fun))
    # e^-60 is no 1/f noise at all
    return float(np.exp(best.x)), loss(-60.0) - float(best.fun)
