"""Tones from elsewhere: the mains in every channel and in the echo, another source of 10 GHz in the room."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from benchmarks.world.disturbance import Array, Complex, Disturbance
from benchmarks.world.disturbed.reflector import shares_of
from benchmarks.world.disturbed.strength import Case


@dataclass(frozen=True)
class Mains(Disturbance):
    """Hum of 50 Hz and harmonics.

    Attributes
    ----------
    rate_hz
        Near 50.
    harmonics, phases_rad
        Orders with sizes over the first's, and the phase of each.
    channels
        Size in each channel in units of the echo, with sign.
    switched_s, factor
        When a lamp switches, and by how much the hum is larger then.
    modulates
        By how much the echo's amplitude goes up and down at twice the mains.
    """

    rate_hz: float
    harmonics: tuple[tuple[int, float], ...]
    phases_rad: Array
    channels: Array
    switched_s: float
    factor: float
    modulates: float

    def echo(self, receiver: int, time_s: Array, place_m: Array, echo: Complex) -> Complex:
        """Let the supply's ripple change the amplitude."""
        del receiver, place_m
        return echo * (1.0 + self.modulates * np.sin(4.0 * np.pi * self.rate_hz * time_s + self.phases_rad[0]))

    def volts(self, channel: int, time_s: Array, volts: Array, amplitude_v: float) -> Array:
        """Add the hum."""
        hum = np.zeros(time_s.size)
        for (order, size), phase in zip(self.harmonics, self.phases_rad, strict=True):
            hum += size * np.sin(2.0 * np.pi * order * self.rate_hz * time_s + phase)
        loud = np.where(time_s < self.switched_s, 1.0, self.factor)
        return volts + amplitude_v * self.channels[channel] * loud * hum


def mains(case: Case, variant: str) -> tuple[Disturbance, ...]:
    """Return `hum` in every channel, or hum that is `modulated` on the echo too, by 1 % or so."""
    rng, count = case.rng, 2 * case.n_receivers
    harmonics = ((1, 1.0), *((order, rng.uniform(0.05, 0.4)) for order in (2, 3, 5, 7)))
    channels = case.between(0.01, 0.1) * rng.uniform(0.3, 1.0, count) * rng.choice([-1.0, 1.0], count)
    factor = rng.choice([rng.uniform(0.1, 0.6), rng.uniform(1.5, 3.0)])
    modulates = case.between(0.003, 0.02) if variant == "modulated" else 0.0
    phases = rng.uniform(0.0, 2.0 * np.pi, len(harmonics))
    return (Mains(rng.normal(50.0, 0.01), harmonics, phases, channels, case.moment_s(), float(factor), modulates),)


@dataclass(frozen=True)
class Foreign(Disturbance):
    """A wave of another frequency: beside the echo it turns at the difference, which drifts evenly and wanders.

    `shares` is its size and phase in each receiver.
    """

    shares: Complex
    beat_hz: float
    drift_hz_s: float
    wander_hz: float
    wanders_at_hz: float

    def echo(self, receiver: int, time_s: Array, place_m: Array, echo: Complex) -> Complex:
        """Add it; the phase is the integral of the frequency."""
        del place_m
        slow = self.wander_hz / self.wanders_at_hz * np.sin(2.0 * np.pi * self.wanders_at_hz * time_s)
        turn = 2.0 * np.pi * (self.beat_hz * time_s + 0.5 * self.drift_hz_s * time_s**2) + slow
        return echo + self.shares[receiver] * np.exp(1j * turn)


def foreign(case: Case, variant: str) -> tuple[Disturbance, ...]:
    """Return a motion detector on the ceiling: 20 to 5000 Hz off to either side, 0.5 to 10 % of the echo."""
    del variant
    rng = case.rng
    beat_hz = float(np.exp(rng.uniform(np.log(20.0), np.log(5000.0)))) * rng.choice([-1.0, 1.0])
    shares = shares_of(case, case.between(0.005, 0.1))
    wander_hz = rng.uniform(0.0, 0.02) * abs(beat_hz)
    return (Foreign(shares, beat_hz, rng.uniform(-0.2, 0.2) * abs(beat_hz), wander_hz, rng.uniform(0.5, 3.0)),)
