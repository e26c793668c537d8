"""The kinds of scenes that populations are drawn of, and one scene of each by seed and number."""

from __future__ import annotations

import zlib
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from benchmarks.world import other_kinds, population
from benchmarks.world.population import PopulationRecord, PopulationScene

__all__ = ["KINDS", "PopulationRecord", "PopulationScene", "draw", "draw_session"]

_MAKERS = {
    "modelled": population.modelled,
    "laboratory": population.laboratory,
    "mistaken": other_kinds.mistaken,
    "disturbed": other_kinds.disturbed,
    "motions": other_kinds.motions,
    "one-receiver": other_kinds.one_receiver,
    "garbage": other_kinds.garbage,
    "generic": other_kinds.generic,
}
KINDS: tuple[str, ...] = tuple(_MAKERS)
NOTHING: Mapping[str, Any] = MappingProxyType({})


def draw(kind: str, seed: int, number: int, held: Mapping[str, Any] = NOTHING) -> PopulationScene:
    """Return scene `number` of the population of a kind and a seed; the same again each time.

    Parameters
    ----------
    kind
        One of `KINDS`.
    seed, number
        Whole and not negative.
    held
        Values by name to hold instead of drawing; no other value changes by that.

    Raises
    ------
    ValueError
        There is no such kind, or nothing of this kind draws a value that is held.
    """
    return draw_session(kind, seed, number, 1, held)[0]


def draw_session(
    kind: str, seed: int, number: int, drops: int, held: Mapping[str, Any] = NOTHING
) -> tuple[PopulationScene, ...]:
    """Return drops with one set of antennas and one front end; the first is the scene that `draw` gives.

    The release is off by a part that all drops share, and each scatters about it.

    Raises
    ------
    ValueError
        As `draw`; or more than one drop of a kind that has no sessions.
    """
    if kind not in _MAKERS:
        raise ValueError(f"no such kind: {kind}; there are {', '.join(KINDS)}")
    return _MAKERS[kind]((seed, number, zlib.crc32(kind.encode())), f"{kind}-{number:04d}", drops, held)
