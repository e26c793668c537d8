"""Conditioning: from a recording to the signals that every correction starts from, each thing measured once.

Method 2.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from radargui.conditioning.band import BandSignals, band_signals, band_times_s, blocks_with
from radargui.conditioning.conditioned import Conditioned
from radargui.conditioning.doppler import ALONE, SETTINGS as DOPPLER, Doppler, measure_doppler, measure_dopplers
from radargui.conditioning.hum import SETTINGS as HUM, Hum, find_hum
from radargui.conditioning.interference import without_ends, without_interference
from radargui.conditioning.noise import LEAST_SAMPLES, block_means, white_noise_v
from radargui.conditioning.onset import creeps_since, find_onset, is_under_way
from radargui.conditioning.open_channels import open_channels
from radargui.conditioning.receiver_check import SETTINGS as PAIR, check_receiver, is_worse_pair, same_channels
from radargui.conditioning.segment import Motion, find_motion
from radargui.conditioning.skew import remove_skew
from radargui.model.arrays import BoolArray, FloatArray, RawArray
from radargui.model.recording import Recording, channel_skew, iq_names, stored_starts
from radargui.model.result import Segment
from radargui.model.setup import Setup

if TYPE_CHECKING:
    from radargui.conditioning.echo import Echo


@dataclass(frozen=True, slots=True)
class RestSettings:
    """What of the quiet part counts as rest. Chosen by hand.

    Attributes
    ----------
    before_onset_s
        Kept free before the onset, which a slow beginning lets be seen late.
    least_s
        Rest that is left at the least where there is an onset at all; kept free before the motion while the onset is
        not known yet.
    hum_margin_s
        Kept free between the rest that a hum is measured on and the onset.
    after_motion_s
        Kept free after the motion: the last small bounces, some 20 ms apart, look like a hum.
    """

    before_onset_s: float = 0.03
    least_s: float = 0.02
    hum_margin_s: float = 0.03
    after_motion_s: float = 0.2


SETTINGS = RestSettings()
CLIPPED_SHARE = 0.03
"""Of the motion at one end of the range: a full wave of a 12 bit converter has 1 % of its samples at its two crests."""
PILED, LEAST_PILED = 5, 20
"""Samples at an end over those at the value beside it, and in number, that no crest has."""
CLIPPED_U = 0.25
"""Uncertainty of ln gain that filled samples leave, times their share (`bench robust`, kind clipped)."""
LOOKED_HZ, LOOKED_PER_FRINGE = 1000.0, 16.0
"""Least rate, and least samples of the fastest wave, of the means whose spectra tell three receivers' lines."""
SEEN_ON_S = 0.025
"""After the latest onset that counts: it is one where the next block is away too."""
LEAST_LED = 0.12
"""Share of a record that an echo under the noise must lead in to be a motion: as in `LEAST_KNOWN` of the path."""
FILLED_SHARE, FILL_ROUNDS = 0.003, 4
"""Share of clipped samples that moves the front end by its u, and rounds after which a fifth of them does not."""


@dataclass(frozen=True, slots=True)
class NoMotion:
    """Nothing to correct in a recording, and why."""

    reason: str


@dataclass(frozen=True, slots=True)
class _Stretch:
    """Samples between two gaps with their motion."""

    samples: slice
    signals: BandSignals
    noise_v: FloatArray
    motion: Motion


def condition(recording: Recording, setup: Setup) -> Conditioned | NoMotion:
    """Condition the signals of a recording: of the stretches between gaps the one to use.

    One with a rest before the motion comes first, for there it is known where the sphere was; then the longest motion.
    Phase cannot be followed across lost samples.

    Parameters
    ----------
    recording
        Two channels a receiver.
    setup
        Its sign of the wiring; its multiplexer skew where the recording comes without one.

    Returns
    -------
    Conditioned or NoMotion
        NoMotion where the voltages do not move more than their noise.
    """
    rate_hz = recording.digitisation.sample_rate_hz
    found = [_motion_in(recording, samples, setup) for samples in stretches(recording)]
    moving = [one for one in found if one is not None]
    if not moving:
        return NoMotion("the voltages do not move more than their noise")

    def worth(one: _Stretch) -> tuple[bool, int]:
        size, motion = one.signals.size, one.motion
        return motion.first * size > SETTINGS.before_onset_s * rate_hz, (motion.last - motion.first) * size

    best = max(moving, key=worth)
    return _conditioned(recording, best, setup)


