"""Decide when a run starts and ends: on motion and until quiet, or at once for a fixed length."""

from abc import ABC, abstractmethod
from bisect import bisect_right
from collections import deque
from enum import Enum
from operator import itemgetter

from radargui.live.trigger import MotionTrigger, TriggerState
from radargui.model.daq import RecordingLimits
from radargui.model.recording import Block, Digitisation


class AcquisitionState(Enum):
    """Where an acquisition is: IDLE, OPENING, RUNNING, STOPPING, then STOPPED or FAILED for good."""

    IDLE = "idle"
    OPENING = "opening"
    RUNNING = "running"
    STOPPING = "stopping"
    STOPPED = "stopped"
    FAILED = "failed"


class RecorderState(Enum):
    """Where a recorder is: IDLE until the source is open, ARMED until something moves, RECORDING, at last DONE.

    Where further runs follow it is ARMED again after each run; SETTLING in between where it is not quiet yet.
    """

    IDLE = "idle"
    ARMED = "armed"
    RECORDING = "recording"
    SETTLING = "settling"
    DONE = "done"


class Ending(Enum):
    """Why a recorder is done."""

    QUIET = "the sphere came to rest"
    MAXIMUM = "the longest length of a run was reached"
    SECONDS = "the length asked for was reached"
    END_OF_DATA = "the source gave no more samples"
    STOPPED = "stopped by the operator"
    FAILED = "recording failed"
    DISK = "the disk was almost full"
    NO_MOTION = "nothing moved as much as the trigger asks for until the end"
    WAITED = "nothing moved in the time allowed for waiting"


_BREAKS_KEPT = 64
"""Gaps that an index can be counted back over: bounds memory on a source that loses much; chosen by hand."""


class IndexMap:
    """Remembers where samples were missing between those pushed."""

    def __init__(self) -> None:
        self._pushed = 0
        self._breaks: deque[tuple[int, int]] = deque(maxlen=_BREAKS_KEPT)

    def push(self, first_index: int, count: int) -> None:
        """Note that samples first_index : first_index + count were pushed."""
        offset = first_index - self._pushed
        if not self._breaks or self._breaks[-1][1] != offset:
            self._breaks.append((self._pushed, offset))
        self._pushed += count

    def absolute(self, pushed_index: int) -> int:
        """Return the absolute index of a sample by its count of pushed samples."""
        piece = max(bisect_right(self._breaks, pushed_index, key=itemgetter(0)) - 1, 0)
        return pushed_index + (self._breaks[piece][1] if self._breaks else 0)


class RunPlan(ABC):
    """Decides from the samples which of them are the run; absolute indices, None while not known.

    Attributes
    ----------
    history
        Samples before the newest block that must be kept while waiting.
    """

    history = 1
    first_index: int | None = None
    trigger_index: int | None = None
    last_index: int | None = None
    ending: Ending | None = None

    @property
    def objection(self) -> str:
        """Why the run may not begin although the sphere falls, in a few words; empty where it would."""
        return ""

    @abstractmethod
    def push(self, block: Block) -> None:
        """Take the next block, a short one: what happened within it is reported as of its end."""

    @abstractmethod
    def rest(self, block: Block) -> bool:
        """Take the next block between two runs; return whether the next one can be armed after it."""

    def arm(self, index: int) -> None:
        """Wait for the next run, from absolute index `index` on."""
        del index
        self.first_index = self.trigger_index = self.last_index = self.ending = None


class FixedPlan(RunPlan):
    """The run starts with the first sample and lasts `seconds`."""

    def __init__(self, digitisation: Digitisation, seconds: float) -> None:
        self._length = max(1, round(seconds * digitisation.sample_rate_hz))

    def push(self, block: Block) -> None:
        """Take the next block; the first one starts the run, and tells of the device's trigger where there is one."""
        if self.first_index is None:
            self.first_index = block.first_index
            self.trigger_index = block.trigger_index
            self.last_index = block.first_index + self._length
            self.ending = Ending.SECONDS

    def rest(self, block: Block) -> bool:
        """Take a block between two runs: the next one can always begin."""
        del block
        return True


