"""Find the longest motion in a recording that is too long to be held in memory, piece by piece."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.signals.averager import block_means, held
from radargui.signals.noise import white_noise_v
from radargui.signals.segment import MIN_SAMPLES, activity, block_size, motions_apart, moving_blocks

PAUSE_S = 2.0
"""Two motions with at least so much rest between them are two."""
REST_S = 2.0
"""Rest before the motion that is taken along at the least. Chosen by hand; `REST_SHARE` may ask for more."""
AFTER_S = 0.5
"""Taken along after the motion, so that its end is in it. Chosen by hand."""
PIECE_S = 5.0
"""What is looked at together; its noise is its own."""
REST_SHARE = 0.2
"""Rest before the motion that is taken along, as a share of the motion: what is quiet is told from it."""

MAX_REST = 0.25
"""Of what may be returned, at most so much is rest."""


@dataclass(frozen=True, slots=True)
class LongMotion:
    """Stored samples first:last around one motion, with rest before it where there is some.

    Attributes
    ----------
    first, last
        Samples of the recording.
    n_motions
        How many there are in the whole; one of them is this one.
    cut
        Whether the motion goes on after `last`.
    """

    first: int
    last: int
    n_motions: int
    cut: bool


def find_long_motion(pieces: Iterable[FloatArray], sample_rate_hz: float, max_samples: int) -> LongMotion | None:
    """Find the longest motion with rest before it, else the longest.

    Motion is found as in `find_motion`, with the noise of each piece and the quiet level of the whole. A hum that lasts
    throughout is part of the quiet level.

    Parameters
    ----------
    pieces
        Consecutive voltages, shape (n_channels, n), any lengths; NaN are held.
    sample_rate_hz
        Rate of each channel.
    max_samples
        Greatest number of samples that is returned.

    Returns
    -------
    LongMotion or None
        None where nothing moves.
    """
    level, count = _levels(pieces, sample_rate_hz)
    if not level.size:
        return None
    size = block_size(sample_rate_hz)
    rate_hz = sample_rate_hz / size
    motions = motions_apart(moving_blocks(level, rate_hz), rate_hz, PAUSE_S)
    if not motions:
        return None
    # of a motion that the record begins with nobody knows where the sphere was
    begin, end = max(motions, key=lambda motion: (motion[0] > 0, motion[1] - motion[0]))
    earlier = max((last for _, last in motions if last <= begin), default=0)
    # hum and quiet level are taken from it, and more so of a long motion
    rest = round(max(REST_S * rate_hz, REST_SHARE * (end - begin)))
    # not back into the motion before
    rest = min(rest, begin - earlier, round(MAX_REST * max_samples / size))
    first = (begin - rest) * size
    wanted = min(end * size + round(AFTER_S * sample_rate_hz), count)
    last = min(wanted, first + max_samples)
    return LongMotion(first, last, len(motions), cut=last < end * size)


def _levels(pieces: Iterable[FloatArray], sample_rate_hz: float) -> tuple[FloatArray, int]:
    """Return the activity of each block of the whole, and the number of samples."""
    size = block_size(sample_rate_hz)
    levels, count = [np.zeros(0)], 0
    for volts in _regular(pieces, max(1, round(PIECE_S * sample_rate_hz / size)) * size):
        count += volts.shape[1]
        if volts.shape[1] >= MIN_SAMPLES:
            whole = held(volts)
            means = block_means(whole, size)
            noise_v = white_noise_v(whole) / np.sqrt(size)
            levels.append(activity(means, sample_rate_hz / size, noise_v))
    return np.concatenate(levels), count


def _regular(pieces: Iterable[FloatArray], length: int) -> Iterator[FloatArray]:
    """Yield the same voltages in pieces of one length, the last one shorter: the input's pieces do not matter."""
    left: list[FloatArray] = []
    held_back = 0
    for piece in pieces:
        left.append(piece)
        held_back += piece.shape[1]
        if held_back < length:
            continue
        volts = np.concatenate(left, axis=1) if len(left) > 1 else piece
        whole = held_back // length * length
        for first in range(0, whole, length):
            yield volts[:, first : first + length]
        left, held_back = [volts[:, whole:].copy()], held_back - whole
    if held_back:
        yield np.concatenate(left, axis=1)
