"""Channels that stand still while the other one of their receiver goes round: a contact is open, a cable came off.

Method 2, Open channels.
"""

from dataclasses import dataclass

import numpy as np

from radargui.model.arrays import BoolArray, FloatArray, runs_of


@dataclass(frozen=True, slots=True)
class OpenSettings:
    """When a channel counts as open. Chosen by hand on contacts and cables that come off (decision 46).

    Attributes
    ----------
    block_s, least_blocks
        Deviations are those of blocks of this length; so many in turn. What is open for less the joint estimate finds.
    still, still_sigmas
        Largest deviation of a channel that stands, in its amplitudes and in its noise.
    round
        Least deviation of the other one, in its amplitudes: through 140 degrees around its zero a sine has 0.6, and the
        cosine 0.2 at the same time.
    """

    block_s: float = 0.0125
    least_blocks: int = 2
    still: float = 0.07
    still_sigmas: float = 1.5
    round: float = 0.55


SETTINGS = OpenSettings()


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
    size = max(1, round(SETTINGS.block_s * sample_rate_hz))
    count = volts.shape[1] // size
    if count < SETTINGS.least_blocks:
        return out
    blocks = volts[:, : count * size].reshape(volts.shape[0], count, size)
    mean, square = blocks.mean(axis=2), np.einsum("cbs,cbs->cb", blocks, blocks) / size
    spread = np.sqrt(np.maximum(square - mean**2, 0.0))
    inside = slice(moving.start // size, max(moving.stop // size, moving.start // size + 1))
    # a sine has the amplitude sqrt(2) of its deviation
    amplitude = np.sqrt(2.0 * np.maximum(square[:, inside].mean(axis=1) - mean[:, inside].mean(axis=1) ** 2, 0.0))
    still = spread < np.maximum(SETTINGS.still * amplitude, SETTINGS.still_sigmas * noise_v)[:, None]
    other = np.arange(volts.shape[0]) ^ 1
    # and is no noise
    goes_round = spread > np.maximum(SETTINGS.round * amplitude, 2.0 * SETTINGS.still_sigmas * noise_v)[:, None]
    is_open = still & goes_round[other]
    for row, own, own_still in zip(out, is_open, still, strict=True):
        for first, last in runs_of(own).tolist():
            if last - first < SETTINGS.least_blocks:
                continue
            # what follows is no echo either while the channel stands
            end = last + int(np.argmin(np.append(own_still[last:], False)))
            # it opened within the block before, and closes within the one after
            row[max(first - 1, 0) * size : volts.shape[1] if end == count else (end + 1) * size] = True
    return out
