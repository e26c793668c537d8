"""Correct each receiver by the chosen method: published, ellipse, none, or a plug-in.

Correct a receiver by one ellipse: constant offset, gain ratio and quadrature error (Heydemann 1981).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from radargui.correction.phase import unwrap, wrapped_phase
from radargui.correction.published import PublishedSteps, correct_published
from radargui.correction.quality import PHASE_OVER_ROUNDNESS, assess, circularity
from radargui.model.arrays import BoolArray, FloatArray, median
from radargui.model.channel_quality import ChannelQuality
from radargui.model.errors import ProcessingError
from radargui.model.finding import why_of
from radargui.model.plugins import load_plugin
from radargui.model.result import CorrectedIQ, Segment
from radargui.signals.conditioned import Conditioned
from radargui.signals.ellipse import Ellipse, fit_ellipse, no_ellipse
from radargui.signals.rows import order_statistics

MIN_ARC_RAD = np.pi
ARC_TURNS = 1.2
"""Turns of the circle at which the phase is off twice as far as its roundness says.

A conic through an arc takes a change of the echo's strength for another centre, and stays round. Of 207 receivers in
slow motions of the laboratory error over u was 7 below 0.7 turns, 3.5 below 0.9, 2.5 to 1.4, 1.4 to 2, 1.1 beyond:
1 + (1.2 / turns)^3 (decision 49).
"""


def correct_ellipse(
    pair_v: FloatArray, segment: Segment, usable: BoolArray | None = None
) -> tuple[FloatArray, Ellipse]:
    """Correct one receiver by the ellipse through the samples of its motion.

    Parameters
    ----------
    pair_v
        I and Q in volts, finite, shape (2, n_samples).
    segment
        The segment with motion.
    usable
        Samples that count, shape (n_samples,); None: all.

    Returns
    -------
    tuple
        I and Q in amplitudes, shape (2, n_samples), and the ellipse.

    Raises
    ------
    ProcessingError
        The motion turns the phase by less than half a fringe, or there is no signal.
    """
    moving = pair_v[:, segment.first : segment.last]
    if usable is not None and usable[segment.first : segment.last].any():
        # clipped crests would flatten the conic
        moving = moving[:, usable[segment.first : segment.last]]
    ellipse = fit_ellipse(moving)
    corrected = ellipse.apply(pair_v)
    # a conic fits every short arc: what it says of the rest of the circle is chance
    arc = np.unwrap(np.arctan2(corrected[1], corrected[0])[segment.first : segment.last])
    if np.ptp(arc) < MIN_ARC_RAD:
        raise no_ellipse()
    return corrected, ellipse


def arc_over_roundness(phase_rad: FloatArray) -> float:
    """Return how many times as far off as its roundness says the phase of an arc (n,) may be."""
    known = phase_rad[np.isfinite(phase_rad)]
    if known.size == 0:
        return 1.0
    first, last = order_statistics(known, 0.005, 0.995)
    return float(1.0 + (2.0 * np.pi * ARC_TURNS / max(last - first, MIN_ARC_RAD)) ** 3)


Steps = PublishedSteps | Ellipse | None
AddedCorrection = Callable[[FloatArray, Segment, BoolArray], FloatArray]
"""A plug-in of the group `radargui.corrections`.