def stretches(recording: Recording) -> tuple[slice, ...]:
    """Return the runs of stored samples between which nothing was lost."""
    edges = [*(stored for stored, _ in stored_starts(recording.gaps, recording.n_samples)), recording.n_samples]
    return tuple(slice(begin, end) for begin, end in itertools.pairwise(edges) if end > begin)


def _motion_in(recording: Recording, samples: slice, setup: Setup) -> _Stretch | None:
    if samples.stop - samples.start < LEAST_SAMPLES:
        return None
    signals = band_signals(recording, samples, setup)
    volts, rate_hz = signals.volts, recording.digitisation.sample_rate_hz / signals.size
    noise_v = white_noise_v(volts)
    motion = find_motion(volts, rate_hz, noise_v)
    if motion is None:
        # a target below a hum or a tone
        clean, lines = without_interference(volts, rate_hz, noise_v)
        motion = find_motion(clean, rate_hz, noise_v) if lines else None
        motion = motion or _steady_motion(clean, signals.usable, rate_hz, noise_v, lines)
    return None if motion is None else _Stretch(samples, signals, noise_v, motion)


def _steady_motion(
    volts: FloatArray, usable: BoolArray, rate_hz: float, noise_v: FloatArray, lines_hz: tuple[float, ...]
) -> Motion | None:
    """Return the motion of a target too weak to shake the voltages, but whose line one or two receivers show."""
    pairs = _pairs(volts)
    if len(pairs) > 2:
        return None
    for pair in pairs:
        _, echo = _followed(volts[pair], usable[pair], rate_hz, noise_v[pair], lines_hz)
        if echo is not None and echo.leads.mean() > LEAST_LED:
            return Motion(0, volts.shape[1], 0.0)
    return None


def _conditioned(recording: Recording, stretch: _Stretch, setup: Setup) -> Conditioned | NoMotion:
    samples, size, volts = stretch.samples, stretch.signals.size, stretch.signals.volts
    rate_hz = recording.digitisation.sample_rate_hz / size
    time_s = band_times_s(recording, samples, size)
    motion, noise_v = stretch.motion, stretch.noise_v
    # on the rest alone: in the motion a target at 50 Hz is a target
    hum = _hum_at_rest(volts, time_s, rate_hz, motion, noise_v)
    if hum is not None:
        volts = volts - hum.at(np.arange(volts.shape[1]) / rate_hz)
        # without the hum the motion is seen where it begins
        motion = find_motion(volts, rate_hz, noise_v) or motion
    # what has no rest to be measured on is told by being there on both sides
    volts, lines = without_interference(volts, rate_hz, noise_v)
    pairs = _pairs(volts)
    toned = (False,) * len(pairs)
    if lines:
        found, inner = find_motion(volts, rate_hz, noise_v), without_ends(volts, rate_hz)
        toned = tuple(find_motion(inner[pair], rate_hz, noise_v[pair]) is None for pair in pairs)
        if found is None or all(toned):
            # below what was taken off a target may still go its way
            found = _steady_motion(volts, stretch.signals.usable, rate_hz, noise_v, lines)
            toned = (False,) * len(pairs)
        if found is None:
            return NoMotion(f"{_only_tones(lines)} moves the voltages")
        motion = found
    phase_sign, as_wired = setup.radar.phase_sign, volts
    if phase_sign < 0:
        volts = volts.copy()
        volts[1::2] *= -1.0
    n_channels, moving = volts.shape[0], slice(motion.first, motion.last)
    delay_s = channel_skew(recording.digitisation, setup.daq).delay_s * np.arange(n_channels, dtype=np.float64)
    # after the hum: its slow swing would hide that a channel stands at its end
    usable = stretch.signals.usable & ~_plateaus(volts, moving)
    if size > 1:
        # a mean that reaches beyond a plateau does not stand at its height
        raw = recording.raw[:, samples]
        usable &= ~blocks_with(_plateaus(raw, slice(motion.first * size, motion.last * size)), size)
    opened = open_channels(volts, noise_v, rate_hz, moving)
    doppler: tuple[Doppler, ...]
    echoes: tuple[Echo | None, ...] = (None,) * len(pairs)
    if len(pairs) < 3:
        # they tell no position: each has to be followed by itself, and at rest too
        at_one_time, found_hz = remove_skew(volts, rate_hz, delay_s), (*lines, *(() if hum is None else hum.lines_hz))
        alone = [_followed(at_one_time[pair], usable[pair], rate_hz, noise_v[pair], found_hz) for pair in pairs]
        doppler, echoes = tuple(one for one, _ in alone), tuple(echo for _, echo in alone)
    else:
        # what holds a path has more samples than its spectra need
        look = max(1, int(rate_hz / max(LOOKED_HZ, LOOKED_PER_FRINGE * stretch.signals.highest_hz)))
        means, noise = block_means(volts[:, moving], look), noise_v / np.sqrt(look)
        found_in = measure_dopplers(means, rate_hz / look, noise, DOPPLER.holding(stretch.signals.fastest_hz))
        doppler = tuple(one.of_samples(look, moving.start) for one in found_in)
    motion = _widened(motion, doppler, echoes)
    (onset_s, rest_end_s), moving = _rest_before(volts, time_s, motion), slice(motion.first, motion.last)
    faults = _open_faults(_faults(as_wired, noise_v, usable, doppler, moving), opened[:, moving])
    usable &= ~opened
    if lines:
        faults = tuple(
            f"{_only_tones(lines)} moves it" if only else own for only, own in zip(toned, faults, strict=True)
        )
    return Conditioned(
        samples,
        size,
        time_s,
        volts,
        usable,
        noise_v,
        Segment(motion.first, motion.last, 0, int(np.searchsorted(time_s, rest_end_s))),
        onset_s,
        rest_end_s,
        doppler,
        echoes,
        faults,
        delay_s,
        rate_hz,
        phase_sign,
    )


