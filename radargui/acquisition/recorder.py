"""The recorder: armed, recording, done; writes the blocks of one run, those before the trigger included."""

from __future__ import annotations

import logging
from collections.abc import Callable
from datetime import datetime, timedelta
from pathlib import Path
from typing import Protocol

from radargui.acquisition.disk import MINIMUM_FREE_BYTES, free_bytes, low_disk_error
from radargui.acquisition.history import History, cut
from radargui.acquisition.recorded_truth import TruthOf, recorded_truth
from radargui.acquisition.run_plan import FixedPlan, MotionPlan, RunPlan
from radargui.acquisition.state import Ending, RecorderState
from radargui.model.block import Block, Gap
from radargui.model.daq import RecordingLimits
from radargui.model.digitisation import Digitisation
from radargui.model.errors import RadarGuiError
from radargui.model.truth import Truth

_logger = logging.getLogger(__name__)
_DISK_CHECK_S = 0.5


class RunFile(Protocol):
    """What the recorder needs of a run writer."""

    @property
    def path(self) -> Path:
        """The file."""

    def write(self, block: Block) -> None:
        """Append a block and the gap before it; indices count from the first sample of the run."""

    def write_truth(self, truth: Truth) -> None:
        """Store what really happened."""

    def close(self, *, complete: bool = True) -> None:
        """Finish the file; idempotent. Not complete: the recording ended by a failure."""


class OpenRun(Protocol):
    """Makes the file of a run; `Session.new_run` is one."""

    def __call__(self, digitisation: Digitisation, *, started_at: str, trigger_index: int | None) -> RunFile:
        """Return the writer of a new run whose first sample was taken at `started_at`."""