class MotionPlan(RunPlan):
    """The run starts `pretrigger_s` before motion and ends when it was quiet for `quiet_s`, or at `maximum_s`.

    An edge that the device started at counts as the motion. `maximum_s` counts from the trigger; waiting ends after
    `wait_s` (`ending` is then WAITED and nothing is recorded).
    """

    _DETECTION_S = 1.0
    """How much later than it began a slow motion may be found with its pre-trigger history still there."""
    _RELEARN_S = 10.0
    """What has moved for so long after a run, and for as long as the longest run, is the new quiet."""

    def __init__(
        self, digitisation: Digitisation, limits: RecordingLimits, trigger: MotionTrigger | None = None
    ) -> None:
        rate = digitisation.sample_rate_hz
        self._trigger = trigger or MotionTrigger(digitisation, limits.threshold)
        self._pretrigger = round(limits.pretrigger_s * rate)
        self._quiet = round(limits.quiet_s * rate)
        self._maximum = round(limits.maximum_s * rate)
        self._wait = round(limits.wait_s * rate)
        self._relearn = round(self._RELEARN_S * rate)
        self._index = IndexMap()
        self._armed = 0
        self._restless = 0
        self._quiet_since: int | None = None
        self.history = self._pretrigger + round(self._DETECTION_S * rate)

    @property
    def objection(self) -> str:
        """See `MotionTrigger.objection`."""
        return self._trigger.objection

    def push(self, block: Block) -> None:
        """Take the next block."""
        self._index.push(block.first_index, block.count)
        if self.trigger_index is None and block.trigger_index is not None:
            self._start(block.trigger_index)
            # what the device kept from before its edge is the history, however long
            self.first_index = block.first_index
        self._judge(self._trigger.push(block.samples), block.end_index)

    def rest(self, block: Block) -> bool:
        """Take the next block between two runs; return whether it has been quiet for `quiet_s`.

        What does not end is the new quiet: a lamp was switched on, a fan.
        """
        self._index.push(block.first_index, block.count)
        if self._is_quiet(self._trigger.push(block.samples), block.end_index):
            self._restless = 0
            return True
        # a hand may stay long, but not longer than the longest run
        self._restless += block.count
        if self._restless > max(self._maximum, self._relearn):
            self._restless = 0
            self._trigger.relearn()
        return False

    def arm(self, index: int) -> None:
        """Wait for the next motion, from absolute index `index` on; only quiet samples go before it."""
        quiet = self._trigger.state.quiet_since_index
        self._quiet_since = None if quiet is None else self._index.absolute(quiet)
        self._armed = index
        super().arm(index)

    def _judge(self, state: TriggerState, end_index: int) -> None:
        if self.trigger_index is not None:
            if self._is_quiet(state, end_index):
                # quiet ends a run early, never beyond its longest length
                self.last_index = end_index if self.last_index is None else min(self.last_index, end_index)
                self.ending = Ending.QUIET
        elif (since := self._motion_since(state)) is not None:
            self._start(since)
        # counted from when it was armed, in samples: a stalled source does not run out of time
        elif end_index - self._armed >= self._wait:
            self.ending = Ending.WAITED

    def _start(self, trigger_index: int) -> None:
        self.trigger_index = trigger_index
        # in a series nothing of the motion before: the rest before a fall must be one
        self.first_index = max(trigger_index - self._pretrigger, self._quiet_since or 0)
        self.last_index = trigger_index + self._maximum
        self.ending = Ending.MAXIMUM

    def _motion_since(self, state: TriggerState) -> int | None:
        """Return where the motion began that was found since this was armed; it may have begun a little before."""
        if state.since_index is None:
            return None
        since = self._index.absolute(state.since_index)
        # a motion that began before the quiet belongs to the run before
        begun = self._quiet_since is None or since >= self._quiet_since
        return since if begun else None

    def _is_quiet(self, state: TriggerState, end_index: int) -> bool:
        if state.quiet_since_index is None:
            return False
        return end_index - self._index.absolute(state.quiet_since_index) >= self._quiet
