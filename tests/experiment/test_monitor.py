"""The monitor shows a source live, again and again, and leaves nothing running."""

from __future__ import annotations

import threading

from support.controlled_source import LONGEST_S, ControlledSource, codes
from support.simulated_setup import simulated_setup

from radargui.acquisition.state import AcquisitionState
from radargui.experiment.monitor import Monitor
from radargui.model.errors import DeviceError

SETUP = simulated_setup()


def test_a_view_can_be_started_and_stopped_again_and_again() -> None:
    sources: list[ControlledSource] = []

    def make() -> ControlledSource:
        sources.append(ControlledSource())
        return sources[-1]

    monitor = Monitor(SETUP, make)
    monitor.stop()
    for _ in range(3):
        monitor.start()
        monitor.start()
        assert monitor.is_running
        assert sources[-1].running.wait(LONGEST_S)
        sources[-1].push_all(codes(1000))
        sources[-1].wait_until_taken()
        monitor.stop()
        monitor.stop()
        assert not monitor.is_running
        assert monitor.acquisition is not None
        assert monitor.acquisition.ring is not None
        assert monitor.acquisition.ring.latest == 1000
    assert [source.calls.count("close") for source in sources] == [1, 1, 1]


def test_a_source_that_cannot_be_opened_ends_the_view_with_its_error() -> None:
    over = threading.Event()
    monitor = Monitor(SETUP, lambda: ControlledSource(opening_error=DeviceError("In use")), on_end=over.set)
    monitor.start()
    assert over.wait(LONGEST_S)
    monitor.stop()
    assert monitor.acquisition is not None
    assert str(monitor.acquisition.error) == "In use"
    assert monitor.acquisition.state is AcquisitionState.FAILED
