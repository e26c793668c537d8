"""The wiring check: from what the channels did in each step to what is wrong with the wires, and the settings for it.

How hard each channel answers, which antenna it belongs to, which way a pair turns; then sentences and settings.
"""

import json
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np

from radargui.model.arrays import BoolArray, FloatArray, IntArray
from radargui.model.errors import ProcessingError
from radargui.model.front_end import with_phase_sign
from radargui.model.setup import Setup
from radargui.model.words import percent
from radargui.signals.ellipse import fit_ellipse

DEAD = 0.1
"""A channel that answers less than this share of the others, everywhere, is dead."""
LEAST = 3.0
"""A channel answers where it shakes this many times harder than in quiet."""

CLEAR_ANSWER = 1.4
"""A channel answers clearly to an antenna when it does so this many times more than to any other."""
CLEAR_TURN = 0.3
"""Least difference between the power that turns one way and the other, relative to their sum."""
SAME = 0.98
"""Correlation from which two channels carry the same signal."""
_FLOOR = 1e-3  # of the strongest answer: below, the logarithm of noise would decide (chosen by hand)
_SLOWEST_HZ, _FASTEST_HZ = 0.5, 200.0
"""Doppler of a hand at 10 GHz, 7 mm/s to 3 m/s: below lies drift, above noise. Chosen by hand."""


@dataclass(frozen=True, slots=True)
class WiringSamples:
    """What was measured; all arrays (n_channels, n), volts, at `rate_hz`; NaN where samples were lost.

    Attributes
    ----------
    rate_hz
        After averaging.
    quiet, away
        Nothing moves; the tracer moves away.
    waves
        A hand in front of each receiver.
    clipped
        Share of the samples that sat at an end of the range, over all steps, shape (n_channels,).
    """

    rate_hz: float
    quiet: FloatArray
    away: FloatArray
    waves: tuple[FloatArray, ...]
    clipped: FloatArray


def shake_v(volts: FloatArray) -> FloatArray:
    """Return the standard deviation of each channel in V, shape (n_channels,); 0 where there are no samples."""
    known = volts[:, np.isfinite(volts).all(axis=0)]
    return np.asarray(known.std(axis=1)) if known.shape[1] else np.zeros(volts.shape[0])


def responses_v(samples: WiringSamples) -> tuple[FloatArray, FloatArray]:
    """Return how hard each channel answers beyond its quiet level: sqrt(std^2 - quiet^2).

    Returns
    -------
    tuple
        When the tracer moves away, shape (n_channels,), and for each wave, shape (n_receivers, n_channels), in V.
    """
    quiet = shake_v(samples.quiet)
    steps = np.array([shake_v(step) for step in (samples.away, *samples.waves)])
    # noise and answer are independent: their variances add
    beyond = np.sqrt(np.clip(steps**2 - quiet**2, 0.0, None))
    beyond[steps < LEAST * quiet] = 0.0
    return beyond[0], beyond[1:]


def dead_channels(away_v: FloatArray, waves_v: FloatArray) -> BoolArray:
    """Return which channels answer to nothing, shape (n_channels,); parameters as `responses_v` returns them."""
    # a channel may be deaf to a wave at another antenna, a dead one to all
    strongest = waves_v.max(axis=0, initial=0.0)
    return np.asarray((away_v <= DEAD * _typical(away_v)) & (strongest <= DEAD * _typical(strongest)))


