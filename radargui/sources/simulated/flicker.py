"""1/f noise, the same however a run is read: slow states at the chunks' edges, exact bridges between them."""

from __future__ import annotations

import numpy as np
from scipy.signal import lfilter

from radargui.model.arrays import FloatArray
from radargui.model.simulation import Simulation
from radargui.sources.simulated.anchors import Anchors
from radargui.sources.simulated.seeds import Stream, generator

LOWEST_HZ, HIGHEST_HZ = 0.1, 1000.0
_CORNERS_HZ = np.geomspace(0.01, 10_000.0, 9)


class Flicker:
    """Independent 1/f noise of all channels.

    Each channel gets the sum of nine Ornstein-Uhlenbeck processes of equal variance s^2 with corner frequencies f_c
    from 0.01 Hz to 10 kHz, evenly spread in log f. Its one-sided spectral density,
    sum 2 s^2 / (pi f_c (1 + (f / f_c)^2)), is C / f within 3 % from 0.1 Hz to 1 kHz (van der Ziel 1950: a spread of
    relaxation times gives 1/f). s is such that the root mean square in this band is `flicker` amplitudes; a decade
    then holds half of that. Below and above the band it goes on for a decade: a run also has an offset of this size,
    and at a low rate the converter folds the fast part down, as one without a filter does.

    The states at the edges of the chunks are an exact autoregression (see `Anchors`), inside a chunk each process
    is drawn free and then bent to meet the next state: the exact distribution of a bridge (conditioning by kriging).

    Parameters
    ----------
    simulation
        Its `flicker`, `amplitude_v` and `seed`.
    rate_hz
        Samples per second and channel.
    n_channels
        Number of channels.
    run
        Each run has its own noise.
    chunk_length
        Samples of a chunk.
    """

    def __init__(self, simulation: Simulation, rate_hz: float, n_channels: int, run: int, chunk_length: int) -> None:
        self._seed, self._run = simulation.seed, run
        self._scale_v = simulation.amplitude_v * simulation.flicker * _unit_scale()
        self._shape = (_CORNERS_HZ.size, n_channels, chunk_length)
        # the decay over one sample is exp(-loss)
        self._loss = 2.0 * np.pi * _CORNERS_HZ / rate_hz
        self._anchors = Anchors(simulation.seed, run, self._loss * chunk_length, n_channels)
        steps = np.arange(1, chunk_length + 1)
        loss = self._loss[:, None]
        self._decay = np.exp(-loss * steps)
        self._share = np.exp(-loss * (chunk_length - steps)) * np.expm1(-2.0 * loss * steps)
        self._share /= np.expm1(-2.0 * loss * chunk_length)

    def add_to(self, volts: FloatArray, chunk: int) -> None:
        """Add the noise of a chunk to its volts (n_channels, chunk_length)."""
        start, end = self._anchors.around(chunk)
        drawn = generator(self._seed, Stream.FLICKER, self._run, chunk).standard_normal(self._shape)
        total = np.zeros(self._shape[1:])
        for term, loss in enumerate(self._loss):
            kick = np.sqrt(-np.expm1(-2.0 * loss))
            free = lfilter([kick], [1.0, -np.exp(-loss)], drawn[term])
            decay, share = self._decay[term], self._share[term]
            missed = end[term] - decay[-1] * start[term] - free[:, -1]
            total += free
            total += start[term][:, None] * decay
            total += missed[:, None] * share
        # steps run from 1: the last one is the first sample of the next chunk
        volts[:, 1:] += self._scale_v * total[:, :-1]
        volts[:, 0] += self._scale_v * start.sum(axis=0)


def spectral_density(frequency_hz: FloatArray) -> FloatArray:
    """Return the one-sided density in 1/Hz, shape (n,), of noise with root mean square 1 between 0.1 Hz and 1 kHz."""
    shape = 1.0 / (_CORNERS_HZ[:, None] * (1.0 + (frequency_hz / _CORNERS_HZ[:, None]) ** 2))
    return np.asarray(_unit_scale() ** 2 * 2.0 / np.pi * shape.sum(axis=0))


def _unit_scale() -> float:
    """Return s for root mean square 1 in the band: the density of each process integrates to an arctangent."""
    inside = np.arctan(HIGHEST_HZ / _CORNERS_HZ) - np.arctan(LOWEST_HZ / _CORNERS_HZ)
    return float(1.0 / np.sqrt(2.0 / np.pi * inside.sum()))
