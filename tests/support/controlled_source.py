"""A source that gives what a test pushes into it, and a run file that remembers what it was given."""

from __future__ import annotations

import queue
import threading
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from radargui.model.arrays import RawArray
from radargui.model.errors import RadarGuiError, SourceError
from radargui.model.recording import Block, Digitisation, Gap, Truth, iq_names

LONGEST_S = 20.0
VOLTS_PER_CODE = 1.0 / 3276.8


def digitisation(n_receivers: int = 3, rate_hz: float = 10000.0, *, codes: bool = True) -> Digitisation:
    scaling = ((0.0, VOLTS_PER_CODE),) * (2 * n_receivers) if codes else None
    return Digitisation(iq_names(n_receivers), rate_hz, scaling)


def codes(
    count: int, n_channels: int = 6, seed: int = 1, *, moving: slice = slice(0, 0), hangs: bool = False
) -> RawArray:
    """Return noise of 20 codes rms, with a line at 200 Hz where it moves; rate 10 kHz.

    Where it does not move there is the echo of what hangs, or nothing, as of a device that passes no direct voltage.
    """
    samples = 20.0 * np.random.default_rng(seed).standard_normal((n_channels, count))
    turns = np.arange(count) * 200.0 / 10000.0
    if hangs:
        turns = np.clip(turns, *turns[[moving.start, max(moving.start, moving.stop - 1)]])
    shown = slice(None) if hangs else moving
    for channel in range(n_channels):
        samples[channel, shown] += 3000.0 * np.cos(2.0 * np.pi * turns[shown] - 0.5 * np.pi * (channel % 2))
    return samples.astype(np.int16)


class ControlledSource:
    """Gives blocks as a test pushes them; counts what is done to it."""

    is_waiting = False
    restarts = 0

    def __init__(self, as_opened: Digitisation | None = None, *, opening_error: RadarGuiError | None = None) -> None:
        self.digitisation = as_opened or digitisation()
        self.opening_error = opening_error
        self.calls: list[str] = []
        self.truths: list[tuple[int, int]] = []
        self.with_truth = False
        self.taken = threading.Event()
        self.running = threading.Event()
        self.next_index = 0
        self._items: queue.SimpleQueue[Block | Exception | None] = queue.SimpleQueue()
        self._stopped = threading.Event()

    def push(self, samples: RawArray, *, lost: int = 0, reason: str = "buffer overflow") -> None:
        gap = Gap(self.next_index, lost, reason) if lost else None
        self.next_index += lost
        self.taken.clear()
        self._items.put(Block(samples, self.next_index, gap))
        self.next_index += samples.shape[1]

    def push_all(self, samples: RawArray, size: int = 200) -> None:
        for first in range(0, samples.shape[1], size):
            self.push(samples[:, first : first + size].copy())

    def push_raw(self, block: Block) -> None:
        self._items.put(block)

    def end(self) -> None:
        self._items.put(None)

    def fail(self, error: Exception | None = None) -> None:
        self._items.put(error or SourceError("The device was removed"))

    def wait_until_taken(self) -> None:
        """Wait until the reader has handed on all that was pushed."""
        assert self.taken.wait(LONGEST_S)

    def open(self) -> Digitisation:
        self.calls.append("open")
        if self.opening_error is not None:
            raise self.opening_error
        return self.digitisation

    def start(self) -> None:
        self.calls.append("start")
        self.running.set()

    def read(self) -> Block | None:
        if self._stopped.is_set():
            return None
        if self._items.empty():
            self.taken.set()
        item = self._items.get(timeout=LONGEST_S)
        if isinstance(item, Exception):
            raise item
        return item

    def stop(self) -> None:
        self.calls.append("stop")
        self._stopped.set()
        self._items.put(None)

    def close(self) -> None:
        self.calls.append("close")

    def backlog(self) -> int:
        return 7

    def truth(self, first_index: int, count: int) -> Truth | None:
        if not self.with_truth:
            return None
        self.truths.append((first_index, count))
        ramp = np.arange(first_index, first_index + count, dtype=np.float64)
        return Truth(np.stack([ramp] * 3), np.stack([ramp] * 3), np.array([0.5]))


class MemoryRun:
    """A run file in memory; may stall or fail at a write."""

    def __init__(self) -> None:
        self.path = Path("run-0001.h5")
        self.blocks: list[Block] = []
        self.truth: Truth | None = None
        self.complete: bool | None = None
        self.started_at = ""
        self.trigger_index: int | None = None
        self.wrote = threading.Event()
        self.go = threading.Event()
        self.go.set()
        self.fail_at: int | None = None
        self.error: Exception | None = None
        self.opened = 0
        self.health: dict[str, object] = {}

    def __call__(self, _: Digitisation, *, started_at: str, trigger_index: int | None) -> MemoryRun:
        self.opened += 1
        self.started_at = started_at
        self.trigger_index = trigger_index
        return self

    @property
    def raw(self) -> RawArray:
        return np.concatenate([block.samples for block in self.blocks], axis=1)

    @property
    def gaps(self) -> list[Gap]:
        return [block.gap for block in self.blocks if block.gap is not None]

    def write(self, block: Block) -> None:
        self.wrote.set()
        assert self.go.wait(LONGEST_S)
        if self.error is not None and len(self.blocks) == self.fail_at:
            raise self.error
        self.blocks.append(block)

    def write_truth(self, truth: Truth) -> None:
        self.truth = truth

    def write_health(self, record: Mapping[str, object]) -> None:
        self.health = dict(record)

    def close(self, *, complete: bool = True) -> None:
        if self.complete is None:
            self.complete = complete
