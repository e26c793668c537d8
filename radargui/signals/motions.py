"""The motions of a recording: all of them together, and each of several by itself."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import chain, pairwise

from radargui.model.recording import Recording
from radargui.model.setup import Setup
from radargui.signals.condition import condition
from radargui.signals.conditioned import Conditioned
from radargui.signals.fall_signs import wired_wrongly
from radargui.signals.stretch import NoMotion


@dataclass(frozen=True, slots=True)
class Motions:
    """The motions of a recording.

    Attributes
    ----------
    together
        All of them.
    apart
        Each of several by itself, in order; nothing where there is one motion.
    """

    together: Conditioned
    apart: Iterator[Conditioned]


def motions_of(recording: Recording, setup: Setup) -> Motions | NoMotion:
    """Return the motions of a recording, with what their fall says of wires and clock.

    Parameters
    ----------
    recording, setup
        As `condition` takes them.
    """
    conditioned = condition(recording, setup)
    if isinstance(conditioned, NoMotion):
        return conditioned
    motions = chain([conditioned], separate_motions(recording, conditioned, setup))
    judged = (_judged(one, setup) for one in motions)
    return Motions(next(judged), judged)


def _judged(conditioned: Conditioned, setup: Setup) -> Conditioned:
    faults, clock = wired_wrongly(conditioned, setup)
    return replace(conditioned, faults=faults, clock=clock)


def separate_motions(recording: Recording, conditioned: Conditioned, setup: Setup) -> Iterator[Conditioned]:
    """Yield each of several motions by itself, in order, with the rest before it; nothing where there is one motion.

    A rest between two motions is cut in its middle. Each part is conditioned anew: what comes after a drop has no share
    in its noise, hum and onset.

    Parameters
    ----------
    recording, setup
        As `condition` takes them.
    conditioned
        All motions together.
    """
    times = _times(conditioned)
    begin, size = int(conditioned.samples.start), conditioned.size
    cuts = [begin + size * ((first + last) // 2) for first, last in conditioned.pauses]
    edges = pairwise([begin, *cuts, int(conditioned.samples.stop)])
    for number, (first, last) in enumerate(edges if cuts else ()):
        alone = condition(recording, setup, slice(first, last))
        if isinstance(alone, Conditioned):
            others = times[:number] + times[number + 1 :]
            yield replace(alone, further=others)


def _times(conditioned: Conditioned) -> tuple[tuple[float, float], ...]:
    """Return when each motion begins and ends."""
    inner = [edge for pause in conditioned.pauses for edge in pause]
    edges = [conditioned.segment.first, *inner, conditioned.segment.last - 1]
    times = conditioned.time_s[edges].tolist()
    return tuple(zip(times[0::2], times[1::2], strict=True))
