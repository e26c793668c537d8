"""The end of the window: never blocks, says what it waits for, can be told not to wait."""

from __future__ import annotations

import re
import threading
from pathlib import Path
from typing import Any

from support.controlled_source import ControlledSource, codes

from radargui.experiment.processing_apart import ProcessingHere
from radargui.gui.control.state import AppState
from radargui.gui.control.waiting import GRACE_S, ClosingStrip
from radargui.gui.main_window import MainWindow
from radargui.model.errors import RadarGuiError
from radargui.model.recording import Block


class StuckSource(ControlledSource):
    """A device that does not come back from a read until the test lets it."""

    def __init__(self) -> None:
        super().__init__()
        self.go = threading.Event()
        self.stuck = threading.Event()

    def read(self) -> Block | None:
        if self._items.empty():
            self.stuck.set()
            self.go.wait(60.0)
        return super().read()


class Slow:
    """A job that ends when the test says so."""

    def __init__(self) -> None:
        self.go = threading.Event()

    def __call__(self) -> None:
        self.go.wait(60.0)


def start_slow_job(window: MainWindow) -> Slow:
    job = Slow()
    window.jobs.start("the slow work", job, lambda _done: None, lambda _error: None)
    return job


def test_closing_says_what_it_waits_for_keeps_drawing_and_closes_when_that_has_ended(
    own_window: MainWindow, wait_for: Any
) -> None:
    job = start_slow_job(own_window)
    frames: list[int] = []
    own_window._timer.timeout.connect(lambda: frames.append(1))
    assert not own_window.close()
    # what the start looks for may be waited for as well
    assert re.search("waiting for .*the slow work", own_window.closing.words.text())
    assert not own_window.bar.isEnabled()
    wait_for(lambda: len(frames) >= 5)
    assert own_window.isVisible()
    own_window.actions_.record.trigger()
    assert own_window.control.state is AppState.IDLE
    job.go.set()
    wait_for(own_window.isHidden)
    assert own_window.unfinished() == ()


def test_a_source_that_does_not_answer_is_named_and_can_be_left_behind(
    make_window: Any, setup_path: Path, wait_for: Any
) -> None:
    source = StuckSource()
    window = make_window(setup_path, source_maker=lambda *_args, **_options: source)
    try:
        source.push_all(codes(1000))
        # what the start looks for is done
        wait_for(lambda: window.sessions._right is not None)
        window.actions_.start.trigger()
        wait_for(source.stuck.is_set)
        window.close()
        assert "waiting for the source to stop" in window.closing.words.text()
        assert window.isVisible()
        window.closing._clock = Clock()
        window.closing.leave.click()
        window.closing._clock.now = GRACE_S + 1.0
        wait_for(window.isHidden)
        assert window.unfinished() == ("the source to stop",)
    finally:
        source.go.set()
    wait_for(lambda: not window.unfinished())


def test_a_run_that_is_being_computed_is_waited_for_and_left_for_later_when_the_operator_says_so(
    make_window: Any, setup_path: Path, wait_for: Any
) -> None:
    window = make_window(setup_path)
    held = hold_processing(window)
    window.actions_.record.trigger()
    wait_for(lambda: window.control.state is AppState.PROCESSING)
    window.may_leave = never_asked
    window.close()
    wait_for(lambda: "the result of the last run" in window.closing.words.text())
    assert not window.isHidden()
    window.closing.leave.click()
    held.set()
    wait_for(window.isHidden)
    session = window.control.session
    assert session is not None
    assert len(session.run_paths()) == 1


def test_nothing_to_wait_for_is_closed_at_once(own_window: MainWindow, wait_for: Any) -> None:
    wait_for(lambda: not own_window.unfinished())
    assert own_window.close()
    assert not own_window.closing.active


def test_the_words_count_the_seconds(wait_for: Any) -> None:
    clock = Clock()
    waits = ["the report"]
    strip = ClosingStrip(lambda: tuple(waits), lambda: None, clock)
    over: list[bool] = []
    strip.over.connect(lambda: over.append(True))
    strip.begin()
    clock.now = 12.0
    wait_for(lambda: strip.words.text() == "Closing: waiting for the report (12 s)")
    waits.clear()
    wait_for(lambda: over)
    assert not strip.active


class Clock:
    """Time as the test sets it."""

    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        return self.now


def never_asked() -> bool:
    raise AssertionError("no run is being recorded")


def hold_processing(window: MainWindow) -> threading.Event:
    """Let the processing of runs wait for the event."""
    held = threading.Event()

    class Held(ProcessingHere):
        """Does a job once it may."""

        def process(self, *job: Any) -> Any:
            if not held.wait(60.0):
                raise RadarGuiError("the test ended nothing")
            return super().process(*job)

    window.control.processing = Held
    return held
