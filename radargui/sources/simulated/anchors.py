"""Anchors of random processes: their states at the edges of the chunks, quickly found at any chunk."""

from __future__ import annotations

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.sources.simulated.seeds import Stream, generator

_BLOCK = 256


class Anchors:
    """Ornstein-Uhlenbeck processes of variance 1, sampled once a chunk: x -> d x + sqrt(1 - d^2) w, d = exp(-loss).

    They are drawn in blocks of 256 chunks, always from the first: the same states whatever is asked for and when. A
    skip costs some microseconds a chunk skipped, going back begins again.

    Parameters
    ----------
    seed, run
        Draw the states.
    loss
        Logarithm of the decay over a chunk, shape (n_processes,).
    n_channels
        Independent processes of each kind.
    """

    def __init__(self, seed: int, run: int, loss: FloatArray, n_channels: int) -> None:
        self._seed, self._run = seed, run
        self._decay = np.exp(-loss)[:, None]
        self._kick = np.sqrt(-np.expm1(-2.0 * loss))[:, None]
        self._shape = (loss.size, n_channels)
        self._block = 0
        self._states = self._begun()

    def around(self, chunk: int) -> tuple[FloatArray, FloatArray]:
        """Return the states at the first sample of a chunk and of the next, shape (n_processes, n_channels) each."""
        block, offset = divmod(chunk, _BLOCK)
        if block < self._block:
            self._block, self._states = 0, self._begun()
        while self._block < block:
            self._block += 1
            self._states = self._continued(self._states[-1], self._block)
        return self._states[offset], self._states[offset + 1]

    def _begun(self) -> FloatArray:
        start = generator(self._seed, Stream.FLICKER_ANCHORS, self._run).standard_normal(self._shape)
        return self._continued(start, 0)

    def _continued(self, state: FloatArray, block: int) -> FloatArray:
        """Return the states of a block and the first of the next, shape (257, n_processes, n_channels)."""
        kicks = generator(self._seed, Stream.FLICKER_ANCHORS, self._run, block).standard_normal((_BLOCK, *self._shape))
        states = np.empty((_BLOCK + 1, *self._shape))
        states[0] = state
        for step, kick in enumerate(kicks):
            states[step + 1] = self._decay * states[step] + self._kick * kick
        return states
