"""Determine gain ratio and quadrature error from the Doppler lines of I and Q, independently of the offset."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from radargui.model.arrays import FloatArray, median
from radargui.model.front_end import FrontEnd
from radargui.signals.doppler import Doppler


@dataclass(frozen=True, slots=True)
class FrontEndSettings:
    """Which frames determine a front end, and how well.

    Attributes
    ----------
    min_frames
        Clear frames without which there is no front end.
    min_bins
        Doppler frequency in bins from which I and Q of a line hold less than 1 % of its own image (Hann window).
    min_power
        Least power of a frame, divided by that of the strong ones (one in ten is stronger): weaker lines may belong to
        a hum.
    min_u
        Standard uncertainties of ln gain and quadrature error (rad) at the least: runs of one receiver differ by this
        (`bench real`, toy cars: 0.762 +- 0.004, 25.3 +- 0.4 deg).
    groups
        Number of groups of successive frames; their means show how far slow disturbances move the front end.
    huber
        Standard deviations beyond which a frame counts less (Huber 1964).
    max_gain, max_angle_deg
        Gain ratio (or its inverse) and quadrature error that no mixer has: cheap ones are within 0.6 to 1.6 and 35
        deg. What shows more turns no one way: a tone or a hum that is the same on both channels.
    """

    min_frames: int = 4
    min_bins: float = 2.5
    min_power: float = 0.15
    min_u: float = 0.004
    groups: int = 8
    huber: float = 3.0
    max_gain: float = 2.5
    max_angle_deg: float = 50.0


SETTINGS = FrontEndSettings()


def front_end_of(doppler: Doppler) -> FrontEnd | None:
    """Return gain ratio and quadrature error from the lines of I and Q; None with few clear frames, or for no mixer.

    An echo that turns one way has no image, <z^2> = 0: g^2 = <Q^2> / <I^2> and sin eps = <I Q> / sqrt(<I^2><Q^2>),
    with the moments taken over the bins of each frame's line. A fit of circles takes a second reflection, at twice the
    Doppler frequency, for an offset, and the square of it for an image (20 dB below the echo: 40 dB); here it is in
    other bins. Frames count by their noise and by their scatter.
    """
    clear = doppler.clear & (doppler.frequency_hz >= SETTINGS.min_bins * doppler.resolution_hz)
    if int(clear.sum()) < SETTINGS.min_frames:
        return None
    # a weak line holds as much of a hum, and so more of its ellipse
    strong = clear & (doppler.power > SETTINGS.min_power * np.quantile(doppler.power[clear], 0.9))
    clear = strong if int(strong.sum()) >= SETTINGS.min_frames else clear
    i_square, q_square = np.maximum(doppler.moments[:2, clear], 1e-300)
    # ln g and eps have errors of one size: both are shares of the amplitude
    log_gain = 0.5 * np.log(q_square / i_square)
    eps = np.arcsin(np.clip(doppler.moments[2, clear] / np.sqrt(i_square * q_square), -1.0, 1.0))
    power = doppler.power[clear]
    # what disturbs is about as strong throughout: the weaker the echo, the farther it is moved
    moved = np.maximum(1.0, median(power) / power)
    (gain, u_gain), (angle, u_angle) = (_mean(one, 1.0 / power, moved) for one in (log_gain, eps))
    if abs(gain) > np.log(SETTINGS.max_gain) or abs(angle) > np.radians(SETTINGS.max_angle_deg):
        return None
    gain = float(np.exp(gain))
    return FrontEnd(gain, gain * u_gain, float(np.degrees(angle)), float(np.degrees(u_angle)))


def _mean(value: FloatArray, noise: FloatArray, moved: FloatArray) -> tuple[float, float]:
    """Return a robust mean of frames and its u; their variances are those of noise and of their scatter, `moved`."""
    middle = float(median(value))
    scatter = (1.4826 * float(median(np.abs(value - middle)))) ** 2
    variance = noise + scatter * moved
    weight = 1.0 / variance
    for _ in range(3):
        far = np.abs(value - middle) / np.sqrt(variance)
        weight = SETTINGS.huber / np.maximum(far, SETTINGS.huber) / variance
        middle = float(weight @ value / weight.sum())
    # half of the frames are independent: they overlap. Slow disturbances show in the means of groups
    u = float(np.sqrt(2.0 / weight.sum()))
    parts = np.array_split(np.arange(value.size), min(SETTINGS.groups, value.size // 3))
    if len(parts) > 2:
        share = np.array([weight[part].sum() for part in parts]) / weight.sum()
        mean = np.array([weight[part] @ value[part] / weight[part].sum() for part in parts])
        u = max(u, float(np.sqrt((share**2 * (mean - middle) ** 2).sum())))
    return middle, float(np.hypot(u, SETTINGS.min_u))
