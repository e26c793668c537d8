"""The wiring check: channels to antennas, then the direction of each pair, then sentences and settings."""

import json
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np

from radargui.model.arrays import BoolArray, FloatArray, IntArray
from radargui.model.front_end import with_phase_sign
from radargui.model.setup import Setup
from radargui.model.words import percent
from radargui.processing.wiring.response import (
    CLEAR_TURN,
    WiringSamples,
    dead_channels,
    is_same_signal,
    owners,
    responses_v,
    turning,
    turns,
)

_CLIPPED = 0.01  # share of the time at the end of the range that is warned of; less spoils little (by hand)
FindingKind = Literal["good", "dead", "clipped", "same", "swapped", "direction", "unclear"]
_Said = tuple[FindingKind, str, int]
"""Kind, sentence, receiver."""
_AGAIN = "Do the check again: slower, farther, and closer to the antenna when waving."
_REMEDIES = {
    "good": "",
    "clipped": "Raise daq.range_v, lower the gain, or look for a cable that is not connected.",
    "dead": "Check its cable, its connectors and daq.terminal; or its place in daq.channels.",
    "same": "One of the two is at the wrong output, or the cables touch: check both.",
    "swapped": "Take the channels proposed.",
    "direction": "Take the channels proposed: exchanging I and Q turns the phase round as well.",
    "unclear": _AGAIN,
}


@dataclass(frozen=True, slots=True)
class WiringFinding:
    """One finding.

    Attributes
    ----------
    kind
        good: nothing to do; dead: an input without signal; clipped: one at the end of its range; same: I and Q carry
        one signal; swapped: channels at another antenna; direction: a path length that falls; unclear: to be measured
        again.
    sentence
        What was found.
    remedy
        What to do about it; empty where nothing.
    receiver
        Which receiver, counted from 0; None where it is about all.
    """

    kind: FindingKind
    sentence: str
    remedy: str = ""
    receiver: int | None = None

    def __str__(self) -> str:
        """Return sentence and remedy."""
        return f"{self.sentence} {self.remedy}".strip()


@dataclass(frozen=True, slots=True)
class WiringReport:
    """The result of the wiring check.

    Attributes
    ----------
    findings
        One for each receiver that is good, and one for each thing that is not.
    channels
        `daq.channels` as it should be; None where it is right or not known.
    phase_sign
        `radar.phase_sign` as it should be; None where it is right or not known.
    """

    findings: tuple[WiringFinding, ...]
    channels: tuple[str, ...] | None = None
    phase_sign: Literal[-1, 1] | None = None

    @property
    def is_good(self) -> bool:
        """Whether nothing is wrong or unclear."""
        return all(finding.kind == "good" for finding in self.findings)

    @property
    def corrects(self) -> bool:
        """Whether other settings are proposed."""
        return bool(self._proposed())

    def settings(self) -> tuple[str, ...]:
        """Return the proposed settings as lines of a setup file."""
        return tuple(f"{table}.{key} = {json.dumps(value)}" for (table, key), value in self._proposed().items())

    def corrected(self, setup: Setup) -> Setup:
        """Return the setup with the proposed settings."""
        for (table, key), value in self._proposed().items():
            setup = setup.model_copy(update={table: getattr(setup, table).model_copy(update={key: value})})
        return setup

    def _proposed(self) -> dict[tuple[str, str], object]:
        settings = {("daq", "channels"): self.channels, ("radar", "phase_sign"): self.phase_sign}
        return {place: value for place, value in settings.items() if value is not None}


def check_wiring(samples: WiringSamples, setup: Setup) -> WiringReport:
    """Return what is wrong with the wires between antennas and inputs.

    Parameters
    ----------
    samples
        What the channels did in each step, in the order of the setup's channels.
    setup
        What was thought to be wired.
    """
    away_v, waves_v = responses_v(samples)
    if not away_v.any() and not waves_v.any():
        power = "Check that transmitter and receivers have power and that the cables are at the device in daq.device."
        return WiringReport((WiringFinding("dead", "No channel answers to anything.", power),))
    dead = dead_channels(away_v, waves_v)
    owner, clear = owners(waves_v, dead)
    pairs = [_pair(receiver, owner, clear, dead, samples, setup) for receiver in range(setup.n_receivers)]
    falling = [pair for pair in pairs if pair.direction < 0]
    rising = [pair for pair in pairs if pair.direction > 0]
    # where most fall the sign of all is wrong, and the pairs that rise have I and Q exchanged
    flip = len(falling) > len(rising)
    exchanged = rising if flip else falling
    said = [*_inputs(setup, dead, samples.clipped)]
    for pair in pairs:
        said += _about(pair, setup, dead, exchanged=pair in exchanged)
    findings = [WiringFinding(kind, text, _REMEDIES[kind], receiver) for kind, text, receiver in said]
    if flip:
        which = "Path lengths fall" if setup.n_receivers > 1 else "The path length falls"
        sentence = f"{which} when the tracer moves away: Q is inverted."
        findings.append(WiringFinding("direction", sentence, "Take the phase_sign proposed."))
    # exchanging I and Q turns the phase round, as inverting Q does
    order = [channel for pair in pairs for channel in ((pair.q, pair.i) if pair in exchanged else (pair.i, pair.q))]
    inputs = tuple(setup.physical_channels[channel] for channel in order)
    # proposed only where the place of every channel is known
    is_new = bool((clear | dead).all()) and inputs != setup.physical_channels
    sign: Literal[-1, 1] = -1 if setup.radar.phase_sign > 0 else 1
    return WiringReport(tuple(findings), channels=inputs if is_new else None, phase_sign=sign if flip else None)


