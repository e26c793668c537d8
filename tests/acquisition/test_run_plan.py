"""A run starts before the motion and ends when it is quiet, or is a fixed length."""

from __future__ import annotations

import numpy as np
from support.controlled_source import digitisation

from radargui.acquisition.run_output import History, cut
from radargui.acquisition.run_plan import Ending, MotionPlan
from radargui.live.trigger import TriggerState
from radargui.model.arrays import RawArray
from radargui.model.daq import RecordingLimits
from radargui.model.recording import Block, Gap

LIMITS = RecordingLimits(pretrigger_s=0.1, quiet_s=0.2, maximum_s=2.0, wait_s=3.0)


class ScriptedTrigger:
    """Moves while the first channel is 1."""

    def __init__(self) -> None:
        self._pushed = 0
        self._since: int | None = None
        self._quiet: int | None = None

    @property
    def state(self) -> TriggerState:
        moving = self._since is not None and self._quiet is None
        return TriggerState(ready=True, moving=moving, since_index=self._since, quiet_since_index=self._quiet)

    def relearn(self) -> None:
        self._quiet = self._pushed

    def push(self, samples: RawArray) -> TriggerState:
        for value in samples[0]:
            moving = value == 1
            if moving and (self._since is None or self._quiet is not None):
                self._since, self._quiet = self._pushed, None
            if not moving and self._since is not None and self._quiet is None:
                self._quiet = self._pushed
            self._pushed += 1
        return self.state


def plan() -> MotionPlan:
    return MotionPlan(digitisation(1, 1000.0), LIMITS, ScriptedTrigger())


def block(first: int, count: int, *, moving: bool = False, gap: Gap | None = None) -> Block:
    return Block(np.full((2, count), int(moving), dtype=np.int16), first, gap)


def push(a_plan: MotionPlan, whole: Block) -> None:
    """Push a block as the recorder does, in slices of 10 ms."""
    for first in range(whole.first_index, whole.end_index, 10):
        a_plan.push(cut(whole, first, first + 10))


def test_a_run_starts_the_pretrigger_time_before_the_motion() -> None:
    a_plan = plan()
    push(a_plan, block(0, 500))
    assert a_plan.first_index is None
    push(a_plan, block(500, 100, moving=True))
    assert (a_plan.first_index, a_plan.trigger_index, a_plan.last_index) == (400, 500, 2500)


def test_a_run_ends_when_it_was_quiet_long_enough_and_not_at_a_short_rest() -> None:
    a_plan = plan()
    push(a_plan, block(0, 500))
    push(a_plan, block(500, 100, moving=True))
    push(a_plan, block(600, 150))
    push(a_plan, block(750, 50, moving=True))
    assert a_plan.ending is Ending.MAXIMUM
    push(a_plan, block(800, 500))
    assert a_plan.ending is Ending.QUIET
    assert a_plan.last_index == 1000


def test_a_motion_that_is_over_within_one_block_is_found() -> None:
    a_plan = plan()
    samples = np.zeros((2, 1000), dtype=np.int16)
    samples[:, 300:320] = 1
    samples[:, 340:360] = 1
    push(a_plan, Block(samples, 0))
    assert a_plan.trigger_index == 300
    assert a_plan.ending is Ending.QUIET
    assert a_plan.last_index == 560


def test_the_trigger_is_at_its_absolute_index_after_a_gap() -> None:
    a_plan = plan()
    push(a_plan, block(0, 300))
    push(a_plan, block(350, 200, gap=Gap(300, 50)))
    push(a_plan, block(550, 50, moving=True))
    assert a_plan.trigger_index == 550


def test_a_history_forgets_old_blocks_only() -> None:
    history = History(100)
    for first in range(0, 500, 50):
        history.push(block(first, 50))
    assert [(part.first_index, part.count) for part in history.since(420)] == [(420, 30), (450, 50)]
    assert [part.first_index for part in history.since(0)] == [400, 450]


def test_a_cut_block_keeps_the_part_of_its_gap_that_lies_inside() -> None:
    whole = block(100, 50, gap=Gap(80, 20, "overflow"))
    assert cut(whole, 90, 120).gap == Gap(90, 10, "overflow")
    assert cut(whole, 90, 120).count == 20
    assert cut(whole, 110, 150).gap is None
    assert cut(whole, 0, 60).count == 0


def test_an_armed_plan_waits_for_the_next_motion_and_takes_only_the_quiet_before_it() -> None:
    a_plan = plan()
    push(a_plan, block(0, 500))
    push(a_plan, block(500, 100, moving=True))
    push(a_plan, block(600, 200))
    assert (a_plan.ending, a_plan.last_index) == (Ending.QUIET, 800)
    a_plan.arm(800)
    assert (a_plan.first_index, a_plan.ending) == (None, None)
    push(a_plan, block(800, 10))
    assert a_plan.first_index is None
    push(a_plan, block(810, 20, moving=True))
    assert (a_plan.first_index, a_plan.trigger_index) == (710, 810)
    push(a_plan, block(830, 200))
    a_plan.arm(1030)
    push(a_plan, block(1030, 20, moving=True))
    assert a_plan.first_index == 930
    push(a_plan, block(1050, 200))
    a_plan.arm(1250)
    push(a_plan, block(1250, 50, moving=True))
    assert (a_plan.first_index, a_plan.trigger_index) == (1150, 1250)


def test_between_two_runs_it_must_be_quiet() -> None:
    a_plan = plan()
    push(a_plan, block(0, 500))
    push(a_plan, block(500, 2100, moving=True))
    assert a_plan.ending is Ending.MAXIMUM
    assert not a_plan.rest(block(2600, 300, moving=True))
    assert not a_plan.rest(block(2900, 150))
    assert a_plan.rest(block(3050, 60))


def test_what_never_ends_is_the_new_quiet() -> None:
    a_plan = plan()
    push(a_plan, block(0, 500))
    push(a_plan, block(500, 2100, moving=True))
    assert not any(a_plan.rest(block(first, 100, moving=True)) for first in range(2600, 12600, 100))
    assert not a_plan.rest(block(12600, 100, moving=True))
    assert not a_plan.rest(block(12700, 100))
    assert a_plan.rest(block(12800, 150))
