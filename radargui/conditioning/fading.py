"""Fading: where an echo sinks into the noise while its target goes on, so that nobody knows the path."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from radargui.conditioning.doppler import Doppler
from radargui.model.arrays import BoolArray


@dataclass(frozen=True, slots=True)
class FadingSettings:
    """When an echo is lost.

    Attributes
    ----------
    over_noise, added_hz
        Least power over the noise in the band that its Doppler frequency needs, 2 f + 100 Hz: at 10 dB the phase hardly
        ever clicks (Rice 1963).
    fast
        A target that stops or turns round slows down first, below so much of the typical frequency.
    weak, very_weak
        Power over the typical power, in both frames beside a hole or in the next one alone, at which a target still
        at speed has left the beam: one that stops keeps its echo.
    least_frames
        Clear frames without which nothing is typical.
    """

    over_noise: float = 10.0
    added_hz: float = 100.0
    fast: float = 0.5
    weak: float = 0.3
    very_weak: float = 0.1
    least_frames: int = 6


SETTINGS = FadingSettings()


def lost_echo(doppler: Doppler, n_samples: int, settings: FadingSettings = SETTINGS) -> BoolArray:
    """Return where the echo of one receiver is lost, shape (n_samples,).

    Parameters
    ----------
    doppler
        Lines of its frames in the motion.
    n_samples
        Of the signals that the frames' samples count in.
    settings
        When it is lost.
    """
    lost = np.zeros(n_samples, dtype=np.bool_)
    clear = doppler.clear
    if int(clear.sum()) < settings.least_frames:
        return lost
    band_bins = (2.0 * doppler.frequency_hz + settings.added_hz) / doppler.resolution_hz
    typical_hz = float(np.median(doppler.frequency_hz[clear]))
    typical = float(np.median(doppler.power[clear]))
    # what is slower than any line that can be told from the trend, but as strong, is a target that turns round or rolls
    slow = ~clear & (doppler.power > settings.very_weak * typical)
    there = (clear | doppler.mixed | slow) & (doppler.power > settings.over_noise * np.maximum(band_bins, 1.0))
    if not there.any():
        return lost
    fast = there & (doppler.frequency_hz > settings.fast * typical_hz)
    sinking, sunk = (fast & (doppler.power < share * typical) for share in (settings.weak, settings.very_weak))
    edges = np.flatnonzero(np.diff(np.concatenate([[1], there.astype(np.int8), [1]]))).reshape(-1, 2)
    runs = [(int(a), int(b)) for a, b in edges]
    if there[0]:
        runs.insert(0, (0, 0))
    if there[-1]:
        runs.append((there.size, there.size))
    for begin, end in runs:
        if not (begin or there.size - end):
            continue
        before, after = slice(max(begin - 2, 0), begin), slice(end, end + 2)
        left = begin > 0 and bool(sunk[begin - 1] or sinking[before].all())
        back = end < there.size and bool(sunk[end] or sinking[after].all())
        if left or back:
            first = 0 if begin == 0 else int(doppler.centre[begin - 1])
            last = n_samples if end >= there.size else int(doppler.centre[end])
            lost[first:last] = True
    return lost
