"""What a measured path must keep to: it follows its signal, never jumps, and starts anew where it was lost.

Method 2.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import asdict, replace
from typing import TYPE_CHECKING

import numpy as np

from radargui.correction.agreement import lasting, strays
from radargui.correction.phase import join_pieces
from radargui.correction.quality import PHASE_OVER_ROUNDNESS, assess
from radargui.model.arrays import BoolArray, FloatArray, IntArray, median
from radargui.model.channel_quality import ChannelQuality
from radargui.model.errors import ProcessingError
from radargui.model.finding import refuse, warn
from radargui.model.front_end import FrontEnd
from radargui.model.result import CorrectedIQ, PathLengths, Track
from radargui.physics.path_length import MIN_RECEIVERS
from radargui.processing.measured_motion import MeasuredMotion
from radargui.signals.conditioned import Conditioned
from radargui.signals.doppler import Doppler
from radargui.signals.follows import ALONE, TOGETHER, follows, missed_frames
from radargui.signals.segment import without_blips
from radargui.signals.whole_turn import is_whole_circle

if TYPE_CHECKING:
    # loads what only one or two receivers need
    from radargui.signals.echo import Echo

JUMP_S = 0.005
"""Around a jump of a path in which nothing is known: half the block in which the phase's roughness is measured."""
MIN_RUN_S = 0.005
"""A path known for less is a moment between two doubts."""
MAX_SCATTER_RAD = 0.8
"""Of a phase about its line of 10 ms: with more, samples are nearer to another turn than to their own."""
MIN_CLEAR = 0.4
"""Share of clear frames below which three receivers are not judged by them: single ones are slow noise or the floor.

Only after a rest: without one no joint estimate tests what adaptive finds in signals that are no echo.
"""
MIN_KNOWN = 0.12
"""Share of the motion that a path of one receiver must be known in: less is more likely noise than an echo."""
MAX_LOST = 0.02
"""Share of the moments with an echo in which a path may lose it that is believed beside them, after a rest: a single
slip is found and left out; a centre that is wrong goes astray everywhere.
"""
PRESENT = (0.5, 2.0)
"""Corrected radius, in amplitudes, of a path that is believed where no echo leads.

A target that is slow or turns round keeps its radius; one that fades sinks to the centre, and what hides it, a hum or
another target, is no nearer to the radius than by its own strength.
"""
PRESENT_S = 0.01
"""Over which the radius is averaged: longer than noise, shorter than a fade that matters."""
MAX_GAP_S = 0.5
"""Where no echo leads for so long between moments that one does, it has faded, and what is left keeps still on any
circle: a flight of 30 cm turns round within it.
"""
MAX_STRAYED = 0.3
"""Share of the moments with an echo in which a path may turn otherwise, and is invalid: more is no single slip."""
MAX_IMAGE, SURE_U = 10.0 ** (-30.0 / 20.0), 4.0
"""Image that wrong constants may leave, over the line, and standard uncertainties beyond which they are wrong.

A toy car whose second reflection grows as it comes nearer drew an ellipse that leaves 26 dB; its lines have 60.
"""


def checked(
    motion: MeasuredMotion, conditioned: Conditioned, wavelength_m: float, *, is_held: bool = False
) -> MeasuredMotion:
    """Return the motion with receivers rejected whose path does not follow its signal, and with its path in pieces.

    Three receivers tell a position: a weak moment, or an impact that shares a frame of the spectrum with the fall, is
    then no reason to begin anew, and only a phase that goes its own way throughout is refused.

    Parameters
    ----------
    motion
        As corrected or estimated.
    conditioned
        Doppler frequencies of its signals, rest, rate.
    wavelength_m
        Of the radar.
    is_held
        Whether a model of the motion holds all receivers, or will test this: where it goes to and fro within a frame
        a path on a whole circle is believed then.
    """
    alone = is_alone(conditioned)
    valid = motion.paths.valid.copy()
    moving, rate_hz = slice(conditioned.segment.first, conditioned.segment.last), conditioned.sample_rate_hz
    has_rest = conditioned.segment.has_rest
    rested = not alone and has_rest
    channels = list(motion.corrected.channels)
    for k, (channel, echo, doppler) in enumerate(zip(channels, conditioned.echoes, conditioned.doppler, strict=True)):
        phase, good = motion.paths.phase_rad[k], valid[k]
        if alone:
            # first: samples beside a jump are wrong for sure, and must not speak against the others
            _drop_jumps(phase, good, rate_hz)
        if channel.verdict == "rejected":
            pass
        elif echo is not None:
            present = _present(motion.corrected, k, echo, moving, rate_hz) if has_rest else None
            channels[k] = _judged_by_echo(channel, phase, good, echo, moving, rate_hz, present)
        elif not (rested and doppler.clear.mean() < MIN_CLEAR):
            whole = is_held and not alone and _is_whole(motion.corrected, k, good, moving)
            channels[k] = _judged(channel, phase, good, doppler, alone=alone, is_whole=whole)
        if alone:
            good &= without_blips(good, max(2, round(MIN_RUN_S * rate_hz)))
            known = float(good[moving].mean())
            if channels[k].verdict != "rejected" and known < MIN_KNOWN:
                channels[k] = replace(channel, finding=refuse("echo_rarely_followed", share=known))
            good &= channels[k].verdict != "rejected"
    corrected = replace(motion.corrected, channels=tuple(channels), valid=valid)
    motion = replace(motion, corrected=corrected, paths=replace(motion.paths, valid=valid))
    return _divided(motion, conditioned, wavelength_m) if alone else motion


