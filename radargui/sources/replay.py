"""Replay: a recording behind the contract of a source."""

from __future__ import annotations

from dataclasses import replace

from radargui.model.block import Block, Gap
from radargui.model.digitisation import Digitisation
from radargui.model.errors import SourceError
from radargui.model.recording import Recording
from radargui.model.truth import Truth
from radargui.sources.clock import SYSTEM_CLOCK, Clock
from radargui.sources.pacing import Pacer

_BLOCK_S = 0.02


class ReplaySource:
    """The samples of a recording, block by block, its gaps as they were.

    Blocks never span a gap; a gap after the last sample is not told, since no block follows it.

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
        self._recording = recording
        rate_hz = recording.digitisation.sample_rate_hz
        self._block = max(round(block_s * rate_hz), 1)
        self._gaps = _joined(recording.gaps)
        self._pacer = Pacer(clock, rate_hz, realtime=realtime)
        self._opened = False
        self._started = False
        self._read = 0
        self._lost = 0
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
            The source is not open.
        """
        if not self._opened:
            raise SourceError("The replay is not open", remedy="Open it before it is started.")
        self._read = self._lost = self._n_gaps = 0
        self._started = True
        self._pacer.start()

    def read(self) -> Block | None:
        """Return the next block, or None at the end of the recording or after `stop`.

        Raises
        ------
        SourceError
            The source was never started.
        """
        if not self._started:
            raise SourceError("The replay was not started", remedy="Start it before it is read.")
        gap = self._gap_here()
        lost = self._lost + (gap.count if gap else 0)
        upcoming = self._gaps[self._n_gaps + (gap is not None) :]
        end = min(self._read + self._block, self._recording.n_samples)
        if upcoming:
            end = min(end, upcoming[0].first_index - lost)
        if end <= self._read or not self._pacer.wait_for(end + lost):
            return None
        block = Block(self._recording.raw[:, self._read : end].copy(), self._read + lost, gap)
        self._lost, self._read = lost, end
        self._n_gaps += gap is not None
        return block

    def stop(self) -> None:
        """End the replay; a waiting `read` returns None at once."""
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
        return max(min(taken - self._lost, self._recording.n_samples) - self._read, 0)

    def truth(self, first_index: int, count: int) -> Truth | None:
        """Return None: a recording's truth stays in its file."""
        del first_index, count
        return None

    def _gap_here(self) -> Gap | None:
        upcoming = self._gaps[self._n_gaps : self._n_gaps + 1]
        return upcoming[0] if upcoming and upcoming[0].first_index <= self._read + self._lost else None


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