def _only_tones(lines_hz: tuple[float, ...]) -> str:
    return f"nothing but a hum or tones ({', '.join(f'{frequency:.0f}' for frequency in lines_hz[:4])} Hz)"


def _pairs(volts: FloatArray) -> list[slice]:
    """Return the channels of each receiver."""
    return [slice(first, first + 2) for first in range(0, volts.shape[0], 2)]


def _followed(
    pair_v: FloatArray, usable: BoolArray, rate_hz: float, noise_v: FloatArray, lines_hz: tuple[float, ...]
) -> tuple[Doppler, Echo | None]:
    """Return the lines and the echo of one receiver; clipped samples are filled with what the echo shows there."""
    # half a second to load, and only one or two receivers need it
    from radargui.conditioning.echo import follow_echo

    doppler = measure_doppler(pair_v, rate_hz, noise_v, ALONE).without_mains(lines_hz)
    echo = follow_echo(pair_v, usable, noise_v, doppler)
    share = float((~usable).mean())
    for _ in range(FILL_ROUNDS if share > FILLED_SHARE else 0):
        if echo is None:
            break
        as_before = replace(ALONE, lengths_s=(doppler.size / rate_hz,))
        filled = np.where(usable, pair_v, echo.shown_v)
        doppler = measure_doppler(filled, rate_hz, noise_v, as_before).without_mains(lines_hz)
        before, echo = echo.front_end, follow_echo(filled, usable, noise_v, doppler)
        if echo is not None:
            echo = replace(echo, front_end=echo.front_end.with_change_since(before, CLIPPED_U * share))
    return doppler, echo


def _widened(motion: Motion, doppler: tuple[Doppler, ...], echoes: tuple[Echo | None, ...]) -> Motion:
    """Return the motion with all frames that an echo leads in: a steady one under noise does not shake the voltages."""
    first, last = motion.first, motion.last
    for own, echo in zip(doppler, echoes, strict=True):
        seen = np.flatnonzero(own.clear & echo.leads[own.centre]) if echo is not None else np.empty(0, dtype=np.intp)
        if echo is not None and seen.size:
            first = min(first, int(own.centre[seen[0]]) if seen[0] else 0)
            last = max(last, int(own.centre[seen[-1]]) if seen[-1] < own.centre.size - 1 else echo.leads.size)
    return Motion(first, last, motion.window_s)


def _plateaus(volts: RawArray, moving: slice) -> BoolArray:
    """Return where a channel lies at its highest or lowest value, if it does so for longer than a wave's crest.

    More than a share of the motion, or many times as often as at the value next to it: the two last codes of a sine
    stand as 2.4 to 1.
    """
    out = np.zeros(volts.shape, dtype=np.bool_)
    for row, channel in zip(out, volts, strict=True):
        inside = channel[moving]
        for end, inner in ((inside.max(), -np.inf), (inside.min(), np.inf)):
            at_end = inside == end
            count = int(np.count_nonzero(at_end))
            if count == inside.size or count <= min(CLIPPED_SHARE * inside.size, LEAST_PILED):
                continue
            beside = inside[~at_end].max() if inner < 0 else inside[~at_end].min()
            if count > CLIPPED_SHARE * inside.size or count > max(PILED * int((inside == beside).sum()), LEAST_PILED):
                row |= channel == end
    return out


