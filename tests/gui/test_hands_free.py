"""Drop after drop without a hand: what is shown meanwhile, and the key that rejects a run and takes it back."""

from __future__ import annotations

from typing import Any

import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QPalette
from PySide6.QtWidgets import QApplication
from support.controlled_source import ControlledSource, codes

from radargui.gui.control.state import AppState
from radargui.gui.main_window import MainWindow
from radargui.gui.runs.run_model import COLUMNS
from radargui.session.session import Session
from radargui.sources.factory import at_once


@pytest.fixture
def beeps(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    heard: list[int] = []
    monkeypatch.setattr("PySide6.QtWidgets.QApplication.beep", lambda: heard.append(1))
    return heard


def shown(window: MainWindow) -> list[str]:
    table = window.runs.table
    return [entry.name for row, entry in enumerate(window.runs.model.entries) if not table.isRowHidden(row)]


def test_two_drops_are_recorded_hands_free_and_the_hand_between_them_is_set_aside(
    seen_window: MainWindow, wait_for: Any, record_one: Any, beeps: list[int], qtbot: Any
) -> None:
    window = seen_window
    words: list[str] = []
    window.control.state_changed.connect(lambda: words.append(window.bar.state.text))
    window.bar.runs.setValue(2)
    record_one(window)
    assert any(text.startswith("ARMED   drop 1 (1 of 2), waiting for motion") for text in words)
    assert any(text.startswith("RECORDING   drop 2 (2 of 2), ") for text in words), words
    assert shown(window) == ["run-0001", "run-0003"]
    assert window.runs.rejected.text() == "Show rejected (1)"

    window.actions_.show_rejected.trigger()
    assert shown(window) == ["run-0001", "run-0002", "run-0003"]
    model = window.runs.model
    grey = QApplication.palette().brush(QPalette.ColorGroup.Disabled, QPalette.ColorRole.Text)
    assert model.data(model.index(1, 0), Qt.ItemDataRole.ForegroundRole) == grey
    assert model.data(model.index(0, 0), Qt.ItemDataRole.ForegroundRole) is None
    assert model.entries[1].verdict.startswith("set aside, SIMULATED: ")

    assert window.health.run.text().startswith("run-0003: ")
    assert "none lost" in window.health.run.text()
    assert "live within " in str(window.run.figures.notes)
    assert "live within " in model.data(model.index(2, list(COLUMNS).index("Verdict")), Qt.ItemDataRole.ToolTipRole)
    wait_for(lambda: len(beeps) == 4)

    path = window.control.session.path
    window.sessions.open(path)
    # it is read beside the window: until then the runs are those of before
    wait_for(lambda: not window.jobs.running and len(model.entries) > 2 and model.entries[2].summary)
    assert "live within " in model.entries[2].agreement
    assert model.entries[1].rejected

    # the key rejects the last run, and again takes it back
    window.runs.table.setFocus()
    qtbot.keyClick(window, Qt.Key.Key_Delete)
    wait_for(lambda: model.entries[2].rejected)
    assert list(Session.open(path, write=False).rejected) == ["run-0002.h5", "run-0003.h5"]
    window.runs.table.selectRow(2)
    qtbot.keyClick(window, Qt.Key.Key_Backspace)
    wait_for(lambda: not model.entries[2].rejected)
    assert list(Session.open(path, write=False).rejected) == ["run-0002.h5"]
    (said,) = (one.text for one in window.board.notices if "run-0003" in one.text)
    assert said.endswith("counts again."), "what it was before is not said beside it"
    wait_for(lambda: not window.jobs.running)


def test_a_rejected_run_is_replaced_by_another_one_while_the_series_goes_on(
    make_window: Any, setup_path: Any, wait_for: Any, beeps: list[int]
) -> None:
    window = make_window(setup_path)
    window.actions_.sound.setChecked(False)
    window.bar.runs.setValue(50)
    window.actions_.record.trigger()
    wait_for(lambda: window.runs.model.entries)
    window.actions_.reject.trigger()
    wait_for(lambda: window.control.n_runs == 51)
    recorded = len(window.runs.model.entries)
    wait_for(lambda: len(window.runs.model.entries) > recorded and ": e = " in window.bar.state.text)
    window.actions_.stop.trigger()
    window.actions_.stop.trigger()
    wait_for(lambda: not window.control.state.running)
    # the last one there was, which on a busy machine is not the first any more
    assert [one.rejected for one in window.runs.model.entries].count("rejected by the operator") == 1
    assert beeps == []


def test_without_a_run_the_key_says_so(window: MainWindow) -> None:
    window.actions_.reject.trigger()
    assert window.board.notices[-1].text == "There is no run to reject."


def test_the_switches_of_sound_and_rejected_runs_are_remembered(make_window: Any, setup_path: Any) -> None:
    first = make_window(setup_path)
    assert first.actions_.sound.isChecked()
    first.actions_.sound.trigger()
    first.runs.rejected.click()
    first.close()
    second = make_window(setup_path)
    assert not second.actions_.sound.isChecked()
    assert second.actions_.show_rejected.isChecked()
    assert second.runs.rejected.isChecked()


class EdgeSource(ControlledSource):
    """A device that waits for an edge and was started again twice."""

    is_waiting = True


def at_an_edge(window: MainWindow) -> None:
    window.hardware.choose("ni")
    window.setup_model.assign("daq.start_source", "PFI0")
    window.setup_model.assign("daq.start", "digital")


def test_an_armed_device_says_which_edge_it_waits_for_and_restarts_are_told(
    make_window: Any, setup_path: Any, wait_for: Any
) -> None:
    source = EdgeSource()
    window = make_window(setup_path, source_maker=lambda *_args, **_options: source)
    at_an_edge(window)
    window.actions_.record.trigger()
    wait_for(lambda: window.bar.state.text == "ARMED   drop 1, waiting for rising edge at PFI0")
    source.is_waiting = False
    source.restarts = 2
    source.push_all(codes(1000))
    wait_for(lambda: any("started again, 2 times so far" in text for text in window.strip.texts()))
    window.actions_.stop.trigger()
    wait_for(lambda: not window.control.state.running)


def test_the_live_view_never_waits_for_an_edge(make_window: Any, setup_path: Any, wait_for: Any) -> None:
    asked: list[Any] = []
    source = EdgeSource()

    def make(_kind: Any, setup: Any, **_options: Any) -> Any:
        asked.append(setup.daq)
        return source

    window = make_window(setup_path, source_maker=make)
    at_an_edge(window)
    window.actions_.start.trigger()
    source.push_all(codes(1000))
    wait_for(lambda: window.control.state is AppState.LIVE)
    assert asked[0].start == "now"
    assert window.setup_model.setup.daq.start == "digital"
    assert at_once(window.setup_model.setup).daq.start_source is None
    assert window.bar.state.text == "LIVE   NOT RECORDED"
    window.actions_.stop.trigger()
    wait_for(lambda: not window.control.state.running)


def test_armed_in_a_hum_that_hides_a_fall_says_why_and_what_to_do(window: MainWindow, wait_for: Any) -> None:
    for key, value in {"scene": "rest", "rest_s": 60.0, "mains": 0.4, "mains_frequency_hz": 180.0}.items():
        window.setup_model.assign(f"simulation.{key}", value)
    window.record()
    wait_for(lambda: window.bar.state.text.endswith("waiting for motion that may not be seen: see the message below"))
    said = window.strip.texts()
    assert len(said) == 1
    assert said[0].startswith("A fall may not start the run: it would shake the voltages ")
    assert said[0].endswith("find what disturbs, or lower “Trigger”.")
    window.actions_.stop.trigger()
    wait_for(lambda: not window.control.state.running)
    assert said[0] not in window.strip.texts()
