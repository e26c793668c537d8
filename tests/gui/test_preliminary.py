"""The preliminary result stands while the joint correction is computed; it is replaced, or kept after a cancel."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from support.changed import changed
from support.gui_sessions import make_session
from support.run_contents import read_summary
from support.stored_runs import SETUP

from radargui.acquisition.run_plan import Ending
from radargui.experiment.event import RecordedRun
from radargui.experiment.processing_apart import ProcessingApart
from radargui.experiment.reprocess import own_setup
from radargui.files.run_file import read_run
from radargui.gui.control.state import AppState
from radargui.gui.main_window import MainWindow
from radargui.gui.runs.run_controller import COMPUTING
from radargui.processing.process import STOPPED, process


@pytest.fixture
def joint_window(window: MainWindow) -> MainWindow:
    window.setup_model.replace(changed(SETUP, processing={"correction": "joint"}, recording={"maximum_s": 0.6}))
    return window


def stands(window: MainWindow) -> bool:
    return window.run.result is not None and window.run.result.preliminary


def test_the_result_by_flights_is_shown_as_preliminary_and_replaced_by_the_joint_one(
    joint_window: MainWindow, wait_for: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    window = joint_window
    heard: list[int] = []
    monkeypatch.setattr("PySide6.QtWidgets.QApplication.beep", lambda: heard.append(1))
    window.actions_.record.trigger()
    wait_for(lambda: stands(window))
    window.refresh()
    (entry,) = window.runs.model.entries
    assert entry.verdict.startswith("preliminary, ")
    assert window.runs.table.chosen == entry
    assert window.run.result.corrected.method == "flights"
    assert window.run._title.text() == "drop 1 (run-0001, simulated), preliminary"
    assert COMPUTING in window.run.figures.notes
    wait_for(lambda: window.track._title.text() == "drop 1 (run-0001, simulated): preliminary result")
    window.panels.go_to("run")
    assert "preliminary" in window.run.figures.toPlainText()
    assert read_summary(entry.path) is None, "kept is only what is final"
    wait_for(lambda: window.track.shown is not None and window.track.shown.zero)
    quick = window.track.shown
    assert quick.fit_time_s.size > 0
    assert quick.residual_mm.size > 0
    assert window.track.curves.shown_detail == "residual"
    wait_for(lambda: window.bar.state.text.startswith("PROCESSING   "))
    wait_for(lambda: window.bar.state.text.endswith(f"%   drop 1: e = {entry.restitution()}, preliminary"))

    wait_for(lambda: window.control.state is AppState.DONE)
    (final,) = window.runs.model.entries
    assert not window.run.result.preliminary
    assert window.run.result.corrected.method == "joint"
    assert final.verdict == "good, SIMULATED"
    assert window.run._title.text() == "drop 1 (run-0001, simulated)"
    assert COMPUTING not in window.run.figures.notes
    wait_for(lambda: window.track._title.text() == "drop 1 (run-0001, simulated): result")
    wait_for(lambda: window.track.shown is not quick)
    assert window.track.shown.residual_mm.tolist() != quick.residual_mm.tolist()
    assert window.bar.state.text == f"FINAL   drop 1: e = {final.restitution()}"
    assert read_summary(final.path)["correction"] == "joint"
    assert heard == [1], "the sound comes once, with the first result"


@pytest.mark.slow
def test_stop_while_the_joint_correction_is_computed_keeps_the_preliminary_result(
    joint_window: MainWindow, wait_for: Any
) -> None:
    window = joint_window
    window.control.processing = ProcessingApart
    window.actions_.record.trigger()
    wait_for(lambda: stands(window))
    wait_for(lambda: window.control.state is AppState.PROCESSING)
    window.actions_.stop.trigger()
    wait_for(lambda: window.control.state is AppState.DONE)
    assert window.run.result.findings[0] == STOPPED
    stopped, *_ = window.run.figures.notes
    # the flights stand here, not what the adaptive correction gives
    assert stopped.startswith("The joint correction was stopped before it ended: what stood before it stands")
    (entry,) = window.runs.model.entries
    assert window.bar.state.text == f"PRELIMINARY   drop 1: e = {entry.restitution()}, 1 warning"
    summary = read_summary(entry.path)
    assert (summary["correction"], summary["preliminary"]) == ("flights", True)
    assert window.board.notices == ()


def test_a_quick_result_of_an_earlier_drop_does_not_take_the_eye_off_a_later_one(
    window: MainWindow, wait_for: Any, tmp_path: Path
) -> None:
    window.sessions.open(make_session(tmp_path / "data", 4, n_runs=2))
    wait_for(lambda: not window.jobs.running)
    window.runs.show_session(window.runs.folder, [replace(one, summary=None) for one in window.runs.model.entries])
    first, second = (entry.path for entry in window.runs.model.entries)
    result = process(read_run(second), own_setup(second))
    quick = replace(result, preliminary=True)
    # two drops wait: the newer one has its quick result first, and each its final one later
    for path, given in ((second, quick), (first, quick), (first, result), (second, result)):
        window.control.run_recorded.emit(RecordedRun(1, path, given, Ending.QUIET, ""))
        assert window.runs.table.chosen.path == second
        assert window.run._title.text().startswith("drop 2 (run-0002, simulated)")
        assert window.situation.now.says.startswith("drop 2: e = ")
    assert all(entry.has_e for entry in window.runs.model.entries)
    wait_for(lambda: not window.jobs.running)


def test_a_final_result_does_not_take_the_eye_off_another_run(
    window: MainWindow, wait_for: Any, tmp_path: Path
) -> None:
    window.sessions.open(make_session(tmp_path / "data", 4, n_runs=2))
    wait_for(lambda: not window.jobs.running)
    first, second = (entry.path for entry in window.runs.model.entries)
    result = process(read_run(second), own_setup(second))
    recorded = RecordedRun(2, second, replace(result, preliminary=True), Ending.QUIET, "")
    window.run_controller.add(recorded)
    assert stands(window)
    assert window.runs.table.chosen.path == second
    window.runs.table.selectRow(0)
    wait_for(lambda: not stands(window))
    window.run_controller.add(replace(recorded, result=result))
    assert window.runs.table.chosen.path == first
    # it may still be read
    wait_for(lambda: window.run._title.text() == "drop 1 (run-0001, simulated)")
    assert window.runs.model.entries[1].verdict == "good, SIMULATED"
    window.runs.table.selectRow(1)
    assert window.run.result is result, "kept for the moment it is asked for"
    wait_for(lambda: not window.jobs.running)
