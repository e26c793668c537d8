"""All receivers corrected by the chosen method."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from radargui.correction.ellipse import Ellipse, correct_ellipse
from radargui.correction.none import correct_none
from radargui.correction.phase import unwrap, wrapped_phase
from radargui.correction.published import PublishedSteps, correct_published
from radargui.correction.quality import assess
from radargui.model.arrays import BoolArray, FloatArray
from radargui.model.corrected import CorrectedIQ
from radargui.model.errors import ProcessingError
from radargui.model.quality import ChannelQuality
from radargui.model.segment import Segment

Steps = PublishedSteps | Ellipse | None


def correct(
    volts: FloatArray,
    time_s: FloatArray,
    sample_rate_hz: float,
    segment: Segment,
    noise_v: FloatArray,
    clipped: BoolArray,
    method: str,
    progress: Callable[[float], None] | None = None,
) -> CorrectedIQ:
    """Remove the IQ mismatch of each receiver.

    Parameters
    ----------
    volts
        Finite, skew removed, shape (2 n_receivers, n_samples).
    time_s
        Shape (n_samples,).
    sample_rate_hz
        Rate of each channel.
    segment
        The segment with motion.
    noise_v
        White noise of each channel, shape (2 n_receivers,).
    clipped
        Samples that are not to be used, shape (2 n_receivers, n_samples).
    method
        published, ellipse or none.
    progress
        Called with the share done.

    Returns
    -------
    CorrectedIQ
        A receiver that cannot be corrected is NaN, its quality "rejected" with the reason.
    """
    n_receivers, n_samples = volts.shape[0] // 2, volts.shape[1]
    i, q = np.full((n_receivers, n_samples), np.nan), np.full((n_receivers, n_samples), np.nan)
    u_phase = np.full((n_receivers, n_samples), np.nan)
    valid = ~(clipped[0::2] | clipped[1::2])
    channels: list[ChannelQuality] = []
    steps: list[Steps] = []
    for k in range(n_receivers):
        pair = slice(2 * k, 2 * k + 2)
        name = str(k + 1)
        try:
            iq, step = _correct_one(volts[pair], sample_rate_hz, segment, method)
        except ProcessingError as error:
            channels.append(ChannelQuality(name, verdict="rejected", reason=error.message))
            steps.append(None)
            valid[k] = False
            continue
        i[k], q[k] = iq
        channels.append(
            _quality(
                name, iq, volts[pair], segment, noise_v[pair], valid[k], np.asarray(clipped[pair].any(axis=0)), step
            )
        )
        u_phase[k] = max(channels[-1].circularity or 0.0, 1e-12)
        steps.append(step)
        if progress is not None:
            progress((k + 1) / n_receivers)
    return CorrectedIQ(time_s, i, q, valid & np.isfinite(i), u_phase, method, tuple(channels), tuple(steps))


def _correct_one(pair_v: FloatArray, sample_rate_hz: float, segment: Segment, method: str) -> tuple[FloatArray, Steps]:
    if method == "published":
        return correct_published(pair_v, sample_rate_hz, segment)
    if method == "ellipse":
        return correct_ellipse(pair_v, segment)
    return correct_none(pair_v, segment), None


def _quality(
    name: str,
    iq: FloatArray,
    pair_v: FloatArray,
    segment: Segment,
    noise_v: FloatArray,
    valid: BoolArray,
    clipped: BoolArray,
    step: Steps,
) -> ChannelQuality:
    moving = slice(segment.first, segment.last)
    scale = pair_v[:, moving].std(axis=1) / np.maximum(iq[:, moving].std(axis=1), 1e-300)
    gain, quadrature = None, None
    if isinstance(step, Ellipse):
        gain, quadrature = step.gain_ratio, step.quadrature_error_rad
    elif isinstance(step, PublishedSteps):
        gain = float(np.median(step.q.scale[moving]) / np.median(step.i.scale[moving]))
    phase = unwrap(wrapped_phase(iq[None, 0, moving], iq[None, 1, moving]))[0]
    return assess(
        name,
        iq=iq[:, moving],
        phase_rad=phase,
        valid=valid[moving],
        noise=float(np.sqrt(np.mean((noise_v / scale) ** 2))),
        clipped=clipped[moving],
        gain_ratio=gain,
        quadrature_error_rad=quadrature,
    )
