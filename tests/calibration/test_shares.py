"""Work on each recording in processes: answers in order, an end at any time, a sentence where a process is lost."""

from __future__ import annotations

import multiprocessing
import os
import signal

import pytest

from radargui.calibration.fit import Shares, crew, working
from radargui.model.errors import CancelledError, ProcessingError


def double(number: int) -> int:
    return 2 * number


def killed(number: int) -> int:
    if number == 1:
        os.kill(os.getpid(), signal.SIGKILL if hasattr(signal, "SIGKILL") else signal.SIGTERM)
    return number


def endless(_number: int) -> None:
    while True:
        pass


def test_answers_come_in_the_order_of_the_recordings_with_their_progress() -> None:
    done: list[float] = []
    shares = Shares(done.append, 3)
    with working(2, shares) as pair:
        assert crew() is pair
        assert pair.each(double, [(1,), (2,), (3,)], shares.one_done) == [2, 4, 6]
    assert done[-1] == pytest.approx(0.5)


def test_a_process_that_is_killed_is_said_and_not_waited_for() -> None:
    with pytest.raises(ProcessingError, match="ended without an answer"), working(2) as pair:
        pair.each(killed, [(0,), (1,), (2,)])


def test_who_cancels_does_not_wait_for_what_was_begun() -> None:
    def cancelled(_done: float) -> None:
        raise CancelledError

    with pytest.raises(CancelledError), working(2, Shares(cancelled, 1)) as pair:
        pair.each(endless, [(1,), (2,)])
    assert not multiprocessing.active_children()
