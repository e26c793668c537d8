"""What a newcomer does: undo, the palette, the views of a run, what is dropped; each in a few actions."""

from __future__ import annotations

import math
import threading
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PySide6.QtCore import QMimeData, QPoint, QPointF, Qt, QUrl
from PySide6.QtGui import QDragEnterEvent, QDropEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QLineEdit

from radargui.experiment.processing_apart import ProcessingHere
from radargui.gui.control.state import AppState
from radargui.gui.main_window import MainWindow
from radargui.gui.palette import rank
from radargui.gui.panels import HelpBrowser
from radargui.gui.runs.run_panel import VIEWS

CONTROL, SHIFT = Qt.KeyboardModifier.ControlModifier, Qt.KeyboardModifier.ShiftModifier


def settle() -> None:
    for _ in range(3):
        QApplication.processEvents()


def field(window: MainWindow, key: str) -> QLineEdit:
    window.go_to_field(key)
    settle()
    return next(one for one in window.findChildren(QLineEdit) if one.objectName() == key)


def typed(line: QLineEdit, text: str) -> None:
    line.setFocus()
    line.selectAll()
    QTest.keyClicks(line, text)


@pytest.fixture
def clean(active: MainWindow) -> MainWindow:
    """The window as nobody has edited anything in it yet."""
    active.history.clear()
    return active


def test_edits_of_all_panels_are_taken_back_one_by_one_and_done_again(clean: MainWindow) -> None:
    model, before = clean.setup_model, clean.setup_model.setup
    diameter = field(clean, "tracer.diameter_m")
    typed(diameter, "12.5")
    typed(field(clean, "receiver[1].tilt_deg"), "41")
    clean.panels.go_to("session")
    sample = next(one for one in clean.findChildren(QLineEdit) if one.objectName() == "session.sample")
    typed(sample, "steel")
    QTest.keyClick(sample, Qt.Key.Key_Tab)
    assert clean.history.count() == 3, "what is typed in one go is one edit"
    undo, redo = clean.actions_.undo, clean.actions_.redo
    undo.trigger()
    assert clean.session_panel.details.sample == ""
    undo.trigger()
    assert model.value("receiver[1].tilt_deg") == before.receiver[0].tilt_deg
    assert model.value("tracer.diameter_m") == pytest.approx(0.0125)
    undo.trigger()
    assert model.setup == before
    assert not undo.isEnabled()
    for _ in range(3):
        redo.trigger()
    assert model.value("tracer.diameter_m") == pytest.approx(0.0125)
    assert model.value("receiver[1].tilt_deg") == 41.0
    assert clean.session_panel.details.sample == "steel"
    assert not redo.isEnabled()


def test_a_field_takes_back_what_is_typed_in_it_and_then_the_window_goes_on(clean: MainWindow) -> None:
    before = clean.setup_model.setup
    typed(field(clean, "receiver[1].tilt_deg"), "41")
    line = field(clean, "tracer.diameter_m")
    typed(line, "12")
    QTest.keyClick(line, Qt.Key.Key_Z, CONTROL)
    assert clean.setup_model.value("tracer.diameter_m") != pytest.approx(0.012)
    assert clean.setup_model.value("receiver[1].tilt_deg") == 41.0
    while line.isUndoAvailable():
        QTest.keyClick(line, Qt.Key.Key_Z, CONTROL)
    # nothing is left in the field: the window's own steps, of which its own is one
    for _ in range(2):
        QTest.keyClick(line, Qt.Key.Key_Z, CONTROL)
    assert clean.setup_model.setup == before


def test_another_setup_that_was_opened_is_taken_back_with_its_file(clean: MainWindow, tmp_path: Path) -> None:
    model, path = clean.setup_model, clean.setup_model.path
    other = tmp_path / "other.toml"
    assert path is not None
    other.write_text(path.read_text(encoding="utf-8").replace("diameter_m = 0.01", "diameter_m = 0.02"), "utf-8")
    clean.arrivals.open([other])
    assert model.path == other
    clean.actions_.undo.trigger()
    assert model.path == path
    assert not model.modified
    clean.actions_.redo.trigger()
    assert model.path == other


