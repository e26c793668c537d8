"""A run that the device started at an edge: the edge is its trigger."""

from __future__ import annotations

from datetime import UTC, datetime

from support.controlled_source import MemoryRun, codes, digitisation

from radargui.acquisition.recorder import Recorder
from radargui.model.daq import RecordingLimits
from radargui.model.recording import Block

LIMITS = RecordingLimits(pretrigger_s=0.1, maximum_s=0.2, quiet_s=0.1)


def recorded(trigger_index: int, seconds: float | None = None) -> tuple[Recorder, MemoryRun]:
    run = MemoryRun()
    recorder = Recorder(run, LIMITS, seconds=seconds)
    recorder.prepare(digitisation(), datetime.now(UTC))
    for first in range(0, 6000, 200):
        recorder.push(Block(codes(200, seed=first), first, trigger_index=None if first else trigger_index))
    return recorder, run


def test_a_run_begins_at_the_edge_although_nothing_moves() -> None:
    recorder, run = recorded(0)
    assert recorder.is_done
    assert (run.trigger_index, run.raw.shape[1]) == (0, 2000)


def test_a_run_holds_all_that_the_device_kept_from_before_its_edge() -> None:
    recorder, run = recorded(1500)
    assert recorder.is_done
    assert recorder.output.first_index == 0
    assert (run.trigger_index, run.raw.shape[1]) == (1500, 3500)


def test_a_run_of_fixed_length_keeps_the_edge_as_its_trigger() -> None:
    _, run = recorded(1500, seconds=0.3)
    assert (run.trigger_index, run.raw.shape[1]) == (1500, 3000)
