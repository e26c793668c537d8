"""Work that goes step by step: the same here and in processes of its own; what fails there is said here."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Iterator

import pytest
from support.counting import PARTS, counting

from radargui.system.cores import Cores, Lane, cores, on_cores


@pytest.fixture(scope="module")
def apart() -> Iterator[list[Lane[str, int]]]:
    found = Cores(2)
    # the first time nobody waits for them
    assert [type(lane) for lane in found.lanes(counting, PARTS)] == [Lane]
    assert found.wait_ready(60.0)
    yield list(found.lanes(counting, PARTS))
    found.close()


def test_lanes_apart_work_at_once_each_in_a_process_of_its_own(apart: list[Lane[str, int]]) -> None:
    assert len(apart) == 2
    for lane in apart:
        lane.begin(0, 2)
        lane.ask([0])
    assert [dict(lane.answer()) for lane in apart] == [{0: 0}, {0: 0}]
    for lane in apart:
        lane.clear()


def test_what_fails_in_another_process_is_raised_here_and_the_lane_goes_on(apart: list[Lane[str, int]]) -> None:
    lane = apart[1]
    lane.begin(0, -1)
    lane.ask([0])
    with pytest.raises(ZeroDivisionError):
        dict(lane.answer())
    lane.clear()
    lane.begin(0, 1)
    lane.ask([0])
    # asked and never heard: forgotten with the rest
    lane.clear()
    lane.begin(0, 2)
    lane.ask([0])
    assert dict(lane.answer()) == {0: 0}
    lane.clear()


def test_without_a_word_all_is_done_here() -> None:
    assert cores().count == 0
    assert [type(lane) for lane in cores().lanes(counting, 100)] == [Lane]
    with on_cores(1) as found:
        assert found.count == 0


def _step(lane: Lane[str, int]) -> dict[int, int]:
    lane.ask([0])
    return dict(lane.answer())


@pytest.mark.skipif(sys.platform == "win32", reason="no signals there")
def test_once_a_process_is_killed_all_is_done_here() -> None:
    found = Cores(2)
    found.lanes(counting, PARTS)
    assert found.wait_ready(60.0)
    lane = found.lanes(counting, PARTS)[0]
    lane.begin(0, 1)
    os.kill(found.processes()[0], signal.SIGKILL)
    with pytest.raises((EOFError, OSError)):
        _step(lane)
    found.give_up()
    assert [type(one) for one in found.lanes(counting, PARTS)] == [Lane]


def test_two_cores_are_left_to_the_reader_and_the_window(monkeypatch: pytest.MonkeyPatch) -> None:
    for present, used in ((1, 0), (2, 0), (3, 0), (4, 2), (6, 4), (8, 4), (64, 4), (None, 0)):
        monkeypatch.setattr(os, "cpu_count", lambda present=present: present)
        with on_cores() as found:
            assert found.count == used
            assert cores() is found
    assert cores().count == 0
