"""The simulated source: the simulated radar behind the contract of a source."""

from radargui.model.block import Block, Gap
from radargui.model.digitisation import Digitisation
from radargui.model.setup import Setup
from radargui.model.truth import Truth
from radargui.sources.clock import SYSTEM_CLOCK, Clock
from radargui.sources.paced import PacedSource
from radargui.sources.simulated.model import SimulatedRadar


class SimulatedSource(PacedSource):
    """One simulated run, or one that repeats for ever.

    In real time it behaves like a device: a reader that is more than `daq.buffer_s` late loses the oldest samples
    and is reported so by the gap of the next block.

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
        self._radar, daq = SimulatedRadar(setup, run=run, repeat=repeat), setup.daq
        super().__init__(
            "The simulated source", clock, daq.rate_hz, daq.read_interval_s, self._radar.n_samples, realtime=realtime
        )
        self._buffer = max(round(daq.buffer_s * daq.rate_hz), self._block)

    def open(self) -> Digitisation:
        """Return how samples are digitised."""
        self._opened = True
        return self._radar.digitisation

    def _read(self) -> Block | None:
        gap = self._overflow()
        end = self._end_of_block()
        if end <= self._next or not self._wait_for(end):
            return None
        block = Block(self._radar.samples(self._next, end - self._next), self._next, gap)
        self._next = end
        return block

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
