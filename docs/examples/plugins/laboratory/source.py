"""A source of one's own: a device whose driver gives the six voltages block by block."""

from __future__ import annotations

import threading

import numpy as np

from radargui.model.recording import Block, Digitisation, Truth, iq_names
from radargui.model.setup import Setup
from radargui.sources.contract import Clock


class SawtoothSource:
    """Stands for a device: each path grows by a wavelength a tenth of a second. See `radargui.sources.contract.Source`.

    Parameters
    ----------
    setup
        What is acquired: `setup.daq` has rate, range and the device's name.
    run
        Number of the run in its session.
    clock
        Paces the reading; `wait` returns at once when `stop` interrupts it.
    """

    is_waiting = False
    restarts = 0

    def __init__(self, setup: Setup, *, run: int, clock: Clock) -> None:
        self._setup, self._clock, self._ended = setup, clock, threading.Event()
        self._rate_hz, self._length = setup.daq.rate_hz, max(1, round(setup.daq.rate_hz * setup.daq.read_interval_s))
        self._next = 0

    def open(self) -> Digitisation:
        """Reserve the device; say how samples will be digitised. Here: volts, all channels at one time."""
        return Digitisation(iq_names(self._setup.n_receivers), self._rate_hz, channel_skew_s=0.0, device="sawtooth")

    def start(self) -> None:
        """Begin to sample."""
        self._begun_s = self._clock.now()

    def read(self) -> Block | None:
        """Wait for the next block; None for ever after `stop`. A device would return what its driver read."""
        first, last = self._next, self._next + self._length
        if self._clock.wait(self._begun_s + last / self._rate_hz - self._clock.now(), self._ended):
            return None
        self._next = last
        phase = 2.0 * np.pi * np.arange(first, last) / (0.1 * self._rate_hz)
        return Block(np.tile([np.cos(phase), np.sin(phase)], (self._setup.n_receivers, 1)), first)

    def stop(self) -> None:
        """End sampling, from any thread."""
        self._ended.set()

    def close(self) -> None:
        """Release the device."""

    def backlog(self) -> int:
        """Return how many samples wait in the driver."""
        return 0

    def truth(self, first_index: int, count: int) -> Truth | None:
        """Return nothing: only a simulation knows what really happened."""
        return None
