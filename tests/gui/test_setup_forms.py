"""The forms of the setup: what is typed, what is wrong, what is saved."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QRect, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QComboBox, QLineEdit, QWidget
from support.simulated_recording import simulate_recording

from radargui.files.run_writer import RunWriter
from radargui.gui.bubble import FaultBubble
from radargui.gui.control.state import AppState
from radargui.gui.layout import FaultText, FormScroll
from radargui.gui.main_window import MainWindow
from radargui.gui.panels import TITLES
from radargui.gui.setup_words import parse_number, show_number
from radargui.model.errors import DeviceError
from radargui.model.recording import Block
from radargui.model.setup import dump_setup, read_setup
from radargui.physics.path_length import place_antennas, t_matrix
from radargui.session.info import default_data_folder
from radargui.sources.ni.discovery import NiDevice

OTHER = {"antennas": "hardware", "hardware": "antennas"}


def field(window: MainWindow, key: str) -> QLineEdit:
    found = window.findChild(QLineEdit, key)
    assert found is not None
    return found


def type_into(line: QLineEdit, text: str) -> None:
    line.setText(text)
    line.textEdited.emit(text)


def test_a_new_tilt_changes_the_matrix_at_once(window: MainWindow) -> None:
    before = window.antennas.matrix.matrix.text()
    type_into(field(window, "receiver[2].tilt_deg"), "55")
    after = window.antennas.matrix.matrix.text()
    assert after != before
    shown = np.array([[float(value) for value in row.split()] for row in after.splitlines()])
    np.testing.assert_allclose(shown, t_matrix(place_antennas(window.setup_model.setup)), atol=5e-5)
    assert window.setup_model.setup.receiver[1].tilt_deg == 55.0


def test_distances_are_typed_in_mm_and_kept_in_m(window: MainWindow) -> None:
    type_into(field(window, "receiver[1].distance_m"), "702,5")
    type_into(field(window, "tracer.release_position_m[3]"), "118")
    assert window.setup_model.setup.receiver[0].distance_m == 0.7025
    assert window.setup_model.setup.tracer.release_position_m == (0.0, 0.0, 0.118)


def test_the_air_gives_the_wave_its_length_once_it_is_told_whole_and_no_index_stands_beside_it(
    window: MainWindow,
) -> None:
    model = window.setup_model
    before = model.setup.radar.wavelength_m
    type_into(field(window, "air.temperature_c"), "23")
    assert "Pressure" in model.error
    type_into(field(window, "air.pressure_hpa"), "965")
    type_into(field(window, "air.humidity_percent"), "40")
    # of two that say one thing neither is taken silently
    assert "Refractive index" in model.error
    type_into(field(window, "radar.refractive_index"), "")
    assert model.valid
    assert model.setup.radar.index == model.setup.air.refractive_index
    assert 0.0 < abs(model.setup.radar.wavelength_m - before) < 1e-4 * before


BAD_VALUES = (
    ("antennas", "receiver[2].tilt_deg", "200", "Tilt: 200 is not allowed: a number from 0 to 180°"),
    ("antennas", "receiver[2].tilt_deg", "abc", "Tilt: abc is not allowed: a number from 0 to 180°"),
    ("antennas", "transmitter.distance_m", "-5", "Distance: -5 is not allowed: a number above 0 to 100000 mm"),
    ("antennas", "radar.frequency_hz", "3", None),
    ("antennas", "radar.frequency_hz", "0.01", "Frequency: 0.01 is not allowed: a number from 0.1 to 1000 GHz"),
    ("antennas", "tracer.diameter_m", "600", "Diameter: 600 is not allowed: a number above 0 to 500 mm"),
    ("antennas", "tracer.release_position_m[2]", "1e9", "Release y: 1000000000 is not allowed: a number from -1"),
    ("antennas", "floor.height_m", "deep", "Floor z: deep is not allowed: a number from -"),
    ("hardware", "daq.rate_hz", "-1", "Rate per channel: -1 is not allowed: a number from 10 to 1e7 Hz"),
    ("hardware", "daq.rate_hz", "", "Rate per channel: a value is needed: a number from 10 to 1e7 Hz"),
    ("hardware", "recording.threshold", "2", "Trigger: 2 is not allowed: a number from 3 to 1000 × noise"),
    ("hardware", "simulation.restitution", "1.2", "Restitution e: 1.2 is not allowed: a number from 0 to below 1"),
    ("hardware", "daq.channels", "ai0, ai1", "Channels: “Channels” names 2 channels: allowed 6 for 3 receivers"),
    ("hardware", "daq.remote", "lab", "Device server: lab is not allowed: a text HOST:PORT"),
    ("hardware", "daq.channel_skew_s", "20000", "Channel skew: 20000 is not allowed: a number from 0 to 10000 µs"),
)


def faults(panel: QWidget) -> list[FaultText | FaultBubble]:
    return [one for kind in (FaultText, FaultBubble) for one in panel.findChildren(kind) if one.isVisibleTo(panel)]


def places(panel: QWidget) -> dict[str, QRect]:
    """Return where each field of a panel is in what scrolls."""
    layer = panel.findChild(FormScroll).content
    lines = [one for one in panel.findChildren(QLineEdit) if one.isVisibleTo(panel)]
    return {one.objectName(): QRect(one.mapTo(layer, QPoint()), one.size()) for one in lines}


def test_what_is_wrong_stands_at_its_field_in_its_words_and_unit_and_stops_start(window: MainWindow) -> None:
    for name, key, text, said in BAD_VALUES:
        window.hardware.choose("ni" if key.startswith("daq.") else "simulated")
        line, panel, other = field(window, key), getattr(window, name), OTHER[name]
        panel.sections.reveal(line)
        good = line.text()
        type_into(line, text)
        if said is None:
            assert not faults(panel)
            type_into(line, good)
            continue
        window.panels.go_to(name)
        QApplication.processEvents()
        (fault,) = faults(panel)
        assert fault.text().startswith(said), fault.text()
        # right beneath the line
        at, below = line.mapTo(panel, line.rect().bottomLeft()).y(), fault.mapTo(panel, fault.rect().topLeft()).y()
        assert 0 <= below - at <= 12, key
        # and for who does not see it
        assert line.accessibleDescription().startswith(said)
        assert "border" in line.styleSheet()
        framed = [one for one in window.findChildren(QLineEdit) if "border" in one.styleSheet()]
        assert framed == [line]
        # who looks at the other panel is told where
        (elsewhere,) = faults(getattr(window, other))
        assert elsewhere.text().startswith(f"{TITLES[name]}, "), elsewhere.text()
        assert "_" not in elsewhere.text()
        assert not window.actions_.start.isEnabled()
        assert not window.actions_.record.isEnabled()
        type_into(line, good)
        assert not faults(window.hardware)
        assert not faults(window.antennas)
        assert window.actions_.start.isEnabled()


def test_no_field_moves_when_something_is_wrong(window: MainWindow) -> None:
    window.hardware.choose("simulated")
    for name, key in (
        ("antennas", "receiver[2].tilt_deg"),
        ("antennas", "radar.frequency_hz"),
        ("antennas", "tracer.diameter_m"),
        ("antennas", "air.temperature_c"),
        ("hardware", "recording.pretrigger_s"),
        ("hardware", "simulation.restitution"),
    ):
        panel, line = getattr(window, name), field(window, key)
        window.go_to_field(key)
        QApplication.processEvents()
        before, good = places(panel), line.text()
        type_into(line, "-999")
        QApplication.processEvents()
        assert faults(panel), key
        assert places(panel) == before, key
        type_into(line, good)


def test_what_is_wrong_is_never_said_over_what_has_the_keys(antennas: MainWindow) -> None:
    panel, line = antennas.antennas, field(antennas, "tracer.diameter_m")
    antennas.go_to_field("tracer.diameter_m")
    type_into(line, "600")
    QApplication.processEvents()
    said = panel.fault.text()
    assert faults(panel) == [panel.fault]
    assert said.startswith("Diameter: 600 is not allowed")
    QTest.keyClick(line, Qt.Key.Key_Tab)
    QApplication.processEvents()
    keys = QApplication.focusWidget()
    assert keys is not None
    assert keys is not line
    # it went beneath the form, and comes back with the keys
    assert faults(panel) == [panel.elsewhere]
    assert said in panel.elsewhere.text()
    QTest.keyClick(keys, Qt.Key.Key_Tab, Qt.KeyboardModifier.ShiftModifier)
    QApplication.processEvents()
    assert faults(panel) == [panel.fault]


def test_a_fault_in_a_form_that_is_hidden_is_told_beneath(window: MainWindow) -> None:
    window.hardware.choose("ni")
    type_into(field(window, "daq.device"), "")
    (fault,) = faults(window.hardware)
    assert fault.text().startswith("Device: a value is needed")
    window.hardware.choose("simulated")
    (fault,) = faults(window.hardware)
    assert fault.text().startswith("Hardware setup, Device: a value is needed")


def test_a_replay_without_a_file_says_so_at_its_field(window: MainWindow) -> None:
    window.hardware.choose("replay")
    window.actions_.record.trigger()
    assert window.hardware.replay.file.fault.text() == "No file to replay is chosen"
    window.hardware.replay.file.line.setText(str(Path("drop.h5")))
    assert window.hardware.replay.file.fault.isHidden()


def test_a_replay_says_where_the_setup_is_not_that_of_the_recording_and_takes_it_over(
    window: MainWindow, tmp_path: Path, wait_for: Any
) -> None:
    own = window.setup_model.setup
    tilted = own.model_copy(
        update={"receiver": (*own.receiver[:2], own.receiver[2].model_copy(update={"tilt_deg": 47.0}))}
    )
    recording, _ = simulate_recording(own)
    for name, setup in (("same", own), ("other", tilted)):
        path = tmp_path / f"{name}.h5"
        with RunWriter(path, recording.digitisation, started_at="", setup_toml=dump_setup(setup)) as writer:
            writer.write(Block(recording.raw[:, :500], 0))
    replay = window.hardware.replay
    window.hardware.choose("replay")
    replay.file.line.setText(str(tmp_path / "other.h5"))
    wait_for(lambda: replay.other.isVisibleTo(window.hardware))
    assert replay.other.text().endswith("is computed with the one here: Receiver 3: Tilt.")
    replay.take_own.click()
    assert window.setup_model.setup == tilted
    assert not replay.other.isVisibleTo(window.hardware)
    assert window.setup_model.unsaved == ("receiver[3].tilt_deg",)
    replay.file.line.setText(str(tmp_path / "same.h5"))
    wait_for(lambda: replay.other.isVisibleTo(window.hardware))
    # what was edited stands in no file
    assert not replay.take_own.isEnabled()
    window.setup_model.undo_all()
    assert not replay.other.isVisibleTo(window.hardware)


def test_receivers_are_added_and_removed_with_their_channels(window: MainWindow) -> None:
    table = window.antennas.table
    table.add.click()
    assert window.setup_model.setup.n_receivers == 4
    assert len(window.setup_model.setup.physical_channels) == 8
    assert not table.add.isEnabled()
    assert len(window.scopes.time.scopes) == 4
    assert field(window, "receiver[4].tilt_deg").text() == "40"
    for _ in range(3):
        window.setup_model.remove_receiver(1)
    assert window.setup_model.valid
    assert window.setup_model.setup.n_receivers == 1
    assert len(window.scopes.time.scopes) == 1
    assert "needs three receivers" in window.antennas.matrix.condition.text()


def test_antennas_that_cannot_tell_directions_apart_are_warned_of(window: MainWindow) -> None:
    warning = window.antennas.matrix.warning
    assert warning.isHidden()
    type_into(field(window, "receiver[2].azimuth_deg"), "90")
    assert not warning.isHidden()
    assert "singular" in warning.text()
    type_into(field(window, "receiver[2].azimuth_deg"), "95")
    assert "grows up to" in warning.text()


def test_a_saved_setup_keeps_the_comments_of_the_file(window: MainWindow, setup_path: Path) -> None:
    type_into(field(window, "receiver[3].tilt_deg"), "41.5")
    assert window.windowTitle().startswith("lab.toml*")
    window.actions_.save_setup.trigger()
    text = setup_path.read_text(encoding="utf-8")
    assert text.startswith("# measured by the operator in May\n")
    assert "# centre of the sphere at rest before the fall" in text
    assert read_setup(setup_path).receiver[2].tilt_deg == 41.5
    assert window.windowTitle().startswith("lab.toml")
    assert "*" not in window.windowTitle()


def test_a_shipped_setup_is_never_written_over(
    make_window: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    window = make_window(None)
    target = tmp_path / "mine.toml"
    monkeypatch.setattr("PySide6.QtWidgets.QFileDialog.getSaveFileName", lambda *_args, **_options: (str(target), ""))
    assert window.setup_model.shipped
    window.actions_.save_setup.trigger()
    assert "# centre of the sphere at rest before the fall" in target.read_text(encoding="utf-8")
    assert window.setup_model.path == target


def test_a_setup_that_cannot_be_read_leaves_the_one_there_is(window: MainWindow, tmp_path: Path, wait_for: Any) -> None:
    bad = tmp_path / "bad.toml"
    bad.write_text("schema = 2\n", encoding="utf-8")
    setup = window.setup_model.setup
    assert not window.setup_file.open(bad)
    wait_for(lambda: window.strip.texts())
    assert "bad.toml" in window.strip.texts()[0]
    assert window.setup_model.setup is setup


def test_choosing_a_source_shows_its_form(window: MainWindow) -> None:
    window.hardware.choose("ni")
    assert window.hardware.ni.isVisibleTo(window.hardware)
    assert not window.hardware.replay.isVisibleTo(window.hardware)
    terminal = window.findChild(QComboBox, "daq.terminal")
    assert terminal is not None
    terminal.setCurrentIndex(terminal.findData("rse"))
    terminal.activated.emit(terminal.currentIndex())
    assert window.setup_model.setup.daq.terminal == "rse"


def test_the_search_for_devices_fills_the_list_or_says_why_not(
    make_window: Any, setup_path: Path, wait_for: Any
) -> None:
    answers: list[Any] = [
        (NiDevice("Dev3", product_type="DAQPad-6015"),),
        DeviceError("The driver is not installed", remedy="Install NI-DAQmx."),
        (),
    ]
    asked: list[Any] = []

    def find(remote: str | None, certificate: str | None) -> Any:
        asked.append((remote, certificate))
        answer = answers[len(asked) - 1]
        if isinstance(answer, Exception):
            raise answer
        return answer

    window = make_window(setup_path, find_devices=find)
    window.hardware.choose("ni")
    form = window.hardware.ni
    form.button.click()
    wait_for(lambda: form.button.isEnabled())
    assert form.found.itemText(0) == "Dev3 (DAQPad-6015)"
    assert window.setup_model.setup.daq.device == "Dev3"
    window.setup_model.assign("daq.remote", "lab:31763")
    window.setup_model.assign("daq.remote_certificate", "lab.pem")
    form.button.click()
    wait_for(lambda: form.button.isEnabled())
    assert form.answer.text() == str(answers[1])
    form.button.click()
    wait_for(lambda: form.button.isEnabled())
    assert "No device found" in form.answer.text()
    assert asked == [(None, None), ("lab:31763", "lab.pem"), ("lab:31763", "lab.pem")]


@pytest.mark.parametrize(
    ("text", "value"),
    [("0.7", 0.7), ("0,7", 0.7), (" -1e3 ", -1000.0), ("−5", -5.0), ("", None), ("x1", "x1"), ("1,2.3", "1,2.3")],
)
def test_numbers_are_understood_with_point_or_comma(text: str, value: object) -> None:
    assert parse_number(text) == value


def test_scaled_numbers_come_back_as_they_were_typed() -> None:
    for text in ("0.1", "702.5", "33.333", "1e-3", "123456"):
        value = parse_number(text, 1000.0)
        assert float(show_number(value, 1000.0)) == float(text)


def test_a_folder_or_file_that_cannot_be_used_is_told_at_its_field(
    window: MainWindow, wait_for: Any, tmp_path: Path
) -> None:
    def failed() -> None:
        window.actions_.record.trigger()
        wait_for(lambda: window.control.state is AppState.FAILED)
        assert window.board.notices[0].level == "error", "and among the messages"

    window.panels.go_to("session")
    folder, fault = field(window, "session.data_folder"), window.session_panel.folder.fault
    folder.setText(str(tmp_path / "lab.toml" / "data"))
    failed()
    # Record went where it is measured
    window.panels.go_to("session")
    assert fault.isVisible()
    assert fault.text().startswith(f"Data folder: No session can be made in {tmp_path / 'lab.toml' / 'data'}: ")
    folder.setText("")
    assert fault.isHidden()
    assert window.session_panel.data_folder == default_data_folder(), "as the empty field says"
    assert folder.placeholderText() == str(default_data_folder())

    folder.setText(str(tmp_path / "data"))
    window.hardware.choose("replay")
    window.panels.go_to("hardware")
    window.hardware.replay.file.line.setText(str(tmp_path / "gone.csv"))
    failed()
    fault = window.hardware.replay.file.fault
    window.panels.go_to("hardware")
    assert fault.isVisible()
    assert fault.text().startswith("File: ")
    assert "gone.csv" in fault.text()
    assert window.session_panel.folder.fault.isHidden()
    window.hardware.replay.file.line.setText(str(tmp_path / "lab.csv"))
    assert fault.isHidden()


def test_a_place_that_nobody_gave_is_typed_number_by_number_and_taken_out_again(window: MainWindow) -> None:
    model = window.setup_model
    fields = [field(window, f"container.inner_m[{axis}]") for axis in (1, 2)]
    assert window.antennas.findChild(QLineEdit, "container.inner_m[3]") is None
    for key, value in (("wall_m", 0.02), ("refractive_index", 1.02), ("height_m", 0.1)):
        model.assign(f"container.{key}", value)
    type_into(fields[0], "300")
    assert not model.valid
    type_into(fields[1], "250")
    assert model.valid
    assert model.setup.container.inner_m == (0.3, 0.25)
    for one in fields:
        type_into(one, "")
    for key in ("wall_m", "refractive_index", "height_m"):
        model.assign(f"container.{key}", None)
    assert model.valid
    assert model.setup.container.walls is None
