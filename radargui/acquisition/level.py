"""The level of each channel: peak voltage and whether it clips."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from radargui.model.arrays import RawArray
from radargui.model.digitisation import Digitisation

LOWEST_CODE, HIGHEST_CODE = -32768, 32767


@dataclass(frozen=True, slots=True)
class Level:
    """Level of one channel over recent samples.

    Attributes
    ----------
    name
        Channel.
    lowest_v, highest_v
        Extremes in volts.
    full_scale_v
        Largest voltage a code can stand for; None where samples are volts.
    clipped
        Whether a sample sat at the end of the range.
    """

    name: str
    lowest_v: float
    highest_v: float
    full_scale_v: float | None
    clipped: bool

    @property
    def peak_v(self) -> float:
        """Largest absolute voltage."""
        return max(abs(self.lowest_v), abs(self.highest_v))


def levels(samples: RawArray, digitisation: Digitisation) -> tuple[Level, ...]:
    """Return the level of each channel of raw samples, shape (n_channels, n); none where n is 0."""
    if samples.shape[1] == 0:
        return ()
    extremes = np.stack([np.fmin.reduce(samples, axis=1), np.fmax.reduce(samples, axis=1)], axis=1)
    volts = np.sort(digitisation.volts(extremes), axis=1)
    codes = samples.dtype == np.int16
    full_scale = digitisation.full_scale_v() if codes else None
    return tuple(
        Level(
            name=name,
            lowest_v=float(volts[channel, 0]),
            highest_v=float(volts[channel, 1]),
            full_scale_v=None if full_scale is None else float(np.abs(full_scale[channel]).max()),
            clipped=bool(codes and (extremes[channel, 0] <= LOWEST_CODE or extremes[channel, 1] >= HIGHEST_CODE)),
        )
        for channel, name in enumerate(digitisation.channel_names)
    )
