"""What the window says while results are computed: how far, how long still, what comes after."""

from __future__ import annotations

from types import SimpleNamespace

from pytestqt.qtbot import QtBot

from radargui.gui.control.state import AppState
from radargui.gui.control.waiting import StoppingStrip


def test_the_remaining_time_of_a_result_is_foretold_from_how_it_went_so_far(qtbot: QtBot) -> None:
    now = [100.0]
    control = SimpleNamespace(
        state=AppState.PROCESSING,
        backlog=[1, 2],
        reached=SimpleNamespace(asked=0),
        progress=0.0,
        end=lambda _: None,
    )
    strip = StoppingStrip(control, clock=lambda: now[0])  # type: ignore[arg-type]
    qtbot.addWidget(strip)
    strip.look("drop 1")
    assert strip.words.text() == "Waiting for the result of drop 1 (0 % computed, 1 more after it), 0 s so far"
    now[0], control.progress = 104.0, 0.04
    strip.look("drop 1")
    assert "left" not in strip.words.text()
    now[0], control.progress = 106.0, 0.25
    strip.look("drop 1")
    assert strip.words.text() == (
        "Waiting for the result of drop 1 (25 % computed, about 18 s left, 1 more after it), 6 s so far"
    )
    # the next result counts from its own beginning
    now[0], control.progress, control.backlog = 124.0, 0.0, [2]
    strip.look("drop 2")
    now[0], control.progress = 126.0, 0.5
    strip.look("drop 2")
    assert strip.words.text() == "Waiting for the result of drop 2 (50 % computed, about 2 s left), 26 s so far"
