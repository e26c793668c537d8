"""Across the room: what stands there, in letters that stay as large; the keys that work in it; the sounds."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QFontMetrics, QFontMetricsF
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication
from support.controlled_source import ControlledSource, codes

from radargui.gui.control.control_bar import wrapped
from radargui.gui.control.state import AppState
from radargui.gui.main_window import MainWindow
from radargui.gui.runs.across import LINES, WIDEST, AcrossView
from radargui.gui.runs.run_keeping import PATTERNS_MS
from radargui.gui.runs.situation import Situation


@pytest.fixture(scope="module")
def all_is_seen() -> bool:
    """The window of the module is one in which no state is over before it was looked at."""
    return True


@pytest.fixture
def across(window: MainWindow, wait_for: Any) -> Iterator[AcrossView]:
    window.activateWindow()
    wait_for(window.isActiveWindow)
    QTest.keyClick(window, Qt.Key.Key_F11)
    (view,) = window.findChildren(AcrossView)
    wait_for(view.isActiveWindow)
    yield view
    window.actions_.across.setChecked(False)


@pytest.fixture
def beeps(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    heard: list[int] = []
    monkeypatch.setattr("PySide6.QtWidgets.QApplication.beep", lambda: heard.append(1))
    return heard


def test_f11_fills_the_screen_and_shows_state_result_run_and_what_is_next(
    across: AcrossView, window: MainWindow, wait_for: Any
) -> None:
    assert across.size() == across.screen().size()
    now = across.situation
    assert (now.word, now.result, now.run) == ("IDLE", "", "")
    assert now.next == "Press R to record, Space to look at the signal"
    seen: list[Situation] = []
    window.control.state_changed.connect(lambda: seen.append(across.situation))
    QTest.keyClick(across, Qt.Key.Key_R)
    wait_for(lambda: window.control.state in (AppState.DONE, AppState.FAILED))
    wait_for(lambda: across.situation.state is AppState.DONE)
    by_state = {one.state: one for one in seen}
    assert by_state[AppState.ARMED].next == "Let the sphere drop"
    assert by_state[AppState.ARMED].run == "drop 1"
    assert by_state[AppState.RECORDING].next.startswith("Hands off")
    entry = window.runs.model.entries[0]
    assert across.situation.result == f"e = {entry.restitution()}"
    assert "±" in across.situation.result
    assert across.situation.run == "drop 1"
    assert across.situation.next == "Hang the sphere up again, then press R"


def test_the_colour_of_done_says_how_good_the_newest_result_is(
    across: AcrossView, window: MainWindow, record_one: Any, wait_for: Any
) -> None:
    record_one(window)
    wait_for(lambda: across.situation.role == "good")
    entry = window.runs.model.entries[0]
    bad = {"status": "rejected", "reason": "receiver 2: clipped"}
    for summary, role in (({**(entry.summary or {}), "warnings": ["the floor moves"]}, "mark"), (bad, "alarm")):
        window.runs.change(entry.path, summary=summary)
        wait_for(lambda role=role: across.situation.role == role)
        assert ("The floor moves." in across.situation.why) is (role == "mark")
    assert across.situation.result == "no e"
    assert "clipped" in across.situation.why
    assert across.situation.next == AppState.DONE.next
    picture = window.bar.state.grab().toImage()
    assert picture.pixelColor(6, picture.height() // 2).name() == window.theme.colours.alarm


@pytest.mark.parametrize("key", [Qt.Key.Key_Escape, Qt.Key.Key_F11])
def test_esc_and_f11_come_back_and_stop_nothing(
    across: AcrossView, window: MainWindow, wait_for: Any, key: Qt.Key
) -> None:
    QTest.keyClick(across, Qt.Key.Key_Space)
    wait_for(lambda: window.control.state is AppState.LIVE)
    wait_for(lambda: across.situation.state is AppState.LIVE)
    QTest.keyClick(across, key)
    assert not across.isVisible()
    assert window.control.state is AppState.LIVE
    assert not window.actions_.across.isChecked()


def test_closing_it_is_leaving_it(across: AcrossView, window: MainWindow) -> None:
    across.close()
    assert not window.actions_.across.isChecked()
    assert window.isVisible()


def test_letters_follow_the_screen_and_never_what_is_shown(across: AcrossView) -> None:
    fonts = {name: font.pixelSize() for name, font in across.fonts().items()}
    for result in ("e = 0.8 ± 0.3", "e = 0.80123 ± 0.00045"):
        across.show_situation(Situation(AppState.PROCESSING, result=result, coming="drop 12 (12 of 100)"))
        assert {name: font.pixelSize() for name, font in across.fonts().items()} == fonts
    for name, font in across.fonts().items():
        lines = LINES.get(name, 1)
        metrics = QFontMetricsF(font)
        assert metrics.horizontalAdvance(WIDEST[name]) <= 0.95 * across.width(), name
        assert lines * metrics.lineSpacing() <= 0.3 * across.height(), name
    # read from five metres: a letter of 1/10 of the screen at the least
    assert fonts["state"] > across.height() / 10


def test_a_failure_is_read_there(make_window: Any, setup_path: Any, wait_for: Any, beeps: list[int]) -> None:
    source = ControlledSource()
    window = make_window(setup_path, source_maker=lambda *_args, **_options: source)
    window.actions_.across.trigger()
    (view,) = window.findChildren(AcrossView)
    window.actions_.start.trigger()
    source.push_all(codes(1000))
    source.fail()
    wait_for(lambda: view.situation.state is AppState.FAILED)
    wait_for(lambda: view.situation.next == "The device was removed")
    wait_for(lambda: len(beeps) == len(PATTERNS_MS["fault"]))


def test_trigger_result_and_fault_are_switched_each_by_itself(
    window: MainWindow, record_one: Any, wait_for: Any, beeps: list[int]
) -> None:
    does = window.actions_
    assert (does.sound.isChecked(), does.sound_trigger.isChecked(), does.sound_fault.isChecked()) == (True, False, True)
    does.sound.setChecked(False)
    does.sound_trigger.setChecked(True)
    record_one(window)
    wait_for(lambda: len(beeps) == len(PATTERNS_MS["trigger"]))
    does.sound_trigger.setChecked(False)
    record_one(window)
    QApplication.processEvents()
    assert len(beeps) == len(PATTERNS_MS["trigger"])


def test_patterns_are_told_apart_by_counting() -> None:
    assert len({len(times) for times in PATTERNS_MS.values()}) == len(PATTERNS_MS)


def test_the_switches_of_the_sounds_are_remembered(make_window: Any, setup_path: Any) -> None:
    first = make_window(setup_path)
    first.actions_.sound_trigger.trigger()
    first.actions_.sound_fault.trigger()
    first.close()
    second = make_window(setup_path)
    assert second.actions_.sound_trigger.isChecked()
    assert not second.actions_.sound_fault.isChecked()
    assert second.actions_.sound.isChecked()


def test_the_key_for_the_next_plot_goes_round_those_that_are_seen(window: MainWindow, wait_for: Any) -> None:
    window.activateWindow()
    wait_for(window.isActiveWindow)
    window.panels.work_in("measure")
    window.actions_.reset_layout.trigger()
    seen = []
    for _ in range(40):
        QTest.keyClick(window, Qt.Key.Key_F4)
        focused = QApplication.focusWidget()
        if focused in seen:
            break
        seen.append(focused)
    assert len(seen) >= 7
    assert window.scopes.time.scopes[0] in seen
    assert all(plot.isVisible() for plot in seen)


def test_an_error_of_many_lines_stays_in_its_place(across: AcrossView) -> None:
    metrics = QFontMetrics(across.fonts()["next"])
    height = 2 * metrics.lineSpacing()
    told = "The device is not there.\n\n    Device Specified: Dev1\n\nStatus Code: -200220\n" * 4
    words = wrapped(told, metrics, across.width(), height)
    assert words.startswith("The device is not there. Device Specified: Dev1")
    assert words.count("\n") == 1
    assert "·" not in words


def test_a_failure_shows_no_result_of_an_earlier_run(
    across: AcrossView, window: MainWindow, wait_for: Any, tmp_path: Path
) -> None:
    QTest.keyClick(across, Qt.Key.Key_R)
    wait_for(lambda: across.situation.state is AppState.DONE and across.situation.result)
    assert across.situation.run == "drop 1"
    window.hardware.choose("replay")
    window.hardware.replay.file.line.setText(str(tmp_path / "missing.csv"))
    QTest.keyClick(across, Qt.Key.Key_R)
    wait_for(lambda: across.situation.state is AppState.FAILED)
    assert (across.situation.run, across.situation.result) == ("", "")
    # the reason comes a moment later
    wait_for(lambda: "missing.csv" in across.situation.next)


def test_while_a_run_is_recorded_or_computed_no_e_of_another_stands_there(
    across: AcrossView, window: MainWindow, wait_for: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen: list[Situation] = []
    window.situation.changed.connect(lambda: seen.append(window.situation.now))
    QTest.keyClick(across, Qt.Key.Key_R)
    wait_for(lambda: across.situation.state is AppState.DONE and across.situation.result)
    seen.clear()
    QTest.keyClick(across, Qt.Key.Key_R)
    wait_for(lambda: across.situation.state is AppState.DONE and across.situation.run == "drop 2")
    armed = [one for one in seen if one.state is AppState.ARMED]
    assert {(one.run, one.result == armed[0].result) for one in armed} == {("drop 2; e of drop 1", True)}
    for state in (AppState.RECORDING, AppState.PROCESSING):
        beside = [one for one in seen if one.state is state and one.entry is None]
        assert beside, state
        # until the live track sees the first bounce
        assert all(one.result == "e = –" or one.result.startswith("live e = 0.") for one in beside)
        assert {one.run for one in beside} == {"drop 2"}
        assert all(one.detail.endswith(one.result) for one in beside)
