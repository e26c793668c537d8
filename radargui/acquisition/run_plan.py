"""When a run starts and ends: on motion and until quiet, or a fixed length at once."""

from __future__ import annotations

from typing import Protocol

from radargui.acquisition.index_map import IndexMap
from radargui.acquisition.state import Ending
from radargui.model.arrays import RawArray
from radargui.model.block import Block
from radargui.model.daq import RecordingLimits
from radargui.model.digitisation import Digitisation
from radargui.motion.trigger import MotionTrigger, TriggerState


class Trigger(Protocol):
    """What a plan needs of a motion trigger."""

    def push(self, samples_raw: RawArray) -> TriggerState:
        """Take the next samples, shape (n_channels, n), and return what is known after them."""


class RunPlan(Protocol):
    """Decides from the samples which of them are the run; absolute indices, None while not known."""

    first_index: int | None
    trigger_index: int | None
    last_index: int | None
    ending: Ending | None

    @property
    def history(self) -> int:
        """Samples before the newest block that must be kept while waiting."""

    def push(self, block: Block) -> None:
        """Take the next block."""


class FixedPlan:
    """The run starts with the first sample and lasts `seconds`."""

    def __init__(self, digitisation: Digitisation, seconds: float) -> None:
        self._length = max(1, round(seconds * digitisation.sample_rate_hz))
        self.first_index: int | None = None
        self.trigger_index: int | None = None
        self.last_index: int | None = None
        self.ending: Ending | None = None

    @property
    def history(self) -> int:
        """Nothing before the run is kept."""
        return 1

    def push(self, block: Block) -> None:
        """Take the next block; the first one starts the run, and tells of the device's trigger where there is one."""
        if self.first_index is None:
            self.first_index = block.first_index
            self.trigger_index = block.trigger_index
            self.last_index = block.first_index + self._length
            self.ending = Ending.SECONDS


class MotionPlan:
    """The run starts `pretrigger_s` before motion and ends when it was quiet for `quiet_s`, or at `maximum_s`.

    An edge that the device started at counts as the motion. `maximum_s` counts from the trigger; waiting ends after
    `wait_s` (`ending` is then WAITED and nothing is recorded).
    """

    _DETECTION_S = 1.0
    """How much later than it began a slow motion may be found with its pre-trigger history still there."""
    _SLICE_S = 0.01
    """The trigger tells its latest news only: it gets long blocks in slices, so that no short motion is missed."""

    def __init__(self, digitisation: Digitisation, limits: RecordingLimits, trigger: Trigger | None = None) -> None:
        rate = digitisation.sample_rate_hz
        self._trigger = trigger or MotionTrigger(digitisation, limits.threshold)
        self._pretrigger = round(limits.pretrigger_s * rate)
        self._quiet = round(limits.quiet_s * rate)
        self._maximum = round(limits.maximum_s * rate)
        self._wait = round(limits.wait_s * rate)
        self._detection = round(self._DETECTION_S * rate)
        self._slice = max(1, round(self._SLICE_S * rate))
        self._index = IndexMap()
        self.first_index: int | None = None
        self.trigger_index: int | None = None
        self.last_index: int | None = None
        self.ending: Ending | None = None

    @property
    def history(self) -> int:
        """Samples before the newest block that must be kept while waiting."""
        return self._pretrigger + self._detection

    def push(self, block: Block) -> None:
        """Take the next block."""
        self._index.push(block.first_index, block.count)
        if self.trigger_index is None and block.trigger_index is not None:
            self._start(block.trigger_index)
            # what the device kept from before its edge is the history, however long
            self.first_index = block.first_index
        for first in range(0, block.count, self._slice):
            if self.ending in (Ending.QUIET, Ending.WAITED):
                return
            part = block.samples[:, first : first + self._slice]
            self._judge(self._trigger.push(part), block.first_index + first + part.shape[1])

    def _judge(self, state: TriggerState, end_index: int) -> None:
        if self.trigger_index is not None:
            if self._is_quiet(state, end_index):
                self.last_index = end_index if self.last_index is None else min(self.last_index, end_index)
                self.ending = Ending.QUIET
        elif state.since_index is not None:
            self._start(self._index.absolute(state.since_index))
        elif end_index >= self._wait:
            self.ending = Ending.WAITED

    def _start(self, trigger_index: int) -> None:
        self.trigger_index = trigger_index
        self.first_index = trigger_index - self._pretrigger
        self.last_index = trigger_index + self._maximum
        self.ending = Ending.MAXIMUM

    def _is_quiet(self, state: TriggerState, end_index: int) -> bool:
        if state.quiet_since_index is None:
            return False
        return end_index - self._index.absolute(state.quiet_since_index) >= self._quiet
