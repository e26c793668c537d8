"""What is said of a setup is said with the names that its fields have, whole, and leads to the field."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any

from PySide6.QtCore import Qt
from PySide6.QtGui import QFontMetrics, QTextCursor
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QPushButton
from support.results import drop_result

from radargui.gui.control.control_bar import wrapped
from radargui.gui.control.state import AppState
from radargui.gui.main_window import MainWindow
from radargui.gui.runs.run_model import RunEntry
from radargui.gui.runs.situation import Situation
from radargui.gui.setup.fields import LineField
from radargui.gui.setup_words import in_words, words_of
from radargui.model.finding import as_stored
from radargui.system.resources import resource_table

TURNED = "the sphere scatters as if receiver[2].polarization_deg were +44 degrees off: measure receiver[2].azimuth_deg"


def test_keys_are_called_as_their_fields_are_and_say_whose_they_are() -> None:
    assert in_words("measure receiver[2].azimuth_deg again") == "measure “Receiver 2: Azimuth” again"
    assert in_words("transmitter.distance_m = 12") == "“Transmitter: Distance” = 12"
    assert in_words("set a larger range (daq.range_v)") == "set a larger range (“Range ±”)"
    assert in_words("the receivers' tilt_deg are small") == "the receivers' “Tilt” are small"
    assert in_words("the channel of receiver[3] is empty") == "the channel of receiver 3 is empty"
    assert in_words("lab.toml and run_0001 stay") == "lab.toml and run_0001 stay"


def test_a_key_without_its_table_leads_to_its_field_where_that_is_one() -> None:
    linked = in_words("measure frequency_hz and the receivers' tilt_deg", linked=True)
    assert linked == 'measure “Frequency” (<a href="setup:radar.frequency_hz">Go there</a>) and the receivers\' “Tilt”'


def test_no_finding_speaks_of_a_key() -> None:
    for code, words in resource_table("findings").items():
        said = in_words(str(words["text"])) if isinstance(words, dict) and "text" in words else ""
        # what is filled in later stands in braces
        said = re.sub(r"\{[^{}]*\}", "", said)
        left = [key for key in re.findall(r"\b[a-z]+(?:\[\d\])?\.[a-z_]+", said) if words_of(key).name != key]
        assert not left, (code, said)
        assert "receiver[" not in said, code


def test_what_is_said_of_a_run_leads_to_the_field(active: MainWindow, wait_for: Any) -> None:
    window = active
    window.panels.go_to("run")
    window.run.show_result(replace(drop_result(rate_hz=2000.0), findings=(as_stored(TURNED),)), "drop 1")
    view = window.run.figures
    said = "“Receiver 2: Azimuth” (Go there)"
    wait_for(lambda: said in view.toPlainText())
    assert "receiver[2]" not in view.toPlainText()
    cursor = view.document().find("Go there", view.document().find("Receiver 2: Azimuth"))
    cursor.setPosition(cursor.selectionEnd() - 2, QTextCursor.MoveMode.MoveAnchor)
    view.setTextCursor(cursor)
    QTest.mouseClick(view.viewport(), Qt.MouseButton.LeftButton, pos=view.cursorRect().center())
    (field,) = [one for one in window.findChildren(LineField) if one.key == "receiver[2].azimuth_deg"]
    wait_for(field.hasFocus)
    assert window.antennas.isVisible()
    # of a place the first coordinate, in the other panel
    window.go_to_field("simulation.restitution")
    (field,) = [one for one in window.findChildren(LineField) if one.key == "simulation.restitution"]
    wait_for(field.hasFocus)


def test_a_message_speaks_in_the_names_of_the_fields_and_leads_there(active: MainWindow, wait_for: Any) -> None:
    window = active
    window.panels.work_in("measure")
    window.control.warned.emit("No run was recorded: find what disturbs, or lower recording.threshold.", "")
    wait_for(lambda: window.strip.isVisible())
    (said,) = window.strip.texts()
    assert said == "No run was recorded: find what disturbs, or lower “Trigger”."
    (there,) = [one for one in window.strip.findChildren(QPushButton) if one.text() == "Go there"]
    QTest.mouseClick(there, Qt.MouseButton.LeftButton)
    (field,) = [one for one in window.findChildren(LineField) if one.key == "recording.threshold"]
    wait_for(field.hasFocus)
    assert window.hardware.isVisible()
    # what names no value leads nowhere
    window.board.clear()
    window.control.warned.emit("run_0001 is short", "")
    wait_for(lambda: window.strip.texts() == ("run_0001 is short",))
    assert [one.text() for one in window.strip.findChildren(QPushButton) if one.isVisible()] == ["Copy", "Dismiss"]


def test_the_longest_reason_stands_whole_across_the_room(active: MainWindow, tmp_path: Any) -> None:
    texts = [words["text"] for words in resource_table("findings").values() if isinstance(words, dict)]
    longest = in_words(max((str(text) for text in texts), key=len))
    view = active.across
    view.resize(1920, 1080)
    view.show_situation(Situation(AppState.DONE, "FINAL", "mark", why=longest))
    metrics = QFontMetrics(view.fonts()["why"])
    shown = wrapped(longest, metrics, *view.room_of("why"))
    assert "…" not in shown
    assert shown.replace("\n", " ").split() == longest.split()


def test_a_refused_run_is_explained_in_the_names_of_the_fields(tmp_path: Any) -> None:
    summary = {"status": "rejected", "reason": "set receiver[2].tilt_deg in degrees"}
    assert RunEntry(tmp_path / "run-0001.h5", summary=summary).verdict == "rejected: set “Receiver 2: Tilt” in degrees"
