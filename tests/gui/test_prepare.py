"""Prepare: sections of which one is open, the drawing with its numbers, and the way from a fault to its field."""

from __future__ import annotations

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QLineEdit

from radargui.gui.layout import Sections
from radargui.gui.main_window import MainWindow
from radargui.gui.setup.geometry_sketch import GeometrySketch


def settle() -> None:
    for _ in range(3):
        QApplication.processEvents()


def open_ones(sections: Sections) -> list[str]:
    return [title for title, head in sections.heads.items() if head.isChecked()]


def line(window: MainWindow, key: str) -> QLineEdit:
    found = window.findChild(QLineEdit, key)
    assert found is not None
    return found


def test_one_section_is_open_at_a_time_by_mouse_and_by_key(active: MainWindow) -> None:
    sections = active.hardware.sections
    assert open_ones(sections) == ["Source"]
    assert not line(active, "recording.threshold").isVisible()
    QTest.mouseClick(sections.heads["Recording"], Qt.MouseButton.LeftButton)
    assert open_ones(sections) == ["Recording"]
    assert line(active, "recording.threshold").isVisible()
    assert not line(active, "simulation.restitution").isVisible()
    head = sections.heads["Advanced"]
    head.setFocus()
    QTest.keyClick(head, Qt.Key.Key_Return)
    assert open_ones(sections) == ["Advanced"]
    for name in ("snr_db", "mismatch", "seed"):
        assert line(active, f"simulation.{name}").isVisible()
    # a device has no such settings: what was open then is not left without a title
    active.hardware.choose("ni")
    assert open_ones(sections) == ["Source"]
    assert not head.isVisible()


def test_a_field_that_is_asked_for_is_shown_wherever_it_stands(active: MainWindow) -> None:
    for key in ("recording.maximum_s", "receiver[2].azimuth_deg", "tracer.diameter_m", "site.latitude_deg"):
        active.go_to_field(key)
        settle()
        assert line(active, key).hasFocus(), key
        assert not line(active, key).visibleRegion().isEmpty(), key


def test_what_is_wrong_in_a_closed_section_is_said_beneath_the_form(active: MainWindow) -> None:
    active.hardware.sections.heads["Recording"].click()
    active.setup_model.assign("recording.threshold", 1.0)
    assert active.hardware.elsewhere.text() == ""
    active.hardware.sections.heads["Processing"].click()
    active.setup_model.assign("recording.threshold", 2.0)
    assert "Trigger" in active.hardware.elsewhere.text()


@pytest.mark.parametrize("size", [(1366, 768), (1920, 1080)])
def test_the_drawing_and_the_channels_stand_beside_the_sections(window: MainWindow, size: tuple[int, int]) -> None:
    window.resize(*size)
    window.panels.work_in("prepare")
    window.actions_.reset_layout.trigger()
    settle()
    whole = window.panels.width() * window.panels.height()
    shares = {
        name: window.panels.docks[name].width() * window.panels.docks[name].height() / whole
        for name in ("hardware", "geometry", "channels")
    }
    assert shares["hardware"] == pytest.approx(0.27, abs=0.05)
    assert shares["geometry"] > 0.5
    assert window.sketch.isVisible()
    assert window.channels.isVisible()
    # both names of the forms are on their tabs
    titles = [bar.tabText(tab) for bar in window.panels._bars for tab in range(bar.count()) if bar.isVisible()]
    assert {"Hardware setup", "Antenna calibration"} <= set(titles)


def test_beside_each_place_stands_what_is_typed(window: MainWindow) -> None:
    sketch: GeometrySketch = window.sketch
    assert sketch.words_beside(0, sketch.places[1]).split("\n") == ["Rx 1", "tilt 40°", "distance 700 mm"]
    window.setup_model.assign("receiver[1].azimuth_deg", 77.5)
    assert sketch.words_beside(1, sketch.places[1]).split("\n") == ["Rx 1", "azimuth 77.5°"]
    assert sketch.words_beside(0, sketch.places[-1]).split("\n") == ["Release", "z 120 mm"]
