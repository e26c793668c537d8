"""Prepare a stretch between two gaps: take hum and tones off its signals and find the motion in it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.model.finding import Finding, refuse
from radargui.model.recording import Recording
from radargui.model.setup import Setup
from radargui.signals.band import BandSignals, band_signals
from radargui.signals.followed import steady_motion
from radargui.signals.hum import SETTINGS as HUM, Hum, find_hum
from radargui.signals.interference import without_interference
from radargui.signals.noise import MIN_SAMPLES, white_noise_v
from radargui.signals.onset import REST
from radargui.signals.rows import pairs_of
from radargui.signals.segment import Motion, find_motion


@dataclass(frozen=True, slots=True)
class NoMotion:
    """The answer for a recording that shows no motion, with the reason."""

    finding: Finding


@dataclass(frozen=True, slots=True)
class Stretch:
    """The samples between two gaps, and the motion in them.

    Attributes
    ----------
    samples
        Of the recording.
    signals
        Less the hum and the tones.
    noise_v
        White noise of a mean of each channel.
    motion
        Found after hum and tones were removed.
    hum
        Pick-up of the mains, measured at rest and taken off.
    tones_hz
        Frequencies of lines that last throughout; they are removed.
    toned
        Receivers that show nothing but these lines.
    """

    samples: slice
    signals: BandSignals
    noise_v: FloatArray
    motion: Motion
    hum: Hum | None
    tones_hz: tuple[float, ...]
    toned: tuple[bool, ...]


def find_stretch(recording: Recording, samples: slice, first_index: int, setup: Setup) -> Stretch | NoMotion:
    """Return the signals of a stretch without hum and tones, and their motion.

    Parameters
    ----------
    recording, samples, first_index, setup
        As in `band_signals`.
    """
    if samples.stop - samples.start < MIN_SAMPLES:
        return NO_MOTION
    signals = band_signals(recording, samples, first_index, setup)
    volts, rate_hz = signals.volts, signals.rate_hz
    noise_v = white_noise_v(volts)

    def motion_in(volts: FloatArray, channels: slice = slice(None)) -> Motion | None:
        return find_motion(volts[channels], rate_hz, noise_v[channels])

    def without_tones(volts: FloatArray) -> tuple[FloatArray, tuple[float, ...], slice]:
        return without_interference(volts, rate_hz, noise_v)

    def below(clean: FloatArray, tones_hz: tuple[float, ...]) -> Motion | None:
        # below what was taken off a target may still go its way
        return steady_motion(clean, signals.usable, rate_hz, noise_v, tones_hz)

    motion = motion_in(volts)
    if motion is None:
        clean, tones_hz, _ = without_tones(volts)
        motion = (motion_in(clean) if tones_hz else None) or below(clean, tones_hz)
    if motion is None:
        return NO_MOTION
    # on the rest alone: in the motion a target at 50 Hz is a target
    hum = _hum_at_rest(signals, motion, noise_v)
    if hum is not None:
        volts = volts - hum.at(np.arange(volts.shape[1]) / rate_hz)
        # without the hum the motion is seen where it begins
        motion = motion_in(volts) or motion
    # what has no rest to be measured on is known by being there on both sides
    volts, tones_hz, sure = without_tones(volts)
    toned = (False,) * recording.n_receivers
    if tones_hz:
        found = motion_in(volts)
        toned = tuple(motion_in(volts[:, sure], pair) is None for pair in pairs_of(volts))
        if found is None or all(toned):
            found, toned = below(volts, tones_hz), (False,) * len(toned)
        if found is None:
            return NoMotion(refuse("tones_only", lines_hz=tones_hz[:NAMED_TONES]))
        motion = found
    return Stretch(samples, replace(signals, volts=volts), noise_v, motion, hum, tones_hz, toned)


NO_MOTION = NoMotion(refuse("nothing_moves"))
NAMED_TONES = 4
"""Of the lines of a tone so many are told."""


def _hum_at_rest(signals: BandSignals, motion: Motion, noise_v: FloatArray) -> Hum | None:
    """Return the hum of the rests before and after the motion."""
    volts, rate_hz = signals.volts, signals.rate_hz
    before = slice(0, motion.first - round(REST.min_s * rate_hz))
    after = slice(motion.last + round(REST.after_motion_s * rate_hz), volts.shape[1])
    least = 0.5 * HUM.min_rest_s * rate_hz
    rests = tuple(part for part in (before, after) if part.stop - part.start >= least)
    return find_hum(volts, rate_hz, rests, noise_v)