def test_letters_in_their_order_find_a_command() -> None:
    assert rank("mkrep", "Make report") is not None
    assert rank("rm", "Make report") is None
    near, far = rank("rep", "Make report"), rank("rep", "Report as a series of drops")
    assert near == far == 0
    assert rank("rep", "Process run again") is None
    assert rank("pra", "Process run again") == 0
    assert (rank("oce", "Process run again") or 0) > 0


def test_the_palette_does_what_the_menus_do_and_says_why_not(clean: MainWindow) -> None:
    palette = clean.palette_
    QTest.keyClick(clean, Qt.Key.Key_K, CONTROL)
    settle()
    assert palette.isVisible()
    QTest.keyClicks(palette.line, "undo")
    first = palette.table.rows.entries[0]
    assert first == ("Undo", "Ctrl+Z", "not now: nothing was edited")
    QTest.keyClick(palette.line, Qt.Key.Key_Return)
    assert palette.isVisible(), "what cannot be done is not done"
    palette.line.clear()
    QTest.keyClicks(palette.line, "analyse")
    QTest.keyClick(palette.line, Qt.Key.Key_Return)
    settle()
    assert not palette.isVisible()
    assert clean.panels.workspace == "analyse"
    clean.actions_.palette.trigger()
    QTest.keyClicks(palette.line, "waterf")
    QTest.keyClick(palette.line, Qt.Key.Key_Return)
    assert clean.run.chosen == "waterfall"


def test_every_view_of_a_run_shares_one_moment(clean: MainWindow, record_one: Any, wait_for: Any) -> None:
    record_one(clean)
    clean.panels.work_in("analyse")
    wait_for(lambda: clean.run.result is not None)
    run = clean.run
    wait_for(lambda: math.isfinite(run.instant.at_s))
    assert run.result is not None
    zero_s = run.result.zero[0]
    for name in VIEWS:
        run.choose(name)
        settle()
        assert run.chosen == name
    run.choose("height")
    plot = run.tabs.page("track").curves.height_plot
    wait_for(lambda: plot.curve.getData()[0] is not None and plot.curve.getData()[0].size > 10)
    # a click, and the arrow keys of the plot of the whole run
    place = plot.mapFromScene(plot.view.mapViewToScene(QPointF(0.1, 0.0)))
    QTest.mouseClick(plot.viewport(), Qt.MouseButton.LeftButton, pos=place)
    wait_for(lambda: run.instant.at_s == pytest.approx(zero_s + 0.1, abs=0.01))
    run.overview.setFocus()
    before = run.instant.at_s
    QTest.keyClick(run.overview, Qt.Key.Key_Right)
    assert before < run.instant.at_s < before + 0.1
    said = run._there.text()
    assert said.startswith("t = 0.1")
    assert "z +" in said
    run.choose("steps")
    wait_for(lambda: run.tabs.page("steps").key.text())
    lines = [line for own, (line, _) in run.instant._lines.items() if own in run.tabs.page("steps")._plots]
    assert {round(line.value(), 6) for line in lines if line.isVisible()} == {round(run.instant.at_s - zero_s, 6)}


def test_dragging_over_a_plot_says_duration_frequency_and_speed(clean: MainWindow) -> None:
    plot = clean.track.curves.height_plot
    plot.measure(QPointF(-2.0, 100.0), QPointF(-1.9, 0.0))
    assert plot.cursors is not None
    assert "10 Hz" in plot.cursors.text
    assert plot.cursors.text.endswith("-1 m/s")
    plot.show_cursors(False)


