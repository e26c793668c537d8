"""Several motions in one record, each from its rest: a drop, the hand that carries the sphere back, the next drop."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

from radargui.conditioning.condition import condition
from radargui.conditioning.conditioned import Conditioned
from radargui.model.recording import Recording
from radargui.model.setup import Setup
from radargui.processing.checks.receivers import wired_wrongly
from radargui.processing.part import Part


def separate_motions(recording: Recording, conditioned: Conditioned, setup: Setup) -> Iterator[Part]:
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
            yield Part(setup, alone, *wired_wrongly(alone, setup), further=others)


def _times(conditioned: Conditioned) -> tuple[tuple[float, float], ...]:
    """Return when each motion begins and ends."""
    inner = [edge for pause in conditioned.pauses for edge in pause]
    edges = [conditioned.segment.first, *inner, conditioned.segment.last - 1]
    times = conditioned.time_s[edges].tolist()
    return tuple(zip(times[0::2], times[1::2], strict=True))
