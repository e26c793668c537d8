"""The form of the NI device: certificate, start at an edge, restart, and the check of the setup."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest
from PySide6.QtWidgets import QCheckBox, QComboBox, QLineEdit

from radargui.gui.main_window import MainWindow
from radargui.model.errors import DeviceError


@pytest.fixture
def ni(window: MainWindow) -> Any:
    window.hardware.choose("ni")
    return window.hardware.ni


def choose(form: Any, key: str, value: str) -> None:
    box = form.findChild(QComboBox, key)
    box.setCurrentIndex(box.findData(value))
    box.activated.emit(box.currentIndex())


def is_shown(form: Any, kind: type, key: str) -> bool:
    return form.findChild(kind, key).isVisibleTo(form)


def test_a_start_at_an_edge_asks_for_its_place_and_one_at_once_does_not(window: MainWindow, ni: Any) -> None:
    assert not is_shown(ni, QLineEdit, "daq.start_source")
    choose(ni, "daq.start", "digital")
    daq = window.setup_model.setup.daq
    assert window.setup_model.valid
    assert (daq.start, daq.start_source) == ("digital", "PFI0")
    assert is_shown(ni, QLineEdit, "daq.start_source")
    assert not is_shown(ni, QLineEdit, "daq.start_level_v")
    choose(ni, "daq.start", "analog")
    assert is_shown(ni, QLineEdit, "daq.start_level_v")
    choose(ni, "daq.start_edge", "falling")
    ni.findChild(QCheckBox, "daq.start_pretrigger").click()
    assert window.setup_model.setup.daq.start_pretrigger
    assert window.setup_model.setup.daq.start_edge == "falling"
    choose(ni, "daq.start", "now")
    assert window.setup_model.valid
    assert not window.setup_model.setup.daq.start_pretrigger


def test_the_restart_after_an_error_is_switched_and_timed(window: MainWindow, ni: Any) -> None:
    assert not is_shown(ni, QLineEdit, "recording.restart_within_s")
    ni.findChild(QCheckBox, "recording.restart_after_error").click()
    assert window.setup_model.setup.recording.restart_after_error
    line = ni.findChild(QLineEdit, "recording.restart_within_s")
    assert line.isVisibleTo(ni)
    line.textEdited.emit(line.setText("12") or "12")
    assert window.setup_model.setup.recording.restart_within_s == 12.0


def test_the_certificate_is_chosen_as_a_file(window: MainWindow, ni: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    window.setup_model.assign("daq.remote", "lab:31763")
    monkeypatch.setattr("PySide6.QtWidgets.QFileDialog.getOpenFileName", lambda *_args, **_options: ("lab.pem", ""))
    ni._browse()
    assert window.setup_model.setup.daq.remote_certificate == "lab.pem"
    assert ni.findChild(QLineEdit, "daq.remote_certificate").text() == "lab.pem"


def test_an_error_of_the_driver_names_the_fields_and_not_the_keys(window: MainWindow, ni: Any, wait_for: Any) -> None:
    window.setup_model.assign("daq.remote", "no-such-computer.invalid:31763")
    window.actions_.record.trigger()
    wait_for(lambda: any(one.level == "error" for one in window.board.notices))
    (text,) = (one.text for one in window.board.notices if one.level == "error")
    assert "Check “Device server”, or give the IP address" in text
    assert "no-such-computer.invalid" in text
    ni.check_button.click()
    wait_for(ni.check_button.isEnabled)
    assert "“Device server”" in ni.checked.text()


def test_the_check_of_the_setup_tells_what_will_be_in_force_or_why_not(
    window: MainWindow, ni: Any, wait_for: Any
) -> None:
    lines = (("range", "-5 to 5 V"), ("rate", "6 channels x 33.3 kS/s = 200 kS/s of 200 kS/s"))
    asked: list[Any] = []

    def check(setup: Any) -> Any:
        asked.append(setup)
        if len(asked) == 2:
            raise DeviceError("Dev1 is in use.", remedy="Stop the other program.")
        return SimpleNamespace(device=SimpleNamespace(title="Dev1 (DAQPad-6015)"), lines=lines)

    ni.check = check
    ni.check_button.click()
    assert not ni.check_button.isEnabled()
    wait_for(ni.check_button.isEnabled)
    assert ni.checked.text().splitlines() == [
        "The setup works on Dev1 (DAQPad-6015).",
        "Range: -5 to 5 V",
        "Rate: 6 channels x 33.3 kS/s = 200 kS/s of 200 kS/s",
    ]
    window.setup_model.assign("daq.range_v", 10.0)
    assert not ni.checked.isVisibleTo(ni)
    ni.check_button.click()
    wait_for(ni.check_button.isEnabled)
    assert "Dev1 is in use. " in ni.checked.text()
    assert asked[1].daq.range_v == 10.0
    window.setup_model.assign("daq.rate_hz", -1.0)
    assert not ni.check_button.isEnabled()
