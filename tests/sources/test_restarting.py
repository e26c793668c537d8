"""A source that restarts its device: nothing that was read is lost, and what is missing is told."""

from __future__ import annotations

import threading
from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, strategies as st
from support.changed import changed
from support.controlled_source import digitisation
from support.fake_clock import FakeClock
from support.ni_samples import code_recording, ni_setup
from support.ni_server import ByHand, NiServer, serve

from radargui.model.errors import DeviceError, SourceError
from radargui.model.recording import Block, Digitisation, Gap
from radargui.sources.factory import RestartingSource, SampleClock, make_source
from radargui.sources.ni.source import NiSource

RATE_HZ = 10_000.0


class FailingSource:
    """Gives `blocks` of 200 samples in the time they take, then fails."""

    is_waiting = False
    restarts = 0

    def __init__(self, clock: FakeClock, blocks: int, *, cannot_open: bool = False, rate_hz: float = RATE_HZ) -> None:
        self.clock = clock
        self.left = blocks
        self.cannot_open = cannot_open
        self.rate_hz = rate_hz
        self.calls: list[str] = []
        self.index = 0

    def open(self) -> Digitisation:
        self.calls.append("open")
        if self.cannot_open:
            raise DeviceError("Dev1 cannot be reached any more.", remedy="Plug it in.")
        return digitisation(rate_hz=self.rate_hz)

    def start(self) -> None:
        self.calls.append("start")

    def read(self) -> Block | None:
        if self.left == 0:
            raise DeviceError("Samples of Dev1 were lost.", remedy="Raise daq.buffer_s.")
        self.left -= 1
        self.clock.advance(200 / RATE_HZ)
        block = Block(np.zeros((6, 200), dtype=np.int16), self.index, trigger_index=None if self.index else 0)
        self.index += 200
        return block

    def stop(self) -> None:
        self.calls.append("stop")

    def close(self) -> None:
        self.calls.append("close")

    def backlog(self) -> int:
        return 3

    def truth(self, first_index: int, count: int) -> None:
        return None


def restarting(clock: FakeClock, *sources: FailingSource, within_s: float = 10.0) -> RestartingSource:
    queue = list(sources)
    return RestartingSource(lambda _: queue.pop(0), within_s=within_s, clock=clock)


def test_a_restart_is_a_gap_of_the_time_that_passed_and_indices_go_on() -> None:
    clock = FakeClock()
    first, away, second = FailingSource(clock, 5), FailingSource(clock, 0, cannot_open=True), FailingSource(clock, 2)
    source = restarting(clock, first, away, second)
    source.open()
    source.start()
    blocks = [source.read() for _ in range(7)]
    source.close()
    assert [block.first_index for block in blocks if block] == [0, 200, 400, 600, 800, 6000, 6200]
    gap = blocks[5].gap if blocks[5] else None
    assert gap is not None
    assert (gap.first_index, gap.count) == (1000, 5000)  # one wait of 0.5 s between the tries
    assert gap.reason == "restarted, count by the clock: Samples of Dev1 were lost."
    assert [block.gap for block in blocks if block and block is not blocks[5]] == [None] * 6
    assert [block.trigger_index for block in blocks if block] == [0] + [None] * 6
    assert source.restarts == 1
    assert first.calls[:4] == ["open", "start", "stop", "close"]
    assert away.calls == ["open", "close"]
    assert second.calls == ["open", "start", "stop", "close"]


def test_a_reader_that_was_late_before_an_overflow_counts_what_waited_as_lost_too() -> None:
    clock = FakeClock()
    source = restarting(clock, FailingSource(clock, 5), FailingSource(clock, 1))
    source.open()
    source.start()
    for _ in range(5):
        source.read()
    clock.advance(0.3)  # the reader was busy
    block = source.read()
    assert block is not None
    assert block.gap is not None
    assert block.gap.count == 3000


def test_a_device_that_does_not_come_back_is_told_with_both_errors_and_stays_failed() -> None:
    clock = FakeClock()
    gone = [FailingSource(clock, 0, cannot_open=True) for _ in range(20)]
    source = restarting(clock, FailingSource(clock, 1), *gone, within_s=3.0)
    source.open()
    source.start()
    assert source.read() is not None
    for _ in range(2):
        with pytest.raises(DeviceError) as caught:
            source.read()
    assert str(caught.value) == (
        "Samples of Dev1 were lost. It could not be started again within 3 s: Dev1 cannot be reached any more. "
        "Raise daq.buffer_s."
    )
    assert sum(clock.waits) == pytest.approx(3.0)
    source.stop()
    assert source.read() is None


def test_a_device_that_comes_back_as_another_one_is_not_taken_for_the_same() -> None:
    clock = FakeClock()
    source = restarting(clock, FailingSource(clock, 0), FailingSource(clock, 5, rate_hz=5000.0), within_s=0.0)
    source.open()
    source.start()
    with pytest.raises(SourceError, match="came back with another rate"):
        source.read()


def test_what_cannot_be_opened_at_first_is_not_tried_again() -> None:
    clock = FakeClock()
    source = restarting(clock, FailingSource(clock, 0, cannot_open=True))
    with pytest.raises(DeviceError, match="cannot be reached"):
        source.open()
    source.close()


def test_a_gap_of_the_source_itself_goes_through_with_its_place() -> None:
    class WithGap(FailingSource):
        def read(self) -> Block | None:
            block = super().read()
            assert block is not None
            return Block(block.samples, block.first_index + 50, Gap(block.first_index, 50, "late"))

    clock = FakeClock()
    source = restarting(clock, FailingSource(clock, 1), WithGap(clock, 1))
    source.open()
    source.start()
    source.read()
    block = source.read()
    assert block is not None
    assert block.gap is not None
    assert block.gap.first_index == 200
    assert block.first_index == 200 + block.gap.count