def is_alone(conditioned: Conditioned) -> bool:
    """Whether each receiver has to be believed by itself: fewer than three make no position."""
    return conditioned.n_receivers < MIN_RECEIVERS


def lay_down(phase_rad: FloatArray, valid: BoolArray, piece: IntArray, rest: slice) -> FloatArray:
    """Return phases with a zero in each piece: in the first one the mean at rest, else its first valid sample.

    Parameters
    ----------
    phase_rad, valid
        Shape (n_receivers, n_samples).
    piece
        Number of each sample's piece, shape (n_samples,).
    rest
        Samples at rest; empty without any.
    """
    out = phase_rad.copy()
    for number in range(int(piece.max(initial=0)) + 1):
        inside = piece == number
        for row, known in zip(out, valid & inside, strict=True):
            if not known.any():
                continue
            # only the first piece reaches back to the rest: the others have no common zero with it
            at_rest = row[rest][known[rest]] if number == 0 else row[:0]
            zero = at_rest.mean() if at_rest.size else row[np.argmax(known)]
            np.subtract(row, zero, out=row, where=inside)
    return out


def _drop_jumps(phase_rad: FloatArray, valid: BoolArray, rate_hz: float) -> None:
    """Call invalid, in place, where a path jumps or is rough: neither is motion.

    Half a turn from one sample to the next is a jump; a phase that scatters by a radian about its line of 10 ms has
    lost count somewhere in it.
    """
    reach = max(2, round(JUMP_S * rate_hz))
    size = 2 * reach
    count = valid.size // size
    along = np.arange(size) - 0.5 * (size - 1)
    for place in np.flatnonzero((np.abs(np.diff(phase_rad)) > np.pi) & valid[1:] & valid[:-1]):
        valid[max(place - reach, 0) : place + reach + 1] = False
    blocks = phase_rad[: count * size].reshape(count, size)
    blocks = blocks - blocks.mean(axis=1, keepdims=True)
    # less its line: steady motion is no scatter
    residual = blocks - (blocks @ along)[:, None] / (along @ along) * along
    valid[: count * size] &= ~np.repeat(np.sqrt((residual**2).mean(axis=1)) > MAX_SCATTER_RAD, size)


def _judged(
    channel: ChannelQuality, phase_rad: FloatArray, valid: BoolArray, doppler: Doppler, *, alone: bool, is_whole: bool
) -> ChannelQuality:
    """Return the verdict on a receiver; alone, single moments that do not follow become invalid, in place."""
    missed, share = missed_frames(phase_rad, valid, doppler, is_whole=is_whole)
    if not follows(missed, share, ALONE if alone else TOGETHER):
        return _strayed(channel, share)
    if alone:
        valid &= ~doppler.around(missed, valid.size)
    return channel


def _is_whole(corrected: CorrectedIQ, number: int, valid: BoolArray, moving: slice) -> bool:
    """Whether a receiver's corrected signal goes all around its circle, and on it."""
    iq = np.stack([corrected.i[number, moving], corrected.q[number, moving]])
    snr_db = corrected.channels[number].snr_db
    known = valid[moving] & np.isfinite(iq).all(axis=0)
    # SNR = 10 log10(A^2 / 2 sigma^2), A = 1
    noise = 0.0 if snr_db is None else float(np.sqrt(0.5 * 10.0 ** (-snr_db / 10.0)))
    return is_whole_circle(iq[:, known], noise)


