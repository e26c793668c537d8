"""Check that a phase turns as fast as the Doppler frequency of the spectra says."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from radargui.model.arrays import BoolArray, FloatArray
from radargui.signals.doppler import SETTINGS, Doppler, measure_doppler


@dataclass(frozen=True, slots=True)
class FollowSettings:
    """When a phase is said not to follow. Chosen by hand; `bench robust` and `bench real` are the test (decision 20).

    Attributes
    ----------
    share, bins
        A frame is missed where the frequencies differ by more than a share of the Doppler frequency and more than so
        many bins of its spectrum.
    max_missed, min_missed
        Share of the frames that may be missed (at an impact two speeds share a frame), and how many at any rate.
    still_bins
        Largest frequency of the phase, in bins, where the spectrum shows no line.
    arc_line, arc_rad
        A frame is not counted as missed if its line has less than `arc_line` of the strongest line's power and its
        phase stays within `arc_rad`: motion to and fro by 0.1 mm has a hundredth of the power, by 0.3 mm a tenth.
    covered
        Share of a frame's samples that must be valid for it to count.
    """

    share: float = 0.08
    bins: float = 0.7
    max_missed: float = 0.1
    min_missed: int = 3
    still_bins: float = 2.5
    arc_line: float = 0.03
    arc_rad: float = 0.7
    covered: float = 0.7


ALONE = FollowSettings()
TOGETHER = FollowSettings(max_missed=0.5, min_missed=4)
"""Where all receivers are fitted together. Chosen by hand: single moments are bridged, a path that strays is not."""
_PARTS = 8
"""Of a frame's middle half: a turn round falls into one of them."""


def missed_frames(
    phase_rad: FloatArray,
    valid: BoolArray,
    doppler: Doppler,
    settings: FollowSettings = ALONE,
    *,
    is_whole: bool = False,
) -> tuple[BoolArray, float]:
    """Return in which frames the phase turns otherwise than the spectrum says, and the share of the steady ones.

    Where there is no line the phase must not turn as if there were one.

    Parameters
    ----------
    phase_rad
        Of one receiver, unwrapped, shape (n_samples,).
    valid
        Same shape.
    doppler
        Lines of the receiver's frames.
    settings
        What counts as missed.
    is_whole
        Whether corrected I and Q lie on the circle and all around it. A path that turns round within a frame, as that
        of a sphere that bounces low, then only has to show the same line as the signal.
    """
    part = max(1, doppler.size // (2 * _PARTS))
    inside = (doppler.centre >= _PARTS * part // 2) & (doppler.centre + _PARTS * part // 2 <= phase_rad.size)
    # means of the parts of each frame's middle half; how far they lie apart is how far it turned, to and fro. A
    # mismatch makes the phase wave, but a mean over a turn does not
    place = doppler.centre[inside, None] - _PARTS * part // 2 + np.arange(_PARTS * part)
    phase = phase_rad[place].reshape(-1, _PARTS, part)
    good = valid[place].reshape(phase.shape) & np.isfinite(phase)
    number = good.sum(axis=2)
    held = (number >= settings.covered * part).all(axis=1)
    means = np.where(good, phase, 0.0).sum(axis=2) / np.maximum(number, 1)
    steps_hz = np.diff(means, axis=1) * doppler.sample_rate_hz / (2.0 * np.pi * part)
    turned_hz = np.abs(steps_hz).mean(axis=1)
    line, steady = (doppler.clear | doppler.mixed)[inside], doppler.steady[inside]
    if not steady.any():
        steady = doppler.clear[inside]
    expected = np.where(line, doppler.frequency_hz[inside], 0.0)
    within = np.maximum(settings.share * expected, settings.bins * doppler.resolution_hz)
    # a line that is broadened by a turn round or an impact says no one speed
    is_clear = ~doppler.clear[inside] | steady
    allowed = np.where(line, within, settings.still_bins * doppler.resolution_hz)
    off = is_clear & held & (np.abs(turned_hz - expected) > allowed)
    # a few turns and back within one frame have a narrow line too, at no mean speed, but at one that the phase had; an
    # offset makes a phase turn round more often
    speeds_hz = np.abs(steps_hz)
    swings = (np.diff(np.sign(steps_hz), axis=1) != 0.0).sum(axis=1) <= 1
    off &= ~(line & swings & (speeds_hz.min(axis=1) < expected) & (expected < speeds_hz.max(axis=1)))
    # a hand that trembles goes to and fro on a short arc, whose line is weak
    power = doppler.power[inside]
    off &= ~((power < settings.arc_line * power.max(initial=0.0)) & (np.ptp(means, axis=1) < settings.arc_rad))
    if is_whole and (off & line).any():
        # another offset would leave a turn that is not whole, or not round
        turns_round = (np.diff(np.sign(steps_hz), axis=1) != 0.0).any(axis=1)
        shown_hz = _shown_hz(phase_rad, doppler)[inside]
        off &= ~(line & turns_round & (np.abs(shown_hz - expected) <= within))
    missed = np.zeros(doppler.centre.size, dtype=np.bool_)
    missed[np.flatnonzero(inside)] = off
    return missed, float((off & steady).sum() / max(int((held & steady).sum()), 1))


def _shown_hz(phase_rad: FloatArray, doppler: Doppler) -> FloatArray:
    """Return the frequency of the strongest line of a unit circle with this phase, in the same frames."""
    known = np.nan_to_num(phase_rad)
    circle = np.stack([np.cos(known), np.sin(known)])
    frames = replace(SETTINGS, lengths_s=(doppler.size / doppler.sample_rate_hz,))
    shown = measure_doppler(circle, doppler.sample_rate_hz, np.full(2, 1e-3), frames)
    return np.interp(doppler.centre, shown.centre, shown.frequency_hz)


def follows(missed: BoolArray, share: float, settings: FollowSettings = ALONE) -> bool:
    """Whether a phase follows its signal, from what `missed_frames` counted: frames (n_frames,), and the share."""
    return int(missed.sum()) < settings.min_missed or share <= settings.max_missed
