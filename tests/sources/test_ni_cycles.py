"""Starts and stops leave nothing behind; 200 of them are in tests/benchmarks/device_cycles.py."""

from __future__ import annotations

import threading

import psutil
import pytest
from support.ni_samples import code_recording, ni_setup
from support.ni_server import serve

from radargui.acquisition.acquisition import Acquisition
from radargui.model.errors import DeviceError
from radargui.sources.factory import make_source
from radargui.sources.ni.source import NiSource


def own_threads() -> int:
    """Threads but those of the stand-in server's pool, which grows when two calls happen to meet."""
    return sum(not thread.name.startswith("ThreadPoolExecutor") for thread in threading.enumerate())


def test_ten_acquisitions_leave_no_thread_no_task_and_no_connection() -> None:
    with serve(code_recording(4000), at_end="end") as server:
        marks = []
        for number in range(12):
            setup = ni_setup(server.address)
            acquisition = Acquisition(make_source("ni", setup), setup, ring_s=0.5)
            acquisition.start()
            acquisition.stop()
            assert acquisition.error is None
            assert server.tasks == []
            if number in (1, 11):
                marks.append((own_threads(), psutil.Process().num_fds()))
        # gRPC closes a socket a moment after the channel
        assert marks[1][0] <= marks[0][0]
        assert marks[1][1] <= marks[0][1] + 3
    assert server.calls["CreateTask"] == server.calls["ClearTask"]


@pytest.mark.parametrize("rpc", ["CreateTask", "CreateAIVoltageChan", "CfgSampClkTiming", "TaskControl", "StartTask"])
def test_a_refusal_at_any_step_leaves_no_task_and_the_device_free(rpc: str) -> None:
    with serve(code_recording(400)) as server:
        server.fail(rpc, -50103, times=1)
        source = NiSource(ni_setup(server.address))
        with pytest.raises(DeviceError, match="in use by another program"):  # noqa: PT012  either may be refused
            source.open()
            source.start()
        source.close()
        assert server.tasks == []
        source.open()
        source.start()
        assert source.read() is not None
        source.close()


@pytest.mark.parametrize("rpc", ["StopTask", "ClearTask"])
def test_a_failure_while_ending_is_no_news_and_ends_all_the_same(rpc: str) -> None:
    with serve(code_recording(400)) as server:
        server.fail(rpc, -201003, times=1)
        source = NiSource(ni_setup(server.address))
        source.open()
        source.start()
        assert source.read() is not None
        source.stop()
        source.close()
        source.close()