@dataclass(frozen=True, slots=True)
class _Pair:
    """The channels that belong to one antenna; direction 1: L rises, -1: it falls, 0: not known."""

    receiver: int
    i: int
    q: int
    direction: int
    change_m: float | None
    clear: bool
    same: bool


def _pair(
    receiver: int, owner: IntArray, clear: BoolArray, dead: BoolArray, samples: WiringSamples, setup: Setup
) -> _Pair:
    first, second = (int(channel) for channel in np.flatnonzero(owner == receiver))
    # a channel that stands at the place of an I stays an I
    i, q = (second, first) if first % 2 and not second % 2 else (first, second)
    pair_v = samples.away[[i, q]]
    pair_v = with_phase_sign(pair_v[:, np.isfinite(pair_v).all(axis=0)], setup.radar.phase_sign)
    # moving away lengthens every L: the phase must rise
    ratio, same = turning(pair_v, samples.rate_hz), is_same_signal(pair_v)
    known = not dead[[i, q]].any() and abs(ratio) >= CLEAR_TURN and not same
    n_turns = turns(pair_v) if known else None
    change_m = None if n_turns is None else abs(n_turns) * setup.radar.wavelength_m
    return _Pair(receiver, i, q, int(np.sign(ratio)) if known else 0, change_m, bool(clear[[i, q]].all()), same)


def _inputs(setup: Setup, dead: BoolArray, clipped: FloatArray) -> Iterator[_Said]:
    """Yield what is wrong with single inputs."""
    for channel, (name, physical) in enumerate(zip(setup.channel_names, setup.physical_channels, strict=True)):
        place = f"{name} ({physical})"
        if clipped[channel] > _CLIPPED:
            said = f"{place} is at the end of its range {percent(clipped[channel])} of the time."
            yield "clipped", said, channel // 2
        if dead[channel]:
            yield "dead", f"{place} does not answer to anything.", channel // 2


def _about(pair: _Pair, setup: Setup, dead: BoolArray, *, exchanged: bool) -> list[_Said]:
    """Return what is to be said of one receiver."""
    names, inputs, number = setup.channel_names, setup.physical_channels, pair.receiver + 1
    said: list[tuple[FindingKind, str]] = []
    strangers = [channel for channel in (pair.i, pair.q) if channel // 2 != pair.receiver and not dead[channel]]
    if strangers and pair.clear:
        which = " and ".join(f"{names[channel]} ({inputs[channel]})" for channel in strangers)
        said.append(("swapped", f"{which} belong{'s' if len(strangers) == 1 else ''} to receiver {number}."))
    if not dead[[pair.i, pair.q]].any():
        if not pair.clear:
            said.append(("unclear", f"No channels answer clearly to the hand in front of receiver {number}."))
        if pair.same:
            both = f"{names[pair.i]} and {names[pair.q]}"
            said.append(("same", f"{both} of receiver {number} carry the same signal."))
        elif pair.direction == 0:
            said.append(("unclear", f"Whether L{number} rises or falls cannot be told."))
        elif exchanged:
            turns_round = f"L{number} {'falls' if pair.direction < 0 else 'rises'} where the others do not"
            why = f"I and Q of receiver {number} are exchanged, or its Q is inverted"
            said.append(("direction", f"{turns_round}: {why}."))
        if not said and pair.direction > 0:
            by = "" if pair.change_m is None else f" by {pair.change_m:.2f} m"
            answer = f"{names[pair.i]} and {names[pair.q]} answer to it, and L{number} rises{by}."
            said.append(("good", f"Receiver {number}: {answer}"))
    return [(kind, sentence, pair.receiver) for kind, sentence in said]
