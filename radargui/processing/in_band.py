"""The way of one or two receivers: each echo in its Doppler band, and circles where the offset is not known there.

Method 2.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict
from typing import TYPE_CHECKING

import numpy as np

from radargui.conditioning.conditioned import Conditioned
from radargui.correction.quality import PHASE_OVER_ROUNDNESS, assess
from radargui.model.arrays import FloatArray, median
from radargui.model.channel_quality import ChannelQuality
from radargui.model.errors import ProcessingError
from radargui.model.finding import refuse
from radargui.model.result import CorrectedIQ, PathLengths
from radargui.processing.continuity import checked
from radargui.processing.measured_motion import MeasuredMotion

if TYPE_CHECKING:
    # loads what only one or two receivers need
    from radargui.conditioning.echo import Echo

ABOVE_NOISE = 1.5
"""What a channel shows over its noise, below which circles are not tried: 4 dB, where no fringe can be counted."""

WHOLE = 0.97
"""Share of the motion known in the band above which circles are not tried."""

MOST_FRINGES = 60
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
    partly &= all(echo is None or np.ptp(echo.phase_rad) < 2.0 * np.pi * MOST_FRINGES for echo in conditioned.echoes)
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