Given I and Q of one receiver in V, shape (2, n_samples), where motion and rest are, and which samples are sound, it
returns I and Q on the unit circle, NaN where unknown, same shape. It raises `ProcessingError` where it cannot.
"""

SOME = 8
"""Samples of the motion of which one tells the scale, the same from one zero crossing to the next."""
PUBLISHED_OVER_ROUNDNESS = 2.1
"""`PHASE_OVER_ROUNDNESS` of the published procedure: its bias is held from the first extreme back, and its pieces take
off what else would show."""
MIN_U_PHASE_RAD = 1e-12
"""Of a signal that is perfectly round: a weight stays finite."""


def correct(
    conditioned: Conditioned, method: str, progress: Callable[[float], None] = lambda _: None
) -> tuple[CorrectedIQ, FloatArray]:
    """Remove the IQ mismatch of each receiver, and count its fringes.

    Parameters
    ----------
    conditioned
        Signals, motion, noise.
    method
        published, ellipse, none, or the name of a plug-in.
    progress
        Called with the share done.

    Returns
    -------
    tuple
        Corrected IQ and the unwrapped phase of its valid samples, shape (n_receivers, n_samples). A receiver that
        cannot be corrected is NaN, its quality "rejected" with the reason.
    """
    volts, segment = conditioned.at_one_time_v, conditioned.segment
    n_receivers = conditioned.n_receivers
    corrected = np.full(volts.shape, np.nan)
    u_phase, phase = (np.full((n_receivers, conditioned.n_samples), np.nan) for _ in range(2))
    valid = conditioned.valid
    channels: list[ChannelQuality] = []
    steps: list[Steps] = []
    for k in range(n_receivers):
        pair, name, step = slice(2 * k, 2 * k + 2), str(k + 1), None
        # one that cannot be corrected must not take the others along
        try:
            corrected[pair], step = _correct_one(conditioned, k, volts[pair], method)
        except ProcessingError as error:
            channels.append(ChannelQuality(name, finding=why_of(error)))
            valid[k] = False
        else:
            moving = np.s_[segment.first : segment.last]
            iq, good = corrected[pair, moving], valid[k, moving]
            wrapped = wrapped_phase(*corrected[pair])
            # invalid samples must not lead the count of turns astray
            phase[k] = unwrap(np.where(valid[k], wrapped, np.nan)[None])[0]
            turned = phase[k, moving] if good.all() else unwrap(wrapped[None, moving])[0]
            scale, noise = _scale(volts[pair, moving], iq, segment, step), conditioned.noise_v[pair]
            # I and Q may be scaled otherwise: the phase takes the mean of both
            relative = np.sqrt(0.5 * ((noise[0] / scale[0]) ** 2 + (noise[1] / scale[1]) ** 2))
            some = good[::SOME]
            # a receiver of which nothing is valid still has a noise to be reported
            noises = np.broadcast_to(relative, some.shape)[some | ~some.any()]
            quality = assess(
                name,
                iq=iq,
                phase_rad=turned,
                valid=good,
                noise=float(median(noises)),
                fraction_clipped=float((~conditioned.usable[pair, moving]).any(axis=0).mean()),
                rescaled=isinstance(step, PublishedSteps),
                **_mixer(step, scale),
            )
            channels.append(quality)
            if isinstance(step, PublishedSteps):
                over, whole = PUBLISHED_OVER_ROUNDNESS, quality.circularity
            else:
                # over the whole way, too: an echo that grows leaves an offset that the ellipse does not follow
                known = good & np.isfinite(iq).all(axis=0)
                over, whole = PHASE_OVER_ROUNDNESS, circularity(iq[:, known]) if known.any() else None
                over *= arc_over_roundness(turned[good]) if isinstance(step, Ellipse) else 1.0
            u_phase[k] = max(over * (whole or 0.0), MIN_U_PHASE_RAD)
        steps.append(step)
        progress((k + 1) / n_receivers)
    i, q = corrected[0::2], corrected[1::2]
    known, qualities = valid & np.isfinite(i), tuple(channels)
    return CorrectedIQ(conditioned.time_s, i, q, known, u_phase, method, qualities, tuple(steps)), phase


def correct_none(pair_v: FloatArray, segment: Segment) -> FloatArray:
    """Return I and Q divided by their root-mean-square radius in the motion, shape (2, n_samples)."""
    moving = pair_v[:, segment.first : segment.last]
    radius = float(np.sqrt((moving**2).sum(axis=0).mean()))
    return pair_v / max(radius, 1e-300)


def _correct_one(conditioned: Conditioned, number: int, pair_v: FloatArray, method: str) -> tuple[FloatArray, Steps]:
    segment = conditioned.segment
    if method == "published":
        highest_hz = conditioned.doppler[number].highest_hz
        return correct_published(pair_v, conditioned.sample_rate_hz, segment, highest_hz, int(conditioned.size > 1))
    if method == "ellipse":
        return correct_ellipse(pair_v, segment, conditioned.valid[number])
    if method == "none":
        return correct_none(pair_v, segment), None
    added: AddedCorrection = load_plugin("corrections", method)
    return np.array(added(pair_v, segment, conditioned.valid[number]), dtype=np.float64).reshape(pair_v.shape), None


def _scale(moving_v: FloatArray, iq: FloatArray, segment: Segment, step: Steps) -> FloatArray:
    """Return the volts that one unit of corrected I and Q stands for, at some samples of the motion or (2, 1)."""
    if isinstance(step, PublishedSteps):
        return np.stack([own.scale[segment.first : segment.last : SOME] for own in (step.i, step.q)])
    return np.asarray(moving_v.std(axis=1, keepdims=True) / np.maximum(iq.std(axis=1, keepdims=True), 1e-300))


def _mixer(step: Steps, scale: FloatArray) -> dict[str, float]:
    """Return what a correction says of the front end, by the names in `ChannelQuality`; scale as of `_scale`."""
    if isinstance(step, Ellipse):
        return {"gain_ratio": step.gain_ratio, "quadrature_error_deg": float(np.degrees(step.quadrature_error_rad))}
    return {"gain_ratio": float(median(scale[1]) / median(scale[0]))} if isinstance(step, PublishedSteps) else {}
