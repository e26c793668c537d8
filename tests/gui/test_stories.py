"""Stories of operators: nobody is misled by another run, another session, a replay, a backlog, a storm of warnings."""

from __future__ import annotations

import multiprocessing
import shutil
import threading
from pathlib import Path
from typing import Any

import h5py
import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QComboBox, QLineEdit
from support.changed import changed
from support.gui_sessions import make_session
from support.shown_plots import points_of
from support.stored_runs import SETUP
from support.window_clocks import SeenClock

from radargui.experiment.processing_apart import ProcessingApart, ProcessingHere
from radargui.gui.control.state import AppState
from radargui.gui.main_window import MainWindow
from radargui.gui.runs.run_model import RunEntry
from radargui.model.drop import RunOrigin
from radargui.model.errors import FileError
from radargui.report.content import Grid
from radargui.report.facts import SessionFacts, report_facts
from radargui.report.findings_section import front_chapters
from radargui.report.run_facts import RunFacts, glance, study
from radargui.report.run_section import run_page
from radargui.restitution.series import series_of
from radargui.session.session import Session
from radargui.sources.factory import make_source


def listed(window: MainWindow) -> list[tuple[str, str]]:
    return [(entry.label, entry.name) for entry in window.runs.model.entries]


def opened(window: MainWindow, path: Path, wait_for: Any) -> None:
    window.sessions.open(path)
    wait_for(lambda: not window.jobs.running)


def shown(window: MainWindow, wait_for: Any, row: int = 0) -> None:
    window.runs.table.selectRow(row)
    wait_for(lambda: window.run.result is not None and not window.jobs.running)


def test_from_the_first_start_to_the_report_by_keys_alone(make_window: Any, wait_for: Any, tmp_path: Path) -> None:
    window = make_window(None)
    window.activateWindow()
    wait_for(window.isActiveWindow)
    assert window.setup_model.shipped
    assert (window.hardware.kind, window.bar.state.text) == ("simulated", "IDLE")
    assert window.board.notices == ()
    window.panels.go_to("hardware")
    # low and quick, typed as an operator would
    rate = window.findChild(QLineEdit, "daq.rate_hz")
    rate.setFocus()
    rate.selectAll()
    QTest.keyClicks(rate, "6000")
    correction = window.findChild(QComboBox, "processing.correction")
    correction.setFocus()
    QTest.keyClick(correction, Qt.Key.Key_Home)
    for _ in range(correction.findData("published")):
        QTest.keyClick(correction, Qt.Key.Key_Down)
    assert window.setup_model.setup.processing.correction == "published"
    QTest.keyClick(correction, Qt.Key.Key_R)
    wait_for(lambda: window.control.state in (AppState.DONE, AppState.FAILED))
    assert window.bar.state.text.startswith("FINAL   drop 1: e = ")
    QTest.keyClick(window, Qt.Key.Key_R, Qt.KeyboardModifier.ControlModifier)
    wait_for(window.runs.open_report.isEnabled)
    session = window.control.session
    assert session is not None
    assert session.path.parent == tmp_path / "data"
    assert session.setup.daq.rate_hz == 6000.0
    assert (session.path / "report" / "report.pdf").is_file()
    wait_for(lambda: not window.jobs.running)


def test_the_samples_that_a_run_tells_are_its_own(window: MainWindow, record_one: Any) -> None:
    window.bar.runs.setValue(2)
    record_one(window)
    for entry in window.runs.model.entries:
        with h5py.File(entry.path) as file:
            own = file["raw"].shape[1]
        assert entry.health.startswith(f"{own} samples, "), entry.health


def test_an_old_session_is_reviewed_then_a_new_one_recorded(
    window: MainWindow, wait_for: Any, record_one: Any, tmp_path: Path
) -> None:
    window.session_panel.set_details("Ada", "today", "steel", "glass")
    window.setup_model.path = None
    window.setup_model.replace(SETUP)
    old = make_session(tmp_path / "data", 4, operator="Grace", notes="of May")
    opened(window, old, wait_for)
    shown(window, wait_for)
    assert window.track.result is not None
    assert window.run._title.text() == "drop 1 (run-0001, simulated)"
    assert window.session_panel.details[:2] == ("Grace", "of May")
    asked: list[str] = []
    window.sessions.ask_where = lambda name: asked.append(name) or ""
    window.actions_.record.trigger()
    assert asked == [old.name]
    assert window.control.state is AppState.IDLE, "not answered: nothing is recorded"

    window.sessions.ask_where = lambda _name: "new"
    record_one(window)
    session = window.control.session
    assert session is not None
    assert session.path != old
    assert (session.info.operator, session.info.notes) == ("Ada", "today")
    assert len(Session.open(old, write=False).run_paths()) == 1
    assert listed(window) == [("1", "run-0001")]
    assert window.runs.model.entries[0].path.parent == session.path

    opened(window, old, wait_for)
    window.sessions.ask_where = lambda _name: "add"
    record_one(window)
    assert listed(window) == [("1", "run-0001"), ("2", "run-0002")]
    assert window.bar.state.text.startswith("FINAL   drop 2: ")
    window.sessions.ask_where = lambda _name: pytest.fail("asked once")
    record_one(window)
    assert len(Session.open(old, write=False).run_paths()) == 3


