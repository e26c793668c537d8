"""Replay: a recording behind the contract of a source."""

from dataclasses import replace

from radargui.model.block import Block, Gap
from radargui.model.digitisation import Digitisation
from radargui.model.errors import SourceError
from radargui.model.recording import Recording
from radargui.sources.clock import SYSTEM_CLOCK, Clock
from radargui.sources.paced import PacedSource

_BLOCK_S = 0.02
"""As a device is read (`daq.read_interval_s`)."""


class ReplaySource(PacedSource):
    """The samples of a recording, block by block, its gaps as they were.

    Blocks never span a gap; a gap after the last sample is not reported, since no block follows it.

    Parameters
    ----------
    recording
        What is replayed.
    realtime
        Give out samples when their time has come; otherwise as fast as asked.
    clock
        Paces real time.
    block_s
        Length of a block.
    """

    def __init__(
        self,
        recording: Recording,
        *,
        realtime: bool = False,
        clock: Clock = SYSTEM_CLOCK,
        block_s: float = _BLOCK_S,
    ) -> None:
        rate_hz = recording.digitisation.sample_rate_hz
        super().__init__("The replay", clock, rate_hz, block_s, recording.n_samples, realtime=realtime)
        self._recording = recording
        self._gaps = _joined(recording.gaps)
        self._n_gaps = 0

    def open(self) -> Digitisation:
        """Return how the recording was digitised.

        Raises
        ------
        SourceError
            The recording is empty.
        """
        if self._recording.n_samples == 0:
            raise SourceError(f"{self._recording.name} holds no samples", remedy="Choose another file to replay.")
        self._opened = True
        digitisation = self._recording.digitisation
        return replace(digitisation, device=digitisation.device or f"replay of {self._recording.name}")

    def start(self) -> None:
        """Begin at the first sample.

        Raises
        ------
        SourceError
            The replay is not open.
        """
        super().start()
        self._n_gaps = 0

    def _read(self) -> Block | None:
        gap = self._gap_here()
        lost = self._lost + (gap.count if gap else 0)
        upcoming = self._gaps[self._n_gaps + (gap is not None) :]
        end = self._end_of_block()
        if upcoming:
            end = min(end, upcoming[0].first_index - lost)
        if end <= self._next or not self._wait_for(end + lost):
            return None
        block = Block(self._recording.raw[:, self._next : end].copy(), self._next + lost, gap)
        self._lost, self._next = lost, end
        self._n_gaps += gap is not None
        return block

    def _gap_here(self) -> Gap | None:
        upcoming = self._gaps[self._n_gaps : self._n_gaps + 1]
        return upcoming[0] if upcoming and upcoming[0].first_index <= self._next + self._lost else None


def _joined(gaps: tuple[Gap, ...]) -> tuple[Gap, ...]:
    """Return gaps in order, those without a sample between them as one."""
    joined: list[Gap] = []
    for gap in sorted((gap for gap in gaps if gap.count > 0), key=lambda gap: gap.first_index):
        last = joined[-1] if joined else None
        if last is not None and gap.first_index <= last.first_index + last.count:
            joined[-1] = replace(last, count=last.count + gap.count)
        else:
            joined.append(gap)
    return tuple(joined)
