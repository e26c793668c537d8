"""Give each part of the simulation an independent stream of random numbers."""

from enum import IntEnum

import numpy as np


class Draw(IntEnum):
    """Parts that draw random numbers; switching one off leaves the others as they are."""

    HARDWARE = 1
    BIAS = 2
    AMPLITUDE = 3
    DRIFT = 4
    REFLECTION = 5
    MAINS = 6
    NOISE = 7
    MAINS_PHASE = 8
    FLICKER = 9
    FLICKER_ANCHORS = 10
    WALL = 11
    KICK = 12
    RESTITUTION = 13


def generator(seed: int, purpose: Draw, *key: int) -> np.random.Generator:
    """Return the generator of a part; `key` tells run, receiver or chunk."""
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(int(purpose), *key)))
