"""Mains pick-up: measured while the tracer rests, taken off the whole record."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import minimize_scalar

from radargui.model.arrays import FloatArray
from radargui.model.pieces import pieces
from radargui.model.segment import Segment
from radargui.motion.mains import HARMONICS, MAINS_HZ, harmonics
from radargui.motion.noise import block_means
from radargui.motion.onset import find_onset

POOLED_HZ = 2000.0
LEAST_REST_S = 0.1
SEARCH_HZ = 0.5
"""A grid keeps its frequency within this of the nominal one."""
CONVINCING = 60.0
"""Drop of chi-square, beyond its degrees of freedom, that a harmonic must bring."""
BESIDE_HZ, STANDS_OUT = (-9.0, -6.0, 6.0, 9.0), 4.0
"""A line must bring more than this many times what lines beside it bring: 1/f noise is no hum."""
MARGIN_S = 0.03
"""Kept free before the onset of the motion."""
MARGIN_AFTER_S = 0.2
"""Kept free after the motion: the last small bounces, some 20 ms apart, are no hum either."""


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
        Amplitudes at time 0 of the record, shape (n_channels, n_orders).
    """

    frequency_hz: float
    orders: tuple[int, ...]
    cosine_v: FloatArray
    sine_v: FloatArray

    @property
    def amplitude_v(self) -> FloatArray:
        """Amplitude of the strongest harmonic in each channel, shape (n_channels,)."""
        return np.asarray(np.hypot(self.cosine_v, self.sine_v).max(axis=1))

    def at(self, time_s: FloatArray) -> FloatArray:
        """Return the pick-up at times of the record, volts, shape (n_channels, n_samples)."""
        weights = np.stack([self.cosine_v, self.sine_v], axis=2).reshape(self.cosine_v.shape[0], -1)
        out = np.empty((weights.shape[0], time_s.size))
        for part in pieces(time_s.size):
            out[:, part] = weights @ harmonics(time_s[part], self.frequency_hz, self.orders)
        return out


def rests(segment: Segment, n_samples: int, sample_rate_hz: float) -> tuple[slice, ...]:
    """Return the samples before and after the motion in which the tracer rests."""
    after = segment.last + round(MARGIN_AFTER_S * sample_rate_hz)
    found = (slice(segment.rest_first, segment.rest_last), slice(after, n_samples))
    return tuple(rest for rest in found if rest.stop - rest.start >= 0.5 * LEAST_REST_S * sample_rate_hz)


def find_hum(volts: FloatArray, sample_rate_hz: float, rest: Sequence[slice], noise_v: FloatArray) -> Hum | None:
    """Find the pick-up of the mains in the samples at rest, by least squares in amplitudes and frequency.

    Where the tracer rests its signal is constant, so that nothing of the motion is taken for a hum; a straight line a
    channel and rest carries offset and drift.

    Parameters
    ----------
    volts
        Finite, shape (n_channels, n_samples).
    sample_rate_hz
        Rate of each channel.
    rest
        Stretches at rest.
    noise_v
        White noise of each channel, shape (n_channels,).

    Returns
    -------
    Hum or None
        None where less than 0.1 s is at rest or no hum stands out of the noise.
    """
    if sum(part.stop - part.start for part in rest) < LEAST_REST_S * sample_rate_hz:
        return None
    size = max(1, round(sample_rate_hz / POOLED_HZ))
    stretches = [_pooled(volts[:, part], part.start, size, sample_rate_hz) for part in rest]
    sigma = noise_v / np.sqrt(size)
    # two rests far apart make many minima side by side: all frequencies are looked at
    span_s = (rest[-1].stop - rest[0].start) / sample_rate_hz
    step = min(0.1, 0.15 / span_s)
    grid = np.concatenate([nominal + np.arange(-SEARCH_HZ, SEARCH_HZ + step, step) for nominal in MAINS_HZ])
    frequency = float(min(grid, key=lambda f: _misfit(stretches, sigma, f, (1,))))
    orders: tuple[int, ...] = ()
    flat = misfit = _misfit(stretches, sigma, frequency, orders)
    for order in range(1, HARMONICS + 1):
        if order * frequency < 0.4 * sample_rate_hz / size:
            other = _misfit(stretches, sigma, frequency, (*orders, order))
            beside = [_misfit(stretches, sigma, order * frequency + away, (1,)) for away in BESIDE_HZ]
            usual = max(0.0, flat - float(np.mean(beside)))
            if misfit - other > CONVINCING + 2.0 * volts.shape[0] + STANDS_OUT * usual:
                orders, misfit = (*orders, order), other
    if not orders:
        return None
    refined = minimize_scalar(
        lambda f: _misfit(stretches, sigma, f, orders),
        bounds=(frequency - step, frequency + step),
        method="bounded",
        options={"xatol": 1e-6},
    )
    frequency = float(refined.x)
    amplitudes = _solve(stretches, frequency, orders)[0]
    # a mean over `size` samples makes an oscillation smaller by its Dirichlet kernel
    angle = np.pi * np.array(orders) * frequency / sample_rate_hz
    shrunk = np.sin(size * angle) / (size * np.sin(angle))
    return Hum(frequency, orders, (amplitudes[0::2].T / shrunk), (amplitudes[1::2].T / shrunk))