def test_a_new_session_is_empty(window: MainWindow, wait_for: Any, record_one: Any) -> None:
    record_one(window)
    shown(window, wait_for)
    assert "drop 1: e = " in window.bar.state.text
    assert all(points_of(scope) > 0 for scope in window.scopes.time.scopes)
    window.panels.go_to("run")
    window.run.tabs.setCurrentWidget(window.run.samples)
    wait_for(lambda: window.run.samples.plots)
    window.actions_.new_session.trigger()
    assert window.bar.state.text == "IDLE"
    assert window.run.result is None
    assert window.run._title.text() == "No run chosen"
    assert window.run.figures.toPlainText() == ""
    assert window.run.samples.plots == []
    assert window.track.shown is None
    assert window.track.result is None
    assert window.track._title.text() == "Live track: nothing yet"
    assert window.runs.model.entries == []
    assert window.runs.series.isHidden()
    assert window.health.run.text() == ""
    assert all(points_of(scope) == 0 for scope in window.scopes.time.scopes)
    assert all(points_of(plane) == 0 for plane in (*window.planes.raw, *window.planes.corrected))


def test_a_file_replayed_twice_in_a_session_of_measurements_changes_no_statistics(
    window: MainWindow, wait_for: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    window.setup_model.path = None
    window.setup_model.replace(SETUP)
    path = make_session(tmp_path / "data", 4)
    # as a device gave it
    measured = RunOrigin("measured", "the samples of the device")
    real = "radargui.files.run_card._origin"
    from radargui.files import run_card

    origin_in = run_card._origin
    monkeypatch.setattr(real, lambda file: measured if file.filename.endswith("run-0001.h5") else origin_in(file))
    copy = Path(shutil.copy(path / "run-0001.h5", tmp_path / "drop.h5"))
    opened(window, path, wait_for)
    before = window.runs.model.series
    assert (before.kind, before.e.n) == ("measured", 1)

    window.sessions.ask_where = lambda _name: "add"
    window.hardware.choose("replay")
    window.hardware.replay.file.line.setText(str(copy))
    for number in (1, 2):
        window.actions_.record.trigger()
        wait_for(lambda: window.control.state in (AppState.DONE, AppState.FAILED))
        assert window.control.state is AppState.DONE, window.board.notices
        assert window.bar.state.text.startswith(f"FINAL   replay {number}: ")
    assert listed(window) == [("1", "run-0001"), ("R1", "run-0002"), ("R2", "run-0003")]
    assert [entry.verdict.split(", ")[-1] for entry in window.runs.model.entries][1:] == ["REPLAY OF SIMULATED"] * 2
    after = window.runs.model.series
    assert after.e == before.e
    assert set(after.left_out) == {"run-0002", "run-0003"}
    assert window.runs.series.text().endswith("2 left out")

    session = window.control.session
    assert session is not None
    facts = [study(run, session.setup, _stored) for run in session.run_paths()]
    assert series_of([one.drop for one in facts]).e == before.e
    first, *_ = front_chapters(report_facts([SessionFacts(session.info, tuple(facts))], "now"))
    left_out = [block.rows for block in first.blocks if isinstance(block, Grid) and "Not in the mean" in block.title]
    assert left_out[0][0] == ("run-0002", "replay of simulated", "a replay is no drop of its own")
    replays = [entry.drop for entry in window.runs.model.entries[1:]]
    assert series_of(replays).left_out == {"run-0003": "the same drop as run-0002"}


def _stored(path: Path, setup: Any) -> Any:
    from radargui.processing.result_of_run import result_of_run

    return result_of_run(path, setup)


def test_a_simulated_session_says_so_in_window_and_report(window: MainWindow, wait_for: Any, record_one: Any) -> None:
    record_one(window)
    assert " · SIMULATED" in window.windowTitle()
    session = window.control.session
    assert session is not None
    facts = [study(run, session.setup, _stored) for run in session.run_paths()]
    found = report_facts([SessionFacts(session.info, tuple(facts))], "now")
    chapters = [*front_chapters(found), *map(run_page, facts)]
    assert "simulated" in chapters[0].title
    assert "simulated" in chapters[-1].title
    assert "Dev1" not in str(chapters)


def test_the_list_keeps_the_order_of_the_drops_and_the_banner_never_mixes_two(
    window: MainWindow, tmp_path: Path
) -> None:
    model = window.runs.model
    for number in (9999, 1, 2, 10000):
        window.runs.put(RunEntry(tmp_path / f"run-{number:04d}.h5", rejected="no fall" if number == 2 else None))
    assert [(one.label, one.name) for one in model.entries] == [
        ("1", "run-0001"),
        ("–", "run-0002"),
        ("2", "run-9999"),
        ("3", "run-10000"),
    ]
    assert [one.called for one in model.entries] == ["drop 1", "run-0002", "drop 2", "drop 3"]


N_DROPS = 4


def test_drops_with_a_backlog_closed_in_the_middle_are_found_again(
    make_window: Any, setup_path: Path, wait_for: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    go = threading.Event()

    class Held(ProcessingHere):
        """Does the first job, and the others once it may."""

        def process(self, job: Any, progress: Any, *rest: Any) -> Any:
            while job.path.stem != "run-0001" and not go.wait(0.01):
                progress(0.4)
            return super().process(job, progress, *rest)

    clock, told = SeenClock(step_s=0.25), threading.Event()

    def go_on() -> None:
        # the drops are recorded in less time than the first one may need: the second waits for its result, the third
        # until the window has told it
        is_first, is_computed = window.control.run_number < 2, any(one.summary for one in window.runs.model.entries)
        waits = window.control.run_number > 2 and window.control.state is AppState.ARMED
        if told.is_set() or is_first or (is_computed and not waits):
            clock.go_on()

    window = make_window(
        setup_path, source_maker=lambda kind, setup, **options: make_source(kind, setup, clock=clock, **options)
    )
    window.control.processing = Held
    window._timer.setInterval(20)
    window._timer.timeout.connect(go_on)
    model = window.setup_model
    # the cheapest runs there are, in few blocks: this is about their number
    recording = {"pretrigger_s": 0.1, "quiet_s": 0.1, "falls_only": False}
    model.replace(
        changed(
            SETUP,
            recording=recording,
            daq={"read_interval_s": 0.25, "rate_hz": 4000.0},
            # rests that outlast three steps of the clock: the window sees that the third one waits, whatever it does
            simulation={"restitution": 0.3, "rest_s": 1.0},
        )
    )
    model.assign("processing.correction", "none")
    window.bar.runs.setValue(N_DROPS)
    window.actions_.record.trigger()
    # what is computed is told of its own drop, whatever was recorded meanwhile
    wait_for(lambda: " recorded;   drop 1: e = " in window.bar.state.text)
    told.set()
    wait_for(lambda: len(window.control.backlog) == N_DROPS - 1)
    wait_for(lambda: "Waiting for the result of drop 2 (40 % computed" in window.stopping.words.text())
    wait_for(lambda: f"{N_DROPS - 2} more after it" in window.stopping.words.text())
    assert window.stopping.isVisibleTo(window)
    assert [entry.label for entry in window.runs.model.entries] == [str(n + 1) for n in range(N_DROPS)]
    window.may_leave = lambda: pytest.fail("nothing is being recorded")
    window.close()
    wait_for(lambda: f"the results of {N_DROPS - 1} runs" in window.closing.words.text())
    assert "recording" not in window.closing.words.text()
    window.stopping.later.click()
    wait_for(window.isHidden)
    session = window.control.session
    assert session is not None
    assert len(session.run_paths()) == N_DROPS
    session.close()

    monkeypatch.setattr("radargui.experiment.reprocess.ProcessingApart", ProcessingHere)
    again = make_window(setup_path)
    wait_for(lambda: again.later.isVisibleTo(again))
    assert again.later.words.text().startswith(f"{N_DROPS - 1} runs wait for their results, in {session.path.name}")
    again.sessions.open(session.path)
    again.later.accept.click()
    wait_for(lambda: not again.work.busy and not again.jobs.running)
    wait_for(lambda: all(entry.summary for entry in again.runs.model.entries))
    assert len(again.runs.model.entries) == N_DROPS
    again.later.look()
    wait_for(lambda: not again.jobs.running)
    assert again.later.isHidden()


@pytest.mark.slow
def test_what_was_left_for_later_is_computed_in_a_process_of_its_own(
    make_window: Any, setup_path: Path, wait_for: Any
) -> None:
    window = make_window(setup_path)
    # as the program does it, not as the other tests
    window.control.processing = ProcessingApart
    model = window.setup_model
    # the joint fit takes seconds: there is time to leave it
    model.replace(changed(SETUP, processing={"correction": "joint"}, recording={"maximum_s": 0.5}))
    window.actions_.record.trigger()
    wait_for(lambda: window.stopping.isVisibleTo(window))
    window.stopping.later.click()
    wait_for(lambda: not window.control.state.running)
    wait_for(lambda: not multiprocessing.active_children())
    wait_for(lambda: window.later.isVisibleTo(window))
    assert window.later.words.text().startswith("1 run waits for its result")
    (entry,) = window.runs.model.entries
    assert entry.summary is None or entry.summary["preliminary"]
    seen: set[str] = set()
    window.later.accept.click()

    def computed() -> bool:
        seen.update(child.name for child in multiprocessing.active_children())
        (entry,) = window.runs.model.entries
        return entry.summary is not None and not entry.summary.get("preliminary") and not window.work.busy

    wait_for(computed)
    assert seen == {"radargui-processing"}
    wait_for(lambda: not multiprocessing.active_children())


def test_a_full_disk_is_not_hidden_by_clipping_warnings(window: MainWindow, wait_for: Any) -> None:
    full = FileError("run-0007.h5 cannot be written: no space left on device.", remedy="Make room.")
    window.control.failed.emit(full)
    for number in range(1, 50):
        window.control.warned.emit(f"I1 sat at the end of its range in {number} samples", "signal")
    for number in range(60):
        window.board.post("info", f"note {number}")
    worst = window.strip.texts()[0]
    assert "no space left" in worst
    wait_for(lambda: window.strip.texts()[1] == "I1 sat at the end of its range in 49 samples")
    assert window.board.notices[1].count == 49
    window.control._enter(AppState.FAILED)
    assert window.bar.state.text == "FAILED   see the message below"
    window.board.dismiss(window.board.notices[0])
    assert window.bar.state.text == f"FAILED   {full}"


def test_the_report_of_a_session_can_be_opened_where_it_is_there(
    window: MainWindow, wait_for: Any, tmp_path: Path
) -> None:
    path = make_session(tmp_path / "data", 4)
    opened(window, path, wait_for)
    assert not window.runs.open_report.isEnabled()
    (path / "report").mkdir()
    (path / "report" / "report.html").write_text("<p>", encoding="utf-8")
    window.control.use_session(None)
    opened(window, path, wait_for)
    assert window.runs.open_report.isEnabled()


def test_nobody_is_told_that_this_window_writes_to_its_own_session(
    window: MainWindow, wait_for: Any, tmp_path: Path
) -> None:
    opened(window, make_session(tmp_path / "data", 4), wait_for)
    window.actions_.sessions.trigger()
    browser = window.sessions.browser
    wait_for(lambda: not browser.looks.busy)
    browser.table.selectRow(0)
    wait_for(lambda: not window.jobs.running)
    assert "writes to it" not in browser.details.text()


def test_the_preview_follows_the_runs_and_reads_nothing_before_it_is_opened(
    window: MainWindow, wait_for: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    read: list[str] = []

    def noted(path: Path, normal: Any) -> RunFacts:
        read.append(path.stem)
        return glance(path, normal)

    monkeypatch.setattr("radargui.report.facts.glance", noted)
    path = make_session(tmp_path / "data", 4, sample="<b>steel</b>")
    opened(window, path, wait_for)
    wait_for(lambda: not window.jobs.running)
    assert read == []
    window.actions_.preview.trigger()
    page = window.run_controller.report_preview.page
    wait_for(lambda: "run-0001" in page.toPlainText())
    assert "of <b>steel</b>: e = 0.50" in page.toPlainText()
    (second,) = make_session(tmp_path / "other", 5).glob("run-0001.h5")
    second.rename(path / "run-0002.h5")
    window.runs.put(RunEntry(path / "run-0002.h5"))
    wait_for(lambda: "run-0002" in page.toPlainText())
    assert read == ["run-0001", "run-0002"], "a run is read once"
    window.run_controller.report_preview.close()
    window.runs.put(RunEntry(path / "run-0002.h5"))
    wait_for(lambda: not window.jobs.running)
    assert len(read) == 2
