"""A source whose wires are wrong: channels exchanged, inverted, dead, doubled."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from radargui.model.arrays import RawArray
from radargui.model.recording import Block, Digitisation, Truth
from radargui.sources.contract import Source


class Miswired:
    """Passes a source on with other wires.

    Parameters
    ----------
    inside
        The source as it should be.
    order
        Input k gets channel order[k] of the source.
    inverted, dead
        Inputs with the other sign, and inputs without signal.
    spoil
        Changes the samples after that.
    """

    def __init__(
        self,
        inside: Source,
        order: Sequence[int] | None = None,
        *,
        inverted: Sequence[int] = (),
        dead: Sequence[int] = (),
        spoil: Callable[[RawArray], RawArray] | None = None,
    ) -> None:
        self._inside = inside
        self._order = order
        self._inverted = list(inverted)
        self._dead = list(dead)
        self._spoil = spoil

    def wired(self, samples: RawArray) -> RawArray:
        out = samples[list(self._order)] if self._order is not None else samples.copy()
        out[self._inverted] = -np.maximum(out[self._inverted], -32767)
        out[self._dead] = 3
        return out if self._spoil is None else self._spoil(out)

    @property
    def is_waiting(self) -> bool:
        return self._inside.is_waiting

    @property
    def restarts(self) -> int:
        return self._inside.restarts

    def open(self) -> Digitisation:
        return self._inside.open()

    def start(self) -> None:
        self._inside.start()

    def read(self) -> Block | None:
        block = self._inside.read()
        return None if block is None else Block(self.wired(block.samples), block.first_index, block.gap)

    def stop(self) -> None:
        self._inside.stop()

    def close(self) -> None:
        self._inside.close()

    def backlog(self) -> int:
        return self._inside.backlog()

    def truth(self, first_index: int, count: int) -> Truth | None:
        return self._inside.truth(first_index, count)
