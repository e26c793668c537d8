"""Runs processed with other settings: compared first, kept only where the operator says so."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from PySide6.QtCore import QEvent, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication
from support.gui_sessions import make_session
from support.stored_runs import raw_digest, results_digest

from radargui.files.run_card import read_run_card
from radargui.files.stored_results import read_stored_results
from radargui.gui.main_window import MainWindow
from radargui.gui.mnemonics import without
from radargui.gui.sessions.transfer_controller import ReprocessDialog
from radargui.gui.setup_words import words_of
from radargui.model.errors import CancelledError


@pytest.fixture
def dialog(window: MainWindow, wait_for: Any, tmp_path: Path) -> ReprocessDialog:
    window.sessions.open(make_session(tmp_path / "data", 4, n_runs=2))
    wait_for(lambda: not window.jobs.running)
    window.actions_.compare.trigger()
    assert window.transfer.dialog is not None
    return window.transfer.dialog


def test_old_and_new_are_compared_and_nothing_changes_until_kept(
    window: MainWindow, dialog: ReprocessDialog, wait_for: Any
) -> None:
    session = window.control.session
    assert session is not None
    runs = session.run_paths()
    raw, results = [raw_digest(run) for run in runs], [results_digest(run) for run in runs]
    old = read_run_card(runs[0]).summary["correction"]
    dialog.correction.setCurrentIndex(dialog.correction.findData("ellipse"))
    assert without(dialog.discard.text()) == "Close", "there is nothing to be discarded"
    dialog.compare.click()
    assert not dialog.compare.isEnabled()
    wait_for(lambda: not dialog.work.busy)
    assert without(dialog.discard.text()) == "Discard"
    lines = dialog.table.rows.entries
    assert [line[0] for line in lines if line[0]] == ["run-0001", "run-0002"]
    assert [line[1] for line in lines[:5]] == ["Verdict", "e", "Fall [mm]", "Impact [m/s]", "g [m/s²]"]
    # in the words of the form, as everywhere in the window
    was = words_of("processing.correction").shown(old)
    assert dialog.settings.text() == f"IQ correction: {was} → Static ellipse (Heydemann)"
    assert [results_digest(run) for run in runs] == results
    dialog.keep.click()
    wait_for(lambda: not dialog.work.busy)
    assert "kept" in dialog.words.text()
    assert without(dialog.discard.text()) == "Close"
    for run in runs:
        assert read_run_card(run).summary["correction"] == "ellipse"
        assert [stored.is_present for stored in read_stored_results(run)] == [False, True]
    assert [raw_digest(run) for run in runs] == raw
    wait_for(lambda: (window.runs.model.entries[1].summary or {}).get("correction") == "ellipse")
    window.runs.table.selectRow(1)
    wait_for(lambda: window.run.result is not None)
    assert window.run.result.corrected.method == "ellipse", "the kept result is shown, not the one of the recording"
    window.panels.go_to("run")
    window.run.tabs.setCurrentWidget(window.run.samples)
    wait_for(lambda: len(window.run.samples.plots) == 3)


def test_f8_compares_with_the_setup_in_the_window_and_overwrites_nothing(
    window: MainWindow, wait_for: Any, tmp_path: Path
) -> None:
    window.sessions.open(make_session(tmp_path / "data", 4))
    wait_for(lambda: window.runs.model.entries and not window.jobs.running)
    window.activateWindow()
    wait_for(window.isActiveWindow)
    window.panels.go_to("runs")
    window.runs.table.selectRow(0)
    (run,) = window.control.session.run_paths()
    before, e = results_digest(run), window.runs.model.entries[0].restitution()
    window.setup_model.assign("processing.correction", "ellipse")
    QTest.keyClick(window, Qt.Key.Key_F8)
    dialog = window.transfer.dialog
    assert isinstance(dialog, ReprocessDialog)
    assert dialog.what.currentText().startswith("The chosen run, drop 1")
    assert dialog.setup.currentText() == "Setup in the window", "an edit of one's own setup ends the review"
    assert not window.work.busy, "nothing is computed before it is asked for"
    dialog.compare.click()
    wait_for(lambda: not dialog.work.busy)
    stored, new = next(line[2:4] for line in dialog.table.rows.entries if line[1] == "e")
    assert stored == e != new
    dialog.discard.click()
    assert (results_digest(run), window.runs.model.entries[0].restitution()) == (before, e)

    # Shift+F8 begins with what the run was recorded with
    window.actions_.compare.trigger()
    assert window.transfer.dialog is not dialog
    assert window.transfer.dialog.setup.currentText() == "As recorded"


def test_discarding_or_cancelling_leaves_the_stored_results(
    window: MainWindow, dialog: ReprocessDialog, wait_for: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    session = window.control.session
    assert session is not None
    before = [run.read_bytes() for run in session.run_paths()]
    dialog.compare.click()
    wait_for(lambda: not dialog.work.busy)
    assert "same as" in dialog.settings.text()
    assert dialog.keep.isEnabled()

    wait_for(lambda: not window.jobs.running)

    def cancelled(_task: object, _share: float) -> None:
        raise CancelledError

    monkeypatch.setattr("radargui.gui.background.Task.report", cancelled)
    dialog.keep.click()
    wait_for(lambda: not dialog.work.busy)
    assert "Cancelled" in dialog.words.text()
    dialog.discard.click()
    assert not dialog.isVisible()
    assert [run.read_bytes() for run in session.run_paths()] == before


def test_a_damaged_run_is_told_and_the_others_are_compared(
    window: MainWindow, dialog: ReprocessDialog, wait_for: Any
) -> None:
    session = window.control.session
    assert session is not None
    session.run_paths()[0].write_bytes(b"no run any more")
    dialog.compare.click()
    wait_for(lambda: not dialog.work.busy)
    lines = dialog.table.rows.entries
    assert lines[0][:2] == ("run-0001", "failed")
    assert lines[1][:2] == ("run-0002", "Verdict")


def test_a_dialog_closed_while_it_works_takes_its_answer_without_a_fault(
    window: MainWindow, dialog: ReprocessDialog, wait_for: Any, qtbot: Any
) -> None:
    dialog.compare.click()
    window.transfer.close()
    QApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete)
    with qtbot.captureExceptions() as faults:
        wait_for(lambda: not window.jobs.running)
    assert not faults
    assert not [notice for notice in window.board.notices if notice.level == "error"]
