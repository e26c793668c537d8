"""Measure the hum of the mains while the tracer rests, in a recording or live, and distinguish it from motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from radargui.model.arrays import FloatArray, pieces
from radargui.signals.averager import block_means

MAINS_HZ = (50.0, 60.0)  # nominal, of public grids (IEC 60196)
MAINS_WITHIN_HZ = 0.4
"""So near to a multiple of the mains a line is of the mains: a tone comes so near to one of the fifteen below 500 Hz by
chance in 2 of 100 cases."""
HARMONICS = 5
"""Orders that are looked for; chosen by hand: the recordings at hand show none beyond."""


@dataclass(frozen=True, slots=True)
class HumSettings:
    """How the hum is searched.

    Attributes
    ----------
    pooled_hz
        Rate of the means that the hum is fitted to: eight of them in a period of the fifth harmonic.
    min_rest_s
        Least rest, five periods of 50 Hz: a shorter one does not distinguish a hum from a drift.
    search_hz
        Largest distance from the nominal frequency; chosen by hand, wide enough for a generator.
    frequency_sd_hz
        Standard deviation of the grid's frequency, prior for rests too short to tell it: the European grid's standard
        frequency range is +-0.05 Hz.
    convincing
        Drop of chi-square that a harmonic must bring beyond two a channel; chosen by hand: of 1000 rests of pure noise
        none brought it.
    beside_hz, stands_out
        A harmonic must lower chi-square by so many times what lines `beside_hz` beside it do, since 1/f noise lowers it
        everywhere.
    """

    pooled_hz: float = 2000.0
    min_rest_s: float = 0.1
    search_hz: float = 0.5
    frequency_sd_hz: float = 0.05
    convincing: float = 60.0
    beside_hz: tuple[float, ...] = (-9.0, -6.0, 6.0, 9.0)
    stands_out: float = 4.0


SETTINGS = HumSettings()
SHORTLIST = 8
"""Frequencies with the strongest lines among which least squares choose: in a short rest lines leak into each other."""
_Rest = tuple[FloatArray, FloatArray]
"""Times and block means of a rest, shapes (n,) and (n_channels, n)."""


@dataclass(frozen=True, slots=True)
class Hum:
    """Sinusoids at harmonics of the mains.

    Attributes
    ----------
    frequency_hz
        Of the mains.
    orders
        Harmonics found.
    cosine_v, sine_v
        Amplitudes at time 0, shape (n_channels, n_orders).
    """

    frequency_hz: float
    orders: tuple[int, ...]
    cosine_v: FloatArray
    sine_v: FloatArray

    @property
    def lines_hz(self) -> tuple[float, ...]:
        """Frequencies of the harmonics found."""
        return tuple(order * self.frequency_hz for order in self.orders)

    def at(self, time_s: FloatArray) -> FloatArray:
        """Return the pick-up in volts, shape (n_channels, n_samples)."""
        weights = np.stack([self.cosine_v, self.sine_v], axis=2).reshape(self.cosine_v.shape[0], -1)
        out = np.empty((weights.shape[0], time_s.size))
        for part in pieces(time_s.size):
            out[:, part] = weights @ harmonics(time_s[part], self.frequency_hz, self.orders)
        return out


def find_hum(volts: FloatArray, sample_rate_hz: float, rests: Sequence[slice], noise_v: FloatArray) -> Hum | None:
    """Find the pick-up of the mains in the samples at rest, by least squares in amplitudes and frequency.

    Where the tracer rests its signal is constant, so that nothing of the motion is taken for a hum; a straight line a
    channel and rest carries offset and drift.

    Parameters
    ----------
    volts
        Finite, shape (n_channels, n_samples); sample n is taken at n / rate.
    sample_rate_hz
        Rate of each channel.
    rests
        Stretches at rest.
    noise_v
        White noise of each channel, shape (n_channels,).

    Returns
    -------
    Hum or None
        None where less than 0.1 s is at rest or no hum stands out of the noise.
    """
    if sum(part.stop - part.start for part in rests) < SETTINGS.min_rest_s * sample_rate_hz:
        return None
    size = max(1, round(sample_rate_hz / SETTINGS.pooled_hz))
    means = tuple(_pooled(volts[:, part], part.start, size, sample_rate_hz) for part in rests)
    pooled = _Rests(means, noise_v**2 / size)

    def misfit_with_prior(frequency_hz: float, orders: Sequence[int]) -> float:
        away = min(abs(frequency_hz - nominal) for nominal in MAINS_HZ)
        return pooled.misfit(frequency_hz, orders) + (away / SETTINGS.frequency_sd_hz) ** 2

    # two rests far apart make many minima side by side: all frequencies are looked at
    span_s = (rests[-1].stop - rests[0].start) / sample_rate_hz
    step = min(0.1, 0.15 / span_s)
    around = np.arange(-SETTINGS.search_hz, SETTINGS.search_hz + step, step)
    grid = np.concatenate([nominal + around for nominal in MAINS_HZ])
    # so near to half of the rate a line and what folds back are one
    if grid.max() > 0.4 * sample_rate_hz / size:
        return None
    # a least-squares solution for each would be half of the work of a whole recording
    shown = np.concatenate([pooled.shown(nominal, around) for nominal in MAINS_HZ])
    shown -= (np.tile(around, len(MAINS_HZ)) / SETTINGS.frequency_sd_hz) ** 2
    frequency = float(min(grid[np.argsort(shown)[-SHORTLIST:]], key=lambda f: misfit_with_prior(f, (1,))))
    orders: tuple[int, ...] = ()
    flat = least = pooled.misfit(frequency, orders)
    for order in range(1, HARMONICS + 1):
        if order * frequency > 0.4 * sample_rate_hz / size:
            break
        other = pooled.misfit(frequency, (*orders, order))
        enough = SETTINGS.convincing + 2.0 * volts.shape[0]
        if least - other <= enough:
            continue
        beside = [pooled.misfit(order * frequency + away, (1,)) for away in SETTINGS.beside_hz]
        # 1/f noise fits lines beside the mains as well
        usual = max(0.0, flat - float(np.mean(beside)))
        if least - other > enough + SETTINGS.stands_out * usual:
            orders, least = (*orders, order), other
    if not orders:
        return None
    # a quarter of a second to load, for the few records that hum
    from scipy.optimize import minimize_scalar

    bounds = (frequency - step, frequency + step)
    refined = minimize_scalar(lambda f: misfit_with_prior(f, orders), bounds=bounds, options={"xatol": 1e-6})
    frequency = float(refined.x)
    amplitudes = _solve(pooled.rests, frequency, orders)[0][: 2 * len(orders)]
    # a mean over `size` samples makes an oscillation smaller by its Dirichlet kernel
    angle = np.pi * np.array(orders) * frequency / sample_rate_hz
    shrunk = np.sin(size * angle) / (size * np.sin(angle))
    return Hum(frequency, orders, amplitudes[0::2].T / shrunk, amplitudes[1::2].T / shrunk)


def without_mains(volts: FloatArray, sample_rate_hz: float, frequency_hz: float, *, line: bool = True) -> FloatArray:
    """Return the voltages less a straight line and the least-squares sinusoids at the mains and its harmonics.

    This distinguishes a hum from a motion before a rest is known. It also removes a motion at that Doppler frequency.

    Parameters
    ----------
    volts
        Shape (n_channels, n_samples).
    sample_rate_hz
        Rate of each channel.
    frequency_hz
        Frequency of the mains.
    line
        Whether the straight line is taken off too.
    """
    time = np.arange(volts.shape[1]) / sample_rate_hz
    orders = [order for order in range(1, HARMONICS + 1) if order * frequency_hz < 0.45 * sample_rate_hz]
    basis = np.concatenate([np.stack([np.ones_like(time), time]), harmonics(time, frequency_hz, orders)]).T
    coefficients, *_ = np.linalg.lstsq(basis, volts.T, rcond=None)
    first = 0 if line else 2
    return np.asarray(volts - (basis[:, first:] @ coefficients[first:]).T)


def harmonics(time_s: FloatArray, frequency_hz: float, orders: Sequence[int]) -> FloatArray:
    """Return cosine and sine by turns of each order of the mains at times, shape (2 n_orders, n)."""
    angle = 2.0 * np.pi * frequency_hz * np.asarray(orders, dtype=np.float64)[:, None] * time_s
    return np.stack([np.cos(angle), np.sin(angle)], axis=1).reshape(-1, time_s.size)


def _pooled(volts: FloatArray, start: int, size: int, rate_hz: float) -> _Rest:
    means = block_means(volts, size)
    middle = start + 0.5 * (size - 1) + size * np.arange(means.shape[1], dtype=np.float64)
    # the line of each rest is fitted in any case: without the offset its sums keep their digits
    return middle / rate_hz, means - means.mean(axis=1, keepdims=True)


def _levelled(time_s: FloatArray, means: FloatArray) -> FloatArray:
    """Return the means of a rest, which add up to nothing, less the slope of their line, same shape."""
    along = time_s - time_s.mean()
    return np.asarray(means - (means @ along / (along @ along))[:, None] * along)


def _solve(rests: Sequence[_Rest], frequency_hz: float, orders: Sequence[int]) -> tuple[FloatArray, FloatArray]:
    """Return amplitudes, cosine and sine by turns, then a line a rest, (n, n_channels), and the pulls they answer to.

    The normal equations are small and well conditioned (sines over many periods, centred lines), and cheap enough for
    the live track.
    """
    n_waves = 2 * len(orders)
    n = n_waves + 2 * len(rests)
    normal, pull = np.zeros((n, n)), np.zeros((n, rests[0][1].shape[0]))
    for number, (time, means) in enumerate(rests):
        along = time - time.mean()
        rows = np.concatenate([harmonics(time, frequency_hz, orders), [np.ones_like(time), along]])
        own = [*range(n_waves), n_waves + 2 * number, n_waves + 2 * number + 1]
        normal[np.ix_(own, own)] += rows @ rows.T
        pull[own] += rows @ means.T
    return np.asarray(np.linalg.solve(normal, pull), dtype=np.float64), pull


class _Rests:
    """Block means of all rests, and how badly waves fit them."""

    def __init__(self, rests: tuple[_Rest, ...], variance_v2: FloatArray) -> None:
        self.rests, self._variance = rests, variance_v2
        self._total = np.sum([(means**2).sum(axis=1) for _, means in rests], axis=0)

    def misfit(self, frequency_hz: float, orders: Sequence[int]) -> float:
        """Return the sum of squared residuals over the noise's variance, all channels together."""
        solution, pull = _solve(self.rests, frequency_hz, orders)
        return float(((self._total - (solution * pull).sum(axis=0)) / self._variance).sum())

    def shown(self, nominal_hz: float, around_hz: FloatArray) -> FloatArray:
        """Return about what a line at each distance from a frequency takes off the misfit, shape (n,).

        The rests are shifted to zero frequency, where sums over a period hold all that is near that frequency.
        """
        amplitude, count = np.zeros((around_hz.size, self._variance.size), dtype=np.complex128), 0
        for time_s, means in self.rests:
            level = _levelled(time_s, means)
            first = np.flatnonzero(np.diff(np.floor(time_s * nominal_hz), prepend=-1.0))
            periods = np.add.reduceat(level * np.exp(-2j * np.pi * nominal_hz * time_s), first, axis=1)
            amplitude += np.exp(-2j * np.pi * np.outer(around_hz, time_s[first] + 0.5 / nominal_hz)) @ periods.T
            count += time_s.size
        return np.asarray((2.0 / count * np.abs(amplitude) ** 2 / self._variance).sum(axis=1))