def _judged_by_echo(
    channel: ChannelQuality,
    phase_rad: FloatArray,
    valid: BoolArray,
    echo: Echo,
    moving: slice,
    rate_hz: float,
    present: BoolArray | None,
) -> ChannelQuality:
    """Return the verdict on a receiver whose echo is known; moments that do not agree become invalid, in place.

    After a rest, whose place is known, a path that agrees with the echo wherever there is one is believed beside it
    too, where the target is `present`: spectra do not see the slow beginning of a fall, nor a turn round.
    """
    away = strays(phase_rad, valid, echo, rate_hz)
    lost = lasting(away, phase_rad, valid, echo)
    before = int((valid & echo.leads)[moving].sum())
    if present is not None and lost.sum() <= MAX_LOST * max(int(echo.leads.sum()), 1):
        valid &= (echo.leads | present) & ~lost
    else:
        valid &= echo.leads
        valid &= ~strays(phase_rad, valid, echo, rate_hz)
    # of what both knew: where no echo leads nothing can stray from it
    share = 1.0 - int((valid & echo.leads)[moving].sum()) / max(before, 1)
    if share > MAX_STRAYED:
        return _strayed(channel, share)
    return replace(channel, finding=refuse("echo_of_another")) if _is_another(channel, echo.front_end) else channel


def _is_another(channel: ChannelQuality, front_end: FrontEnd) -> bool:
    """Whether a channel's constants leave an image that those of the echo's lines do not: (d ln g + j d eps) / 2."""
    if channel.gain_ratio is None or channel.quadrature_error_deg is None:
        return False
    gain = abs(float(np.log(channel.gain_ratio / front_end.gain_ratio)))
    angle = abs(float(np.radians(channel.quadrature_error_deg - front_end.quadrature_error_deg)))
    u_gain, u_angle = front_end.u_gain_ratio / front_end.gain_ratio, np.radians(front_end.u_quadrature_error_deg)
    # an image is half of what leaves it
    return bool(np.hypot(gain, angle) > 2.0 * MAX_IMAGE and (gain > SURE_U * u_gain or angle > SURE_U * u_angle))


def _present(corrected: CorrectedIQ, number: int, echo: Echo, moving: slice, rate_hz: float) -> BoolArray:
    """Return where a target may be although no echo leads: on the circle, and not for longer than it may stand."""
    # a third of a second to load, and only one or two receivers need it
    from scipy.ndimage import uniform_filter1d

    size = max(1, round(PRESENT_S * rate_hz))
    radius = uniform_filter1d(np.nan_to_num(np.hypot(corrected.i[number], corrected.q[number])), size, mode="nearest")
    out = np.asarray((radius > PRESENT[0]) & (radius < PRESENT[1]))
    led = np.flatnonzero(echo.leads[moving]) + moving.start
    for before, after in itertools.pairwise([moving.start - 1, *led.tolist(), moving.stop]):
        if after - before > MAX_GAP_S * rate_hz:
            out[before + 1 : after] = False
    return out


def _strayed(channel: ChannelQuality, share: float) -> ChannelQuality:
    return replace(channel, finding=refuse("phase_led_astray", share=share))


def _divided(motion: MeasuredMotion, conditioned: Conditioned, wavelength_m: float) -> MeasuredMotion:
    paths, segment = motion.paths, conditioned.segment
    phase, piece = join_pieces(paths.phase_rad, paths.valid, conditioned.sample_rate_hz, conditioned.echoes)
    phase = lay_down(phase, paths.valid, piece, slice(segment.rest_first, segment.rest_last))
    per_rad = wavelength_m / (2.0 * np.pi)
    known, lost = np.asarray(paths.valid.any(axis=0)), int(piece[-1])
    findings = [warn("echo_lost", times=lost, has_track=motion.track is not None)] if lost else []
    if segment.has_rest and known.any() and not known[segment.rest_first : segment.rest_last].any():
        findings.insert(0, warn("path_begins_late", begin_s=float(paths.time_s[np.argmax(known)])))
    paths = replace(paths, phase_rad=phase, change_m=phase * per_rad, piece=piece)
    track = None if motion.track is None else known_where(motion.track, piece == 0)
    return replace(motion, paths=paths, track=track, findings=(*motion.findings, *findings))


def known_where(track: Track, known: BoolArray) -> Track:
    """Return a track with places where `known`, shape (n_samples,), says so alone."""
    position_m, u_position_m = (np.where(known, rows, np.nan) for rows in (track.position_m, track.u_position_m))
    return replace(track, position_m=position_m, u_position_m=u_position_m, valid=track.valid & known)


ABOVE_NOISE = 1.5
"""What a channel shows over its noise, below which circles are not tried: 4 dB, where no fringe can be counted."""

