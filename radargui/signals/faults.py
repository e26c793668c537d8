"""Find samples and channels that show no echo: clipped, with an open contact, or dead."""

from dataclasses import dataclass

import numpy as np

from radargui.model.arrays import BoolArray, FloatArray, RawArray, runs_of
from radargui.model.finding import Finding, refuse
from radargui.model.recording import iq_names
from radargui.signals.doppler import Doppler
from radargui.signals.receiver_check import SETTINGS as PAIR, check_receiver, is_worse_pair, same_channels
from radargui.signals.rows import pairs_of

CLIPPED_SHARE = 0.03
"""Of the motion at one end of the range: a full wave of a 12 bit converter has 1 % of its samples at its two crests."""
PILED, MIN_PILED = 5, 20
"""Samples at an end over those at the value beside it, and in number, that no crest has."""


@dataclass(frozen=True, slots=True)
class OpenSettings:
    """When a channel counts as open. Chosen by hand on contacts and cables that come off (decision 46).

    Attributes
    ----------
    block_s, min_blocks
        Deviations are taken over blocks of this length; a channel is open if at least so many blocks in turn are still.
        Shorter openings are found by the estimates.
    still, still_sigmas
        Largest deviation of a channel that stands still: in units of its amplitude, and of its noise.
    round
        Least deviation of the other channel of the receiver, in units of its amplitude: over 140 degrees around its
        zero a sine has 0.6, and the cosine 0.2 at the same time.
    """

    block_s: float = 0.0125
    min_blocks: int = 2
    still: float = 0.07
    still_sigmas: float = 1.5
    round: float = 0.55


OPEN = OpenSettings()


def open_channels(volts: FloatArray, noise_v: FloatArray, sample_rate_hz: float, moving: slice) -> BoolArray:
    """Return where channels are open, shape (2 n_receivers, n_samples); one that stays still is so to the end.

    Parameters
    ----------
    volts, noise_v
        I1, Q1, I2, ... and their white noise, shapes (2 n_receivers, n_samples), (2 n_receivers,).
    sample_rate_hz
        Rate of the samples.
    moving
        The motion, whose deviations are the amplitudes.
    """
    out = np.zeros(volts.shape, dtype=np.bool_)
    size = max(1, round(OPEN.block_s * sample_rate_hz))
    count = volts.shape[1] // size
    if count < OPEN.min_blocks:
        return out
    blocks = volts[:, : count * size].reshape(volts.shape[0], count, size)
    mean, square = blocks.mean(axis=2), np.einsum("cbs,cbs->cb", blocks, blocks) / size
    spread = np.sqrt(np.maximum(square - mean**2, 0.0))
    inside = slice(moving.start // size, max(moving.stop // size, moving.start // size + 1))
    # a sine has the amplitude sqrt(2) of its deviation
    amplitude = np.sqrt(2.0 * np.maximum(square[:, inside].mean(axis=1) - mean[:, inside].mean(axis=1) ** 2, 0.0))
    still = spread < np.maximum(OPEN.still * amplitude, OPEN.still_sigmas * noise_v)[:, None]
    other = np.arange(volts.shape[0]) ^ 1
    # and is no noise
    goes_round = spread > np.maximum(OPEN.round * amplitude, 2.0 * OPEN.still_sigmas * noise_v)[:, None]
    is_open = still & goes_round[other]
    for row, own, own_still in zip(out, is_open, still, strict=True):
        for first, last in runs_of(own).tolist():
            if last - first < OPEN.min_blocks:
                continue
            # what follows is no echo either while the channel stands
            end = last + int(np.argmin(np.append(own_still[last:], False)))
            # it opened within the block before, and closes within the one after
            row[max(first - 1, 0) * size : volts.shape[1] if end == count else (end + 1) * size] = True
    return out


def plateaus(volts: RawArray, moving: slice) -> BoolArray:
    """Return where a channel lies at its highest or lowest value, if it does so for longer than a wave's crest.

    It does if it lies there for more than a share of the motion, or many times as often as at the neighbouring value:
    the two last codes of an unclipped sine occur in the ratio 2.4 to 1.
    """
    out = np.zeros(volts.shape, dtype=np.bool_)
    for row, channel in zip(out, volts, strict=True):
        inside = channel[moving]
        for end, inner in ((inside.max(), -np.inf), (inside.min(), np.inf)):
            at_end = inside == end
            count = int(np.count_nonzero(at_end))
            if count == inside.size or count <= min(CLIPPED_SHARE * inside.size, MIN_PILED):
                continue
            beside = inside[~at_end].max() if inner < 0 else inside[~at_end].min()
            if count > CLIPPED_SHARE * inside.size or count > max(PILED * int((inside == beside).sum()), MIN_PILED):
                row |= channel == end
    return out


def faults_of(
    volts: FloatArray,
    noise_v: FloatArray,
    usable: BoolArray,
    doppler: tuple[Doppler, ...],
    moving: slice,
    phase_sign: int,
) -> tuple[Finding | None, ...]:
    """Return why a receiver is none, one a receiver; None where nothing speaks against it."""
    faults = [
        check_receiver(own.between(moving.start, moving.stop), volts[pair, moving], noise_v[pair], usable[pair, moving])
        for own, pair in zip(doppler, pairs_of(volts), strict=True)
    ]
    names, own = iq_names(len(faults)), tuple(faults)
    for a, b in same_channels(volts[:, moving], noise_v, volts[:, : moving.start], phase_sign):
        for one, other in ((a, b), (b, a)):
            innocent = own[other // 2] or is_worse_pair(doppler[other // 2], doppler[one // 2])
            if own[one // 2] or not innocent:
                faults[one // 2] = refuse("cable_on_both", channel=names[one], other=names[other])
    return tuple(faults)


def with_open(faults: tuple[Finding | None, ...], opened: BoolArray) -> tuple[Finding | None, ...]:
    """Return the faults, those of receivers that lack too much of a motion with which channel does."""
    out, names = list(faults), iq_names(len(faults))
    for channel, share in enumerate(opened.mean(axis=1).tolist()):
        # what is known to be dead need not be open
        if share > PAIR.max_clipped and not faults[channel // 2]:
            out[channel // 2] = refuse("channel_open", channel=names[channel], share=share)
    return tuple(out)
