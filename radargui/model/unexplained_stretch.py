"""Intervals in which one receiver shows what no motion explains: a loose contact, a dip of its supply."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from radargui.model.finding import Finding, refuse


@dataclass(frozen=True, slots=True)
class UnexplainedStretch:
    """Where a receiver, numbered from 0, shows what no motion of the body does."""

    receiver: int
    begin_s: float
    end_s: float


def unexplained_of(stretches: Sequence[UnexplainedStretch]) -> dict[int, Finding]:
    """Return the finding of each receiver that has stretches; the receivers are numbered from 0, in order."""
    return {
        receiver: refuse(
            "dip_unexplained",
            spans=tuple(f"{begin:.3f} to {end:.3f}" for begin, end in _joined(stretches, receiver)),
        )
        for receiver in sorted({one.receiver for one in stretches})
    }


def _joined(stretches: Sequence[UnexplainedStretch], receiver: int) -> list[tuple[float, float]]:
    """Return from when to when the stretches of a receiver go; those that overlap are one."""
    out: list[tuple[float, float]] = []
    for begin, end in sorted((one.begin_s, one.end_s) for one in stretches if one.receiver == receiver):
        if out and begin <= out[-1][1]:
            out[-1] = out[-1][0], max(end, out[-1][1])
        else:
            out.append((begin, end))
    return out
