"""What was changed in the setup is marked in its field, can be taken back, and is never lost unasked."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QMessageBox, QWidget
from support.typing_keys import typed

from radargui.gui.main_window import MainWindow
from radargui.gui.setup.fields import Changed, FormPanel
from radargui.model.setup import plain, read_setup
from radargui.session.info import read_info

Answer = QMessageBox.StandardButton


def field(window: MainWindow, key: str) -> QWidget:
    found = window.findChild(QWidget, key)
    assert found is not None
    return found


def mark(window: MainWindow, key: str) -> Changed:
    found = field(window, key).findChild(Changed)
    assert found is not None
    return found


def shown_changes(window: MainWindow) -> str:
    (text,) = {panel.changes.text() for panel in window.findChildren(FormPanel) if not panel.changes.isHidden()} or {""}
    return text


@pytest.fixture
def answers(monkeypatch: pytest.MonkeyPatch) -> tuple[list[Answer], list[str]]:
    given: list[Answer] = []
    asked: list[str] = []

    def ask(_parent: QWidget, _title: str, words: str, *_buttons: Answer) -> Answer:
        asked.append(words)
        return given.pop(0)

    monkeypatch.setattr(QMessageBox, "question", ask)
    return given, asked


VALUES = (
    ("receiver[2].tilt_deg", "55", "40°"),
    ("receiver[1].distance_m", "-3", "700 mm"),
    ("tracer.release_position_m[3]", "11x", "120 mm"),
    ("radar.frequency_hz", "", "10 GHz"),
    ("floor.height_m", "", "-140 mm"),
)


def test_a_wrong_entry_is_marked_and_taken_back_from_its_field(antennas: MainWindow) -> None:
    before = plain(antennas.setup_model.setup)
    for key, text, was in VALUES:
        assert mark(antennas, key).isHidden()
        typed(antennas, key, text)
        assert not mark(antennas, key).isHidden(), key
        assert f"The file says {was}:" in mark(antennas, key).toolTip()
        others = [one for one in antennas.findChildren(Changed) if not one.isHidden()]
        assert others == [mark(antennas, key)]
        QTest.keyClick(field(antennas, key), Qt.Key.Key_U, Qt.KeyboardModifier.ControlModifier)
        assert mark(antennas, key).isHidden(), key
        assert field(antennas, key).property("text") == was.split(" ")[0].rstrip("°")
        assert antennas.setup_model.valid
        assert plain(antennas.setup_model.setup) == before
        assert not antennas.setup_model.modified


def test_a_mark_is_clicked_and_all_changes_are_taken_back_together(antennas: MainWindow) -> None:
    typed(antennas, "receiver[2].tilt_deg", "55")
    typed(antennas, "transmitter.distance_m", "800")
    antennas.setup_model.assign("processing.geometry", "plane")
    antennas.setup_model.assign("recording.restart_after_error", False)
    marked = {"receiver[2].tilt_deg", "transmitter.distance_m", "processing.geometry"}
    assert marked <= {one.parentWidget().objectName() for one in antennas.findChildren(Changed) if not one.isHidden()}
    QTest.mouseClick(mark(antennas, "receiver[2].tilt_deg"), Qt.MouseButton.LeftButton)
    assert mark(antennas, "receiver[2].tilt_deg").isHidden()
    assert not mark(antennas, "transmitter.distance_m").isHidden()
    antennas.hardware.file.undo_all.click()
    assert all(one.isHidden() for one in antennas.findChildren(Changed))
    assert not antennas.hardware.file.undo_all.isEnabled()
    assert not antennas.setup_model.modified


def test_what_changed_since_the_last_run_is_told(own: MainWindow, record_one: Any) -> None:
    own.setup_model.assign("processing.correction", "adaptive")
    typed(own, "receiver[2].tilt_deg", "41")
    assert shown_changes(own) == ""
    record_one(own)
    assert shown_changes(own) == ""
    typed(own, "receiver[2].tilt_deg", "42")
    assert shown_changes(own) == "Changed since the last run: Receiver 2: Tilt (was 41°)"
    own.actions_.save_setup.trigger()
    assert shown_changes(own), "saved is not the same as recorded"
    typed(own, "receiver[2].tilt_deg", "41")
    assert shown_changes(own) == ""


def test_opening_a_setup_asks_before_edits_are_lost(
    own: MainWindow, answers: Any, tmp_path: Path, setup_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    given, asked = answers
    other = tmp_path / "other.toml"
    other.write_text(setup_path.read_text(encoding="utf-8"), encoding="utf-8")
    monkeypatch.setattr("PySide6.QtWidgets.QFileDialog.getOpenFileName", lambda *_args: (str(other), ""))
    typed(own, "receiver[2].tilt_deg", "55")
    given[:] = [Answer.Cancel]
    own.actions_.open_setup.trigger()
    assert "Receiver 2: Tilt" in asked[-1]
    assert own.setup_model.path == setup_path
    assert own.setup_model.setup.receiver[1].tilt_deg == 55.0
    given[:] = [Answer.Save]
    own.actions_.open_setup.trigger()
    assert read_setup(setup_path).receiver[1].tilt_deg == 55.0
    assert own.setup_model.path == other
    typed(own, "receiver[2].tilt_deg", "-")
    given[:] = [Answer.Discard]
    own.actions_.open_setup.trigger()
    assert own.setup_model.setup.receiver[1].tilt_deg == 40.0
    own.actions_.open_setup.trigger()
    assert len(asked) == 3, "asked although nothing was edited"


def test_the_setup_of_a_session_asks_before_edits_are_lost(
    own: MainWindow, answers: Any, record_one: Any, wait_for: Any
) -> None:
    given, asked = answers
    own.setup_model.assign("processing.correction", "adaptive")
    record_one(own)
    own.actions_.save_setup.trigger()
    typed(own, "receiver[2].tilt_deg", "55")
    session = own.control.session
    assert session is not None
    given[:] = [Answer.Cancel]
    own.sessions._take(read_info(session.path))
    assert len(asked) == 1
    assert own.setup_model.setup.receiver[1].tilt_deg == 55.0
    assert own.control.session is session
    given[:] = [Answer.Discard]
    own.sessions._take(read_info(session.path))
    assert own.setup_model.setup.receiver[1].tilt_deg == 40.0
    assert all(one.isHidden() for one in own.findChildren(Changed))
    assert own.control.session is None


def test_closing_asks_only_where_an_edit_would_be_lost(own: MainWindow, answers: Any, wait_for: Any) -> None:
    given, asked = answers
    del own.may_leave
    typed(own, "receiver[2].tilt_deg", "abc")
    given[:] = [Answer.No]
    own.close()
    assert own.isVisible()
    assert "Receiver 2: Tilt: abc is not allowed" in asked[0]
    typed(own, "receiver[2].tilt_deg", "55")
    own.close()
    wait_for(own.isHidden)
    assert len(asked) == 1


def test_a_mark_stands_within_its_field(antennas: MainWindow) -> None:
    typed(antennas, "receiver[2].distance_m", "701.25")
    assert within(antennas, "receiver[2].distance_m")
    antennas.panels.go_to("hardware")
    antennas.setup_model.assign("simulation.scene", "circle")
    QApplication.processEvents()
    assert within(antennas, "simulation.scene")


def within(window: MainWindow, key: str) -> bool:
    place = mark(window, key).geometry()
    return place.width() >= 12 and field(window, key).rect().contains(place)
