"""Six channels of garbage, seven kinds: nothing in them is the motion of one sphere."""

from __future__ import annotations

import numpy as np
from scipy import signal

from radargui.model.arrays import FloatArray
from radargui.model.recording import Digitisation, Recording, iq_names

RATE_HZ = 33333.0
DURATION_S = 3.0
RANGE_V = 5.0
REST_S = 0.8


def _sinusoids(rng: np.random.Generator, time_s: FloatArray) -> FloatArray:
    """Return a sinusoid of 50 to 300 Hz a channel: I and Q of a pair differ in frequency, so never in quadrature."""
    frequency_hz = rng.uniform(50.0, 300.0, (6, 1))
    return rng.uniform(0.3, 2.0, (6, 1)) * np.sin(2 * np.pi * (frequency_hz * time_s + rng.uniform(0, 1, (6, 1))))


def _after_rest(rng: np.random.Generator, time_s: FloatArray) -> FloatArray:
    return np.where(time_s < REST_S, 0.0, _sinusoids(rng, time_s - REST_S))


def _square(rng: np.random.Generator, time_s: FloatArray) -> FloatArray:
    return np.sign(_sinusoids(rng, time_s)) * rng.uniform(0.3, 2.0, (6, 1))


def _saturated(rng: np.random.Generator, time_s: FloatArray) -> FloatArray:
    return np.clip(rng.uniform(3.0, 8.0) * _sinusoids(rng, time_s), -RANGE_V, RANGE_V)


def _random_walk(rng: np.random.Generator, time_s: FloatArray) -> FloatArray:
    walk = np.cumsum(rng.standard_normal((6, len(time_s))), axis=1)
    return 3.0 * walk / np.abs(walk).max(axis=1, keepdims=True)


def _bursts(rng: np.random.Generator, time_s: FloatArray) -> FloatArray:
    """Return white noise that comes and goes, in each channel at its own times."""
    begin_s, end_s = rng.uniform(0.3, 1.4, (6, 1)), rng.uniform(1.6, 2.8, (6, 1))
    return np.where((time_s > begin_s) & (time_s < end_s), rng.standard_normal((6, len(time_s))), 0.0)


def _chirps(rng: np.random.Generator, time_s: FloatArray) -> FloatArray:
    """Return two chirps a channel that have nothing to do with those of the other channels."""
    out = np.zeros((6, len(time_s)))
    for channel in range(6):
        for _ in range(2):
            first_hz, last_hz = rng.uniform(20.0, 400.0, 2)
            out[channel] += signal.chirp(time_s, first_hz, DURATION_S, last_hz, phi=rng.uniform(0.0, 360.0))
    return out


GARBAGE = {
    "sinusoids": _sinusoids,
    "sinusoids after rest": _after_rest,
    "square waves": _square,
    "saturated sinusoids": _saturated,
    "random walk": _random_walk,
    "bursts of noise": _bursts,
    "unrelated chirps": _chirps,
}


def make_garbage(seed: int, kind: str) -> Recording:
    """Return 3 s of one kind of garbage for three receivers, 16 bit over +-5 V, with 2 mV of noise."""
    rng = np.random.default_rng([seed, sorted(GARBAGE).index(kind)])
    time_s = np.arange(round(DURATION_S * RATE_HZ)) / RATE_HZ
    volts = GARBAGE[kind](rng, time_s) + rng.uniform(-0.2, 0.2, (6, 1)) + 0.002 * rng.standard_normal((6, len(time_s)))
    step_v = 2.0 * RANGE_V / 65536
    codes = np.clip(np.round(volts / step_v), -32768, 32767).astype(np.int16)
    name = f"garbage-{kind.replace(' ', '-')}"
    return Recording(name, codes, Digitisation(iq_names(3), RATE_HZ, ((0.0, step_v),) * 6, device="simulated"))
