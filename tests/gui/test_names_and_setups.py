"""Whose name runs have, whose setup is shown, what began a new session: said, asked, never done unseen."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QLineEdit, QMessageBox
from support.gui_sessions import make_session
from support.stored_runs import SETUP

from radargui.gui.main_window import MainWindow
from radargui.gui.setup.fields import LineField
from radargui.session.info import read_info
from radargui.session.session import Session


def typed(window: MainWindow, name: str, text: str, *, end: bool = True) -> QLineEdit:
    """Type into a field of the session as somebody does who leaves it with Enter, or stays in it."""
    window.panels.go_to("session")
    line = window.session_panel.findChild(QLineEdit, f"session.{name}")
    assert line is not None
    line.setFocus()
    line.selectAll()
    QTest.keyClicks(line, text)
    if end:
        QTest.keyClick(line, Qt.Key.Key_Return)
    return line


@pytest.fixture
def steel(active: MainWindow, wait_for: Any, tmp_path: Path) -> MainWindow:
    """A window in whose session two drops of steel were made."""
    path = make_session(tmp_path / "data", 4, n_runs=2, sample="steel", target="glass")
    active.sessions.open(path)
    wait_for(lambda: len(active.runs.model.entries) == 2 and not active.jobs.running)
    return active


def answering(window: MainWindow, monkeypatch: pytest.MonkeyPatch, words: str) -> list[str]:
    """Press a button of the question that comes; return what was asked."""
    asked: list[str] = []

    def run(box: QMessageBox) -> int:
        asked.append(box.text())
        (button,) = [one for one in box.buttons() if one.text().replace("&", "").startswith(words)]
        button.click()
        return 0

    monkeypatch.setattr("PySide6.QtWidgets.QMessageBox.exec", run)
    return asked


def test_the_name_of_the_next_sample_begins_a_new_session(
    steel: MainWindow, wait_for: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = steel.control.session.path
    asked = answering(steel, monkeypatch, "New session")
    typed(steel, "sample", "brass")
    assert asked == ["2 runs of this session have sample “steel”. Does another one come now, or was that wrong?"]
    wait_for(lambda: not steel.jobs.running)
    assert steel.control.session is None
    assert steel.session_panel.details.sample == "brass", "what was typed is said of the next one"
    assert (read_info(path).sample, read_info(path).journal) == ("steel", ())


def test_a_name_is_corrected_with_a_line_in_the_journal(
    steel: MainWindow, wait_for: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = steel.control.session.path
    asked = answering(steel, monkeypatch, "Correct the name of 2 runs")
    steel.panels.work_in("sessions")
    wait_for(lambda: [one.sample for one in steel.browser.model.entries] == ["steel"])
    typed(steel, "sample", "brass")
    # the list that stands beside it is looked at again
    wait_for(lambda: [one.sample for one in steel.browser.model.entries] == ["brass"])
    wait_for(lambda: read_info(path).journal)
    info = read_info(path)
    assert (info.sample, info.target) == ("brass", "glass")
    assert [one.text for one in info.journal] == ["Sample of 2 runs corrected: “steel” is “brass”"]
    typed(steel, "sample", "brass")
    assert len(asked) == 1, "it is called so already"
    wait_for(lambda: not steel.jobs.running)


def test_runs_that_have_no_name_yet_are_said_to_have_none(
    active: MainWindow, wait_for: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = make_session(tmp_path / "data", 4)
    active.sessions.open(path)
    wait_for(lambda: active.runs.model.entries and not active.jobs.running)
    asked = answering(active, monkeypatch, "Correct the name of 1 run")
    typed(active, "sample", "brass")
    assert asked == ["1 run of this session has no sample. Does another one come now, or was that wrong?"]
    wait_for(lambda: read_info(path).journal)
    assert [one.text for one in read_info(path).journal] == ["Sample of 1 run corrected: none is “brass”"]
    wait_for(lambda: not active.jobs.running)


def test_a_name_that_is_not_meant_stays_as_it_was(
    steel: MainWindow, wait_for: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = steel.control.session.path
    answering(steel, monkeypatch, "Cancel")
    typed(steel, "target", "oak")
    assert steel.session_panel.details[2:] == ("steel", "glass")
    # beside it a note is kept
    typed(steel, "operator", "Grace")
    wait_for(lambda: read_info(path).operator == "Grace")
    assert read_info(path).target == "glass"
    # somebody who types and records without leaving the field
    line = typed(steel, "sample", "brass", end=False)
    steel.setup_model.replace(Session.open(path, write=False).setup)
    QTest.keyClick(line, Qt.Key.Key_F9)
    assert not steel.control.state.running, "nothing is recorded under a name that is not settled"
    assert steel.session_panel.details.sample == "steel"
    wait_for(lambda: not steel.jobs.running)


def test_an_opened_session_shows_its_own_setup_until_it_is_put_away_or_taken_over(
    active: MainWindow, wait_for: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    window, model = active, active.setup_model
    model.assign("receiver[2].tilt_deg", 47.0)
    own, path = model.setup, model.path
    session = make_session(tmp_path / "data", 4)
    window.sessions.open(session)
    wait_for(lambda: window.control.session is not None and not window.jobs.running)
    window.panels.go_to("antennas")
    (tilt,) = [one for one in window.findChildren(LineField) if one.key == "receiver[2].tilt_deg"]
    assert tilt.text() == f"{SETUP.receiver[1].tilt_deg:g}"
    assert not tilt.isEnabled()
    assert window.antennas.take_over.isVisible()
    assert f"setup of {session.name}" in window.windowTitle()
    assert model.own_setup == own

    window.actions_.new_session.trigger()
    assert (model.setup, model.path, tilt.isEnabled(), tilt.text()) == (own, path, True, "47")
    assert window.antennas.take_over.isHidden()

    window.sessions.open(session)
    wait_for(lambda: window.control.session is not None and not window.jobs.running)
    # the edit of one's own would be lost: that is asked for, and it is not
    asked: list[str] = []
    button = QMessageBox.StandardButton

    def answer(_parent: Any, _title: str, words: str, *_buttons: Any) -> Any:
        asked.append(words)
        return button.Cancel if len(asked) == 1 else button.Discard

    monkeypatch.setattr("PySide6.QtWidgets.QMessageBox.question", answer)
    window.antennas.take_over.click()
    assert "Receiver 2: Tilt" in asked[0]
    assert (model.own_setup, model.reviewed) == (own, session.name)
    window.antennas.take_over.click()
    assert (model.setup, model.path) == (SETUP, None)
    assert tilt.isEnabled()
    assert window.control.session is not None, "it stays open"


def test_a_new_session_says_why_it_begins_and_an_edited_setup_has_a_star(
    active: MainWindow, wait_for: Any, record_one: Any
) -> None:
    window = active
    window.setup_model.assign("receiver[2].tilt_deg", 41.0)
    record_one(window)
    first = window.control.session.path
    assert window.control.session.info.setup_name == "lab*"
    assert "edited in the window since" in window.control.session.info.calibration.origin
    window.setup_model.assign("receiver[1].tilt_deg", 41.0)
    record_one(window)
    assert window.control.session.path != first
    assert any(one.text == "New session begins: Receiver 1: Tilt changed." for one in window.board.notices), (
        window.board.notices
    )
    window.setup_model.undo_all()
    record_one(window)
    assert window.control.session.info.setup_name == "lab"


def test_edits_that_come_back_the_next_morning_are_told(make_window: Any, setup_path: Path, board: Any) -> None:
    first = make_window(setup_path)
    first.setup_model.assign("receiver[2].tilt_deg", 47.0)
    first.close()
    board.clear()
    second = make_window()
    assert second.setup_model.setup.receiver[1].tilt_deg == 47.0
    said = "The setup is as you left it: 1 value changed since lab.toml was saved (Receiver 2: Tilt)."
    assert [one.text for one in board.notices] == [said]
    second.setup_model.undo_all()
    assert board.notices == (), "it is so no more"
    second.close()
    board.clear()
    make_window()
    assert board.notices == ()
