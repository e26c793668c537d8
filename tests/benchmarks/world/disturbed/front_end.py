"""Faults of the front end: oscillator, gain, supply, contacts, bits, transfers, a stage that saturates."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from benchmarks.world.disturbance import Array, Codes, Complex, Disturbance
from benchmarks.world.disturbed.strength import Case
from benchmarks.world.room import Room

from radargui.model.recording import Gap

_EDGE_S = 2e-4
"""Supplies and gains change within this."""


@dataclass(frozen=True)
class Oscillator(Disturbance):
    """Its frequency goes off by a share, at once or evenly over a time.

    One oscillator sends and mixes: the phase is k (L - l), l the way of the wave to the mixers. The direct wave between
    the antennas, whose mean is in the offsets, turns too.
    """

    room: Room
    begin_s: float
    lasts_s: float
    share: float
    to_mixer_m: float
    leaks: Complex

    def off(self, time_s: Array) -> Array:
        """Return the relative change of the frequency at times (n,)."""
        return self.share * np.clip((time_s - self.begin_s) / self.lasts_s, 0.0, 1.0)

    def echo(self, receiver: int, time_s: Array, place_m: Array, echo: Complex) -> Complex:
        """Turn echo and direct wave by the change of the wavenumber times what each is longer than the mixers' way."""
        changed = self.room.sphere.wavenumber_rad_m * self.off(time_s)
        path_m = self.room.path_m(place_m)[receiver]
        direct_m = np.linalg.norm(self.room.antennas[receiver + 1].position_m - self.room.antennas[0].position_m)
        turned = echo * np.exp(1j * changed * (path_m - self.to_mixer_m))
        return turned + self.leaks[receiver] * (np.exp(1j * changed * (direct_m - self.to_mixer_m)) - 1.0)


@dataclass(frozen=True)
class Gain(Disturbance):
    """The gain of some channels steps at times; `steps` holds (time, channels, factor)."""

    steps: tuple[tuple[float, tuple[int, ...], float], ...]

    def volts(self, channel: int, time_s: Array, volts: Array, amplitude_v: float) -> Array:
        """Multiply from each step on."""
        del amplitude_v
        out = volts
        for begin_s, channels, factor in self.steps:
            if channel in channels:
                out = out * (1.0 + (factor - 1.0) * np.clip((time_s - begin_s) / _EDGE_S, 0.0, 1.0))
        return out


@dataclass(frozen=True)
class Supply(Disturbance):
    """All voltages sink towards another one for some milliseconds: gain down by a share, an offset beside."""

    begin_s: float
    lasts_s: float
    depth: float
    offsets: Array

    def volts(self, channel: int, time_s: Array, volts: Array, amplitude_v: float) -> Array:
        """Sink and come back with a sine's half wave."""
        dip = np.sin(np.pi * np.clip((time_s - self.begin_s) / self.lasts_s, 0.0, 1.0))
        return volts * (1.0 - self.depth * dip) + amplitude_v * self.depth * self.offsets[channel] * dip


@dataclass(frozen=True)
class Dip(Disturbance):
    """One receiver is weaker for some milliseconds: its echo alone, or after the mixers its offsets too."""

    receiver: int
    begin_s: float
    lasts_s: float
    left: float
    with_offsets: bool

    def gain(self, time_s: Array) -> Array:
        """Return what is left of it at times (n,)."""
        edges_s = self.begin_s + np.array([0.0, _EDGE_S, self.lasts_s - _EDGE_S, self.lasts_s])
        return np.interp(time_s, edges_s, [1.0, self.left, self.left, 1.0])

    def echo(self, receiver: int, time_s: Array, place_m: Array, echo: Complex) -> Complex:
        """Weaken what the antenna gets."""
        del place_m
        return echo if self.with_offsets or receiver != self.receiver else echo * self.gain(time_s)

    def volts(self, channel: int, time_s: Array, volts: Array, amplitude_v: float) -> Array:
        """Weaken what the mixers give, noise and all."""
        del amplitude_v
        return volts * self.gain(time_s) if self.with_offsets and channel // 2 == self.receiver else volts


@dataclass(frozen=True)
class Contact(Disturbance):
    """A loose contact: one channel sees nothing but a little hum within the spans (from, to)."""

    channel: int
    spans_s: tuple[tuple[float, float], ...]
    hum: float

    def volts(self, channel: int, time_s: Array, volts: Array, amplitude_v: float) -> Array:
        """Drop the signal; the noise goes with it."""
        if channel != self.channel:
            return volts
        open_ = np.zeros(time_s.size, dtype=bool)
        for begin_s, end_s in self.spans_s:
            open_ |= (time_s >= begin_s) & (time_s < end_s)
        return np.where(open_, self.hum * amplitude_v * np.sin(2.0 * np.pi * 50.0 * time_s), volts)


@dataclass(frozen=True)
class StuckBit(Disturbance):
    """One bit of one channel's codes stands still from a sample on; 0 is the lowest."""

    channel: int
    bit: int
    at: int
    first: int

    def codes(self, codes: Codes) -> Codes:
        """Set or clear it."""
        out = codes.copy()
        mask = np.int16(1 << self.bit)
        row = out[self.channel, self.first :]
        row[...] = row | mask if self.at else row & ~mask
        return out


@dataclass(frozen=True)
class Slip(Disturbance):
    """One channel comes by some samples late (one is told twice) or early (one is lost) from a sample on."""

    channel: int
    first: int
    by: int

    def codes(self, codes: Codes) -> Codes:
        """Shift the rest of the channel."""
        out, count = codes.copy(), codes.shape[1]
        index = np.arange(count)
        index[self.first :] -= self.by
        out[self.channel] = codes[self.channel, np.clip(index, 0, count - 1)]
        return out


