"""The wiring check: channels to antennas, then the direction of each pair, then sentences and settings."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from radargui.model.arrays import BoolArray, FloatArray, IntArray
from radargui.model.setup import Setup
from radargui.processing.wiring import rotation
from radargui.processing.wiring.findings import WiringFinding, WiringReport
from radargui.processing.wiring.owners import owners
from radargui.processing.wiring.response import WiringSamples, dead_channels, responses_v

_CLIPPED = 0.01
_AGAIN = "Do the check again: slower, farther, and closer to the antenna when waving."


@dataclass(frozen=True, slots=True)
class _Pair:
    """The channels that belong to one antenna; direction 1: L rises, -1: it falls, 0: not told."""

    receiver: int
    i: int
    q: int
    direction: int
    change_m: float | None
    clear: bool


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
        return WiringReport((_nothing(),))
    dead = dead_channels(away_v, waves_v)
    owner, clear = owners(waves_v, dead)
    pairs = [_pair(receiver, owner, clear, dead, samples, setup) for receiver in range(setup.n_receivers)]
    flip, exchanged = _directions(pairs)
    findings = [
        *_inputs(setup, dead, samples.clipped),
        *(finding for pair in pairs for finding in _about(pair, setup, samples, dead, owner, exchanged)),
    ]
    if flip:
        findings.append(_inverted_everywhere(setup))
    order = [channel for pair in pairs for channel in ((pair.q, pair.i) if pair in exchanged else (pair.i, pair.q))]
    known = bool((clear | dead).all())
    inputs = tuple(setup.physical_channels[channel] for channel in order)
    sign: Literal[-1, 1] = -1 if setup.radar.phase_sign > 0 else 1
    return WiringReport(
        tuple(findings),
        channels=inputs if known and inputs != setup.physical_channels else None,
        phase_sign=sign if flip else None,
    )


def _pair(
    receiver: int, owner: IntArray, clear: BoolArray, dead: BoolArray, samples: WiringSamples, setup: Setup
) -> _Pair:
    first, second = (int(channel) for channel in np.flatnonzero(owner == receiver))
    # a channel that stands at the place of an I stays an I
    i, q = (second, first) if first % 2 and not second % 2 else (first, second)
    pair_v = _pair_v(samples.away, i, q)
    ratio = rotation.turning(pair_v, samples.rate_hz) * setup.radar.phase_sign
    told = not dead[[i, q]].any() and abs(ratio) >= rotation.CLEAR and not rotation.is_same_signal(pair_v)
    n_turns = rotation.turns(pair_v) if told else None
    change_m = None if n_turns is None else abs(n_turns) * setup.radar.wavelength_m
    return _Pair(receiver, i, q, int(np.sign(ratio)) if told else 0, change_m, bool(clear[[i, q]].all()))


def _pair_v(volts: FloatArray, i: int, q: int) -> FloatArray:
    return np.asarray(volts[[i, q]])


def _directions(pairs: list[_Pair]) -> tuple[bool, list[_Pair]]:
    """Return whether the sign of all is wrong, and the pairs whose I and Q are exchanged after that."""
    falling = [pair for pair in pairs if pair.direction < 0]
    rising = [pair for pair in pairs if pair.direction > 0]
    return (True, rising) if len(falling) > len(rising) else (False, falling)


def _nothing() -> WiringFinding:
    return WiringFinding(
        "dead",
        "No channel answers to anything.",
        "Check that transmitter and receivers have power and that the cables are at the device in daq.device.",
    )


def _inputs(setup: Setup, dead: BoolArray, clipped: FloatArray) -> list[WiringFinding]:
    findings = []
    for channel, name in enumerate(setup.channel_names):
        place = f"{name} ({setup.physical_channels[channel]})"
        if clipped[channel] > _CLIPPED:
            findings.append(
                WiringFinding(
                    "clipped",
                    f"{place} is at the end of its range {clipped[channel]:.0%} of the time.",
                    "Raise daq.range_v, lower the gain, or look for a cable that is not connected.",
                    channel // 2,
                )
            )
        if dead[channel]:
            findings.append(
                WiringFinding(
                    "dead",
                    f"{place} does not answer to anything.",
                    "Check its cable, its connectors and daq.terminal; or its place in daq.channels.",
                    channel // 2,
                )
            )
    return findings


def _about(
    pair: _Pair,
    setup: Setup,
    samples: WiringSamples,
    dead: BoolArray,
    owner: IntArray,
    exchanged: list[_Pair],
) -> list[WiringFinding]:
    """Return what is to be said of one receiver."""
    names, inputs = setup.channel_names, setup.physical_channels
    receiver, number = pair.receiver, pair.receiver + 1
    findings = []
    strangers = [channel for channel in (pair.i, pair.q) if channel // 2 != receiver and not dead[channel]]
    if strangers and pair.clear:
        told = " and ".join(f"{names[channel]} ({inputs[channel]})" for channel in strangers)
        verb = "belongs" if len(strangers) == 1 else "belong"
        findings.append(
            WiringFinding("swapped", f"{told} {verb} to receiver {number}.", "Take the channels proposed.", receiver)
        )
    if dead[[pair.i, pair.q]].any():
        return findings
    if not pair.clear:
        findings.append(
            WiringFinding(
                "unclear", f"No channels answer clearly to the hand in front of receiver {number}.", _AGAIN, receiver
            )
        )
    if rotation.is_same_signal(_pair_v(samples.away, pair.i, pair.q)):
        findings.append(
            WiringFinding(
                "same",
                f"{names[pair.i]} and {names[pair.q]} of receiver {number} carry the same signal.",
                "One of the two is at the wrong output, or the cables touch: check both.",
                receiver,
            )
        )
    elif pair.direction == 0:
        findings.append(WiringFinding("unclear", f"Whether L{number} rises or falls cannot be told.", _AGAIN, receiver))
    elif pair in exchanged:
        verb = "falls" if pair.direction < 0 else "rises"
        findings.append(
            WiringFinding(
                "direction",
                f"L{number} {verb} where the others do not: I and Q of receiver {number} are exchanged, or its Q is "
                "inverted.",
                "Take the channels proposed: exchanging I and Q turns the phase round as well.",
                receiver,
            )
        )
    if not findings and pair.direction > 0:
        by = "" if pair.change_m is None else f" by {pair.change_m:.2f} m"
        sentence = f"Receiver {number}: {names[pair.i]} and {names[pair.q]} answer to it, and L{number} rises{by}."
        findings.append(WiringFinding("good", sentence, receiver=receiver))
    return findings


def _inverted_everywhere(setup: Setup) -> WiringFinding:
    which = "Path lengths fall" if setup.n_receivers > 1 else "The path length falls"
    return WiringFinding(
        "direction", f"{which} when the tracer moves away: Q is inverted.", "Take the phase_sign proposed."
    )
