"""What each channel shows over the last moment, at rest or not: level, offset, noise, clipping."""

from dataclasses import dataclass

import numpy as np

from radargui.acquisition.ring import Ring
from radargui.acquisition.run_output import Level, levels
from radargui.conditioning.noise import LEAST_SAMPLES, white_noise_v
from radargui.model.recording import Digitisation

MOST_SAMPLES = 1 << 16
"""Of each channel: noise is known to 0.5 % then, and a board of 1 MS/s costs no more than one of 60 kS/s."""


@dataclass(frozen=True, slots=True)
class ChannelFacts:
    """One channel.

    Attributes
    ----------
    level
        As the health line has it.
    offset_v
        Mean.
    noise_v
        Standard deviation of the white noise, as every correction takes it; NaN where too few samples tell it.
    """

    level: Level
    offset_v: float
    noise_v: float


def channel_facts(ring: Ring, digitisation: Digitisation, count: int) -> tuple[ChannelFacts, ...]:
    """Return what each channel shows over the last `count` samples of a ring; none where there are no samples."""
    end = ring.latest
    blocks = ring.blocks(max(0, end - min(count, MOST_SAMPLES)), end)
    if not blocks:
        return ()
    samples = np.concatenate([block.samples for block in blocks], axis=1)
    known = np.isfinite(samples).all(axis=0)
    # sixth differences go over no gap
    longest = digitisation.volts(max(blocks, key=lambda block: block.count).samples)
    longest = longest[:, np.isfinite(longest).all(axis=0)]
    tells = longest.shape[1] >= LEAST_SAMPLES
    noise = white_noise_v(longest) if tells else np.full(digitisation.n_channels, np.nan)
    offset = digitisation.volts(samples[:, known]).mean(axis=1) if known.any() else np.full(noise.shape, np.nan)
    found = levels(samples, digitisation)
    return tuple(map(ChannelFacts, found, offset.tolist(), noise.tolist()))