class Recorder:
    """Records one run; has no thread of its own, whoever calls `push` pays for the disk.

    Parameters
    ----------
    open_run
        Makes the run's file when the run starts.
    limits
        Pre-trigger length, quiet time, longest run, longest wait.
    folder
        Where the file will be, to watch the disk; None: not watched.
    seconds
        Length of a run that starts at once; None: wait for motion.
    minimum_free_bytes
        Recording stops when the disk has less.
    on_change
        Called at each change of state, in the thread that caused it.

    Attributes
    ----------
    first_index
        Absolute index of the run's first sample.
    count, lost
        Samples of each channel written, and lost between them.
    trigger_index
        Of the trigger, counted from the run's first sample; None without trigger.
    path
        The file; None before the run has started.
    disk_free_bytes
        Looked up about twice a second; None where it is not watched.
    ending
        Why it is done; None before.
    """

    def __init__(
        self,
        open_run: OpenRun,
        limits: RecordingLimits,
        *,
        folder: Path | None = None,
        seconds: float | None = None,
        minimum_free_bytes: int = MINIMUM_FREE_BYTES,
        on_change: Callable[[RecorderState], None] | None = None,
    ) -> None:
        self._open_run = open_run
        self._limits = limits
        self._seconds = seconds
        self._minimum_free = minimum_free_bytes
        self._on_change = on_change
        self._gaps: list[Gap] = []
        self._state = RecorderState.IDLE
        self._file: RunFile | None = None
        self._unchecked = 0
        self._folder = folder
        self.disk_free_bytes: int | None = None
        self.first_index = 0
        self.count = 0
        self.lost = 0
        self.trigger_index: int | None = None
        self.path: Path | None = None
        self.ending: Ending | None = None

    @property
    def state(self) -> RecorderState:
        """Where the recorder is."""
        return self._state

    @property
    def is_done(self) -> bool:
        """Whether it takes no more blocks."""
        return self._state is RecorderState.DONE

    def prepare(self, digitisation: Digitisation, started: datetime, truth: TruthOf | None = None) -> None:
        """Arm: from now on blocks are taken.

        Parameters
        ----------
        digitisation
            As the source returned it.
        started
            Time of sample 0, with its offset from UTC.
        truth
            `Source.truth`; None: no truth is written.

        Raises
        ------
        FileError
            The disk is almost full.
        """
        self._digitisation = digitisation
        self._started = started
        self._truth = truth
        self._plan: RunPlan = (
            MotionPlan(digitisation, self._limits) if self._seconds is None else FixedPlan(digitisation, self._seconds)
        )
        self._history = History(self._plan.history)
        self._check_disk()
        self._enter(RecorderState.ARMED)

    def push(self, block: Block) -> None:
        """Take the next block.

        Raises
        ------
        RadarGuiError
            The file cannot be made or written, or the disk is almost full; call `fail` then.
        """
        if self.is_done:
            return
        if block.count:
            self._plan.push(block)
        if self._file is None:
            self._wait(block)
        else:
            self._write(block)
        self._unchecked += block.count
        if self._unchecked >= _DISK_CHECK_S * self._digitisation.sample_rate_hz and not self.is_done:
            self._unchecked = 0
            self._check_disk()

    def finish(self, ending: Ending) -> None:
        """End the run here: the source gave its last sample, or somebody wants to stop; idempotent."""
        if self.is_done:
            return
        if self._file is None and ending is Ending.END_OF_DATA:
            ending = Ending.NO_MOTION
        self._complete(ending)

    def fail(self) -> None:
        """Close the file after a failure of `push`, keeping what was written; never raises; idempotent."""
        if self.is_done:
            return
        try:
            if self._file is not None:
                self._file.close(complete=False)
        except (RadarGuiError, OSError):
            _logger.exception("The run file could not be closed after a failure")
        self._end(Ending.FAILED)

    def _wait(self, block: Block) -> None:
        self._history.push(block)
        if self._plan.first_index is not None:
            self._begin(self._plan.first_index)
        elif self._plan.ending is Ending.WAITED:
            self._end(Ending.WAITED)

    def _begin(self, first_index: int) -> None:
        blocks = self._history.take_from(first_index)
        self.first_index = blocks[0].first_index
        trigger = self._plan.trigger_index
        self.trigger_index = None if trigger is None else max(0, trigger - self.first_index)
        seconds = self.first_index / self._digitisation.sample_rate_hz
        started_at = (self._started + timedelta(seconds=seconds)).isoformat(timespec="microseconds")
        self._file = self._open_run(self._digitisation, started_at=started_at, trigger_index=self.trigger_index)
        self.path = self._file.path
        self._enter(RecorderState.RECORDING)
        for number, block in enumerate(blocks):
            self._write(block if number else Block(block.samples, block.first_index))
            if self.is_done:
                return

    def _write(self, block: Block) -> None:
        last = self._plan.last_index
        part = block if last is None else cut(block, self.first_index, last)
        if (part.count or part.gap) and self._file is not None:
            gap = part.gap and Gap(part.gap.first_index - self.first_index, part.gap.count, part.gap.reason)
            self._file.write(Block(part.samples, part.first_index - self.first_index, gap))
            self.count += part.count
            if gap is not None:
                self._gaps.append(gap)
                self.lost += gap.count
        if last is not None and block.end_index >= last:
            self._complete(self._plan.ending or Ending.MAXIMUM)

    def _complete(self, ending: Ending) -> None:
        file = self._file
        if file is not None:
            try:
                truth = recorded_truth(self._truth, self.first_index, self.count, self._gaps)
                if truth is not None:
                    file.write_truth(truth)
            finally:
                file.close(complete=ending is not Ending.FAILED)
        self._end(ending)

    def _end(self, ending: Ending) -> None:
        self.ending = ending
        self._enter(RecorderState.DONE)

    def _enter(self, state: RecorderState) -> None:
        self._state = state
        if self._on_change is not None:
            self._on_change(state)

    def _check_disk(self) -> None:
        if self._folder is None:
            return
        free = self.disk_free_bytes = free_bytes(self._folder)
        if free is not None and free < self._minimum_free:
            raise low_disk_error(self._folder, free, self._minimum_free)
