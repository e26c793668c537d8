"""Record runs with the samples before their trigger: armed, recording, armed again."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import KW_ONLY, dataclass
from datetime import datetime, timedelta
from pathlib import Path

from radargui.acquisition import run_output
from radargui.acquisition.run_output import FinishedRun, History, OpenRun, RunOutput, TruthOf
from radargui.acquisition.run_plan import Ending, FixedPlan, MotionPlan, RecorderState, RunPlan
from radargui.live.trigger import FallTest
from radargui.model.daq import RecordingLimits
from radargui.model.errors import FileError, FileLostError, RadarGuiError, worded
from radargui.model.recording import Block, Digitisation

_DISK_CHECK_S = 0.5
"""Between two looks at the disk: a source of 6 x 200 kS/s fills 1.2 MB meanwhile, of 200 MB that stay free."""
_SLICE_S = 0.01
"""Blocks are taken in slices: a run that ends within a block leaves its rest to the next run, and no short motion is
missed by the trigger of a plan, which tells its latest news only."""


@dataclass(eq=False)
class Recorder:
    """Records runs one after the other; has no thread of its own, whoever calls `push` pays for the disk.

    A run that the judge refuses is kept, but does not count: the recorder arms for another one. It arms as soon as it
    has been quiet for `quiet_s`, from the samples that it holds: nothing between two runs is lost.

    Parameters
    ----------
    open_run
        Makes a run's file when the run starts.
    limits
        Pre-trigger length, quiet time, longest run, longest wait.
    folder
        Where the files will be, to watch the disk; None: not watched.
    seconds
        Length of a run that starts at once; None: wait for motion.
    n_runs
        Runs wanted.
    make_judge
        Makes the judge of a run; None: every run is wanted.
    minimum_free_bytes
        Recording stops when the disk has less.
    on_change
        Called at each change of state, in the thread that caused it.
    on_run
        Called with each run whose file is closed, before the change of state.

    Attributes
    ----------
    output
        The present or last run; None before one has started.
    health_of_run
        Asked at the end of each run for how it went; the acquisition sets it.
    disk_free_bytes
        Looked up about twice a second; None where it is not watched.
    ending
        Why it is done; None before.
    lost_file
        Which run file was taken away while it was written, and where the recording goes on; empty where none was.
    state
        Where the recorder is.
    n_wanted
        Runs recorded so far that were wanted.
    minimum_free_bytes
        What stays free on the disk.
    armed_again_at
        Absolute index from which the recorder is armed again after a run; None before it is.
    hung_up_at
        The same after a run that was set aside: a hand has moved the tracer, as it does to hang it up again.
    """

    open_run: OpenRun
    limits: RecordingLimits
    _: KW_ONLY
    folder: Path | None = None
    seconds: float | None = None
    n_runs: int = 1
    make_judge: Callable[[Digitisation], FallTest] | None = None
    minimum_free_bytes: int = run_output.MINIMUM_FREE_BYTES
    on_change: Callable[[RecorderState], None] | None = None
    on_run: Callable[[FinishedRun], None] | None = None

    def __post_init__(self) -> None:
        self.state = RecorderState.IDLE
        self.output: RunOutput | None = None
        self._open: RunOutput | None = None
        self._judge: FallTest | None = None
        self._n_opened = 0
        self.n_wanted = 0
        self._unchecked = 0
        self.armed_again_at: int | None = None
        self.hung_up_at: int | None = None
        self._was_hand = False
        self.health_of_run: Callable[[RunOutput], Mapping[str, object]] = lambda _output: {}
        self.disk_free_bytes: int | None = None
        self.ending: Ending | None = None
        self.lost_file = self._objection = ""

    @property
    def is_done(self) -> bool:
        """Whether it takes no more blocks."""
        return self.state is RecorderState.DONE

    @property
    def count(self) -> int:
        """Samples of each channel written to the present or last run."""
        return self.output.count if self.output else 0

    @property
    def path(self) -> Path | None:
        """File of the present or last run; None before one has started."""
        return self.output.path if self.output else None

    @property
    def objection(self) -> str:
        """Why a fall may not start the run that it is armed for, or was to the end, in a few words; empty else."""
        return self._plan.objection if self.state is RecorderState.ARMED else self._objection

    def want_another(self) -> bool:
        """Record one run more than was asked for; False where it is too late. From any thread."""
        if self.is_done:
            return False
        self.n_runs += 1
        return True

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
            The disk is almost full, or nothing can be written to the folder.
        """
        self._digitisation = digitisation
        self._started = started
        self._truth = truth
        self._plan: RunPlan = (
            MotionPlan(digitisation, self.limits) if self.seconds is None else FixedPlan(digitisation, self.seconds)
        )
        self._slice = max(1, round(_SLICE_S * digitisation.sample_rate_hz))
        self._history = History(self._plan.history)
        if self.folder is not None:
            run_output.want_writable(self.folder)
        self._check_disk()
        self._enter(RecorderState.ARMED)

    def push(self, block: Block) -> None:
        """Take the next block.

        Raises
        ------
        RadarGuiError
            A file cannot be made or written, or the disk is almost full; call `fail` then.
        """
        for part in self._slices(block):
            if self.is_done:
                return
            self._push(part)
        # a look at the disk costs a call to the system: not for each block
        self._unchecked += block.count
        if self._unchecked >= _DISK_CHECK_S * self._digitisation.sample_rate_hz and not self.is_done:
            self._unchecked = 0
            self._watch_disk()

    def finish(self, ending: Ending) -> None:
        """End here: the source gave its last sample, or somebody wants to stop; idempotent."""
        if self.is_done:
            return
        if self._open is not None:
            self._complete(self._open, ending, is_last=True)
        else:
            self._end(Ending.NO_MOTION if ending is Ending.END_OF_DATA and self._n_opened == 0 else ending)

    def fail(self) -> None:
        """Close the file after a failure of `push`, keeping what was written; never raises; idempotent."""
        if self.is_done:
            return
        output, self._open = self._open, None
        if output is not None:
            output.abandon()
            self._report(output, Ending.FAILED, "", {}, is_last=True)
        self._end(Ending.FAILED)

    def _slices(self, block: Block) -> Iterator[Block]:
        if block.count <= self._slice:
            yield block
            return
        for first in range(0, block.count, self._slice):
            part = block.samples[:, first : first + self._slice]
            if first:
                yield Block(part, block.first_index + first)
            else:
                yield Block(part, block.first_index, block.gap, block.trigger_index)

    def _push(self, block: Block) -> None:
        self._history.push(block)
        if self.state is RecorderState.SETTLING:
            if block.count and self._plan.rest(block):
                self._arm(block.end_index)
            return
        if block.count:
            self._plan.push(block)
        if self._open is not None:
            self._write(self._open, block)
        elif self._plan.first_index is not None:
            self._begin(self._plan.first_index)
        elif self._plan.ending is Ending.WAITED:
            self._end(Ending.WAITED)

    def _begin(self, first_index: int, *, again: bool = False) -> None:
        """Open a run that begins at a sample; `again`: the present run, whose file was taken away."""
        blocks = self._history.since(first_index)
        # the history may hold less than asked for: a device just started has no past
        first_index = blocks[0].first_index
        if self._plan.last_index is not None and first_index >= self._plan.last_index:
            # the whole motion lies in samples that were lost: a run without any is none
            self._enter(RecorderState.SETTLING)
            return
        trigger = self._plan.trigger_index
        if trigger is not None:
            # in a file that goes on for one taken away the trigger may lie in the lost part
            trigger = None if again and trigger < first_index else max(0, trigger - first_index)
        seconds = first_index / self._digitisation.sample_rate_hz
        started_at = (self._started + timedelta(seconds=seconds)).isoformat(timespec="microseconds")
        file = self.open_run(self._digitisation, started_at=started_at, trigger_index=trigger)
        output = self.output = self._open = RunOutput(file, self._digitisation, first_index)
        self._n_opened += not again
        self._judge = None if self.make_judge is None else self.make_judge(self._digitisation)
        self._enter(RecorderState.RECORDING)
        for number, block in enumerate(blocks):
            if self._open is not output:
                return
            # what was lost before the first sample is not part of the run
            self._write(output, block if number else Block(block.samples, block.first_index))

    def _write(self, output: RunOutput, block: Block) -> None:
        last = self._plan.last_index
        try:
            output.write(block, last)
        except FileLostError as error:
            self._go_on(output, error)
            return
        if self._judge is not None:
            self._judge.push(block.samples)
        if last is not None and block.end_index >= last:
            self._complete(output, self._plan.ending or Ending.MAXIMUM, is_last=False)

    def _go_on(self, lost: RunOutput, error: FileLostError) -> None:
        """Record the rest of a run whose file was taken away into a new one, with all samples that are still held.

        Raises
        ------
        FileError
            No new one can be made.
        """
        self.lost_file = error.message
        try:
            self._begin(lost.first_index, again=True)
        except RadarGuiError as second:
            raise FileLostError(error.message, reasons=second.reasons, remedy=second.message) from second
        if self.output is not None and self.output is not lost:
            self.lost_file = f"{error.message} The recording goes on in {self.output.path}."

    def _complete(self, output: RunOutput, ending: Ending, *, is_last: bool) -> None:
        self._open = None
        refusal = "" if self._judge is None or ending is Ending.FAILED else self._judge.refusal()
        self.n_wanted += not refusal
        self._was_hand = bool(refusal)
        is_last = is_last or self.n_wanted >= self.n_runs
        health = {
            **self.health_of_run(output),
            "first_sample": output.first_index,
            "ending": ending.value,
            "samples_recorded": output.count,
            "samples_lost_in_run": output.lost,
            "gaps_in_run": len(output.gaps),
            "disk_free_bytes": self.disk_free_bytes,
            "channels": output.tally.channels(),
        }
        try:
            output.complete(self._truth, health, whole=ending is not Ending.FAILED)
        except BaseException:
            self._report(output, Ending.FAILED, refusal, health, is_last=True)
            self._end(Ending.FAILED)
            raise
        self._report(output, ending, refusal, health, is_last=is_last)
        if is_last:
            self._end(ending)
        # it is quiet already, or quiet is not asked for
        elif ending in (Ending.QUIET, Ending.SECONDS):
            self._arm(output.end_index)
        else:
            self._enter(RecorderState.SETTLING)

    def _arm(self, index: int) -> None:
        self._plan.arm(index)
        self.armed_again_at = index
        if self._was_hand:
            self.hung_up_at = index
        self._enter(RecorderState.ARMED)

    def _report(
        self, output: RunOutput, ending: Ending, refusal: str, health: Mapping[str, object], *, is_last: bool
    ) -> None:
        if self.on_run is not None:
            span = output.first_index, output.end_index, output.count
            self.on_run(FinishedRun(self._n_opened, output.path, ending, *span, refusal, is_last, health))

    def _end(self, ending: Ending) -> None:
        self.ending, self._objection = ending, self.objection
        self._enter(RecorderState.DONE)

    def _enter(self, state: RecorderState) -> None:
        self.state = state
        if self.on_change is not None:
            self.on_change(state)

    def _watch_disk(self) -> None:
        """Look at the disk; a run under way is completed while there is room to do so."""
        try:
            self._check_disk()
        except FileError:
            if self._open is not None:
                self._complete(self._open, Ending.DISK, is_last=True)
            else:
                self._end(Ending.DISK)
            raise

    def _check_disk(self) -> None:
        free = self.disk_free_bytes = None if self.folder is None else run_output.free_bytes(self.folder)
        least = self.minimum_free_bytes
        # while the file can still be closed
        if free is not None and free < least:
            raise worded(FileError, "little_room", folder=self.folder, free_mb=free / 1e6, least_mb=least / 1e6)
