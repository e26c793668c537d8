"""Record: runs into a session, their results, report and tables."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from support.compare_dialog import keep_new_result
from support.gui_sessions import make_session
from support.inhibitor import inhibitor
from support.run_contents import read_summary

from radargui.acquisition.run_plan import RecorderState
from radargui.experiment.event import ExperimentState
from radargui.gui.control.state import AppState, WorkerState
from radargui.gui.main_window import MainWindow
from radargui.model.errors import DeviceError
from radargui.session.session import Session


def test_a_recorded_run_is_listed_shown_and_can_be_reported(
    window: MainWindow, wait_for: Any, record_one: Any, tmp_path: Path
) -> None:
    window.session_panel.set_details("Ada", "steel on glass")
    record_one(window)

    (entry,) = window.runs.model.entries
    assert entry.path.parent.parent == tmp_path / "data"
    summary = read_summary(entry.path)
    assert summary is not None
    assert summary["e"] == pytest.approx(0.6, rel=0.03)
    assert window.bar.state.text == f"FINAL   drop 1: e = {entry.restitution()}"
    assert window.control.session is not None
    assert window.control.session.info.operator == "Ada"
    assert window.track.result is not None
    # the live trail, which marks impacts too, stands until the result is drawn
    wait_for(lambda: window.track.shown is not None and window.track.shown.fit_time_s.size > 10)
    shown = window.track.shown
    assert shown.impact_time_s.size >= 3
    assert window.runs.table.chosen == entry

    window.panels.go_to("run")
    for page in range(window.run.tabs.count()):
        window.run.tabs.setCurrentIndex(page)
    assert "First fall" in window.run.figures.toPlainText()
    window.run.tabs.setCurrentWidget(window.run.tabs.page("steps"))
    wait_for(lambda: window.run.tabs.page("steps").receiver.count() == 3)

    window.run_controller.export(tmp_path / "tables")
    window.actions_.report.trigger()
    wait_for(lambda: not window.jobs.running)
    assert {path.name for path in (tmp_path / "tables" / "run-0001").iterdir()} == {
        "track.csv",
        "bounces.csv",
        "motion.csv",
        "result.json",
    }
    assert window.runs.open_report.isEnabled()
    assert (window.control.session.path / "report" / "report.html").is_file()
    assert not [notice for notice in window.board.notices if notice.level == "error"], window.board.notices


@pytest.mark.skipif(sys.platform != "linux", reason="the stand-in is Linux's")
def test_the_computer_is_kept_awake_until_the_last_result(
    window: MainWindow, record_one: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, wait_for: Any
) -> None:
    log = inhibitor(tmp_path / "bin")
    monkeypatch.setenv("PATH", str(tmp_path / "bin"), prepend=os.pathsep)
    record_one(window)
    wait_for(lambda: log.read_text(encoding="utf-8").endswith("released\n"))
    assert log.read_text(encoding="utf-8").startswith("--what=sleep:idle --mode=block --who=RadarGUI")


def test_two_runs_go_hands_free_into_one_session_and_can_be_chosen(
    window: MainWindow, wait_for: Any, record_one: Any
) -> None:
    window.bar.runs.setValue(2)
    record_one(window)
    entries = window.runs.model.entries
    assert [entry.name for entry in entries if not entry.rejected] == ["run-0001", "run-0003"]
    assert "nothing in it falls freely" in window.control.session.rejected["run-0002.h5"]
    assert window.bar.state.text.startswith("FINAL   2 drops   drop 2: e = ")
    window.run_controller._kept.clear()
    window.runs.table.selectRow(0)
    wait_for(lambda: window.run.result is not None and window.run.result.recording.name == "run-0001")
    wait_for(lambda: window.track.shown is not None)

    window.setup_model.assign("processing.correction", "ellipse")
    window.actions_.reprocess.trigger()
    keep_new_result(window, wait_for)
    wait_for(lambda: not window.jobs.running)
    assert read_summary(window.runs.model.entries[0].path)["correction"] == "ellipse"
    assert window.run.result.corrected.method == "ellipse"


def test_record_during_the_live_view_ends_it_and_records(window: MainWindow, wait_for: Any, record_one: Any) -> None:
    window.actions_.start.trigger()
    wait_for(lambda: window.control.state is AppState.LIVE)
    record_one(window)
    assert len(window.runs.model.entries) == 1


def test_stop_keeps_the_run_that_is_under_way(window: MainWindow, wait_for: Any) -> None:
    window.bar.runs.setValue(5)
    window.actions_.record.trigger()
    wait_for(lambda: window.control.state is AppState.RECORDING)
    wait_for(lambda: window.control.recorded_s > 0.6)
    window.actions_.stop.trigger()
    wait_for(lambda: not window.control.state.running)
    paths = [entry.path for entry in window.runs.model.entries]
    # on a machine that does other things earlier ones may have ended: none of them is left out
    assert paths
    assert paths == list(window.control.session.run_paths(with_rejected=True))


def test_stop_while_armed_records_nothing_and_says_nothing(make_window: Any, setup_path: Path, wait_for: Any) -> None:
    window = make_window(setup_path)
    window.setup_model.assign("simulation.scene", "rest")
    window.setup_model.assign("simulation.rest_s", 60.0)
    window.actions_.record.trigger()
    wait_for(lambda: window.control.state is AppState.ARMED)
    assert "waiting for motion" in window.bar.state.text
    window.actions_.stop.trigger()
    wait_for(lambda: window.control.state is AppState.IDLE)
    assert window.runs.model.entries == []
    assert window.board.notices == ()


def test_closing_while_recording_asks_and_keeps_the_run(seen_window: MainWindow, wait_for: Any) -> None:
    seen_window.actions_.record.trigger()
    wait_for(lambda: seen_window.control.state is AppState.RECORDING)
    asked: list[bool] = []

    def no() -> bool:
        asked.append(True)
        return False

    seen_window.may_leave = no
    assert not seen_window.close()
    assert seen_window.control.state.running
    seen_window.may_leave = lambda: True
    seen_window.close()
    seen_window.closing.leave_now()
    wait_for(seen_window.isHidden)
    assert asked == [True]
    session = seen_window.control.session
    assert session is not None
    assert len(session.run_paths()) == 1


def test_what_ends_the_program_is_not_asked_back_and_the_run_is_kept(seen_window: MainWindow, wait_for: Any) -> None:
    del seen_window.may_leave
    seen_window.actions_.record.trigger()
    wait_for(lambda: seen_window.control.state is AppState.RECORDING)
    seen_window.leave()
    wait_for(seen_window.isHidden)
    assert seen_window.control.session is not None
    assert len(seen_window.control.session.run_paths()) == 1


def test_a_device_that_does_not_start_leaves_no_empty_session(
    make_window: Any, setup_path: Path, wait_for: Any, tmp_path: Path
) -> None:
    def no_device(*_: object, **__: object) -> None:
        raise DeviceError("NI-DAQmx is not there.")

    window = make_window(setup_path, source_maker=no_device)
    window.actions_.record.trigger()
    wait_for(lambda: window.control.state is AppState.FAILED)
    assert "NI-DAQmx is not there." in window.board.notices[-1].text
    assert window.control.session is None
    assert not list((tmp_path / "data").iterdir())


def test_a_data_folder_that_cannot_be_made_fails_before_recording(
    window: MainWindow, wait_for: Any, tmp_path: Path
) -> None:
    blocking = tmp_path / "a file"
    blocking.write_text("", encoding="utf-8")
    window.session_panel.folder.line.setText(str(blocking / "data"))
    window.actions_.record.trigger()
    wait_for(lambda: window.control.state is AppState.FAILED)
    assert "No session can be made" in window.strip.texts()[0]
    assert window.bar.state.text == "FAILED   see the message below"


def test_a_session_recorded_before_can_be_opened(
    window: MainWindow, setup_path: Path, wait_for: Any, tmp_path: Path
) -> None:
    window.sessions.open(make_session(tmp_path / "data", 4))
    wait_for(lambda: window.runs.model.entries and window.runs.model.entries[0].summary)
    wait_for(lambda: not window.jobs.running)
    assert window.runs.model.entries[0].verdict == "good, SIMULATED"
    window.runs.table.selectRow(0)
    wait_for(lambda: window.run.result is not None)
    window.sessions.open(setup_path.parent)
    wait_for(lambda: window.strip.texts())
    assert "is not a session" in window.strip.texts()[0]


def test_notes_written_after_the_first_run_reach_the_session(
    own_window: MainWindow, record_one: Any, wait_for: Any
) -> None:
    record_one(own_window)
    session = own_window.control.session
    assert session is not None
    own_window.session_panel._notes.setPlainText("second floor plate")
    own_window.close()
    wait_for(own_window.isHidden)
    assert Session.open(session.path).info.notes == "second floor plate"


def test_a_changed_setup_or_data_folder_makes_a_new_session(
    window: MainWindow, wait_for: Any, record_one: Any, tmp_path: Path
) -> None:
    record_one(window)
    first = window.control.session
    window.setup_model.assign("tracer.diameter_m", 0.012)
    record_one(window)
    second = window.control.session
    window.session_panel.folder.line.setText(str(tmp_path / "other"))
    assert window.control.session is None
    assert window.runs.model.entries == []
    record_one(window)
    third = window.control.session
    assert first is not None
    assert second is not None
    assert third is not None
    assert first.path != second.path
    assert second.setup.tracer.diameter_m == 0.012
    assert third.path.parent == tmp_path / "other"


def test_the_making_of_a_report_can_be_cancelled(own_window: MainWindow, wait_for: Any, tmp_path: Path) -> None:
    session = make_session(tmp_path / "data", 4)
    own_window.sessions.open(session)
    wait_for(lambda: own_window.runs.model.entries and not own_window.jobs.running)
    own_window.actions_.report.trigger()
    assert not own_window.runs.report.isEnabled()
    own_window.work.cancel()
    wait_for(lambda: not own_window.work.busy)
    assert own_window.runs.report.isEnabled()
    assert not list(session.glob("report/*.html"))
    assert own_window.board.notices == ()


def test_a_device_that_is_not_there_leaves_nothing_to_be_processed() -> None:
    recorder: Any = SimpleNamespace(state=RecorderState.DONE, path=None)
    experiment: Any = SimpleNamespace(acquisition=SimpleNamespace(recorder=recorder), state=ExperimentState.ARMED)
    worker = WorkerState(experiment=experiment)
    assert worker.records is AppState.STOPPING
    # of an earlier run the result is still computed
    experiment.state = ExperimentState.PROCESSING
    assert worker.records is AppState.PROCESSING
    experiment.state, recorder.path = ExperimentState.ARMED, Path("run-0001.h5")
    assert worker.records is AppState.PROCESSING
    recorder.state = RecorderState.RECORDING
    assert worker.records is AppState.RECORDING
