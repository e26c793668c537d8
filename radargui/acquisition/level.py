"""The level of each channel, now and over one run: lowest and highest voltage, clipping, what is no number."""

from dataclasses import dataclass

import numpy as np

from radargui.model.arrays import FloatArray, IntArray, RawArray
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
    # a negative slope of the scaling turns lowest and highest round
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


class RunTally:
    """Counts of each channel since it was made.

    Parameters
    ----------
    digitisation
        Names and scale of the channels.
    """

    def __init__(self, digitisation: Digitisation) -> None:
        n = digitisation.n_channels
        self._digitisation = digitisation
        self._lowest: FloatArray = np.full(n, np.inf)
        self._highest: FloatArray = np.full(n, -np.inf)
        self._at_rail: IntArray = np.zeros(n, dtype=np.intp)
        self._unknown: IntArray = np.zeros(n, dtype=np.intp)

    def push(self, samples: RawArray) -> None:
        """Count samples, shape (n_channels, n)."""
        if samples.shape[1] == 0:
            return
        if samples.dtype == np.int16:
            lowest, highest = samples.min(axis=1), samples.max(axis=1)
            # only channels that reach the rail are counted sample by sample
            for channel in np.flatnonzero((lowest <= LOWEST_CODE) | (highest >= HIGHEST_CODE)):
                row = samples[channel]
                self._at_rail[channel] += int(((row <= LOWEST_CODE) | (row >= HIGHEST_CODE)).sum())
        else:
            lowest, highest = np.fmin.reduce(samples, axis=1), np.fmax.reduce(samples, axis=1)
            self._unknown += (~np.isfinite(samples)).sum(axis=1)
        self._lowest = np.fmin(self._lowest, lowest)
        self._highest = np.fmax(self._highest, highest)

    def channels(self) -> list[dict[str, object]]:
        """Return one plain table a channel: name, lowest_v, highest_v, at_rail, not_a_number."""
        ends = np.stack([self._lowest, self._highest], axis=1)
        known = np.asarray(np.isfinite(ends).all(axis=1))
        volts = np.sort(self._digitisation.volts(np.where(known[:, None], ends, 0.0)), axis=1)
        return [
            {
                "name": name,
                "lowest_v": float(volts[channel, 0]) if known[channel] else None,
                "highest_v": float(volts[channel, 1]) if known[channel] else None,
                "at_rail": int(self._at_rail[channel]),
                "not_a_number": int(self._unknown[channel]),
            }
            for channel, name in enumerate(self._digitisation.channel_names)
        ]
