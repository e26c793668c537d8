"""The simulated source: the simulated radar behind the contract of a source."""

from __future__ import annotations

from radargui.model.block import Block, Gap
from radargui.model.digitisation import Digitisation
from radargui.model.errors import SourceError
from radargui.model.setup import Setup
from radargui.model.truth import Truth
from radargui.sources.clock import SYSTEM_CLOCK, Clock
from radargui.sources.pacing import Pacer
from radargui.sources.simulated.model import SimulatedRadar


class SimulatedSource:
    """One simulated run, or one that repeats for ever.

    In real time it behaves like a device: a reader that is more than `daq.buffer_s` late loses the oldest samples
    and is told so by the gap of the next block.

    Parameters
    ----------
    setup
        `[simulation]` says what happens, `[daq]` how it is sampled.
    run
        Number of the run in its session: noise, drift and mains differ, hardware and surroundings stay.
    realtime
        Give out samples when their time has come; otherwise as fast as asked.
    clock
        Paces real time.
    repeat
        Carry the sphere back to the release and let it go again, for ever.

    Raises
    ------
    SetupError
        The simulated scene is impossible.
    """

    def __init__(
        self,
        setup: Setup,
        *,
        run: int = 0,
        realtime: bool = False,
        clock: Clock = SYSTEM_CLOCK,
        repeat: bool = False,
    ) -> None:
        self._radar = SimulatedRadar(setup, run=run, repeat=repeat)
        self._block = max(round(setup.daq.read_interval_s * setup.daq.rate_hz), 1)
        self._buffer = max(round(setup.daq.buffer_s * setup.daq.rate_hz), self._block)
        self._pacer = Pacer(clock, setup.daq.rate_hz, realtime=realtime)
        self._opened = False
        self._started = False
        self._next = 0

    def open(self) -> Digitisation:
        """Return how samples are digitised."""
        self._opened = True
        return self._radar.digitisation

    def start(self) -> None:
        """Begin the scene; index 0 is its first sample.

        Raises
        ------
        SourceError
            The source is not open.
        """
        if not self._opened:
            raise SourceError("The simulated source is not open", remedy="Open it before it is started.")
        self._next = 0
        self._started = True
        self._pacer.start()

    def read(self) -> Block | None:
        """Return the next block, or None at the end of the scene or after `stop`.

        Raises
        ------
        SourceError
            The source was never started.
        """
        if not self._started:
            raise SourceError("The simulated source was not started", remedy="Start it before it is read.")
        gap = self._overflow()
        end = self._next + self._block
        if self._radar.n_samples is not None:
            end = min(end, self._radar.n_samples)
        if end <= self._next or not self._pacer.wait_for(end):
            return None
        block = Block(self._radar.samples(self._next, end - self._next), self._next, gap)
        self._next = end
        return block

    def stop(self) -> None:
        """End sampling; a waiting `read` returns None at once."""
        self._pacer.stop()

    def close(self) -> None:
        """Release everything."""
        self.stop()
        self._opened = False

    def backlog(self) -> int:
        """Return how many samples per channel wait; 0 where not in real time."""
        taken = self._pacer.taken()
        if taken is None:
            return 0
        if self._radar.n_samples is not None:
            taken = min(taken, self._radar.n_samples)
        return max(taken - self._next, 0)

    def truth(self, first_index: int, count: int) -> Truth:
        """Return the exact motion during samples first_index : first_index + count.

        Impact times count from sample `first_index`.
        """
        return self._radar.truth(first_index, count)

    def _overflow(self) -> Gap | None:
        lost = self.backlog() - self._buffer
        if lost <= 0:
            return None
        gap = Gap(self._next, lost, "the buffer overflowed: samples were not read in time")
        self._next += lost
        return gap
