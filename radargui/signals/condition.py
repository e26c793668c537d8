"""Condition a recording: measure everything that corrections and estimates start from, each thing once."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.model.finding import refuse
from radargui.model.front_end import with_phase_sign
from radargui.model.recording import Recording, absolute_index, channel_skew
from radargui.model.result import Segment
from radargui.model.setup import Setup
from radargui.physics.path_length import MIN_RECEIVERS
from radargui.signals.averager import block_means, blocks_with
from radargui.signals.conditioned import Conditioned
from radargui.signals.doppler import SETTINGS as DOPPLER, Doppler, measure_dopplers
from radargui.signals.faults import faults_of, open_channels, plateaus, with_open
from radargui.signals.followed import follow_receiver
from radargui.signals.onset import REST, rest_before
from radargui.signals.rows import pairs_of
from radargui.signals.segment import Motion
from radargui.signals.skew import remove_skew
from radargui.signals.stretch import NAMED_TONES, NO_MOTION, NoMotion, Stretch, find_stretch

if TYPE_CHECKING:
    from radargui.signals.echo import Echo

LOOKED_HZ, LOOKED_PER_FRINGE = 1000.0, 16.0
"""Least rate, and least samples of the fastest wave, of the means whose spectra tell three receivers' lines."""


def condition(recording: Recording, setup: Setup, samples: slice | None = None) -> Conditioned | NoMotion:
    """Condition the signals of a recording: of the stretches between gaps the one to use.

    One with a rest before the motion comes first, for there it is known where the sphere was; then the longest motion.
    Phase cannot be followed across lost samples.

    Parameters
    ----------
    recording
        Two channels a receiver.
    setup
        Its sign of the wiring; its multiplexer skew where the recording comes without one.
    samples
        The only stored samples that count, between which nothing was lost; None: all.

    Returns
    -------
    Conditioned or NoMotion
        NoMotion where the voltages do not move more than their noise.
    """
    skew, runs = channel_skew(recording.digitisation, setup.daq), tuple(recording.stretches())
    if samples is not None:
        runs = ((samples, int(absolute_index(samples.start, 1, recording.gaps)[0])),)
    found = [find_stretch(recording, samples, first, setup) for samples, first in runs]
    moving = [one for one in found if isinstance(one, Stretch)]
    if not moving:
        # that nothing but a hum is there says more
        return next((one for one in found if isinstance(one, NoMotion) and one != NO_MOTION), NO_MOTION)

    def worth(one: Stretch) -> tuple[bool, int]:
        motion = one.motion
        return motion.first > REST.before_onset_s * one.signals.rate_hz, (motion.last - motion.first) * one.signals.size

    delay_s = skew.delay_s * np.arange(recording.digitisation.n_channels, dtype=np.float64)
    return _conditioned(recording, max(moving, key=worth), delay_s, setup.radar.phase_sign)


def _conditioned(recording: Recording, stretch: Stretch, delay_s: FloatArray, phase_sign: int) -> Conditioned:
    signals, motion, noise_v = stretch.signals, stretch.motion, stretch.noise_v
    time_s, rate_hz, size = signals.time_s, signals.rate_hz, signals.size
    volts = with_phase_sign(signals.volts, phase_sign)
    at_one_time_v = remove_skew(volts, rate_hz, delay_s, slow=size > 1)
    pairs = pairs_of(volts)
    moving = slice(motion.first, motion.last)
    # after the hum: its slow swing would hide that a channel stands at its end
    usable = signals.usable & ~plateaus(volts, moving)
    if size > 1:
        # a mean that reaches beyond a plateau does not stand at its height
        raw = recording.raw[:, stretch.samples]
        usable &= ~blocks_with(plateaus(raw, slice(motion.first * size, motion.last * size)), size)
    opened = open_channels(volts, noise_v, rate_hz, moving)
    doppler: tuple[Doppler, ...]
    echoes: tuple[Echo | None, ...] = (None,) * len(pairs)
    if len(pairs) < MIN_RECEIVERS:
        # they tell no position: each has to be followed by itself, and at rest too
        found_hz = (*stretch.tones_hz, *(() if stretch.hum is None else stretch.hum.lines_hz))
        alone = [follow_receiver(at_one_time_v[pair], usable[pair], rate_hz, noise_v[pair], found_hz) for pair in pairs]
        doppler, echoes = tuple(one for one, _ in alone), tuple(echo for _, echo in alone)
    else:
        # what holds a path has more samples than its spectra need
        look = max(1, int(rate_hz / max(LOOKED_HZ, LOOKED_PER_FRINGE * signals.highest_hz)))
        means, noise = block_means(volts[:, moving], look), noise_v / np.sqrt(look)
        found_in = measure_dopplers(means, rate_hz / look, noise, DOPPLER.holding(signals.fastest_hz))
        doppler = tuple(one.of_samples(look, moving.start) for one in found_in)
    motion = _widened(motion, doppler, echoes)
    (onset_s, rest_end_s), moving = rest_before(volts, time_s, motion), slice(motion.first, motion.last)
    faults = with_open(faults_of(volts, noise_v, usable, doppler, moving, phase_sign), opened[:, moving])
    opened &= usable
    usable &= ~opened
    if stretch.tones_hz:
        only = refuse("tones_in_receiver", lines_hz=stretch.tones_hz[:NAMED_TONES])
        faults = tuple(only if toned else own for toned, own in zip(stretch.toned, faults, strict=True))
    return Conditioned(
        stretch.samples,
        size,
        time_s,
        volts,
        at_one_time_v,
        usable,
        opened,
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
        motion.pauses,
    )


def _widened(motion: Motion, doppler: tuple[Doppler, ...], echoes: tuple[Echo | None, ...]) -> Motion:
    """Return the motion with all frames that an echo leads in: a steady one under noise does not shake the voltages."""
    first, last = motion.first, motion.last
    for own, echo in zip(doppler, echoes, strict=True):
        seen = np.flatnonzero(own.clear & echo.leads[own.centre]) if echo is not None else np.empty(0, dtype=np.intp)
        if echo is not None and seen.size:
            first = min(first, int(own.centre[seen[0]]) if seen[0] else 0)
            last = max(last, int(own.centre[seen[-1]]) if seen[-1] < own.centre.size - 1 else echo.leads.size)
    return replace(motion, first=first, last=last)
