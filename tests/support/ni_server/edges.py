"""The edges that a task of the stand-in driver can wait for."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class DigitalEdge:
    """An edge at a terminal; comes when a test says so."""

    terminal: str


@dataclass(frozen=True)
class AnalogEdge:
    """A crossing of a level by a channel of the task; comes when the signal does it."""

    source: str
    level_v: float
    rising: bool


@dataclass
class Trigger:
    """What a task waits for.

    Attributes
    ----------
    edge
        What it is.
    pretrigger
        Samples kept from before the edge; 0: sampling begins there.
    at
        The edge came after so many samples; None: it has not come.
    """

    edge: DigitalEdge | AnalogEdge
    pretrigger: int = 0
    at: int | None = None
