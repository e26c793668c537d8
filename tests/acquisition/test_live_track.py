"""A live track that stalls or fails holds nobody back, and ends no recording."""

from __future__ import annotations

import threading

import numpy as np
import pytest
from support.controlled_source import LONGEST_S, ControlledSource, MemoryRun, codes
from support.simulated_setup import simulated_setup

from radargui.acquisition.acquisition import Acquisition
from radargui.acquisition.recorder import Recorder
from radargui.acquisition.run_plan import AcquisitionState
from radargui.live.track import LiveEstimate
from radargui.model.arrays import RawArray
from radargui.model.daq import RecordingLimits
from radargui.model.recording import Digitisation
from radargui.model.setup import Setup

LIMITS = RecordingLimits(pretrigger_s=0.2, quiet_s=0.15, maximum_s=2.0, wait_s=5.0)
SETUP = simulated_setup(daq={"buffer_s": 0.5})


def ended(acquisition: Acquisition) -> None:
    assert acquisition.wait(LONGEST_S)


def test_a_stalled_live_track_holds_nobody_back_and_skips() -> None:
    source = ControlledSource()
    run = MemoryRun()
    entered, go, resumed = threading.Event(), threading.Event(), threading.Event()

    class StallingProcessor:
        def push(self, samples: RawArray, first_index: int) -> LiveEstimate:
            (resumed if entered.is_set() else entered).set()
            assert go.wait(LONGEST_S)
            count = samples.shape[1]
            rows = np.zeros((3, count))
            return LiveEstimate(np.arange(first_index, first_index + count), rows, rows, rows, rows, moving=False)

    def stalling(_: Setup, __: Digitisation) -> StallingProcessor:
        return StallingProcessor()

    acquisition = Acquisition(
        source, SETUP, recorder=Recorder(run, LIMITS, seconds=4.0), make_processor=stalling, patient=True
    )
    acquisition.start()
    source.push(codes(400))
    assert entered.wait(LONGEST_S)
    source.push_all(codes(29600))
    source.wait_until_taken()
    assert acquisition.health.live_lag_s == pytest.approx(3.0)
    go.set()
    assert resumed.wait(LONGEST_S)
    source.push_all(codes(10200))
    ended(acquisition)
    assert run.raw.shape[1] == 40000
    assert acquisition.error is None
    assert acquisition.health.live_skipped_samples > 5000


def failing(_: Setup, __: Digitisation) -> FailingProcessor:
    return FailingProcessor()


class FailingProcessor:
    def push(self, samples: RawArray, first_index: int) -> LiveEstimate:
        raise IndexError(f"{samples.shape} {first_index}")


def test_a_live_track_that_fails_does_not_end_a_recording() -> None:
    source = ControlledSource()
    run = MemoryRun()
    source.push_all(codes(3000))
    acquisition = Acquisition(
        source, SETUP, recorder=Recorder(run, LIMITS, seconds=0.2), make_processor=failing, patient=True
    )
    acquisition.start()
    ended(acquisition)
    assert acquisition.error is None
    assert "The live track failed unexpectedly" in str(acquisition.health.live_error)
    assert run.raw.shape[1] == 2000


def test_a_live_track_that_fails_ends_a_mere_view() -> None:
    source = ControlledSource()
    acquisition = Acquisition(source, SETUP, make_processor=failing)
    acquisition.start()
    source.push_all(codes(400))
    ended(acquisition)
    assert acquisition.state is AcquisitionState.FAILED
    assert "The live track failed" in str(acquisition.error)
