"""Reduce a recording to the lowest rate that still holds its motion.

All later steps work on these means.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from radargui.model.arrays import BoolArray, FloatArray, pieces
from radargui.model.gravity import expected_gravity_m_s2, fall_speed_m_s
from radargui.model.recording import Recording, at_rail
from radargui.model.setup import Setup
from radargui.physics.path_length import MIN_RECEIVERS
from radargui.signals.averager import block_means, blocks_with, code_means, held
from radargui.signals.rows import even_transform_size, order_statistics


@dataclass(frozen=True, slots=True)
class BandSettings:
    """The rate at which a motion is kept. Chosen by hand where no figure stands; decision 26 says what was tried.

    Attributes
    ----------
    least_hz
        Least rate. It holds 2 kHz: a sphere that bounces at 2 m/s has a Doppler frequency of 130 Hz at 10 GHz, but its
        turn at an impact is sharp.
    per_fringe
        Least number of samples in a fringe. A mean over 1/32 fringe keeps 0.998 of a wave, in I and Q alike, so that
        the phase stays. With 16 and 2 kHz published rejects 2 of 30 scenes that it corrects now.
    looked_hz, sure
        Rate at which the fastest line is sought, and the share of it below which a line is taken as it is: a line that
        is aliased to there has the frequency of the rate itself, 240 m/s of path at 10 GHz.
    pooled_hz
        Rate at which a faster one is looked for: path speeds to 450 m/s at 10 GHz.
    frame_s
        Length of the spectra: as long as the shortest of `DopplerSettings`.
    strong
        Least power of a line over the median of its spectrum. White noise reaches it once in some 10^8 frequencies.
    """

    least_hz: float = 4000.0
    per_fringe: float = 32.0
    looked_hz: float = 8000.0
    sure: float = 0.05
    pooled_hz: float = 30000.0
    frame_s: float = 0.0125
    strong: float = 30.0


SETTINGS = BandSettings()
JOINT = BandSettings(least_hz=30000.0, per_fringe=200.0)
"""For estimates that know an impact to microseconds and a radius to parts in ten thousand: joint, flights."""


MIN_OF_SIZE = 0.8
"""Share of the longest means that means of those in which lines were looked for may be as long as."""


@dataclass(frozen=True, slots=True)
class BandSignals:
    """Means of consecutive samples of a stretch.

    Attributes
    ----------
    volts
        Finite, shape (n_channels, n).
    usable
        False where any sample of the mean is clipped or was not a number, same shape.
    time_s
        Mean times of the samples, shape (n,).
    rate_hz
        Means a second.
    size
        Samples of the recording in one mean; 1 where all are kept. What is left over at the end is in none.
    highest_hz
        Frequency of the fastest line; infinite where none was sought.
    """

    volts: FloatArray
    usable: BoolArray
    time_s: FloatArray
    rate_hz: float
    size: int
    highest_hz: float = np.inf

    @property
    def fastest_hz(self) -> float:
        """Frequency that no line is above: half a bin more than where the highest was seen, if any was."""
        return self.highest_hz + 0.5 / SETTINGS.frame_s if self.highest_hz > 0.0 else np.inf


def band_signals(recording: Recording, samples: slice, first_index: int, setup: Setup) -> BandSignals:
    """Return the volts of a stretch as means short enough for its fastest motion.

    White noise stays white in means. All samples of one or two receivers are kept, because they are judged by their
    spectra alone; and all samples are kept where no correction is wanted.

    Parameters
    ----------
    recording
        Two channels a receiver.
    samples
        Stored samples without a gap.
    first_index
        Place of the first of them among all samples, lost ones too.
    setup
        Its correction; release and floor, where it gives both.
    """
    rate_hz = recording.digitisation.sample_rate_hz
    if recording.n_receivers < MIN_RECEIVERS or setup.processing.correction == "none":
        return _pooled(recording, samples, first_index, 1)
    # a mean blurs the turn at an impact, and only the joint estimate could have told it
    settings = JOINT if setup.processing.correction in ("joint", "flights") else SETTINGS
    # no body in a laboratory moves faster: a spectrum of all samples would cost more than all that follows
    for looked_hz, sure in ((settings.looked_hz, settings.sure), (settings.pooled_hz, 1.0)):
        size = max(1, int(rate_hz / max(looked_hz, settings.least_hz)))
        pooled = _pooled(recording, samples, first_index, size)
        line_hz = _fastest_line_hz(pooled.volts, pooled.rate_hz, settings)
        if line_hz < sure * pooled.rate_hz:
            break
    # the line of the last frame of a fall is that of its middle
    highest_hz = max(_fall_hz(setup), line_hz)
    size = max(1, int(rate_hz / max(settings.least_hz, settings.per_fringe * highest_hz)))
    further = size // pooled.size
    if further * pooled.size < MIN_OF_SIZE * size:
        return replace(_pooled(recording, samples, first_index, size), highest_hz=highest_hz)
    if further < 2:
        return replace(pooled, highest_hz=highest_hz)
    size = pooled.size * further
    time_s = _times_s(recording, samples, first_index, size)
    volts, bad = block_means(pooled.volts, further), blocks_with(~pooled.usable, further)
    return BandSignals(volts, ~bad, time_s, rate_hz / size, size, highest_hz)


def _times_s(recording: Recording, samples: slice, first_index: int, size: int) -> FloatArray:
    """Return the mean times of the blocks of a stretch without a gap that begins at an index, shape (n,)."""
    count = (samples.stop - samples.start) // size
    if recording.file_time_s is not None:
        return np.asarray(recording.file_time_s[samples][: count * size].reshape(count, size).mean(axis=1))
    first = first_index + (0 if recording.excerpt is None else recording.excerpt.first_index)
    return np.asarray((first + 0.5 * (size - 1) + size * np.arange(count)) / recording.digitisation.sample_rate_hz)


def _pooled(recording: Recording, samples: slice, first_index: int, size: int) -> BandSignals:
    raw, digitisation = recording.raw[:, samples], recording.digitisation
    count = raw.shape[1] // size
    means, share = np.empty((raw.shape[0], count)), np.full(size, 1.0 / size)
    for part in pieces(count, max(1, (1 << 16) // size)):
        own = raw[:, part.start * size : part.stop * size].reshape(raw.shape[0], -1, size)
        means[:, part] = code_means(own) if own.dtype == np.int16 else own @ share
    # a device's scaling is a line but for parts in a million: codes are averaged before it
    volts = digitisation.volts(means)
    bad = ~np.isfinite(volts)
    if bad.any():
        volts = block_means(held(digitisation.volts(raw)), size)
    bad |= blocks_with(at_rail(raw), size)
    time_s = _times_s(recording, samples, first_index, size)
    return BandSignals(volts, ~bad, time_s, digitisation.sample_rate_hz / size, size)


def _fall_hz(setup: Setup) -> float:
    """Return the highest Doppler frequency of a fall from the release to the floor; 0 where one is not told."""
    height_m = setup.floor.height_m
    if height_m is None or "release_position_m" not in setup.tracer.model_fields_set:
        return 0.0
    fall_m = max(setup.tracer.release_position_m[2] - height_m, 0.0)
    # no path changes faster than twice the speed
    return 2.0 * fall_speed_m_s(fall_m, expected_gravity_m_s2(setup.site)) / setup.radar.wavelength_m


def _fastest_line_hz(volts: FloatArray, rate_hz: float, settings: BandSettings) -> float:
    """Return the highest frequency of the strongest lines of frames, any receiver; 0 where none stands out."""
    size = even_transform_size(max(16, settings.frame_s * rate_hz))
    count = volts.shape[1] // size
    if count == 0:
        return 0.5 * rate_hz
    frames = volts[:, : count * size].reshape(volts.shape[0], count, size)
    mean = frames @ np.full(size, 1.0 / size)
    power = np.einsum("cfs,cfs->cf", frames, frames) / size - mean**2
    # frames at rest cost as much and show nothing: moving ones are above the quiet, or all about alike
    quiet, loud = order_statistics(power, 0.05, 0.95).T
    moving = np.flatnonzero((power > np.minimum(2.0 * quiet, 0.1 * loud)[:, None]).any(axis=0))
    window, highest = np.hanning(size), 0
    for part in pieces(moving.size, 64):
        own = frames[:, moving[part]] - mean[:, moving[part], None]
        spectrum = np.fft.rfft(own * window, axis=2)[..., 1:]
        square = spectrum.real**2 + spectrum.imag**2
        lines = (square[0::2] + square[1::2]).reshape(-1, square.shape[2])
        # only those above the highest so far are worth a median
        place = lines.argmax(axis=1) + 1
        lines, place = lines[place > highest], place[place > highest]
        if place.size:
            strong = lines.max(axis=1) > settings.strong * order_statistics(lines, 0.5)[:, 0]
            highest = max(highest, int(place[strong].max(initial=0)))
    return highest * rate_hz / size