@dataclass(frozen=True)
class Clip(Disturbance):
    """A stage before the converter saturates on one side of one channel within a span, softly by a twentieth."""

    channel: int
    begin_s: float
    end_s: float
    level: float
    side: int

    def volts(self, channel: int, time_s: Array, volts: Array, amplitude_v: float) -> Array:
        """Let no more through than `level` in units of the echo (offset counted), and a twentieth of what is above."""
        if channel != self.channel:
            return volts
        level_v, inside = self.level * amplitude_v, (time_s >= self.begin_s) & (time_s < self.end_s)
        above = np.maximum(self.side * (volts - level_v), 0.0)
        return np.where(inside, volts - 0.95 * self.side * above, volts)


def steps(case: Case, variant: str) -> tuple[Disturbance, ...]:
    """Return one fault of the front end, at a time drawn from the motion."""
    rng, begin_s = case.rng, case.moment_s()
    channel = int(rng.integers(2 * case.n_receivers))
    first = int(begin_s * case.scene.converter.rate_hz)
    if variant in ("jump", "drift"):
        return (_oscillator(case, variant, begin_s),)
    if variant == "gain":
        return (_gain(case),)
    if variant == "supply":
        offsets = rng.uniform(-0.5, 0.5, 2 * case.n_receivers)
        return (Supply(begin_s, case.between(1e-3, 5e-3), case.between(0.05, 0.6), offsets),)
    if variant == "contact":
        lasts_s, count = case.between(1e-3, 20e-3), int(rng.integers(1, 4))
        begins_s = [begin_s, *(case.moment_s() for _ in range(count - 1))]
        return (Contact(channel, tuple((one, one + lasts_s) for one in begins_s), rng.uniform(0.0, 0.02)),)
    if variant == "lost":
        return (Contact(channel, ((begin_s, np.inf),), rng.uniform(0.0, 0.02)),)
    if variant == "bit":
        size = case.scene.mixers[channel // 2].amplitude_v / case.scene.converter.step_v
        bit = max(int(np.log2(case.between(0.01, 0.3) * size)), 0)
        return (StuckBit(channel, bit, int(rng.integers(2)), first if rng.random() < 0.7 else 0),)
    if variant == "slip":
        return (Slip(channel, first, int(rng.choice([-1, 1]))),)
    return (_clip(case, channel),)


def dip(case: Case, variant: str) -> tuple[Disturbance, ...]:
    """Return ten milliseconds of the motion in which one receiver falls to a third, whatever the strength."""
    drop, lasts_s = case.scene.drop, 0.010
    # among the last bounces there is nothing to see
    moves_until_s = max((one.time_s for one in drop.impacts if one.after_m_s > 0.1), default=drop.duration_s)
    begin_s = float(case.rng.uniform(drop.start_s, min(moves_until_s, drop.duration_s - 0.1)))
    return (Dip(int(case.rng.integers(case.n_receivers)), begin_s, lasts_s, 1.0 / 3.0, variant == "offsets"),)


@dataclass(frozen=True)
class Lost(Disturbance):
    """Samples that the computer fetches too late: begin and length of each loss in s, in time order."""

    spans_s: tuple[tuple[float, float], ...]

    def lost(self, rate_hz: float) -> tuple[Gap, ...]:
        """Return them as gaps."""
        return tuple(
            Gap(int(begin_s * rate_hz), max(int(lasts_s * rate_hz), 1), "overrun") for begin_s, lasts_s in self.spans_s
        )  # fmt: skip


def gap(case: Case, variant: str) -> tuple[Disturbance, ...]:
    """Return one to three losses of 1 to 30 ms."""
    del variant
    spans: list[tuple[float, float]] = []
    for begin_s in sorted(case.moment_s() for _ in range(int(case.rng.integers(1, 4)))):
        if not spans or begin_s > sum(spans[-1]) + 0.01:
            spans.append((begin_s, case.between(1e-3, 30e-3)))
    return (Lost(tuple(spans)),)


def _oscillator(case: Case, variant: str, begin_s: float) -> Oscillator:
    rng = case.rng
    leaks = np.array([complex(*one.offset) for one in case.scene.mixers]) * np.exp(1j * rng.normal(0.0, 0.5))
    share = case.between(1e-6, 1e-4) * rng.choice([-1.0, 1.0])
    lasts_s = 1e-3 if variant == "jump" else rng.uniform(0.3, 1.0)
    return Oscillator(case.scene.room, begin_s, lasts_s, share, rng.uniform(0.0, 1.0), leaks)


def _gain(case: Case) -> Gain:
    rng, found = case.rng, []
    for _ in range(int(rng.integers(1, 4))):
        number, whole = int(rng.integers(2 * case.n_receivers)), rng.random() < 0.5
        pair = number - number % 2
        channels = (pair, pair + 1) if whole else (number,)
        found.append((case.moment_s(), channels, 1.0 + case.between(0.005, 0.05) * rng.choice([-1.0, 1.0])))
    return Gain(tuple(found))


def _clip(case: Case, channel: int) -> Clip:
    """Return one that begins while the sphere falls or bounces high, where the echo goes through all its phases."""
    rng, mixer = case.rng, case.scene.mixers[channel // 2]
    begin_s = case.scene.drop.start_s + rng.uniform(-0.1, 0.2)
    side, lasts_s = int(rng.choice([-1, 1])), rng.uniform(0.1, 0.6)
    top = mixer.gain_ratio if channel % 2 else 1.0
    level = mixer.offset[channel % 2] + side * top * (1.0 - case.between(0.03, 0.6))
    return Clip(channel, begin_s, begin_s + lasts_s, level, side)
