"""A sphere carried by hand: overlapping moves, holds between them, and a hand that trembles."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from benchmarks.world.profile import Array

MINIMUM_JERK_PEAK = 1.875
"""Greatest over mean speed of a minimum-jerk move."""
LIFT_S = 0.2
"""Within which the trembling begins and ends: the sphere lies on a stand before, and after where it is put down."""
_TREMBLING_HZ, _TONES = (6.0, 12.0), 5


@dataclass(frozen=True)
class Move:
    """One move of the hand: displacement by `by_m` (3,) from `begin_s` on within `lasts_s`."""

    begin_s: float
    lasts_s: float
    by_m: Array

    @property
    def end_s(self) -> float:
        """When it is over."""
        return self.begin_s + self.lasts_s


def carried(
    moves: Sequence[Move], trembling_m: float, rng: np.random.Generator, *, put_down_s: float
) -> Callable[[Array], Array]:
    """Return displacements (3, n): the sum of minimum-jerk moves, 10 s^3 - 15 s^4 + 6 s^5 each, and the trembling.

    Moves that overlap blend into a curve (Flash & Hogan 1985; Flash & Henis 1991).

    Parameters
    ----------
    trembling_m
        Root mean square of each coordinate.
    put_down_s
        From when on the sphere lies still again; infinity: never.
    """
    frequency_hz = rng.uniform(*_TREMBLING_HZ, (3, _TONES))
    phase = rng.uniform(0.0, 2.0 * np.pi, (3, _TONES))

    def offset_m(time_s: Array) -> Array:
        out = np.zeros((3, time_s.size))
        for one in moves:
            s = np.clip((time_s - one.begin_s) / one.lasts_s, 0.0, 1.0)
            out += np.outer(one.by_m, s**3 * (10.0 - 15.0 * s + 6.0 * s**2))
        lifted, laid = (np.clip(t / LIFT_S, 0.0, 1.0) for t in (time_s, put_down_s - time_s))
        held = np.square((3.0 - 2.0 * lifted) * lifted**2 * (3.0 - 2.0 * laid) * laid**2)
        tones = np.sin(2.0 * np.pi * frequency_hz[..., None] * time_s + phase[..., None]).sum(axis=1)
        return out + trembling_m * np.sqrt(2.0 / _TONES) * held * tones

    return offset_m
