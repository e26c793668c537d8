"""Work in the background: its thread waits for more, its answer comes in the window's thread."""

from __future__ import annotations

import threading
from typing import Any

from radargui.gui.background import Jobs


def test_work_that_follows_other_work_finds_a_thread_that_waits(qapp: Any, wait_for: Any) -> None:
    jobs = Jobs(lambda error: None)
    threads: list[tuple[int, int]] = []
    for _ in range(3):
        jobs.start(
            "the name of a thread", threading.get_ident, lambda one: threads.append((one, threading.get_ident()))
        )
        assert jobs.running == ("the name of a thread",)
        wait_for(lambda: not jobs.running)
    assert len({one for one, _ in threads}) == 1
    assert {answered for _, answered in threads} == {threading.get_ident()}
    assert threads[0][0] != threading.get_ident()
    # what rests has no thread, and takes work again
    (waits,) = (one for one in threading.enumerate() if one.ident == threads[0][0])
    jobs.rest()
    waits.join(10.0)
    assert not waits.is_alive()
    jobs.start("work", threading.get_ident, lambda one: threads.append((one, threading.get_ident())))
    wait_for(lambda: not jobs.running)
    assert len(threads) == 4


def test_an_error_is_led_to_who_looks_after_it_and_what_nobody_wants_any_more_is_dropped(
    qapp: Any, wait_for: Any
) -> None:
    shown: list[BaseException] = []
    own: list[BaseException] = []
    jobs = Jobs(shown.append)

    def fail() -> None:
        raise OSError("the disk is full")

    jobs.start("work", fail)
    jobs.start("work", fail, lambda _: None, own.append)
    jobs.start("work", fail, lambda _: None, own.append, lambda: False)
    wait_for(lambda: not jobs.running)
    assert [str(error) for error in (*shown, *own)] == ["the disk is full", "the disk is full"]
    assert len(own) == 1