def test_what_is_dropped_is_opened_or_imported_and_found_among_the_recent(
    clean: MainWindow, tmp_path: Path, wait_for: Any
) -> None:
    table = np.column_stack([np.arange(200) / 1000.0, np.random.default_rng(1).normal(size=(200, 6))])
    recording = tmp_path / "drop.csv"
    np.savetxt(recording, table, delimiter=",", header="time_s,I1,Q1,I2,Q2,I3,Q3", comments="")
    data = QMimeData()
    data.setUrls([QUrl.fromLocalFile(str(recording))])
    left, none = Qt.MouseButton.LeftButton, Qt.KeyboardModifier.NoModifier
    copy = Qt.DropAction.CopyAction
    QApplication.sendEvent(clean, QDragEnterEvent(QPoint(50, 50), copy, data, left, none))
    QApplication.sendEvent(clean, QDropEvent(QPointF(50, 50), copy, data, left, none))
    dialog = clean.transfer.dialog
    assert dialog is not None
    assert dialog.isVisible()
    wait_for(dialog.go.isEnabled)
    dialog.go.click()
    wait_for(lambda: clean.control.session is not None)
    session = clean.control.session
    assert session is not None
    clean.actions_.new_session.trigger()
    recent = [action for action in clean.arrivals._menu.actions() if session.path.name in action.text()]
    recent[0].trigger()
    wait_for(lambda: clean.control.session is not None and clean.control.session.path == session.path)


def test_f1_opens_the_page_of_what_has_the_keys(clean: MainWindow, monkeypatch: pytest.MonkeyPatch) -> None:
    # without a browser it is shown here
    monkeypatch.setattr("PySide6.QtGui.QDesktopServices.openUrl", lambda _url: False)
    for panel, page in (("antennas", "calibration"), ("browser", "series-of-drops"), ("hardware", "setup-file")):
        clean.panels.go_to(panel)
        settle()
        clean.actions_.help.trigger()
        browser = clean.findChildren(HelpBrowser)[-1]
        assert Path(browser.pages.source().toLocalFile()).stem == page
        browser.close()


def test_a_rejected_run_counts_again_by_undo(clean: MainWindow, record_one: Any, wait_for: Any) -> None:
    record_one(clean)
    clean.actions_.reject.trigger()
    wait_for(lambda: clean.runs.model.entries[0].rejected)
    clean.actions_.undo.trigger()
    wait_for(lambda: not clean.runs.model.entries[0].rejected)
    clean.actions_.redo.trigger()
    wait_for(lambda: clean.runs.model.entries[0].rejected)


def test_the_list_of_runs_is_pictures_or_a_table(clean: MainWindow, record_one: Any, wait_for: Any) -> None:
    record_one(clean)
    clean.panels.work_in("analyse")
    clean.panels.reset()
    settle()
    pictures, table = clean.runs.pictures, clean.runs.table
    assert pictures.isVisible()
    assert not table.isVisible()
    wait_for(lambda: clean.runs.model.entries[0].thumbnail is not None)
    table.clearSelection()
    centre = pictures.visualRect(pictures.model().index(0, 0)).center()
    QTest.mouseClick(pictures.viewport(), Qt.MouseButton.LeftButton, pos=QPoint(centre))
    assert table.chosen is clean.runs.model.entries[0]
    clean.actions_.turn_runs.trigger()
    settle()
    assert table.isVisible()
    clean.actions_.turn_runs.trigger()
    settle()
    assert pictures.isVisible()


def test_a_further_run_is_recorded_while_a_former_one_is_computed(
    clean: MainWindow, wait_for: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    go = threading.Event()

    class Held(ProcessingHere):
        """Computes once it may, or is told to end."""

        def process(self, job: Any, progress: Any, *rest: Any) -> Any:
            while not go.wait(0.01):
                progress(0.5)
            return super().process(job, progress, *rest)

    clean.control.processing = Held
    monkeypatch.setattr("radargui.experiment.reprocess.ProcessingApart", ProcessingHere)
    record, control = clean.actions_.record, clean.control
    record.trigger()
    wait_for(lambda: control.state is AppState.PROCESSING)
    assert record.isEnabled()
    record.trigger()
    assert not record.isEnabled()
    wait_for(lambda: control.state in (AppState.ARMED, AppState.RECORDING))
    # the former one has its result while the next is recorded or computed
    wait_for(lambda: len(clean.runs.model.entries) == 2 and clean.runs.model.entries[0].has_e)
    assert control.state is AppState.PROCESSING
    go.set()
    wait_for(lambda: control.state is AppState.DONE)
    assert [entry.has_e for entry in clean.runs.model.entries] == [True, True]