def _faults(
    as_wired: FloatArray, noise_v: FloatArray, usable: BoolArray, doppler: tuple[Doppler, ...], moving: slice
) -> tuple[str, ...]:
    """Return why a receiver is none, one a receiver; the voltages are without the wiring's sign."""
    faults = [
        check_receiver(
            own.between(moving.start, moving.stop), as_wired[pair, moving], noise_v[pair], usable[pair, moving]
        )
        for own, pair in zip(doppler, _pairs(as_wired), strict=True)
    ]
    names, own = iq_names(len(faults)), tuple(faults)
    # a cable on I and on Q of another shows the same where no sign is applied
    for a, b in same_channels(as_wired[:, moving], noise_v, as_wired[:, : moving.start]):
        for one, other in ((a, b), (b, a)):
            innocent = own[other // 2] or is_worse_pair(doppler[other // 2], doppler[one // 2])
            if own[one // 2] or not innocent:
                faults[one // 2] = f"{names[one]} shows what {names[other]} shows: one cable on both"
    return tuple(faults)


def _open_faults(faults: tuple[str, ...], opened: BoolArray) -> tuple[str, ...]:
    """Return the faults, those of receivers that lack too much of a motion with which channel does."""
    out, names = list(faults), iq_names(len(faults))
    for channel, share in enumerate(opened.mean(axis=1)):
        # what is known to be dead need not be open
        if share > PAIR.most_clipped and not faults[channel // 2]:
            out[channel // 2] = (
                f"{names[channel]} stands still in {100 * share:.0f} % of the motion, and the other channel does not: "
                "a contact is loose, or a cable came off"
            )
    return tuple(out)


def _hum_at_rest(
    volts: FloatArray, time_s: FloatArray, rate_hz: float, motion: Motion, noise_v: FloatArray
) -> Hum | None:
    """Return the hum of the rests before and after the motion."""

    def measured(rest_end: int) -> Hum | None:
        after = slice(motion.last + round(SETTINGS.after_motion_s * rate_hz), volts.shape[1])
        least = 0.5 * HUM.least_rest_s * rate_hz
        rests = tuple(part for part in (slice(0, rest_end), after) if part.stop - part.start >= least)
        return find_hum(volts, rate_hz, rests, noise_v)

    quiet_end = motion.first - round(SETTINGS.least_s * rate_hz)
    hum = measured(quiet_end)
    if hum is None:
        return None
    # a slow beginning of the motion, still counted as rest, can look like a weak hum: once more without it
    onset, _ = _rest_before(volts - hum.at(np.arange(volts.shape[1]) / rate_hz), time_s, motion)
    earlier = int(np.searchsorted(time_s, onset - SETTINGS.hum_margin_s))
    return measured(earlier) if 0 < earlier < quiet_end else hum


def _rest_before(volts: FloatArray, time_s: FloatArray, motion: Motion) -> tuple[float, float]:
    """Return when the tracer leaves its rest (-inf: it begins in motion), and until when it rests for sure.

    Means over 5 ms do not see every motion: an onset long after the voltages are seen to shake is none.
    """
    begin, seen = float(time_s[0]), float(time_s[motion.first])
    if motion.first == 0:
        return float("-inf"), begin
    # every fourth sample tells it as well
    spread = volts[:, ::4].std(axis=1)
    scale = np.maximum(np.sqrt(2.0) * np.median(spread.reshape(-1, 2), axis=1), 1e-300).repeat(2)
    # what comes after the voltages are seen to shake is no onset
    part = slice(0, int(np.searchsorted(time_s, seen + motion.window_s + SEEN_ON_S)))
    onset = find_onset(time_s[part], volts[:, part] / scale[:, None], spread / scale)
    onset = seen if onset is None or onset > seen + motion.window_s else onset
    if not onset > begin:
        return float("-inf"), begin
    crept = creeps_since(time_s[part], volts[:, part] / scale[:, None], onset)
    if crept is not None:
        rest_end = crept - SETTINGS.before_onset_s
        return (crept, rest_end) if rest_end > begin + SETTINGS.least_s else (float("-inf"), begin)
    # a slow beginning is seen late: by about as much as the shaking of the voltages is seen after the onset
    late = max(0.0, seen - onset)
    # what looks at rest for as long again before it may be creeping already
    rest_end = max(onset - late - SETTINGS.before_onset_s, begin + SETTINGS.least_s)
    is_moving = is_under_way(time_s[part], volts[:, part] / scale[:, None], rest_end)
    return (float("-inf"), begin) if is_moving else (onset, rest_end)
