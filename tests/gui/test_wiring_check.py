"""The wiring check in the window: the guide, the findings, and the proposals taken into the setup."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from support.controlled_source import ControlledSource, codes
from support.miswired import Miswired
from support.window_clocks import LedClock

from radargui.gui.control.state import AppState
from radargui.gui.main_window import MainWindow
from radargui.sources.simulated.model import WiringScene

STEP_S = 0.5
"""Of the samples that the window gets before it looks again: shorter than any step of the guide."""
RATE_HZ = 4000.0


@pytest.fixture
def clock() -> LedClock:
    return LedClock()


@pytest.fixture
def simulated(make_window: Any, setup_path: Any, clock: LedClock) -> MainWindow:
    window: MainWindow = make_window(setup_path)
    window.setup_model.assign("daq.rate_hz", RATE_HZ)
    window.wiring.scene = lambda setup: WiringScene(setup, clock=clock)
    return window


@pytest.fixture
def followed(clock: LedClock, wait_for: Any) -> Callable[[MainWindow], list[tuple[str, str]]]:
    """Let the check go on as fast as the window follows; return what the dialog said, one after the other."""

    def follow(window: MainWindow) -> list[tuple[str, str]]:
        said: list[tuple[str, str]] = []
        wait_for(lambda: clock.waited_for and window.wiring._guide is not None)
        feed, dialog = window.control.feed, window.wiring
        assert feed is not None
        while window.wiring._guide is not None and clock.time_s < 60.0:
            clock.advance(STEP_S)
            # all but the block that is being made has come, or the scene is over
            wanted = (clock.time_s - 0.1) * RATE_HZ
            wait_for(lambda wanted=wanted: feed.ring.latest >= wanted or window.wiring._guide is None)
            window.wiring._look()
            said.append((dialog.when.text().split(" ")[0], dialog.step.text()))
        wait_for(lambda: dialog.findings)
        return said

    return follow


def test_right_wires_are_said_to_be_right_and_each_step_was_said(
    simulated: MainWindow, followed: Any, wait_for: Any
) -> None:
    window = simulated
    window.actions_.wiring.trigger()
    dialog = window.wiring
    assert dialog.isVisible()
    dialog.begin.click()
    said = followed(window)
    for words in ("Keep everything still", "Move the tracer slowly", *(f"of receiver {i}," for i in (1, 2, 3))):
        assert any(when == "Now" and words in step for when, step in said), words
        assert any(when == "Get" and words in step for when, step in said), words
    assert dialog.when.text() == "The wiring is right."
    assert len(dialog.findings) == 3
    assert all(line.text().startswith("✓") for line in dialog.findings)
    assert not dialog.take.isVisible()
    wait_for(lambda: not window.control.state.running)
    assert dialog.begin.isEnabled()


def test_exchanged_channels_are_found_and_taken_over_into_the_setup(
    simulated: MainWindow, followed: Any, wait_for: Any
) -> None:
    window = simulated
    make = window.wiring.scene
    window.wiring.scene = lambda setup: Miswired(make(setup), [2, 3, 0, 1, 4, 5])
    # the falling sphere of the live view does not do what the guide says: the check takes its place
    window.actions_.start.trigger()
    wait_for(lambda: window.control.state is AppState.LIVE)
    window.wiring.check()
    dialog = window.wiring
    dialog.show()
    followed(window)
    assert any(line.text().startswith("✗") for line in dialog.findings)
    assert "“Channels” = " in dialog.step.text()
    dialog.take.click()
    assert window.setup_model.setup.daq.channels == ("ai2", "ai3", "ai0", "ai1", "ai4", "ai5")
    assert not dialog.take.isVisible()
    wait_for(lambda: not window.control.state.running)


def test_a_check_whose_samples_end_says_so(make_window: Any, setup_path: Any, wait_for: Any) -> None:
    source = ControlledSource()
    window = make_window(setup_path, source_maker=lambda *_args, **_options: source)
    window.hardware.choose("ni")
    window.wiring.show()
    dialog = window.wiring
    dialog.begin.click()
    source.push_all(codes(4000))
    wait_for(lambda: "Keep everything still" in dialog.step.text())
    source.end()
    wait_for(lambda: "ended before the wiring check did" in dialog.step.text())
    assert dialog.begin.isEnabled()


def test_closing_the_dialog_ends_the_live_view_that_it_began(simulated: MainWindow, wait_for: Any) -> None:
    window = simulated
    window.wiring.show()
    window.wiring.check()
    wait_for(lambda: window.control.state is AppState.LIVE)
    window.wiring.close()
    wait_for(lambda: window.control.state is AppState.IDLE)


def test_a_setup_that_is_wrong_is_not_checked(simulated: MainWindow) -> None:
    simulated.setup_model.assign("daq.rate_hz", -1.0)
    simulated.wiring.check()
    assert "Rate per channel: -1 is not allowed" in simulated.wiring.step.text()
    assert not simulated.control.state.running
