"""Follow the echo of a single receiver.

Front end and offset come from the spectra; the phase of what remains is unwrapped.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.fft import fft, fftfreq, ifft, next_fast_len
from scipy.linalg import solveh_banded
from scipy.ndimage import maximum_filter1d, minimum_filter1d, uniform_filter1d

from radargui.model.arrays import BoolArray, ComplexArray, FloatArray, IntArray, median, runs_of
from radargui.model.front_end import FrontEnd, channels_of, point_of
from radargui.signals.doppler import SETTINGS as LINES, Doppler
from radargui.signals.follows import FollowSettings, missed_frames
from radargui.signals.spectral_front_end import front_end_of


@dataclass(frozen=True, slots=True)
class EchoSettings:
    """How offset and phase are found, and where they are believed; values from `bench robust`.

    Attributes
    ----------
    max_drift
        Largest drift of the offset since it was last measured, in amplitudes, with which a phase is accepted.
    max_wander
        Largest root-mean-square change of the offset within 0.3 s, in amplitudes, with which a phase is accepted.
    min_known
        Share of the clear frames whose offset must be known: with less the target is too slow for spectra.
    slow, max_slow
        Frequencies below `slow` times the lowest Doppler frequency near by are taken off where their power exceeds
        `max_slow` of the whole (a quarter of the amplitude).
    band, added_hz
        The low-pass has its corner at `band` times the highest Doppler frequency near by, plus `added_hz` for changes
        of speed.
    envelope_s
        Time over which the strength of the echo is averaged; two periods of a slow echo at least.
    over_noise
        Least power over the noise in the band: at 7 dB the phase of a 1 kHz band clicks once a second (Rice 1963).
    held
        Least share of usable samples within a period of the low-pass's corner.
    deepest
        Where the envelope sinks below this share of its mean the phase may slip, by noise or by a second echo of two
        thirds.
    max_image
        Largest power of a line's image over that of the line: a tone has an image as strong as itself, an echo behind a
        usual mixer one of a hundredth.
    weak, weak_throughout, weak_elsewhere
        Shares of the high amplitudes (one in ten is higher). What is weaker is not the echo, but a hum or a second
        target that shows where the echo has gone: at any time below `weak`; throughout a stretch below
        `weak_throughout`; throughout a stretch at another frequency below `weak_elsewhere`.
    elsewhere
        Relative difference from which on two frequencies count as different.
    same_strength, joined_s
        After an interruption the echo is the same one if its strength has changed by no more than this factor and the
        interruption was no longer than `joined_s`.
    offset_bins
        Doppler frequency in bins from which the mean under a Hann window holds less than 1 % of the echo.
    knots_s
        Distance of the knots of the offset's curve: drifts are slower than 1 Hz.
    max_scatter
        Largest scatter of the frames about the offset's curve, in amplitudes. With more the curve gets more knots, up
        to one a frame.
    """

    max_drift: float = 0.3
    max_wander: float = 1.4
    min_known: float = 0.2
    slow: float = 0.5
    max_slow: float = 0.06
    band: float = 1.25
    added_hz: float = 40.0
    envelope_s: float = 0.02
    over_noise: float = 5.0
    held: float = 0.4
    deepest: float = 0.25
    max_image: float = 0.06
    weak: float = 0.07
    weak_throughout: float = 0.3
    weak_elsewhere: float = 0.5
    elsewhere: float = 0.25
    same_strength: float = 2.0
    joined_s: float = 0.1
    offset_bins: float = 2.5
    knots_s: float = 0.15
    max_scatter: float = 0.1


SETTINGS = EchoSettings()
ROUGHLY = FollowSettings(share=0.3, bins=1.5)
"""How the phase must follow the line of its own frame: where an offset leads, it hardly turns."""
STANDS = FollowSettings(share=0.9)
"""Where a phase stands still beside a line that is not alone, an offset leads and the target is in the line."""
WANDER_S = 0.3
"""Twice the time over which an offset is smooth."""
_SHARES = 8
"""Parts of a frame in which a line is looked for on both sides."""


@dataclass(frozen=True, slots=True)
class Echo:
    """The signal of one receiver that turns with the target, found without a model of the scene.

    Attributes
    ----------
    wave
        X + jY in volts without front end and offset, in the Doppler band, shape (n_samples,).
    offset
        X + jY of it, shape (n_samples,).
    amplitude_v, u_phase_rad
        Its mean strength, and the standard uncertainty of its phase by noise, shape (n_samples,).
    phase_rad
        Unwrapped, shape (n_samples,).
    leads
        True where the signal exceeds the noise and is one echo, not a tone, an offset or two echoes of equal strength,
        shape (n_samples,).
    front_end
        Gain ratio and quadrature error.
    """

    wave: ComplexArray = field(repr=False)
    offset: ComplexArray = field(repr=False)
    amplitude_v: FloatArray = field(repr=False)
    u_phase_rad: FloatArray = field(repr=False)
    phase_rad: FloatArray = field(repr=False)
    leads: BoolArray = field(repr=False)
    front_end: FrontEnd

    @property
    def shown_v(self) -> FloatArray:
        """I and Q in volts that echo and offset show, shape (2, n_samples)."""
        shown = self.wave + self.offset
        return channels_of(shown, shown, self.front_end.gain_ratio, self.front_end.quadrature_error_rad)


def follow_echo(pair_v: FloatArray, usable: BoolArray, noise_v: FloatArray, doppler: Doppler) -> Echo | None:
    """Follow the echo of one receiver; None where too few frames show a line to tell the echo from its offset.

    Parameters
    ----------
    pair_v, usable
        I and Q at one time, and where they are neither clipped nor lost, shape (2, n_samples).
    noise_v
        White noise of both, shape (2,).
    doppler
        Lines of its frames, all over the samples.
    """
    # first of all: offset and low-pass are told in X and Y, where an echo is a circle
    front_end = front_end_of(doppler)
    if front_end is None:
        return None
    rate_hz = doppler.sample_rate_hz
    x, y = point_of(pair_v[0], pair_v[1], front_end.gain_ratio, front_end.quadrature_error_rad)
    offset, drift = offset_curve(x + 1j * y, doppler)
    slowest_hz, fastest_hz = _range(doppler, x.size)
    wave, too_slow, slow = _without_slow(x + 1j * y - offset, slowest_hz, doppler)
    corner_hz = SETTINGS.band * fastest_hz + SETTINGS.added_hz
    # phase noise falls with the band; of the echo the band takes nothing off
    wave = _low_passed(wave, rate_hz, corner_hz)
    # a slow echo beats with what is left of the offset: over whole periods its strength is even
    periods_s = 2.0 / float(np.quantile(doppler.frequency_hz[doppler.clear], 0.1))
    window, near = (max(3, round(s * rate_hz)) for s in (max(SETTINGS.envelope_s, periods_s), SETTINGS.envelope_s))
    noise_power = float((noise_v**2).sum()) * np.minimum(1.0, 2.0 * corner_hz / rate_hz)
    power = uniform_filter1d(np.abs(wave) ** 2, window, mode="nearest") - noise_power
    amplitude = np.sqrt(np.maximum(power, 1e-300))
    strong = power > SETTINGS.over_noise * noise_power
    # what is slower and runs about as far as the echo turns is another echo, which leads the phase of both
    wander = _wander(offset + slow, rate_hz)
    known = np.hypot(drift / SETTINGS.max_drift, wander / SETTINGS.max_wander) < amplitude
    if not (strong & known).any() or known[doppler.centre[doppler.clear]].mean() < SETTINGS.min_known:
        return None
    usual = float(np.quantile(amplitude[strong & known], 0.9))
    strong &= amplitude > SETTINGS.weak * usual
    # through the centre the phase jumps by half a turn, and nobody knows which way
    deep = minimum_filter1d(np.abs(wave), near) < SETTINGS.deepest * amplitude
    # single samples at the end of the range are filled by their neighbours in the band
    held = uniform_filter1d(usable.all(axis=0).astype(float), max(1, round(rate_hz / corner_hz.max()))) > SETTINGS.held
    # within the band the phase turns by less than half a turn from sample to sample
    phase = np.unwrap(np.angle(wave))
    other = too_slow | _images(doppler, front_end, wave)
    # a line that is neither clear nor mixed is a hum's (`Doppler.without_mains`)
    fast = doppler.frequency_hz > 3.5 * doppler.resolution_hz
    other |= ~doppler.clear & ~doppler.mixed & fast & (doppler.power > LINES.strong)
    other |= missed_frames(phase, strong, doppler, ROUGHLY)[0] & doppler.steady
    other |= missed_frames(phase, strong, doppler, STANDS)[0] & doppler.mixed & fast
    leads = np.asarray(strong & known & held & ~deep & ~doppler.around(other, wave.size))
    leads = _of_one_target(leads, amplitude, phase, usual, round(SETTINGS.joined_s * rate_hz))
    u_phase = np.asarray(np.sqrt(0.5 * noise_power) / amplitude)
    return Echo(wave, offset, amplitude, u_phase, phase, leads, front_end)


def _of_one_target(leads: BoolArray, amplitude: FloatArray, phase: FloatArray, usual: float, near: int) -> BoolArray:
    """Return where the echo leads without the weak stretches that nothing joins to a strong one, shape (n_samples,).

    A target that fades is followed down and up again. A stretch that is weak from its beginning to its end shows
    another target, which is seen while the first one rests or has gone.
    """
    runs = runs_of(leads)
    first, last = runs[:, 0], runs[:, 1] - 1
    reach = np.minimum(last - first, near)
    begins, ends = ((phase[at + reach] - phase[at]) / np.maximum(reach, 1) for at in (first, last - reach))
    level = np.log(np.maximum(amplitude, 1e-300))
    # a target neither changes its strength nor its speed at once; what takes over from it does
    joined = (
        (first[1:] - last[:-1] <= near)
        & (np.abs(level[first[1:]] - level[last[:-1]]) < np.log(SETTINGS.same_strength))
        & (np.abs(begins[1:] - ends[:-1]) <= SETTINGS.elsewhere * np.abs(ends[:-1]))
    )
    chain = np.concatenate([[0], np.cumsum(~joined)])[: len(runs)]
    highest = np.zeros(len(runs))
    np.maximum.at(highest, chain, [amplitude[a:b].max() / usual for a, b in runs])
    speed = np.abs(phase[last] - phase[first]) / np.maximum(last - first, 1)
    sound = highest[chain] > SETTINGS.weak_elsewhere
    out = np.zeros_like(leads)
    for k, (a, b) in enumerate(runs):
        there = np.flatnonzero(sound)[np.argsort(np.abs(first[sound] - a))[:1]]
        alike = np.abs(speed[k] - speed[there]) <= SETTINGS.elsewhere * speed[there]
        out[a:b] = sound[k] or (highest[chain[k]] > SETTINGS.weak_throughout and alike.any())
    return out


def _wander(offset: ComplexArray, rate_hz: float) -> FloatArray:
    """Return the standard deviation of the offset within 0.3 s around each sample, shape (n_samples,)."""
    parts, size = np.stack([offset.real, offset.imag]), max(1, round(WANDER_S * rate_hz))
    parts = parts - parts.mean(axis=1, keepdims=True)
    mean, square = (uniform_filter1d(one, size, axis=1, mode="nearest") for one in (parts, parts**2))
    return np.asarray(np.sqrt(np.maximum(square - mean**2, 0.0).sum(axis=0)))


def _range(doppler: Doppler, n_samples: int) -> tuple[FloatArray, FloatArray]:
    """Return the lowest and the highest Doppler frequency of the frames around each sample, shapes (n_samples,)."""
    hz = np.interp(doppler.centre, doppler.centre[doppler.clear], doppler.frequency_hz[doppler.clear])
    highest = maximum_filter1d(np.maximum(hz, np.where(doppler.mixed, doppler.frequency_hz, 0.0)), 3, mode="nearest")
    lowest = minimum_filter1d(hz, 3, mode="nearest")
    sample = np.arange(n_samples)
    return np.interp(sample, doppler.centre, lowest), np.interp(sample, doppler.centre, highest)


def _without_slow(
    wave: ComplexArray, slowest_hz: FloatArray, doppler: Doppler
) -> tuple[ComplexArray, BoolArray, ComplexArray]:
    """Return the wave without what is slower than the target, where that is strong; the empty frames; what was slower.

    A swelling hum or a second, slow target lies beside the line, and so does the target itself where it turns round.
    """
    nothing = np.zeros(doppler.centre.size, dtype=np.bool_)
    # turns round of the target itself reach into the upper half of what is taken off
    slow = _low_passed(wave, doppler.sample_rate_hz, 0.5 * SETTINGS.slow * slowest_hz)
    power = uniform_filter1d(np.stack([np.abs(slow) ** 2, np.abs(wave) ** 2]), doppler.size, axis=1, mode="nearest")
    share = power[0, doppler.centre] / np.maximum(power[1, doppler.centre], 1e-300)
    if float(median(share[doppler.clear])) < SETTINGS.max_slow:
        return wave, nothing, np.zeros_like(wave)
    slow = _low_passed(wave, doppler.sample_rate_hz, SETTINGS.slow * slowest_hz)
    return wave - slow, ~(doppler.clear | doppler.mixed), slow


def _low_passed(wave: ComplexArray, rate_hz: float, corner_hz: FloatArray) -> ComplexArray:
    """Return the wave through a low-pass whose corner changes: between fixed ones half an octave apart."""
    lowest, highest = float(corner_hz.min()), float(corner_hz.max())
    octaves = float(np.log2(highest / lowest))
    corners = np.geomspace(lowest, highest, 1 + int(np.ceil(2.0 * octaves)))
    place = np.log2(corner_hz / lowest) * (corners.size - 1) / max(octaves, 1e-12)
    pad = min(wave.size - 1, round(rate_hz / lowest))
    spectrum = fft(np.pad(wave, pad, mode="reflect"), next_fast_len(wave.size + 2 * pad))
    hz = np.abs(fftfreq(spectrum.size, 1.0 / rate_hz))
    out = np.zeros_like(wave)
    for k, corner in enumerate(corners):
        share = np.maximum(1.0 - np.abs(place - k), 0.0)
        if share.any():
            # flat without ringing: 99 % at half of the corner, 79 % at the corner, 10 % at 1.45 corners
            passed = ifft(spectrum * np.exp(-np.log(2.0) * (hz / (1.2 * corner)) ** 6))
            out += share * passed[pad : pad + wave.size]
    return out


def _images(doppler: Doppler, front_end: FrontEnd, wave: ComplexArray) -> BoolArray:
    """Return in which frames a line stands on both sides at once, so that a tone or a hum leads, shape (n_frames,).

    The line of a target that turns round is on one side first and on the other side afterwards.
    """
    x, y = point_of(doppler.i, doppler.q, front_end.gain_ratio, front_end.quadrature_error_rad)
    sides = np.abs(np.stack([x + 1j * y, x - 1j * y])) ** 2
    allowed = SETTINGS.max_image + 3.0 / np.maximum(doppler.power, 1e-300)
    both = np.asarray(doppler.clear & (sides.min(axis=0) > allowed * sides.max(axis=0)))
    # one frame may hold both ways of a turn round: only parts of it tell an image from that
    half, short = doppler.size // 2, max(2, doppler.size // _SHARES)
    for k in np.flatnonzero(both & (doppler.frequency_hz > _SHARES / 2 * doppler.resolution_hz)):
        frame = wave[max(doppler.centre[k] - half, 0) : doppler.centre[k] + half]
        turn = np.exp(-2j * np.pi * doppler.frequency_hz[k] / doppler.sample_rate_hz * np.arange(frame.size))
        ahead, back = (np.abs(uniform_filter1d(frame * one, short)) ** 2 for one in (turn, turn.conj()))
        both[k] = np.minimum(ahead, back).sum() > allowed[k] * np.maximum(ahead, back).sum()
    return both


def offset_curve(wave: ComplexArray, doppler: Doppler) -> tuple[ComplexArray, FloatArray]:
    """Return the offset at each sample and how far it may have drifted since it was last seen, shapes (n_samples,).

    Frames are averaged under a Hann window and joined by the smoothest curve through knots. An echo that turns fast has
    no mean, and neither has a second reflection at twice its frequency.

    Parameters
    ----------
    wave
        X + jY without front end, shape (n_samples,).
    doppler
        Lines of its frames; some of them clear.
    """
    seen = doppler.clear & (doppler.frequency_hz >= SETTINGS.offset_bins * doppler.resolution_hz)
    centre, half = doppler.centre[seen], doppler.size // 2
    # its zeros lie on whole bins: an echo of 2.5 bins and more averages out
    window = np.hanning(doppler.size)
    mean = np.array([window @ wave[at - half : at - half + doppler.size] for at in centre]) / window.sum()
    # <|z|^2> under the window, by Parseval
    amplitude = np.sqrt(4.0 * median(doppler.moments[0, seen]) / (doppler.size * (window**2).sum()))
    step = max(round(SETTINGS.knots_s * doppler.sample_rate_hz), half)
    knots, curve, apart = _curve(centre, mean, step, half, wave.size)
    while apart > SETTINGS.max_scatter * amplitude and step > half:
        step = max(step // 2, half)
        knots, curve, apart = _curve(centre, mean, step, half, wave.size)
    sample = np.arange(wave.size)
    offset = np.interp(sample, knots, curve[:, 0]) + 1j * np.interp(sample, knots, curve[:, 1])
    # where nothing was seen an offset may have gone on as it went before
    slopes = np.hypot(*np.diff(curve, axis=0).T) / step
    speed = np.maximum(median(slopes), slopes[np.minimum(sample // step, slopes.size - 1)])
    after = np.searchsorted(centre, sample)
    before, behind = centre[np.maximum(after - 1, 0)], centre[np.minimum(after, centre.size - 1)]
    return offset, speed * np.minimum(np.abs(sample - before), np.abs(sample - behind))


def _curve(
    centre: IntArray, mean: ComplexArray, step: int, half: int, n_samples: int
) -> tuple[IntArray, FloatArray, float]:
    """Return knots, the curve's X and Y at them, shape (n_knots, 2), and the root mean square of what it misses."""
    knots = np.arange(0, n_samples + step, step)
    place, share = np.divmod(centre / step, 1.0)
    rows, place = np.arange(centre.size), place.astype(np.intp)
    design = np.zeros((centre.size, knots.size))
    design[rows, place], design[rows, np.minimum(place + 1, knots.size - 1)] = 1.0 - share, share
    normal, frames = design.T @ design, step / half
    # curvature costs as much as the frames between two knots; slope a little, so that the ends do not run away
    for order, cost in ((2, frames), (1, 0.01 * frames)):
        if knots.size > order:
            difference = np.diff(np.eye(knots.size), order, axis=0)
            normal += cost * difference.T @ difference
    bands = [np.pad(np.diagonal(normal, k), (k, 0)) for k in range(min(3, knots.size))]
    value = np.stack([mean.real, mean.imag], axis=1)
    curve = solveh_banded(np.array(bands[::-1]), design.T @ value)
    return knots, curve, float(np.sqrt(np.mean((design @ curve - value) ** 2)))