WHOLE = 0.97
"""Share of the motion known in the band above which circles are not tried."""

MAX_FRINGES = 60
"""After a rest above which circles are not tried: a drop has fewer, and what circles cost grows with their square."""


def measure_in_band(
    conditioned: Conditioned, wavelength_m: float, by_circles: Callable[[Conditioned], MeasuredMotion]
) -> MeasuredMotion:
    """Return the motion of one or two receivers by their echoes in the Doppler band.

    The band needs a target fast enough to separate the echo from the offset; circles do it by their shape, where a slow
    target runs round often enough. The one that knows more stands.

    Parameters
    ----------
    conditioned
        Signals of one or two receivers.
    wavelength_m
        Of the radar.
    by_circles
        Makes the motion by the adaptive circles.

    Raises
    ------
    ProcessingError
        Neither can be made.
    """
    in_band = _in_band(conditioned, wavelength_m)
    moving = slice(conditioned.segment.first, conditioned.segment.last)
    # a Doppler band knows no offset where the target is slower than the band is wide: the slow beginning after a rest
    partly = conditioned.segment.has_rest and in_band.paths.valid[:, moving].mean() < WHOLE
    partly &= all(echo is None or np.ptp(echo.phase_rad) < 2.0 * np.pi * MAX_FRINGES for echo in conditioned.echoes)
    # below the noise a circle is fitted to noise, and finds one
    spread = np.sqrt(conditioned.volts.var(axis=1).reshape(-1, 2).max(axis=1))
    noise = conditioned.noise_v.reshape(-1, 2).max(axis=1)
    rows = zip(conditioned.echoes, spread, noise, strict=True)
    if not partly and all(echo is not None or own < ABOVE_NOISE * n for echo, own, n in rows):
        return in_band
    try:
        circles = by_circles(conditioned)
    except ProcessingError:
        if all(echo is None for echo in conditioned.echoes):
            raise
        return in_band
    # both are judged by their signal already: the one that is known for longer
    # whoever knows less of what the band knows follows something else
    both = int((circles.paths.valid & in_band.paths.valid).sum())
    return circles if both >= WHOLE * in_band.paths.valid.sum() and _known(circles) > _known(in_band) else in_band


def _in_band(conditioned: Conditioned, wavelength_m: float) -> MeasuredMotion:
    """Return the echoes that conditioning followed, on the unit circle; a receiver without one is rejected."""
    shape = (conditioned.n_receivers, conditioned.n_samples)
    i, q, phase, u_phase = (np.full(shape, np.nan) for _ in range(4))
    valid = np.zeros(shape, dtype=np.bool_)
    channels = []
    for k, echo in enumerate(conditioned.echoes):
        if echo is None:
            channels.append(ChannelQuality(str(k + 1), finding=refuse("no_doppler_line")))
            continue
        unit = echo.wave / echo.amplitude_v
        i[k], q[k], phase[k], valid[k] = unit.real, unit.imag, echo.phase_rad, echo.leads
        quality = _quality(conditioned, k, echo, np.stack([unit.real, unit.imag]))
        # noise is known; what bends the circle is taken for phase as well, since nobody knows which it is
        u_phase[k] = np.hypot(echo.u_phase_rad, PHASE_OVER_ROUNDNESS * (quality.circularity or 0.0))
        channels.append(quality)
    corrected = CorrectedIQ(conditioned.time_s, i, q, valid, u_phase, "adaptive", tuple(channels))
    per_rad = wavelength_m / (2.0 * np.pi)
    paths = PathLengths(conditioned.time_s, phase, phase * per_rad, u_phase * per_rad, valid)
    return checked(MeasuredMotion(corrected, paths, None), conditioned, wavelength_m)


def _quality(conditioned: Conditioned, number: int, echo: Echo, iq: FloatArray) -> ChannelQuality:
    """Return the quality of a receiver's echo in the motion; `iq`: on the unit circle, shape (2, n_samples)."""
    moving = slice(conditioned.segment.first, conditioned.segment.last)
    known = echo.leads[moving]
    return assess(
        str(number + 1),
        iq=iq[:, moving],
        phase_rad=echo.phase_rad[moving],
        valid=known,
        noise=float(median(echo.u_phase_rad[moving][known])) if known.any() else 1.0,
        fraction_clipped=float(conditioned.unusable_share[number]),
        **asdict(echo.front_end),
    )


def _known(motion: MeasuredMotion) -> int:
    """Return how many samples are valid in receivers that are not rejected."""
    sound = np.array([channel.verdict != "rejected" for channel in motion.corrected.channels])
    return int(motion.paths.valid[sound].sum())