def _typical(values: FloatArray) -> float:
    """Return the upper median: with half of the channels dead it is still one that lives."""
    return float(np.sort(values)[values.size // 2])


def owners(waves_v: FloatArray, dead: BoolArray) -> tuple[IntArray, BoolArray]:
    """Return the antenna of each channel, two channels an antenna, and whether that is clear.

    Neither the gain of a channel nor how hard the hand was waved matters: the logarithms of the answers are freed of
    the mean of each channel and of each wave before channels are given to antennas (the assignment with the largest
    sum). A channel that is dead or not clear keeps the place that it should have, where that is left.

    Parameters
    ----------
    waves_v
        Answers, shape (n_receivers, n_channels).
    dead
        Which channels answer to nothing, shape (n_channels,).

    Returns
    -------
    tuple
        Receivers counted from 0, shape (n_channels,), and True where it is clear.
    """
    n_receivers, n_channels = waves_v.shape
    expected = np.arange(n_channels) // 2
    if n_receivers == 1:
        return expected, ~dead
    score = _contrast(waves_v, ~dead)
    score[:, dead] = 0.0
    channels = np.arange(n_channels)
    # in doubt as the setup has it: half of what counts as clear
    biased = score.copy()
    biased[expected, channels] += 0.5 * np.log(CLEAR_ANSWER)
    # two channels an antenna, all at once: greedy choices strand the last one
    # a quarter of a second to load, for who checks wires
    from scipy.optimize import linear_sum_assignment

    rows, columns = linear_sum_assignment(np.repeat(biased, 2, axis=0), maximize=True)
    owner = np.empty(n_channels, dtype=np.intp)
    owner[columns] = rows // 2
    # clear is what the second best antenna leaves
    others = score.copy()
    others[owner, channels] = -np.inf
    clear = score[owner, channels] - others.max(axis=0) >= np.log(CLEAR_ANSWER)
    return owner, clear & ~dead


def _contrast(waves_v: FloatArray, alive: BoolArray) -> FloatArray:
    """Return log answers without the means of channels and of waves, shape (n_receivers, n_channels)."""
    scale = waves_v.max(initial=0.0) or 1.0
    score = np.log(np.maximum(waves_v / scale, _FLOOR))
    if alive.any():
        # gain of the channel, then vigour of the wave: the vigours then add up to nothing, and one round is enough
        score -= score.mean(axis=0)
        score -= score[:, alive].mean(axis=1, keepdims=True)
    return score


def turning(pair_v: FloatArray, rate_hz: float) -> float:
    """Return the power of I + jQ at positive minus that at negative frequencies over their sum, -1 to 1.

    A phase that rises turns the positive way. Offset, unequal gains and a quadrature error only add an image of less
    power on the other side. 0 where there is nothing.

    Parameters
    ----------
    pair_v
        I and Q in volts, shape (2, n_samples), lost samples left out.
    rate_hz
        Samples per second.
    """
    if pair_v.shape[1] < 8:
        return 0.0
    # offsets are no rotation
    signal = pair_v - pair_v.mean(axis=1, keepdims=True)
    # of I + jQ: a complex signal has its two directions at plus and minus f
    spectrum = np.abs(np.fft.fft((signal[0] + 1j * signal[1]) * np.hanning(signal.shape[1]))) ** 2
    frequency = np.fft.fftfreq(signal.shape[1], 1.0 / rate_hz)
    wanted = (np.abs(frequency) >= _SLOWEST_HZ) & (np.abs(frequency) <= _FASTEST_HZ)
    up, down = spectrum[wanted & (frequency > 0)].sum(), spectrum[wanted & (frequency < 0)].sum()
    return float((up - down) / (up + down)) if up + down > 0.0 else 0.0


def is_same_signal(pair_v: FloatArray) -> bool:
    """Return whether two channels, shape (2, n_samples), carry the same signal, be it with the other sign."""
    if pair_v.shape[1] < 8 or (pair_v.std(axis=1) == 0.0).any():
        return False
    return bool(abs(float(np.asarray(np.corrcoef(pair_v))[0, 1])) >= SAME)


def turns(pair_v: FloatArray) -> float | None:
    """Return by how many turns the phase of a pair, shape (2, n_samples), went on; None where it is no ellipse."""
    try:
        x, y = fit_ellipse(pair_v).apply(pair_v)
    except ProcessingError:
        return None
    phase = np.unwrap(np.arctan2(y, x))
    return float((phase[-1] - phase[0]) / (2.0 * np.pi)) if np.isfinite(phase).all() else None


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