def without_hum(volts: FloatArray, sample_rate_hz: float, segment: Segment | None, noise_v: FloatArray) -> FloatArray:
    """Return the voltages less the pick-up of the mains found while the tracer rests, same shape.

    Parameters
    ----------
    volts
        Finite, shape (n_channels, n_samples).
    sample_rate_hz
        Rate of each channel.
    segment
        The motion; None leaves the voltages as they are.
    noise_v
        White noise of each channel, shape (n_channels,).
    """
    if segment is None:
        return volts
    time = np.arange(volts.shape[1]) / sample_rate_hz
    hum = find_hum(volts, sample_rate_hz, rests(segment, volts.shape[1], sample_rate_hz), noise_v)
    if hum is None:
        return volts
    # a slow beginning of the motion, still counted as rest, can look like a weak hum: once more without it
    onset = find_onset(time, volts - hum.at(time))
    if onset is not None and MARGIN_S < onset < segment.rest_last / sample_rate_hz + MARGIN_S:
        earlier = replace(segment, rest_last=round((onset - MARGIN_S) * sample_rate_hz))
        hum = find_hum(volts, sample_rate_hz, rests(earlier, volts.shape[1], sample_rate_hz), noise_v)
    return volts if hum is None else volts - hum.at(time)


def _pooled(volts: FloatArray, start: int, size: int, rate_hz: float) -> tuple[FloatArray, FloatArray]:
    """Return times and block means of a rest; shapes (n,) and (n_channels, n)."""
    means = block_means(volts, size)
    middle = start + 0.5 * (size - 1) + size * np.arange(means.shape[1], dtype=np.float64)
    return middle / rate_hz, means


def _solve(
    stretches: Sequence[tuple[FloatArray, FloatArray]], frequency_hz: float, orders: Sequence[int]
) -> tuple[FloatArray, FloatArray]:
    """Return amplitudes, cosine and sine by turns, shape (2 n_orders, n_channels), and all residuals."""
    total = sum(time.size for time, _ in stretches)
    design = np.zeros((total, 2 * len(orders) + 2 * len(stretches)))
    begin = 0
    for number, (time, _) in enumerate(stretches):
        rows = slice(begin, begin + time.size)
        begin += time.size
        design[rows, : 2 * len(orders)] = harmonics(time, frequency_hz, orders).T
        design[rows, 2 * len(orders) + 2 * number] = 1.0
        design[rows, 2 * len(orders) + 2 * number + 1] = time - time.mean()
    values = np.concatenate([means for _, means in stretches], axis=1).T
    solution, *_ = np.linalg.lstsq(design, values, rcond=None)
    return solution[: 2 * len(orders)], values - design @ solution


def _misfit(
    stretches: Sequence[tuple[FloatArray, FloatArray]], sigma_v: FloatArray, frequency_hz: float, orders: Sequence[int]
) -> float:
    residual = _solve(stretches, frequency_hz, orders)[1]
    return float(((residual / sigma_v) ** 2).sum())
