"""The way of one or two receivers: each echo in its Doppler band, and circles where the offset is not known there."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from radargui.conditioning.conditioned import Conditioned
from radargui.correction.agreement import strays
from radargui.correction.doppler_band import correct_in_band
from radargui.model.corrected import CorrectedIQ
from radargui.model.errors import ProcessingError
from radargui.model.path import PathLengths
from radargui.model.quality import ChannelQuality
from radargui.processing.continuity import MOST_AWAY, MOST_GAP_S, MOST_TURNS, checked, longest_gap_s
from radargui.processing.measured_motion import MeasuredMotion

ABOVE_NOISE = 1.5
"""What a channel shows over its noise, below which circles are not tried: 4 dB, where no fringe can be counted."""

WHOLE = 0.97
"""Share of the motion known in the band above which circles are not tried."""


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
    # a Doppler band knows no offset where the target is slower than the band is wide
    partly = in_band.paths.valid[:, moving].mean() < WHOLE
    if partly and conditioned.segment.has_rest and _turns(conditioned) < MOST_TURNS:
        # the slow beginning of a fall is known to circles alone, from the rest on
        # their own judge must not be what they are to replace
        unjudged = tuple(own.between(0, 0) for own in conditioned.doppler)
        circles = by_circles(replace(conditioned, echoes=(None,) * conditioned.n_receivers, doppler=unjudged))
        if _agree(circles, conditioned) and _known(circles) > _known(in_band):
            return circles
    # below the noise a circle is fitted to noise, and finds one
    spread = np.sqrt(conditioned.volts.var(axis=1).reshape(-1, 2).max(axis=1))
    noise = conditioned.noise_v.reshape(-1, 2).max(axis=1)
    if all(
        echo is not None or own < ABOVE_NOISE * n
        for echo, own, n in zip(conditioned.echoes, spread, noise, strict=True)
    ):
        return in_band
    try:
        circles = by_circles(conditioned)
    except ProcessingError:
        if all(echo is None for echo in conditioned.echoes):
            raise
        return in_band
    # both are judged by their signal already: the one that is known for longer
    return max(circles, in_band, key=_known)


def _agree(circles: MeasuredMotion, conditioned: Conditioned) -> bool:
    """Whether circles that know the slow beginning of a motion turn as the echoes do where these lead."""
    moving = slice(conditioned.segment.first, conditioned.segment.last)
    for k, echo in enumerate(conditioned.echoes):
        phase, valid = circles.paths.phase_rad[k], circles.paths.valid[k]
        if echo is None or longest_gap_s(echo, moving, conditioned.sample_rate_hz) >= MOST_GAP_S:
            return False
        if circles.corrected.channels[k].verdict == "rejected":
            return False
        away = strays(phase, valid, echo, conditioned.sample_rate_hz) & echo.leads
        if away.sum() > MOST_AWAY * max(int(echo.leads.sum()), 1):
            return False
    return True


def _turns(conditioned: Conditioned) -> float:
    """Return the most fringes that an echo runs through."""
    return max((float(np.ptp(echo.phase_rad)) for echo in conditioned.echoes if echo is not None), default=0.0) / 6.28


def _in_band(conditioned: Conditioned, wavelength_m: float) -> MeasuredMotion:
    shape = (conditioned.n_receivers, conditioned.n_samples)
    i, q, phase, u_phase = (np.full(shape, np.nan) for _ in range(4))
    valid = np.zeros(shape, dtype=np.bool_)
    channels = []
    for k in range(conditioned.n_receivers):
        found = correct_in_band(conditioned, k)
        if found is None:
            channels.append(ChannelQuality(str(k + 1), verdict="rejected", reason="no Doppler frequency stands out"))
            continue
        (i[k], q[k]), phase[k], u_phase[k], valid[k] = found.iq, found.phase_rad, found.u_phase_rad, found.valid
        channels.append(found.quality)
    corrected = CorrectedIQ(conditioned.time_s, i, q, valid, u_phase, "adaptive", tuple(channels))
    per_rad = wavelength_m / (2.0 * np.pi)
    paths = PathLengths(conditioned.time_s, phase, phase * per_rad, u_phase * per_rad, valid)
    return checked(MeasuredMotion(corrected, paths, None), conditioned, wavelength_m)


def _known(motion: MeasuredMotion) -> int:
    """Return how many samples are valid in receivers that are not rejected."""
    sound = np.array([channel.verdict != "rejected" for channel in motion.corrected.channels])
    return int(motion.paths.valid[sound].sum())
