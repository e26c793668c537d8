"""Sessions in the window: found, looked at, opened for review, noted."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from datetime import date, datetime
from pathlib import Path
from threading import Event
from typing import Any

import pytest
from PySide6.QtCore import QRectF
from PySide6.QtGui import QPainter
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot
from support.gui_sessions import make_session
from support.run_contents import read_markers

from radargui.files.run_writer import RunWriter
from radargui.gui.control.state import AppState
from radargui.gui.main_window import MainWindow
from radargui.gui.runs import run_controller, thumbnails
from radargui.gui.runs.run_model import RunEntry, RunModel
from radargui.gui.runs.thumbnails import ThumbnailView, curves
from radargui.gui.sessions.browser import COLUMNS, day_of
from radargui.gui.theme import Theme
from radargui.session.info import JournalEntry, read_info
from radargui.session.lock import owner_of
from radargui.session.session import Session


@pytest.fixture
def data_folder(tmp_path: Path) -> Path:
    folder = tmp_path / "data"
    make_session(folder, 4, operator="Ada", sample="steel sphere", notes="glass <b>plate</b>")
    make_session(folder, 9, n_runs=2, operator="Grace", target="steel plate")
    return folder


def found(window: MainWindow) -> list[str]:
    return [one.operator for one in window.sessions.browser.model.entries]


def searched(window: MainWindow, wait_for: Any, **texts: str) -> list[str]:
    browser = window.sessions.browser
    for name, field in browser.search.fields.items():
        field.setText(texts.get(name, ""))
    browser.search.changed.emit()
    wait_for(lambda: not browser.looks.busy)
    return found(window)


def test_sessions_are_found_again_and_their_runs_seen(data_folder: Path, window: MainWindow, wait_for: Any) -> None:
    window.actions_.sessions.trigger()
    browser = window.sessions.browser
    wait_for(lambda: not browser.looks.busy)
    assert found(window) == ["Grace", "Ada"]
    assert "2 sessions with 3 runs" in browser.words.text()
    e, _, rest = browser.model.index(1, 5).data().partition(" ± ")
    assert float(e) == pytest.approx(0.5, abs=0.01)
    assert rest.endswith(", simulated"), "a single drop has an uncertainty and no range"
    for texts, wanted in (
        ({"operator": "ada"}, ["Ada"]),
        ({"sample": "steel"}, ["Grace", "Ada"]),
        ({"text": "glass"}, ["Ada"]),
        ({"since": "2026-05-05"}, ["Grace"]),
        ({"until": "2026-05-05"}, ["Ada"]),
        ({"since": "2026", "until": "2026-05"}, ["Grace", "Ada"]),
        ({"until": "2025"}, []),
        ({"e_min": "0.9"}, []),
        ({"e_min": "0,2", "e_max": "0.9"}, ["Grace", "Ada"]),
    ):
        assert searched(window, wait_for, **texts) == wanted, texts
    assert searched(window, wait_for, since="yesterday") == ["Grace", "Ada"]
    assert [name for name, one in browser.search.faults.items() if not one.isHidden()] == ["since"]
    assert browser.search.faults["since"].text() == "Write it as 2026-01-31"

    browser.table.selectRow(0)
    wait_for(lambda: len(browser.runs.entries) == 2)
    look = browser.runs.entries[0]
    assert look.thumbnail is not None
    assert sum(curve.size() for curve in curves(look.thumbnail, QRectF(0, 0, 100, 50))) > 50
    browser.thumbnails.grab()


def test_a_month_or_a_year_alone_is_all_of_it() -> None:
    assert (day_of("2024"), day_of("2024", last=True)) == (date(2024, 1, 1), date(2024, 12, 31))
    assert (day_of("2024-02"), day_of("2024-02", last=True)) == (date(2024, 2, 1), date(2024, 2, 29))
    assert day_of("2024-02-03", last=True) == date(2024, 2, 3)
    for text in ("yesterday", "24", "2024-13", "2024-02-30", "2024-02-03-04"):
        with pytest.raises(ValueError, match=r"month|day|isoformat"):
            day_of(text)


def test_the_columns_of_the_sessions_are_read_whole(data_folder: Path, window: MainWindow, wait_for: Any) -> None:
    window.resize(1366, 768)
    window.actions_.sessions.trigger()
    browser = window.sessions.browser
    wait_for(lambda: browser.model.entries and not browser.looks.busy)
    assert browser.table.horizontalScrollBar().maximum() == 0
    for column, title in enumerate(COLUMNS):
        assert browser.table.sizeHintForColumn(column) <= browser.table.columnWidth(column), title


def test_a_session_is_opened_for_review_and_its_setup_taken(
    data_folder: Path, window: MainWindow, wait_for: Any
) -> None:
    window.actions_.sessions.trigger()
    browser = window.sessions.browser
    wait_for(lambda: not browser.looks.busy)
    browser.table.selectRow(1)
    browser.review.click()
    wait_for(lambda: window.control.session is not None)
    assert not window.control.session.read_only
    assert window.session_panel.details.operator == "Ada"
    assert window.session_panel.details.sample == "steel sphere"
    wait_for(lambda: window.runs.model.entries and window.runs.model.entries[0].summary)
    browser.take_setup.click()
    wait_for(lambda: window.control.session is None)
    assert window.setup_model.own_setup.daq.rate_hz == 2000.0
    assert window.setup_model.path is None
    wait_for(lambda: not window.jobs.running)
    assert all(owner_of(path) is None for path in data_folder.iterdir()), "other programs may write to it now"


def test_sessions_chosen_together_are_reported_as_a_series(
    data_folder: Path, own_window: MainWindow, wait_for: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    own_window.actions_.sessions.trigger()
    browser = own_window.sessions.browser
    wait_for(lambda: not browser.looks.busy)
    browser.table.selectRow(0)
    assert not browser.series.isEnabled()
    browser.table.selectAll()
    assert not browser.review.isEnabled()
    monkeypatch.setattr("PySide6.QtWidgets.QFileDialog.getExistingDirectory", lambda *_: str(tmp_path / "series"))
    browser.series.click()
    wait_for(lambda: not own_window.work.busy)
    document = json.loads((tmp_path / "series" / "report.json").read_text(encoding="utf-8"))
    assert [one["session"]["operator"] for one in document["sessions"]] == ["Grace", "Ada"]
    assert (tmp_path / "series" / "report.pdf").stat().st_size


OTHER_PROGRAM = """
import sys
from pathlib import Path
from radargui.session.lock import SessionLock
lock = SessionLock(Path(sys.argv[1]))
print("held", flush=True)
sys.stdin.read()
"""


@pytest.fixture
def held_elsewhere() -> Iterator[Callable[[Path], None]]:
    """Let another program write to a session until the test has ended."""
    with ExitStack() as programs:

        def hold(folder: Path) -> None:
            program = subprocess.Popen(
                [sys.executable, "-c", OTHER_PROGRAM, str(folder)], stdin=subprocess.PIPE, stdout=subprocess.PIPE
            )
            programs.enter_context(program)
            programs.callback(program.stdin.close)
            assert program.stdout.readline()

        yield hold


def test_a_session_that_another_program_writes_is_opened_for_looking(
    data_folder: Path, window: MainWindow, wait_for: Any, held_elsewhere: Callable[[Path], None]
) -> None:
    path = sorted(data_folder.iterdir())[0]
    before = (path / "session.json").read_bytes()
    held_elsewhere(path)
    window.sessions.open(path)
    wait_for(lambda: window.strip.texts() and not window.jobs.running)
    assert "opened for looking only" in window.strip.texts()[0]
    assert window.session_panel._notes.isReadOnly()
    assert not window.session_panel._keep_mark.isEnabled()
    window.session_panel.details_changed.emit()
    window.sessions.flush()
    window.runs.table.selectRow(0)
    wait_for(lambda: window.run.result is not None)
    assert (path / "session.json").read_bytes() == before
    assert not [notice for notice in window.board.notices if notice.level == "error"]


def test_sample_target_and_notes_of_a_moment_are_kept(
    window: MainWindow, wait_for: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    # the short run of a test must not end before its note is written
    marked, mark, close = Event(), Session.mark, RunWriter.close

    def mark_and_tell(session: Session, text: str, *, now: datetime) -> JournalEntry:
        entry = mark(session, text, now=now)
        marked.set()
        return entry

    def close_when_marked(writer: RunWriter) -> None:
        marked.wait(10.0)
        close(writer)

    monkeypatch.setattr(Session, "mark", mark_and_tell)
    monkeypatch.setattr(RunWriter, "close", close_when_marked)
    panel = window.session_panel
    panel._lines["Sample"].setText("glass sphere")
    panel._lines["Target"].setText("granular bed")
    window.actions_.record.trigger()
    wait_for(lambda: window.control.session is not None and window.control.session.recording is not None)
    panel.mark.setText("door slammed")
    panel._keep_mark.click()
    wait_for(lambda: window.control.state in (AppState.DONE, AppState.FAILED))
    wait_for(lambda: "door slammed" in panel._marked.text())
    session = window.control.session
    assert session is not None
    info = read_info(session.path)
    assert (info.sample, info.target, info.setup_name) == ("glass sphere", "granular bed", "lab")
    (entry,) = info.journal
    assert entry.text == "door slammed"
    assert entry.run == "run-0001.h5"
    (marker,) = read_markers(session.path / entry.run)
    assert marker.index == entry.index


def test_nothing_of_an_earlier_run_stands_beneath_the_name_of_another(
    tmp_path: Path, own_window: MainWindow, wait_for: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    session = make_session(tmp_path / "data", 3, n_runs=3)
    (session / "run-0002.h5").write_bytes(b"no run")
    goes_on = Event()
    read = run_controller._result_of

    def slowly(path: Path, *more: Any) -> Any:
        if path.name == "run-0003.h5":
            goes_on.wait(60.0)
        return read(path, *more)

    monkeypatch.setattr(run_controller, "_result_of", slowly)
    own_window.sessions.open(session)
    panel, table = own_window.run, own_window.runs.table
    wait_for(lambda: len(own_window.runs.model.entries) == 3)
    own_window.panels.go_to("run")
    table.choose(lambda one: one.path.name == "run-0001.h5")
    wait_for(lambda: "e of the first impact" in panel.figures.toPlainText())
    # samples are drawn once they are looked at
    panel.tabs.setCurrentWidget(panel.samples)
    wait_for(lambda: panel.samples.plots != [])
    panel.tabs.setCurrentWidget(panel.tabs.page("methods"))
    assert any(box.isChecked() for box in panel.tabs.page("methods").boxes.values())
    # a damaged one
    table.choose(lambda one: one.path.name == "run-0002.h5")
    wait_for(lambda: "cannot be shown" in panel._title.text())
    wait_for(lambda: not own_window.jobs.running)
    assert panel.result is None
    assert panel.figures.toPlainText() == ""
    assert panel.samples.plots == []
    panel.tabs.setCurrentWidget(panel.tabs.page("steps"))
    QApplication.processEvents()
    own_window.empty.refresh()
    assert own_window.empty.labels["run"].text() == "This run cannot be shown."
    methods = panel.tabs.page("methods")
    panel.tabs.setCurrentWidget(methods)
    assert not methods.compute.isEnabled()
    assert not any(box.isChecked() or box.isEnabled() for box in methods.boxes.values())
    panel.tabs.setCurrentWidget(panel.figures)
    # one that takes its time
    table.choose(lambda one: one.path.name == "run-0001.h5")
    wait_for(lambda: panel.figures.toPlainText())
    table.choose(lambda one: one.path.name == "run-0003.h5")
    wait_for(lambda: panel.figures.toPlainText() == "")
    assert "run-0003" in panel._title.text()
    goes_on.set()
    wait_for(lambda: "e of the first impact" in panel.figures.toPlainText())
    assert panel._title.text().startswith("drop 3")


def test_a_long_reason_stays_within_its_picture(theme: Theme, qtbot: QtBot, monkeypatch: pytest.MonkeyPatch) -> None:
    runs = RunModel()
    view = ThumbnailView(theme, runs)
    qtbot.addWidget(view)
    view.resize(400, 150)
    problem = "it cannot be read as a run file, however long one looks. " * 4
    runs.replace_all([RunEntry(Path("run-0001.h5"), problem=problem)])
    written: list[tuple[QRectF, str]] = []
    draw = thumbnails.write

    def write(painter: QPainter, box: QRectF, words: str, *how: Any) -> None:
        written.append((box, words))
        draw(painter, box, words, *how)

    monkeypatch.setattr(thumbnails, "write", write)
    view.grab()
    box, words = written[-1]
    assert words.startswith("it cannot")
    assert words.endswith("…")
    assert (words.count("\n") + 1) * view.fontMetrics().height() <= box.height()
