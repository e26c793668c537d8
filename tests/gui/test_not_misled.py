"""Keys, wheel, tabs, estimates, buttons, sounds: nothing happens unseen, nothing is taken away from who looks at it."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from PySide6.QtCore import QEvent, QPoint, QPointF, Qt
from PySide6.QtGui import QKeyEvent, QWheelEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QMessageBox
from support.fake_clock import FakeClock
from support.gui_sessions import make_session

from radargui.gui.control.state import AppState, Asked, Backlog
from radargui.gui.control.waiting import StoppingStrip
from radargui.gui.main_window import MainWindow
from radargui.gui.runs.across import AcrossView
from radargui.gui.runs.run_list_panel import words_of
from radargui.gui.series import COLUMNS, SeriesRow
from radargui.gui.setup.fields import LineField
from radargui.restitution.series import Series
from radargui.restitution.statistics import statistics_of
from radargui.session.catalogue import default_index_path


def test_the_key_that_undoes_a_value_is_not_taken_by_qt(active: MainWindow) -> None:
    (field,) = [one for one in active.findChildren(LineField) if one.key == "simulation.restitution"]
    active.setup_model.assign("simulation.restitution", 0.7)
    field.setFocus()
    control = Qt.KeyboardModifier.ControlModifier
    asked = QKeyEvent(QEvent.Type.ShortcutOverride, Qt.Key.Key_U, control)
    QApplication.sendEvent(field, asked)
    assert not asked.isAccepted(), "a key that is accepted here empties the field on Linux"
    QTest.keyClick(field, Qt.Key.Key_U, control)
    assert field.text() == "0.6"
    assert not active.setup_model.modified


@pytest.mark.parametrize("steps", [120, -120])
def test_the_wheel_over_runs_changes_nothing(active: MainWindow, steps: int) -> None:
    runs = active.bar.runs
    runs.setValue(5)
    runs.setFocus()
    at = QPointF(runs.rect().center())
    no = (Qt.MouseButton.NoButton, Qt.KeyboardModifier.NoModifier, Qt.ScrollPhase.NoScrollPhase)
    QApplication.sendEvent(runs, QWheelEvent(at, at, QPoint(), QPoint(0, steps), *no, False))
    assert runs.value() == 5


def test_a_result_in_the_background_takes_no_tab_away(window: MainWindow, wait_for: Any, tmp_path: Path) -> None:
    window.sessions.open(make_session(tmp_path / "data", 4))
    wait_for(lambda: window.runs.model.entries and not window.jobs.running)
    window.panels.go_to("runs")
    window.runs.table.selectRow(0)
    wait_for(lambda: not window.jobs.running)
    assert window.run.isVisible(), "who chooses a run wants to see it"
    window.panels.go_to("scopes")
    wait_for(lambda: window.scopes.isVisible() and not window.run.isVisible())
    # as it comes where runs were computed that had been left for later
    window.later.computed.emit()
    wait_for(lambda: not window.jobs.running)
    assert window.runs.table.chosen is not None
    assert window.scopes.isVisible()
    assert not window.run.isVisible()


def test_the_time_that_is_left_never_grows(qtbot: Any) -> None:
    clock, reached = FakeClock(), SimpleNamespace(asked=Asked.NOTHING)
    backlog = Backlog([Path("run-0001.h5")])
    control: Any = SimpleNamespace(state=AppState.PROCESSING, backlog=backlog, reached=reached, progress=0.0)
    strip = StoppingStrip(control, clock.now)
    qtbot.addWidget(strip)
    left: list[float] = []
    # it stalls at 40 %, and comes late
    for share in (0.0, 0.1, 0.2, 0.3, 0.4, *[0.4] * 12, 0.41, 0.5, 0.6, 0.9):
        control.progress = share
        strip.look("drop 1")
        words = strip.words.text()
        if "about " in words:
            left.append(float(words.partition("about ")[2].partition(" s left")[0]))
        clock.advance(1.0)
    assert left[0] > 3.0
    assert left == sorted(left, reverse=True)
    assert "left" not in strip.words.text(), "later than foretold: nothing is foretold any more"


def test_where_no_program_opens_a_report_its_first_page_is_shown(
    window: MainWindow, wait_for: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = make_session(tmp_path / "data", 4)
    (path / "report").mkdir()
    (path / "report" / "report.html").write_text("<p>", encoding="utf-8")
    monkeypatch.setattr("PySide6.QtGui.QDesktopServices.openUrl", lambda _url: False)
    window.sessions.open(path)
    wait_for(lambda: window.runs.open_report.isEnabled())
    window.runs.open_report.trigger()
    preview = window.run_controller.report_preview
    wait_for(lambda: preview.isVisible() and "run-0001" in preview.page.toPlainText())
    assert "No program here shows reports, its first page is shown instead" in window.board.notices[0].text
    window.runs.open_folder.trigger()
    assert str(path) in window.board.notices[0].text


def test_a_second_window_on_the_same_folder_is_told(
    make_window: Any, setup_path: Path, tmp_path: Path, wait_for: Any, board: Any
) -> None:
    place = default_index_path(tmp_path / "data").with_suffix(".window")
    place.mkdir(parents=True)
    holds = (
        "import sys; from pathlib import Path; from radargui.session.lock import SessionLock; "
        f"lock = SessionLock(Path({str(place)!r})); print('held', flush=True); sys.stdin.read()"
    )
    with subprocess.Popen([sys.executable, "-c", holds], stdin=subprocess.PIPE, stdout=subprocess.PIPE) as other:
        assert other.stdout is not None
        assert other.stdout.readline().strip() == b"held"
        make_window(setup_path)
        wait_for(lambda: any("A second window works in" in one.text for one in board.notices))
        said = next(one.text for one in board.notices if "second window" in one.text)
        assert f"process {other.pid} on this computer" in said
        other.communicate()
    board.clear()
    window = make_window(setup_path)
    wait_for(lambda: window.sessions._right is not None)
    assert board.notices == ()


def test_which_sounds_are_on_is_seen_in_both_windows(window: MainWindow) -> None:
    does = window.actions_
    does.across.setChecked(True)
    (across,) = window.findChildren(AcrossView)
    assert window.bar.sound.toolTip() == across.situation.sound == "Sound: result, fault"
    for switch in (does.sound, does.sound_fault):
        switch.setChecked(False)
    assert window.bar.sound.toolTip() == across.situation.sound == "Sound off"
    does.sound_trigger.setChecked(True)
    assert window.bar.sound.toolTip() == across.situation.sound == "Sound: trigger"
    does.across.setChecked(False)
    for switch, on in ((does.sound, True), (does.sound_fault, True), (does.sound_trigger, False)):
        switch.setChecked(on)


def test_who_presses_enter_while_a_run_is_recorded_stays(
    own_window: MainWindow, monkeypatch: pytest.MonkeyPatch
) -> None:
    button = QMessageBox.StandardButton
    asked: list[Any] = []

    def pressed_enter(_parent: Any, _title: str, _words: str, _buttons: Any, default: Any) -> Any:
        asked.append(default)
        return default

    monkeypatch.setattr("PySide6.QtWidgets.QMessageBox.question", pressed_enter)
    assert not MainWindow.may_leave(own_window)
    assert asked == [button.No]


def test_digits_of_a_series_are_those_that_u_leaves() -> None:
    e = [0.6, 0.6 + 3.0e-7, 0.6 - 3.0e-7]
    row = SeriesRow("a", "e", statistics_of(e, [2e-4] * 3, [2.4e-4] * 3))
    cells = {title.replace("\n", " "): text(row) for title, text in COLUMNS.items()}
    assert cells["Mean"] == "0.60000"
    assert cells["Standard deviation"] == cells["Standard error"] == "< 0.00001"
    # the same beside the last drops
    shown = words_of(Series(e=row.found))
    assert shown.startswith("n = 3   mean 0.60000 ± ")
    assert shown.endswith("   s < 0.00001")
    scattered = SeriesRow("a", "e", statistics_of([0.59, 0.60, 0.61], [2e-4] * 3, [2.4e-4] * 3))
    assert COLUMNS["Standard\ndeviation"](scattered) == "0.0100"
