"""Mains pick-up: measured while the tracer rests, taken off the whole record."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import minimize_scalar

from radargui.model.arrays import FloatArray
from radargui.model.segment import Segment
from radargui.motion.mains import HARMONICS, MAINS_HZ
from radargui.motion.onset import find_onset

POOLED_HZ = 2000.0
LEAST_REST_S = 0.1
SEARCH_HZ = 0.5
"""A grid keeps its frequency within this of the nominal one."""
CONVINCING = 60.0
"""Drop of chi-square, beyond its degrees of freedom, that a harmonic must bring."""
MARGIN_S = 0.03
"""Kept free between the end of the motion and the rest after it."""


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
        out = np.zeros((self.cosine_v.shape[0], time_s.size))
        for place, order in enumerate(self.orders):
            angle = 2.0 * np.pi * order * self.frequency_hz * time_s
            out += self.cosine_v[:, place, None] * np.cos(angle) + self.sine_v[:, place, None] * np.sin(angle)
        return out


def rests(segment: Segment, n_samples: int, sample_rate_hz: float) -> tuple[slice, ...]:
    """Return the samples before and after the motion in which the tracer rests."""
    after = segment.last + round(MARGIN_S * sample_rate_hz)
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
    pieces = [_pooled(volts[:, part], part.start, size, sample_rate_hz) for part in rest]
    sigma = noise_v / np.sqrt(size)
    searched = [
        minimize_scalar(
            lambda f: _misfit(pieces, sigma, f, (1,)),
            bounds=(nominal - SEARCH_HZ, nominal + SEARCH_HZ),
            method="bounded",
        )
        for nominal in MAINS_HZ
    ]
    frequency = float(min(searched, key=lambda found: found.fun).x)
    orders: tuple[int, ...] = ()
    misfit = _misfit(pieces, sigma, frequency, orders)
    for order in range(1, HARMONICS + 1):
        if order * frequency < 0.4 * sample_rate_hz / size:
            other = _misfit(pieces, sigma, frequency, (*orders, order))
            if misfit - other > CONVINCING + 2.0 * volts.shape[0]:
                orders, misfit = (*orders, order), other
    if not orders:
        return None
    refined = minimize_scalar(
        lambda f: _misfit(pieces, sigma, f, orders),
        bounds=(frequency - 0.05, frequency + 0.05),
        method="bounded",
        options={"xatol": 1e-6},
    )
    frequency = float(refined.x)
    amplitudes = _solve(pieces, frequency, orders)[0]
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
    count = volts.shape[1] // size
    means = volts[:, : count * size].reshape(volts.shape[0], count, size).mean(axis=2)
    return (start + np.arange(count) * size + 0.5 * (size - 1)) / rate_hz, means


def _solve(
    pieces: Sequence[tuple[FloatArray, FloatArray]], frequency_hz: float, orders: Sequence[int]
) -> tuple[FloatArray, FloatArray]:
    """Return amplitudes, cosine and sine by turns, shape (2 n_orders, n_channels), and all residuals."""
    total = sum(time.size for time, _ in pieces)
    design = np.zeros((total, 2 * len(orders) + 2 * len(pieces)))
    begin = 0
    for number, (time, _) in enumerate(pieces):
        rows = slice(begin, begin + time.size)
        begin += time.size
        for place, order in enumerate(orders):
            angle = 2.0 * np.pi * order * frequency_hz * time
            design[rows, 2 * place], design[rows, 2 * place + 1] = np.cos(angle), np.sin(angle)
        design[rows, 2 * len(orders) + 2 * number] = 1.0
        design[rows, 2 * len(orders) + 2 * number + 1] = time - time.mean()
    values = np.concatenate([means for _, means in pieces], axis=1).T
    solution, *_ = np.linalg.lstsq(design, values, rcond=None)
    return solution[: 2 * len(orders)], values - design @ solution


def _misfit(
    pieces: Sequence[tuple[FloatArray, FloatArray]], sigma_v: FloatArray, frequency_hz: float, orders: Sequence[int]
) -> float:
    residual = _solve(pieces, frequency_hz, orders)[1]
    return float(((residual / sigma_v) ** 2).sum())
