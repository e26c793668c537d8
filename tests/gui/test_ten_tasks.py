"""Ten tasks of a newcomer, each by the keys alone and by the mouse alone, in at most six actions.

An action is a key or a chord, a click, or a word that is typed in one go; what the system asks (which file) is none.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtGui import QKeySequence
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QComboBox, QFileDialog, QLabel, QLineEdit, QMenu, QPushButton, QWidget
from support.calibrations import calibration_of
from support.gui_sessions import make_session

from radargui.experiment.calibrating import CalibrationOrder
from radargui.files.run_card import read_run_card
from radargui.gui.control.state import AppState
from radargui.gui.main_window import MainWindow
from radargui.gui.mnemonics import without
from radargui.gui.panels import WORKSPACES

MAX_ACTIONS = 6
WAYS = ("keys", "mouse")
LEFT = Qt.MouseButton.LeftButton


def settle() -> None:
    for _ in range(3):
        QApplication.processEvents()


class Hands:
    """Does what hands can do, and counts it; the mouse reaches only what is seen."""

    def __init__(self, window: MainWindow) -> None:
        self.window, self.n_actions = window, 0

    def _acts(self) -> None:
        self.n_actions += 1
        assert self.n_actions <= MAX_ACTIONS

    def key(self, keys: str) -> None:
        self._acts()
        chord = QKeySequence(keys)[0]
        target = QApplication.focusWidget() or QApplication.activeWindow() or self.window
        QTest.keyClick(target, chord.key(), chord.keyboardModifiers())
        settle()

    def letter(self, words: str) -> None:
        """Press Alt and the letter of what stands in the dialog in front."""
        front = QApplication.activeWindow()
        assert front is not None
        parts = [*front.findChildren(QPushButton), *front.findChildren(QLabel)]
        (letter,) = {
            QKeySequence.mnemonic(one.text()).toString()
            for one in parts
            if one.isVisible() and without(one.text()) == words
        }
        assert letter, words
        self.key(letter)

    def write(self, text: str) -> None:
        self._acts()
        line = QApplication.focusWidget()
        assert isinstance(line, QLineEdit)
        QTest.keyClicks(line, text)
        settle()

    def click(self, widget: QWidget, at: QPoint | None = None) -> None:
        self._acts()
        at = widget.rect().center() if at is None else at
        assert widget.isEnabled()
        assert widget.visibleRegion().contains(at), widget
        QTest.mouseClick(widget, LEFT, pos=at)
        settle()

    def workspace(self, name: str) -> None:
        tabs = self.window.panels.tabs
        self.click(tabs, tabs.tabRect(list(WORKSPACES).index(name)).center())

    def menu(self, entry: str) -> None:
        """Open the menu that has an entry, and choose that."""
        bar = self.window.menuBar()
        # a menu that is got from its action is deleted with what was got
        for menu in bar.findChildren(QMenu):
            for action in menu.actions():
                if menu.menuAction() in bar.actions() and without(action.text()) == entry:
                    self.click(bar, bar.actionGeometry(menu.menuAction()).center())
                    self.click(menu, menu.actionGeometry(action).center())
                    return
        raise AssertionError(f"no menu has {entry}")

    def choose(self, box: QComboBox, data: str) -> None:
        """Open a list, and choose from it; a list takes what comes within a double click for part of its opening."""
        interval_ms = QApplication.doubleClickInterval()
        QApplication.setDoubleClickInterval(0)
        self.click(box)
        QApplication.setDoubleClickInterval(interval_ms)
        view = box.view()
        self.click(view.viewport(), view.visualRect(box.model().index(box.findData(data), 0)).center())


@pytest.fixture
def ready(window: MainWindow, wait_for: Any) -> MainWindow:
    window.activateWindow()
    wait_for(window.isActiveWindow)
    window.actions_.reset_layout.trigger()
    window.panels.work_in("measure")
    settle()
    return window


def opened(window: MainWindow, path: Path, wait_for: Any) -> None:
    """Open a session, and go back to where it is measured."""
    window.sessions.open(path)
    wait_for(lambda: window.runs.model.entries and window.runs.model.entries[0].summary and not window.jobs.running)
    window.panels.work_in("measure")
    settle()


@pytest.mark.parametrize("way", WAYS)
def test_calibrate_the_antennas(make_window: Any, setup_path: Path, wait_for: Any, tmp_path: Path, way: str) -> None:
    # the first, before the other tests' window: a key that two windows know means nothing
    def fit(order: CalibrationOrder, _progress: Callable[[float], None]) -> Any:
        return replace(calibration_of(order.setup, shift_u=2.0), verdict="good")

    window = make_window(setup_path, calibrator=fit)
    opened(window, make_session(tmp_path / "data", 4), wait_for)
    window.activateWindow()
    wait_for(window.isActiveWindow)
    hands = Hands(window)
    if way == "keys":
        hands.key("Shift+F7")
    else:
        hands.workspace("prepare")
        begin = next(
            one for one in window.channels.findChildren(QPushButton) if without(one.text()) == "Calibrate the antennas…"
        )
        hands.click(begin)
    dialog = window.calibration.dialog
    wait_for(lambda: dialog.isActiveWindow() and dialog.next.isEnabled())
    for _ in range(2):
        hands.key("Return") if way == "keys" else hands.click(dialog.next)
    wait_for(lambda: dialog.found)
    hands.letter(without(dialog.use.text())) if way == "keys" else hands.click(dialog.use)
    assert window.setup_model.setup.calibration is not None


@pytest.mark.parametrize("way", WAYS)
def test_record_a_drop(ready: MainWindow, wait_for: Any, way: str) -> None:
    hands = Hands(ready)
    hands.key("R") if way == "keys" else hands.click(ready.bar.buttons[1])
    wait_for(lambda: ready.control.state is AppState.DONE)
    assert "e = " in ready.bar.state.text


@pytest.mark.parametrize("way", WAYS)
def test_read_e_of_a_drop(ready: MainWindow, wait_for: Any, tmp_path: Path, way: str) -> None:
    opened(ready, make_session(tmp_path / "data", 4), wait_for)
    ready.runs.table.clearSelection()
    hands = Hands(ready)
    if way == "keys":
        for key in ("Ctrl+3", "Alt+7", "Return"):
            hands.key(key)
    else:
        hands.workspace("analyse")
        pictures = ready.runs.pictures
        hands.click(pictures.viewport(), pictures.visualRect(pictures.model().index(0, 0)).center())
    wait_for(lambda: ready.run.result is not None and not ready.jobs.running)
    assert ready.run.figures.isVisible()
    wait_for(lambda: "e of the first impact" in ready.run.figures.toPlainText())


@pytest.mark.parametrize("way", WAYS)
def test_make_the_report(ready: MainWindow, wait_for: Any, tmp_path: Path, way: str) -> None:
    path = make_session(tmp_path / "data", 4)
    opened(ready, path, wait_for)
    hands = Hands(ready)
    hands.key("Ctrl+R") if way == "keys" else hands.menu("Make report")
    wait_for(ready.runs.open_report.isEnabled)
    assert (path / "report" / "report.pdf").is_file()


@pytest.mark.parametrize("way", WAYS)
def test_find_the_session_of_last_week(ready: MainWindow, wait_for: Any, tmp_path: Path, way: str) -> None:
    path = make_session(tmp_path / "data", 4, sample="ruby sphere")
    make_session(tmp_path / "data", 11, sample="steel sphere")
    hands, browser = Hands(ready), ready.browser
    if way == "keys":
        hands.key("Ctrl+F")
        hands.write("ruby")
        wait_for(lambda: len(browser.model.entries) == 1 and not browser.looks.busy)
        hands.key("Down")
        hands.key("Return")
    else:
        hands.workspace("sessions")
        wait_for(lambda: len(browser.model.entries) == 2 and not browser.looks.busy)
        # the last one is the upper one
        hands.click(browser.table.viewport(), browser.table.visualRect(browser.table.model().index(1, 0)).center())
        hands.click(browser.review)
    wait_for(lambda: ready.control.session is not None)
    assert ready.control.session is not None
    assert ready.control.session.path == path
    browser.search.fields["text"].clear()


@pytest.mark.parametrize("way", WAYS)
def test_compute_a_run_with_another_setup(ready: MainWindow, wait_for: Any, tmp_path: Path, way: str) -> None:
    path = make_session(tmp_path / "data", 4)
    opened(ready, path, wait_for)
    hands, file = Hands(ready), path / "run-0001.h5"
    before = read_run_card(file).summary["correction"]
    hands.key("Shift+F8") if way == "keys" else hands.menu("Process again and compare…")
    dialog: Any = ready.transfer.dialog
    wait_for(dialog.isActiveWindow)
    if way == "keys":
        hands.letter("IQ correction")
        hands.key("End")
        hands.key("Return")
    else:
        hands.choose(dialog.correction, "ellipse")
        hands.click(dialog.compare)
    wait_for(lambda: dialog.keep.isEnabled() and not dialog.work.busy)
    hands.letter("Keep the new results") if way == "keys" else hands.click(dialog.keep)
    wait_for(lambda: not dialog.work.busy and read_run_card(file).summary["correction"] != before)


@pytest.mark.parametrize("way", WAYS)
def test_compare_two_sessions(ready: MainWindow, wait_for: Any, tmp_path: Path, way: str) -> None:
    for day in (4, 11):
        make_session(tmp_path / "data", day)
    hands, browser = Hands(ready), ready.browser
    hands.key("Ctrl+F") if way == "keys" else hands.workspace("sessions")
    wait_for(lambda: len(browser.model.entries) == 2 and not browser.looks.busy)
    if way == "keys":
        for key in ("Down", "Shift+Down", "Shift+Return"):
            hands.key(key)
    else:
        viewport, model = browser.table.viewport(), browser.table.model()
        first, last = (browser.table.visualRect(model.index(row, 0)).center() for row in (0, 1))
        hands.click(viewport, first)
        # drawn over both
        QTest.mousePress(viewport, LEFT, pos=first)
        QTest.mouseMove(viewport, last)
        QTest.mouseRelease(viewport, LEFT, pos=last)
        hands.click(browser.compare)
    wait_for(lambda: ready.series.facts is not None and len(ready.series.facts.sessions) == 2)
    assert ready.panels.workspace == "analyse"
    assert ready.run.chosen == "table"


@pytest.mark.parametrize("way", WAYS)
def test_write_a_note(ready: MainWindow, wait_for: Any, tmp_path: Path, way: str) -> None:
    opened(ready, make_session(tmp_path / "data", 4), wait_for)
    hands = Hands(ready)
    hands.key("Ctrl+M") if way == "keys" else hands.menu("Note now")
    hands.write("the fan was on")
    keep = next(one for one in ready.session_panel.findChildren(QPushButton) if without(one.text()) == "Keep")
    hands.key("Return") if way == "keys" else hands.click(keep)
    wait_for(lambda: any("the fan was on" in one.text() for one in ready.session_panel.findChildren(QLabel)))


@pytest.mark.parametrize("way", WAYS)
def test_import_a_table(
    ready: MainWindow, wait_for: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, way: str
) -> None:
    table = np.column_stack([np.arange(200) / 1000.0, np.random.default_rng(1).normal(size=(200, 6))])
    file = tmp_path / "drop.csv"
    np.savetxt(file, table, delimiter=",", header="time_s,I1,Q1,I2,Q2,I3,Q3", comments="")
    # what the system's own dialog gives
    monkeypatch.setattr(QFileDialog, "getOpenFileNames", lambda *_said: ([str(file)], ""))
    hands = Hands(ready)
    hands.key("Ctrl+I") if way == "keys" else hands.menu("Import recordings…")
    dialog: Any = ready.transfer.dialog
    wait_for(dialog.isActiveWindow)
    chooses = next(one for one in dialog.findChildren(QPushButton) if without(one.text()) == "Choose files…")
    hands.letter("Choose files…") if way == "keys" else hands.click(chooses)
    wait_for(dialog.go.isEnabled)
    hands.letter(without(dialog.go.text())) if way == "keys" else hands.click(dialog.go)
    wait_for(lambda: ready.control.session is not None and not ready.work.busy)


@pytest.mark.parametrize("way", WAYS)
def test_undo_an_edit(ready: MainWindow, way: str) -> None:
    ready.history.clear()
    before = ready.setup_model.setup
    ready.setup_model.assign("tracer.diameter_m", 0.0125)
    assert ready.setup_model.setup != before
    hands = Hands(ready)
    hands.key("Ctrl+Z") if way == "keys" else hands.menu("Undo")
    assert ready.setup_model.setup == before
