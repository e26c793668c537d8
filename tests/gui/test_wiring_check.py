"""The wiring check in the window: the guide, the findings, and the proposals taken into the setup."""

from __future__ import annotations

from typing import Any

import pytest
from support.controlled_source import ControlledSource, codes
from support.miswired import Miswired

from radargui.gui.control.app_state import AppState
from radargui.gui.main_window import MainWindow
from radargui.sources.simulated.wiring_scene import WiringScene

SPEED = 12.0


@pytest.fixture
def simulated(make_window: Any, setup_path: Any, fast_clock: Any) -> MainWindow:
    window = make_window(setup_path)
    window.setup_model.assign("daq.rate_hz", 4000.0)
    window.wiring.scene = lambda setup: WiringScene(setup, clock=fast_clock(SPEED))
    return window


def test_right_wires_are_said_to_be_right_and_each_step_was_said(simulated: MainWindow, wait_for: Any) -> None:
    window, told = simulated, []
    window.actions_.wiring.trigger()
    dialog = window.wiring.dialog
    assert dialog.isVisible()
    dialog.begin.click()

    def found() -> bool:
        told.append((dialog.when.text().split(" ")[0], dialog.step.text()))
        return bool(dialog.finding_texts())

    wait_for(found)
    for words in ("Keep everything still", "Move the tracer slowly", *(f"of receiver {i}," for i in (1, 2, 3))):
        assert any(when == "Now" and words in step for when, step in told), words
    assert any(when == "Get" for when, _ in told)
    assert dialog.when.text() == "The wiring is right."
    assert len(dialog.finding_texts()) == 3
    assert all(text.startswith("✓") for text in dialog.finding_texts())
    assert not dialog.take.isVisible()
    wait_for(lambda: not window.control.state.running)
    assert dialog.begin.isEnabled()


def test_exchanged_channels_are_found_and_taken_over_into_the_setup(simulated: MainWindow, wait_for: Any) -> None:
    window = simulated
    make = window.wiring.scene
    window.wiring.scene = lambda setup: Miswired(make(setup), [2, 3, 0, 1, 4, 5])
    # the falling sphere of the live view does not do what the guide says: the check takes its place
    window.actions_.start.trigger()
    wait_for(lambda: window.control.state is AppState.LIVE)
    window.wiring.begin()
    dialog = window.wiring.dialog
    dialog.show()
    wait_for(dialog.finding_texts)
    assert any(text.startswith("✗") for text in dialog.finding_texts())
    assert "daq.channels" in dialog.step.text()
    dialog.take.click()
    assert window.setup_model.setup.daq.channels == ("ai2", "ai3", "ai0", "ai1", "ai4", "ai5")
    assert not dialog.take.isVisible()
    wait_for(lambda: not window.control.state.running)


def test_a_check_whose_samples_end_says_so(make_window: Any, setup_path: Any, wait_for: Any) -> None:
    source = ControlledSource()
    window = make_window(setup_path, source_maker=lambda *_args, **_options: source)
    window.hardware.choose("ni")
    window.wiring.show()
    dialog = window.wiring.dialog
    dialog.begin.click()
    source.push_all(codes(4000))
    wait_for(lambda: "Keep everything still" in dialog.step.text())
    source.end()
    wait_for(lambda: "ended before the wiring check did" in dialog.step.text())
    assert dialog.begin.isEnabled()


def test_closing_the_dialog_ends_the_live_view_that_it_began(simulated: MainWindow, wait_for: Any) -> None:
    window = simulated
    window.wiring.show()
    window.wiring.begin()
    wait_for(lambda: window.control.state is AppState.LIVE)
    window.wiring.dialog.close()
    wait_for(lambda: window.control.state is AppState.IDLE)


def test_a_setup_that_is_wrong_is_not_checked(simulated: MainWindow) -> None:
    simulated.setup_model.assign("daq.rate_hz", -1.0)
    simulated.wiring.begin()
    assert "daq.rate_hz" in simulated.wiring.dialog.step.text()
    assert not simulated.control.state.running