def test_stop_ends_the_tries() -> None:
    class StoppingClock(FakeClock):
        def wait(self, seconds: float, interrupt: threading.Event) -> bool:
            source.stop()
            return super().wait(seconds, interrupt)

    clock = StoppingClock()
    source = restarting(clock, FailingSource(clock, 0), FailingSource(clock, 0, cannot_open=True))
    source.open()
    source.start()
    assert source.read() is None
    source.close()


@given(
    drift=st.floats(-1e-4, 1e-4),
    delays_s=st.lists(st.floats(0.0, 0.05), min_size=20, max_size=200),
)
def test_the_sample_of_a_time_is_told_within_the_least_delay_and_the_drift(drift: float, delays_s: list[float]) -> None:
    clock = SampleClock(RATE_HZ)
    for number, delay_s in enumerate([0.0, *delays_s], start=1):
        clock.arrived(200 * number, 100.0 + 200 * number / RATE_HZ * (1.0 + drift) + delay_s)
    now_s = 100.0 + 200 * (len(delays_s) + 1) / RATE_HZ * (1.0 + drift)
    true = 200 * (len(delays_s) + 1)
    error_s = abs(clock.index_at(now_s) - true) / RATE_HZ
    assert error_s <= 3e-4 * (now_s - 100.0) + 1e-4


def faults() -> list[tuple[str, Callable[[NiServer], None], Callable[[NiServer], None]]]:
    def overflow(server: NiServer) -> None:
        server.fail("ReadBinaryI16", -200279, times=1)

    def device_memory(server: NiServer) -> None:
        server.fail("ReadBinaryI16", -200361, times=1, samples_read=13)

    def silence(server: NiServer) -> None:
        server.fail("ReadBinaryI16", -200284, times=4)

    def removed(server: NiServer) -> None:
        server.remove("Dev1")

    def nothing(server: NiServer) -> None:
        pass

    return [
        ("-200279", overflow, nothing),
        ("-200361", device_memory, nothing),
        ("-200284", silence, nothing),
        ("-201003", removed, lambda server: server.plug_in("Dev1")),
    ]


@pytest.mark.parametrize(("code", "fault", "mend"), faults(), ids=[name for name, *_ in faults()])
def test_the_device_is_restarted_after_each_error_of_the_driver_with_what_was_read_kept(
    code: str, fault: Callable[[NiServer], None], mend: Callable[[NiServer], None]
) -> None:
    recording = code_recording(4000)

    class Mending(FakeClock):
        def wait(self, seconds: float, interrupt: threading.Event) -> bool:
            mend(server)
            return super().wait(seconds, interrupt)

    clock = Mending()
    with serve(recording) as server:
        setup = changed(ni_setup(server.address), recording={"restart_after_error": True})
        source = make_source("ni", setup, clock=clock)
        source.open()
        source.start()
        before = [source.read() for _ in range(3)]
        fault(server)
        after = [source.read() for _ in range(2)]
        source.stop()
        source.close()
        assert server.tasks == []
    kept = np.concatenate([block.samples for block in before if block], axis=1)
    np.testing.assert_array_equal(kept, recording.raw[:, :600])
    gap = after[0].gap if after[0] else None
    assert gap is not None
    assert gap.first_index == 600
    assert gap.count >= 1
    assert code in gap.reason
    again = np.concatenate([block.samples for block in after if block], axis=1)
    np.testing.assert_array_equal(again, recording.raw[:, :400])
    assert all(
        late is not None and early is not None and late.first_index == early.end_index
        for early, late in pairwise(after)
    )


def test_a_lost_server_is_found_again_when_it_is_back() -> None:
    recording = code_recording(4000)
    addresses: list[str] = []

    def make(again: bool) -> NiSource:
        return NiSource(ni_setup(addresses[-1]))

    with serve(recording) as old, serve(recording) as new:
        addresses.append(old.address)
        source = RestartingSource(make, within_s=5.0, clock=FakeClock())
        source.open()
        source.start()
        assert source.read() is not None
        old.kill()
        addresses.append(new.address)
        block = source.read()
        source.close()
        assert new.tasks == []
    assert block is not None
    assert block.gap is not None
    assert "was lost while reading" in block.gap.reason


def test_the_restart_does_not_wait_for_the_start_signal_again() -> None:
    pace = ByHand()
    with serve(code_recording(4000), pace=pace) as server:
        setup = changed(
            ni_setup(server.address, start="digital", start_source="PFI0"), recording={"restart_after_error": True}
        )
        source = make_source("ni", setup)
        source.open()
        source.start()
        server.edge("/Dev1/PFI0")
        pace.advance(200)
        first = source.read()
        server.fail("ReadBinaryI16", -200279, times=1)
        feeding = threading.Event()
        feeder = threading.Thread(target=lambda: [pace.advance(200) for _ in iter(lambda: feeding.wait(0.01), True)])
        feeder.start()
        second = source.read()
        feeding.set()
        feeder.join()
        assert server.calls["CfgDigEdgeStartTrig"] == 1
        source.close()
    assert first is not None
    assert first.trigger_index == 0
    assert second is not None
    assert second.gap is not None


def test_without_permission_or_about_an_edge_a_device_is_not_restarted() -> None:
    assert isinstance(make_source("ni", ni_setup(None)), NiSource)
    about = changed(
        ni_setup(None, start="digital", start_source="PFI0", start_pretrigger=True),
        recording={"restart_after_error": True},
    )
    assert isinstance(make_source("ni", about), NiSource)
