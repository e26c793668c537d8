"""What a person fills in: the tables of a setup, and which wire of the radar goes to which channel."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from benchmarks.world.disturbance import Codes, Disturbance
from benchmarks.world.disturbed.strength import Case


@dataclass(frozen=True)
class Wiring(Disturbance):
    """Channels under wrong names: what the computer calls channel k is channel `order[k]`, times `sizes[k]`.

    Each keeps the time at which it was converted. `order` may be shorter or longer than the channels are many.
    """

    order: tuple[int, ...]
    sizes: tuple[float, ...]

    def codes(self, codes: Codes) -> Codes:
        """Return the codes (len(order), n)."""
        named = np.round(codes[list(self.order)] * np.array(self.sizes)[:, None])
        return np.clip(named, -32768, 32767).astype(np.int16)


@dataclass
class Sheet:
    """A setup on its way to be stated wrongly; whoever makes a mistake writes into it.

    Attributes
    ----------
    case
        The drop, the strength of the mistake and what to draw with.
    tables
        The setup's tables, as a setup file has them.
    wiring
        None where each wire is where its name says.
    skew_in_file
        Whether the samples bring the skew, or only the setup has it.
    """

    case: Case
    tables: dict[str, Any]
    wiring: Wiring | None = None
    skew_in_file: bool = True
    chosen: list[int] = field(init=False)

    def __post_init__(self) -> None:
        """Choose the receivers that a mistake is made with."""
        self.chosen = [int(k) for k in self.case.rng.permutation(self.case.n_receivers)]

    @property
    def receivers(self) -> list[dict[str, Any]]:
        """All of them."""
        return self.tables["receiver"]  # type: ignore[no-any-return]

    @property
    def one(self) -> dict[str, Any]:
        """The receiver that a mistake about one is made with."""
        return self.receivers[self.chosen[0]]

    def off(self, smallest: float, largest: float) -> float:
        """Return an error of the strength, its sign drawn."""
        return float(self.case.rng.choice([-1.0, 1.0])) * self.case.between(smallest, largest)

    def rewire(self, order: list[int], sizes: list[float] | None = None) -> None:
        """State the channels in this order, each times its size."""
        self.wiring = Wiring(tuple(order), tuple(sizes or [1.0] * len(order)))
