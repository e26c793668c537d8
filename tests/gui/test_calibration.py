"""The guided calibration: four steps, a result that is used, kept, compared or discarded, and the next drop's check."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QPainter, QPicture
from PySide6.QtWidgets import QFileDialog
from pytestqt.qtbot import QtBot
from support.calibrations import calibration_of

from radargui.calibration.unknowns import GROUPS
from radargui.experiment.calibrating import CalibrationOrder, write_calibration
from radargui.gui.main_window import MainWindow
from radargui.model.calibrated_setup import calibrated
from radargui.model.calibration import read_calibration
from radargui.model.errors import UsageError
from radargui.model.setup import read_setup, write_setup

Progress = Callable[[float], None]


class Fit:
    """Stands for the fit: gives what it is asked to, remembers what it was asked."""

    def __init__(self) -> None:
        self.orders: list[CalibrationOrder] = []
        self.verdict, self.error = "good", None
        self.goes_on = threading.Event()
        self.goes_on.set()

    def __call__(self, order: CalibrationOrder, progress: Progress) -> Any:
        self.orders.append(order)
        if self.error is not None:
            raise self.error
        while not self.goes_on.wait(0.01):
            progress(0.5)
        return replace(calibration_of(order.setup, shift_u=2.0), verdict=self.verdict)


@pytest.fixture
def fit() -> Fit:
    return Fit()


@pytest.fixture
def window(make_window: Any, setup_path: Path, fit: Fit) -> MainWindow:
    made: MainWindow = make_window(setup_path, calibrator=fit)
    made.calibration.dialog.recordings.put([Path("run-0001.h5")])
    return made


def test_of_a_sorted_list_the_recording_that_is_chosen_on_the_screen_is_meant(window: MainWindow) -> None:
    recordings = window.calibration.dialog.recordings
    recordings.put([Path("run-0002.h5")])
    recordings.table.sortByColumn(0, Qt.SortOrder.DescendingOrder)
    recordings.table.selectRow(0)
    recordings.say_known("turntable.toml")
    assert [one.known for one in recordings.table.rows.entries] == ["fall", "turntable.toml"]
    recordings.table.selectRow(0)
    recordings.remove.click()
    assert [one.file.name for one in recordings.table.rows.entries] == ["run-0001.h5"]


def test_the_keys_lead_from_recordings_to_a_setup_that_refers_to_its_calibration(
    window: MainWindow, fit: Fit, qtbot: QtBot, wait_for: Any, setup_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    window.actions_.calibrate.trigger()
    dialog, before = window.calibration.dialog, window.setup_model.setup
    assert dialog.isVisible()
    assert not dialog.next.isEnabled()
    asked: list[str] = []
    monkeypatch.setattr(QFileDialog, "getOpenFileNames", lambda *said: (asked.append(said[2]) or [], ""))
    dialog.recordings.add.click()
    assert asked == [str(window.session_panel.data_folder)]
    assert dialog.next.toolTip() == "Add recordings, or open a session with drops first"
    dialog.recordings.put([Path("a/run-0001.h5"), Path("a/run-0002.h5")])
    dialog.recordings.table.selectRow(1)
    dialog.recordings.say_known("turntable.toml")
    qtbot.keyClick(dialog, Qt.Key.Key_Return)
    assert dialog.step.text() == "Step 2 of 4: what is unknown"
    assert dialog.next.toolTip() == "To the next step"
    dialog.unknowns.boxes["azimuth"].setChecked(False)
    qtbot.keyClick(dialog, Qt.Key.Key_Return)
    wait_for(lambda: dialog.found)
    (order,) = fit.orders
    assert order.known == ("fall", "turntable.toml")
    assert order.free == ("tilt", "distance", "release")
    assert dialog.view.title.text() == "Good"
    assert "The data cannot tell: a common scale" in dialog.view.words.text()
    assert dialog.view.parameters.rows.entries[0][:2] == ("Receiver 1: Tilt, °", "40.00 ± 0.60")
    assert dialog.view.parameters.rows.entries[0][3:] == ("+0.60", "+0.9")
    dialog.use.click()
    assert not dialog.isVisible()
    path = setup_path.with_name("calibration-2025-11-03.json")
    assert read_calibration(path).values[0] == before.receiver[0].tilt_deg + 0.6
    assert window.setup_model.setup.receiver[0].tilt_deg == pytest.approx(before.receiver[0].tilt_deg + 0.6)
    assert window.setup_model.differs("receiver[1].tilt_deg")
    group = window.antennas.calibration
    assert group.words.text() == "Calibration of 3 November 2025 by A. Operator, good"
    window.setup_file.save()
    assert read_setup(setup_path).calibration == window.setup_model.setup.calibration
    # edited by hand afterwards: said by name
    window.setup_model.assign("receiver[1].tilt_deg", 30.0)
    assert "“Receiver 1: Tilt” = 30.0000 (calibrated 40.6000); their own u_ hold" in group.fault.text()


def test_the_form_offers_what_the_fit_can_find(window: MainWindow) -> None:
    unknowns = window.calibration.dialog.unknowns
    assert set(unknowns.boxes) == set(GROUPS)
    unknowns.show_setup(window.setup_model.setup)
    assert unknowns._priors["distance"].text() == "no uncertainty given: ± 20 mm taken"
    window.setup_model.assign("receiver[2].u_tilt_deg", 0.4)
    unknowns.show_setup(window.setup_model.setup)
    assert unknowns._priors["tilt"].text() == "Receiver 2 ± 0.4°"


def test_a_refused_calibration_cannot_be_used_and_is_discarded(window: MainWindow, fit: Fit, wait_for: Any) -> None:
    fit.verdict = "refused"
    dialog, before = window.calibration.dialog, window.setup_model.setup
    dialog.show()
    dialog.next.click()
    dialog.next.click()
    wait_for(lambda: dialog.found)
    assert not dialog.use.isEnabled()
    assert dialog.save.isEnabled()
    dialog.discard.click()
    assert not dialog.isVisible()
    assert window.setup_model.setup == before


def test_the_result_is_read_without_words_upon_another_a_minus_nothing_or_another_u(window: MainWindow) -> None:
    window.actions_.calibrate.trigger()
    dialog = window.calibration.dialog
    view, notes = dialog.view, ("u widened by 1.20 (Birge ratio)",)
    dialog.pages.setCurrentWidget(view)
    # the screen of the tests is narrower than any of today
    dialog.resize(1060, 640)
    found = calibration_of(window.setup_model.setup, shift_u=-0.01)
    residuals = tuple(replace(one, file="2025-11-03T10-00-00/run-0001") for one in found.residuals)
    view.show_calibration(replace(found, notes=notes, residuals=residuals))
    assert view.words.text().endswith("\nu widened by 1.20 (Birge ratio).")
    assert {entry[4] for entry in view.parameters.rows.entries} == {"0.0"}
    assert not any(
        words[0] in "+-" and float(words) == 0.0 for entry in view.parameters.rows.entries for words in entry[3:]
    )
    view.show_calibration(calibration_of(window.setup_model.setup, shift_u=0.001))
    assert {entry[3:] for entry in view.parameters.rows.entries} == {("0.00", "0.0"), ("0.0", "0.0")}
    view.show_calibration(replace(found, notes=notes, residuals=residuals))
    view.plot.grab()
    assert all(one.horizontalScrollBar().maximum() == 0 for one in (view.parameters, view.residuals))
    axis, picture = view.plot.getPlotItem().getAxis("left"), QPicture()
    with closing_painter(picture) as painter:
        _, _, texts = axis.generateDrawSpecs(painter)
    places = sorted((rect.top(), rect.bottom()) for rect, _, _ in texts)
    assert len(places) >= 2
    assert all(bottom <= top for (_, bottom), (top, _) in pairwise(places))


@contextmanager
def closing_painter(device: QPicture) -> Iterator[QPainter]:
    painter = QPainter(device)
    try:
        yield painter
    finally:
        painter.end()


def test_a_fit_that_fails_or_is_cancelled_says_so_and_changes_nothing(
    window: MainWindow, fit: Fit, wait_for: Any
) -> None:
    dialog = window.calibration.dialog
    dialog.show()
    dialog.next.click()
    fit.error = UsageError("run-0001.h5 holds no drop")
    dialog.next.click()
    wait_for(lambda: dialog.fault.text() == "run-0001.h5 holds no drop")
    fit.error = None
    fit.goes_on.clear()
    dialog.next.click()
    wait_for(lambda: dialog.work.busy and len(fit.orders) == 2)
    # the window is drawn and answers meanwhile
    assert dialog.step.text() == "Step 3 of 4: calibrating"
    dialog.work.cancel()
    wait_for(lambda: dialog.fault.text() == "Cancelled; nothing was changed.")
    assert dialog.found is None


def test_a_setup_changed_meanwhile_is_not_overwritten(window: MainWindow, wait_for: Any, tmp_path: Path) -> None:
    dialog = window.calibration.dialog
    dialog.show()
    dialog.next.click()
    dialog.next.click()
    wait_for(lambda: dialog.found)
    window.setup_model.assign("receiver[1].tilt_deg", 33.0)
    dialog.use.click()
    assert dialog.fault.text().startswith("The setup was changed since")
    assert not list(tmp_path.glob("calibration-*.json"))


def test_a_result_is_saved_elsewhere_and_compared_with_an_older_one(
    window: MainWindow, wait_for: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    dialog, other = window.calibration.dialog, tmp_path / "other.json"
    dialog.show()
    dialog.next.click()
    dialog.next.click()
    wait_for(lambda: dialog.found)
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_: (str(other), ""))
    dialog.save.click()
    assert read_calibration(other).names == dialog.found.names
    older = calibration_of(window.setup_model.setup, made_at="2024-05-01T08:00:00+00:00")
    write_calibration(tmp_path / "older.json", older)
    monkeypatch.setattr(QFileDialog, "getOpenFileName", lambda *_: (str(tmp_path / "older.json"), ""))
    dialog.compare.click()
    assert dialog.view.compared.text() == "Before: older.json, of 2024-05-01"
    assert dialog.view.parameters.rows.entries[0][1] == "40.00 ± 0.30"
    (tmp_path / "older.json").write_text("{}")
    dialog.compare.click()
    assert "older.json is damaged" in dialog.fault.text()


def test_the_first_drop_says_whether_the_calibration_holds_and_the_browser_asks_the_drops(
    make_window: Any, setup_path: Path, fit: Fit, record_one: Any, wait_for: Any, tmp_path: Path
) -> None:
    setup = read_setup(setup_path)
    covariance = np.diag(np.array([1e-4 if n.endswith("_deg") else 1e-8 for n in calibration_of(setup).names]))
    made, file = calibration_of(setup, covariance=covariance, made_at="2020-01-01T00:00:00+00:00"), tmp_path / "c.json"
    write_calibration(file, made)
    write_setup(calibrated(setup, made, file), setup_path)
    window = make_window(setup_path, calibrator=fit)
    group = window.antennas.calibration
    assert "days old, more than" in group.fault.text()
    record_one(window)
    assert any("days old, more than" in one.text for one in window.board.notices)
    wait_for(lambda: "Last check: the calibration of 1 January 2020" in group.checked.text())
    window.actions_.sessions.trigger()
    browser = window.sessions.browser
    wait_for(lambda: browser.model.entries)
    browser.table.selectRow(0)
    browser.calibrate.click()
    recordings = window.calibration.dialog.recordings
    wait_for(lambda: recordings.table.rows.entries)
    assert [one.file.name for one in recordings.table.rows.entries] == ["run-0001.h5"]
    assert recordings.table.rows.entries[0].known == "fall"
