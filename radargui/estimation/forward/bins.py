"""Bins: short averages of the samples that keep what the samples say about a smooth motion (method 4, Bins)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from radargui.estimation.forward.sphere import PolarisedSphere, polarised_sphere
from radargui.estimation.signals import ScaledSignals
from radargui.model.arrays import BoolArray, FloatArray, IntArray
from radargui.model.gravity import expected_gravity_m_s2
from radargui.model.radar import Walls
from radargui.model.setup import Setup
from radargui.physics.edges import StatedEdges
from radargui.physics.path_length import Antennas, place_antennas
from radargui.physics.plate import StatedSurface
from radargui.physics.setup_unknowns import SetupUnknowns


@dataclass(frozen=True, slots=True)
class BinSettings:
    """How long a bin may be.

    Attributes
    ----------
    per_fringe
        Bins a fringe: the two nodes stand for the mean of a wave up to (pi / 24)^4 / 270, a millionth of its amplitude.
    longest_s
        While moving: less than half a knot's distance, so that no coefficient of the motion is without data.
    longest_at_rest_s
        At rest, where only noise and drift change. Both chosen by hand.
    """

    per_fringe: float = 24.0
    longest_s: float = 0.004
    longest_at_rest_s: float = 0.010


BINS = BinSettings()
_WEAKENED = 1e3
"""Times the noise of a bin that shall say next to nothing."""


@dataclass(frozen=True, slots=True)
class Bins:
    """Averages over 1/24 fringe or 4 ms, never across a break.

    The mean over a bin of a signal m(t) is (m(t - s) + m(t + s)) / 2 up to the fourth order in the bin's width, s the
    standard deviation of the sample times: the model is compared with the mean at these two nodes, so that nothing
    is lost and cost does not depend on the sample rate.

    Attributes
    ----------
    time_s
        Mean time of channel 0, shape (n_bins,).
    node_s
        s, shape (n_bins,).
    value
        Means, shape (n_channels, n_bins).
    sigma
        Standard deviation of the means, shape (n_channels, n_bins).
    count
        Samples in each bin.
    first_s, last_s
        Times of first and last sample.
    expected
        What the squared residual in units of `sigma` should be: below one where noise is not white, shape (n_channels,
        n_bins).
    """

    time_s: FloatArray
    node_s: FloatArray
    value: FloatArray
    sigma: FloatArray
    count: IntArray
    first_s: FloatArray
    last_s: FloatArray
    expected: FloatArray

    @property
    def n_bins(self) -> int:
        """Number of bins."""
        return int(self.time_s.size)

    @property
    def typical_sigma(self) -> FloatArray:
        """Median noise of a bin of one channel, mean of I and Q, shape (n_receivers,)."""
        return np.asarray(np.median(self.sigma.reshape(-1, 2, self.n_bins).mean(axis=1), axis=1))

    def of(self, which: IntArray) -> Bins:
        """Return some of the bins, by number, (n,)."""
        return replace(
            self,
            time_s=self.time_s[which],
            node_s=self.node_s[which],
            value=self.value[:, which],
            sigma=self.sigma[:, which],
            count=self.count[which],
            first_s=self.first_s[which],
            last_s=self.last_s[which],
            expected=self.expected[:, which],
        )

    def weakened(self, which: BoolArray) -> Bins:
        """Return the bins, some of which, (n_bins,), say next to nothing."""
        return replace(self, sigma=np.where(which, _WEAKENED * self.sigma, self.sigma))

    def known_to(self, u: FloatArray) -> Bins:
        """Return the bins where what they are told by is known to no better than u, shape (n_bins,)."""
        return replace(self, sigma=np.hypot(self.sigma, u))

    def runs(self, joins: BoolArray, most: int, settings: BinSettings = BINS) -> IntArray:
        """Return where runs of up to `most` neighbours begin, 4 ms at the longest, none across a gap.

        Parameters
        ----------
        joins
            Bins that may join the one before, shape (n_bins,).
        most
            How many.
        settings
            The longest.
        """
        # neighbours are a sample apart, all but those beside a gap
        step = self.first_s[1:] - self.last_s[:-1]
        apart = ~joins | np.append(True, step > 1.5 * step.min(initial=np.inf))
        begin = [0]
        for k in range(1, self.n_bins):
            if apart[k] or k - begin[-1] == most or self.last_s[k] - self.first_s[begin[-1]] > settings.longest_s:
                begin.append(k)
        return np.array(begin)

    def together(self, begin: IntArray) -> Bins:
        """Return the means over runs that begin at some bins, (n_runs,): mean and spread of all their samples."""
        last = np.append(begin[1:], self.n_bins) - 1
        count = np.add.reduceat(self.count, begin)
        time, value = (weighted_means(one, self.count, begin) for one in (self.time_s, self.value))
        away = self.time_s - np.repeat(time, last - begin + 1)
        spread = np.sqrt(weighted_means(self.node_s**2 + away**2, self.count, begin))
        # independent means of samples of equal weight
        square = weighted_means(self.count * self.sigma**2, self.count, begin) / count
        # what is not white is slower than a bin: its variance is no smaller in a longer one
        seen = np.minimum(weighted_means(self.sigma**2 * self.expected, self.count, begin) / square, 1.0)
        return Bins(time, spread, value, np.sqrt(square), count, self.first_s[begin], self.last_s[last], seen)


@dataclass(frozen=True, slots=True)
class Multiplexer:
    """How channels follow each other: each may keep a share kappa of the one before, the first of the last.

    Attributes
    ----------
    before
        Unit and sign of the channel before over those of each channel, shape (n_channels,).
    scan_s
        Time between samples of one channel.
    """

    before: FloatArray
    scan_s: float

    def excess(self, value: FloatArray, time_s: FloatArray) -> FloatArray:
        """Return the channel before minus the channel, d value / d kappa, for values (n_channels, n) at bins' times.

        Both are the model's: measured ones would share their noise with the residual.
        """
        # the scan before ended with the last channel
        last = np.interp(time_s - self.scan_s, time_s, value[-1])
        # each channel has its own unit and sign
        return np.asarray(self.before[:, None] * np.concatenate([last[None], value[:-1]]) - value)


@dataclass(frozen=True, slots=True)
class BinnedData:
    """The data of an estimate: what stays the same while motion and mismatch are improved.

    Attributes
    ----------
    bins
        Averages of the samples.
    antennas, release_m, wavelength_m
        Geometry; the tracer rests at `release_m`, shape (3,).
    rest
        Bins in which it surely rests, shape (n_bins,).
    delay_s
        Delay of each channel against channel 0, shape (n_channels,).
    onset_s
        End of the rest as seen in the samples.
    gravity_m_s2
        g of the place, for what asks whether something falls.
    sphere
        The tracer and the antennas' polarisation; None where it counts as a point.
    multiplexer
        What the channels may have of each other; None where that is not looked for.
    slow_noise
        Functions of slow noise at the bins (`Drift.uncorrelated`), shape (n_channels, n_bins, n); None without any.
    setup
        What the setup leaves open; None: nothing.
    walls
        Of a container in the rays; None where none stands there.
    surface
        What the setup says that the floor reflects; None: nothing.
    edges
        Where it says that the floor ends; None: nowhere.
    """

    bins: Bins
    antennas: Antennas
    release_m: FloatArray
    wavelength_m: float
    rest: BoolArray
    delay_s: FloatArray
    onset_s: float
    gravity_m_s2: float
    sphere: PolarisedSphere | None = None
    multiplexer: Multiplexer | None = None
    slow_noise: FloatArray | None = None
    setup: SetupUnknowns | None = None
    walls: Walls | None = None
    surface: StatedSurface | None = None
    edges: StatedEdges | None = None

    @staticmethod
    def of(bins: Bins, signals: ScaledSignals, setup: Setup) -> BinnedData:
        """Return the data of bins of some signals, with what the setup says of geometry and sphere."""
        return BinnedData(
            bins.weakened(bins.time_s < clear_of_holder_s(setup, signals.onset_s)),
            place_antennas(setup),
            np.asarray(setup.tracer.release_position_m),
            setup.radar.wavelength_m,
            bins.last_s < signals.rest_end_s,
            signals.delay_s,
            signals.onset_s,
            expected_gravity_m_s2(setup.site),
            polarised_sphere(setup),
            None if signals.before is None else Multiplexer(signals.before, 1.0 / signals.rate_hz),
            setup=SetupUnknowns.of(setup),
            walls=setup.container.walls,
            surface=StatedSurface.of(setup),
            edges=StatedEdges.of(setup),
        )

    @property
    def drift(self) -> FloatArray:
        """Functions of slow noise, shape (n_channels, n_bins, n), n = 0 without any."""
        return np.zeros((*self.bins.value.shape, 0)) if self.slow_noise is None else self.slow_noise

    def together(self, begin: IntArray) -> BinnedData:
        """Return the data with runs of bins that begin at some, (n_runs,), none partly at rest, as one bin each."""
        drift = weighted_means(self.drift.swapaxes(1, 2), self.bins.count, begin).swapaxes(1, 2)
        return replace(self, bins=self.bins.together(begin), rest=self.rest[begin], slow_noise=drift)


def clear_of_holder_s(setup: Setup, onset_s: float) -> float:
    """Return from when on a sphere is twice as far from what held it: before, nobody knows what that adds."""
    holder_m = setup.tracer.holder_distance_m
    if holder_m is None:
        return -np.inf
    return float(onset_s + np.sqrt(2.0 * holder_m / expected_gravity_m_s2(setup.site)))


def weighted_means(values: FloatArray, weight: IntArray, begin: IntArray) -> FloatArray:
    """Return means (..., n_runs) of values (..., n), weights (n,), over runs that begin at places (n_runs,)."""
    return np.asarray(np.add.reduceat(values * weight, begin, axis=-1) / np.add.reduceat(weight, begin))


def pool(signals: ScaledSignals, spacing_s: float) -> Bins:
    """Average runs of samples of equal length, about `spacing_s`."""
    length = max(1, int(spacing_s * signals.rate_hz + 1e-9))
    return _average(signals, np.arange(signals.time_s.size) // length)


def bin_by_fringe(
    signals: ScaledSignals,
    time_s: FloatArray,
    turns_hz: FloatArray,
    motion_start_s: float,
    breaks_s: FloatArray,
    settings: BinSettings = BINS,
) -> Bins:
    """Average over 1/24 fringe of the fastest receiver, at most 4 ms (10 ms at rest), broken at `breaks_s`.

    Parameters
    ----------
    signals
        Samples.
    time_s, turns_hz
        Fringes per second of the fastest receiver at some times, shape (n,).
    motion_start_s
        Before it the tracer rests.
    breaks_s
        Impacts and other times that no bin may contain, shape (n_breaks,).
    settings
        Lengths.
    """
    # by phase, not by time: near an apex a fringe lasts, at an impact it is over in milliseconds
    rate = np.interp(signals.time_s, time_s, turns_hz)
    longest = np.where(signals.time_s < motion_start_s, settings.longest_at_rest_s, settings.longest_s)
    # never longer than a knot's half, however slowly the phase turns
    progress = np.cumsum(np.maximum(settings.per_fringe * rate, 1.0 / longest)) / signals.rate_hz
    label = np.floor(progress).astype(np.intp)
    # a mean over an impact is a point on no circle
    part = np.searchsorted(np.concatenate([[motion_start_s], breaks_s]), signals.time_s)
    # lost samples: a bin across them would have its two nodes where nothing was seen
    gap = np.cumsum(np.diff(signals.time_s, prepend=signals.time_s[0]) > 1.5 / signals.rate_hz)
    change = np.flatnonzero((np.diff(label) != 0) | (np.diff(part) != 0) | (np.diff(gap) != 0)) + 1
    new = np.zeros(label.size, dtype=np.intp)
    new[change] = 1
    return _average(signals, np.cumsum(new))


def _average(signals: ScaledSignals, label: IntArray) -> Bins:
    # clipped samples are left out of their bin; the others keep it, with its own mean time
    keep = signals.usable
    label, time, value = label[keep], signals.time_s[keep], signals.value[:, keep]
    first = np.flatnonzero(np.diff(label, prepend=-1))
    count = np.diff(np.append(first, label.size))
    mean_time = np.add.reduceat(time, first) / count
    # of the samples that are there: the nodes then stand for them, also in a bin with a hole
    offset = time - np.repeat(mean_time, count)
    spread = np.sqrt(np.add.reduceat(offset**2, first) / count + signals.spread_s**2)
    mean = np.add.reduceat(value, first, axis=1) / count
    sigma = signals.sigma[:, None] / np.sqrt(count)
    return Bins(mean_time, spread, mean, sigma, count, time[first], time[first + count - 1], np.ones_like(sigma))
