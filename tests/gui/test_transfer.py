"""Import with its mapping step, and export, through the dialogs of the window."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.changed import changed
from support.file_samples import codes, int16_digitisation
from support.gui_sessions import make_session
from support.results import default_setup
from support.simulated_recording import simulate_recording
from support.stored_runs import SETUP

from radargui.files.reading import read_recording
from radargui.files.run_writer import RunWriter
from radargui.gui.main_window import MainWindow
from radargui.gui.sessions.import_dialog import ImportDialog
from radargui.gui.sessions.transfer_controller import ExportDialog
from radargui.model.errors import CancelledError
from radargui.model.recording import Block
from radargui.model.setup import dump_setup
from radargui.session.info import read_info

NAMES = ["ai0", "ai1", "ai2", "ai3", "ai4", "ai5"]


@pytest.fixture
def volts() -> Any:
    return simulate_recording(SETUP)[0].volts()


def write_csv(path: Path, volts: Any, names: list[str]) -> Path:
    rows = [",".join(f"{value:.6f}" for value in column) for column in volts.T]
    path.write_text("\n".join([",".join(names), *rows]) + "\n", encoding="utf-8")
    return path


def dialog_of(window: MainWindow) -> Any:
    assert window.transfer.dialog is not None
    return window.transfer.dialog


def import_dialog(window: MainWindow, files: list[Path], wait_for: Any) -> ImportDialog:
    window.actions_.import_.trigger()
    dialog = dialog_of(window)
    dialog.choose(files)
    wait_for(lambda: not window.jobs.running)
    return dialog


def test_a_table_is_imported_with_a_corrected_mapping_that_is_remembered(
    window: MainWindow, wait_for: Any, tmp_path: Path, volts: Any
) -> None:
    # the wires of the first receiver are swapped: only the operator knows
    file = write_csv(tmp_path / "drop.csv", volts[[1, 0, 2, 3, 4, 5]], NAMES)
    setup = tmp_path / "falling.toml"
    setup.write_text(dump_setup(SETUP), encoding="utf-8")
    dialog = import_dialog(window, [file], wait_for)
    assert dialog.mapping.names == tuple(NAMES)
    assert "order" in dialog.mapping.words.text()
    dialog.mapping.boxes[0].setCurrentIndex(2)
    assert not dialog.go.isEnabled()
    dialog.mapping.boxes[1].setCurrentIndex(1)
    assert dialog.mapping.names[:2] == ("ai1", "ai0")
    assert dialog.go.isEnabled()
    dialog.rate.setValue(2000.0)
    dialog.use_setup(setup)
    dialog.go.click()
    wait_for(lambda: not window.work.busy)
    session = window.control.session
    assert session is not None, window.board.notices
    assert read_info(session.path).setup_name == "falling"
    read = read_recording(session.path / "run-0001.h5")
    assert read.digitisation.sample_rate_hz == 2000.0
    np.testing.assert_allclose(read.volts(), volts, atol=1e-6)
    wait_for(lambda: window.runs.model.entries and window.runs.model.entries[0].summary)
    assert window.runs.model.entries[0].summary["e"] == pytest.approx(0.5, abs=0.05)

    again = import_dialog(window, [file], wait_for)
    assert again.mapping.names[:2] == ("ai1", "ai0")
    assert "before" in again.mapping.words.text()


def test_files_of_one_receiver_each_become_one_run(
    window: MainWindow, wait_for: Any, tmp_path: Path, volts: Any
) -> None:
    files = [
        write_csv(tmp_path / f"rx{number}.csv", volts[2 * number - 2 : 2 * number], ["I", "Q"]) for number in (1, 2, 3)
    ]
    dialog = import_dialog(window, files, wait_for)
    assert "receivers" in dialog.setup_fault.text()
    dialog.together.setChecked(True)
    wait_for(lambda: not window.jobs.running)
    assert dialog.mapping.names == tuple(f"rx{number}.csv: {part}" for number in (1, 2, 3) for part in "IQ")
    dialog.rate.setValue(2000.0)
    dialog.process.setChecked(False)
    dialog.go.click()
    wait_for(lambda: not window.work.busy)
    assert window.control.session is not None, window.board.notices
    read = read_recording(window.control.session.path / "run-0001.h5")
    np.testing.assert_allclose(read.volts(), volts, atol=1e-6)


def test_files_that_bring_different_setups_wait_for_one_to_be_chosen(
    window: MainWindow, wait_for: Any, tmp_path: Path
) -> None:
    files = [tmp_path / "run-0001.h5", tmp_path / "run-0002.h5"]
    for file, diameter_m in zip(files, (0.01, 0.02), strict=True):
        setup = changed(default_setup(), tracer={"diameter_m": diameter_m})
        with RunWriter(file, int16_digitisation(), started_at="", setup_toml=dump_setup(setup)) as writer:
            writer.write(Block(codes(6, 300), 0))
    dialog = import_dialog(window, files, wait_for)
    assert "run-0002.h5 brings another setup than" in dialog.setup_fault.text()
    assert not dialog.go.isEnabled()
    dialog.setup.setCurrentIndex(0)
    assert dialog.setup_fault.text() == ""
    assert dialog.go.isEnabled()
    dialog.reject()


def test_a_file_that_cannot_be_read_is_told_in_the_dialog(window: MainWindow, wait_for: Any, tmp_path: Path) -> None:
    bad = tmp_path / "bad.mat"
    bad.write_bytes(b"no matlab file at all")
    dialog = import_dialog(window, [bad], wait_for)
    assert "bad.mat" in dialog.files_fault.text()
    assert not dialog.go.isEnabled()


def test_a_session_is_exported_and_nothing_is_replaced_unasked(
    window: MainWindow, wait_for: Any, tmp_path: Path
) -> None:
    path = make_session(tmp_path / "data", 4, n_runs=2)
    window.sessions.open(path)
    wait_for(lambda: not window.jobs.running)
    target = tmp_path / "out"

    def ordered(folder: Path) -> ExportDialog:
        window.actions_.export_samples.trigger()
        dialog = dialog_of(window)
        assert isinstance(dialog, ExportDialog)
        dialog.kind.setCurrentIndex(dialog.kind.findData("tdms"))
        dialog.folder.line.setText(str(folder))
        dialog.go.click()
        wait_for(lambda: not window.jobs.running and not window.work.busy)
        return dialog

    assert ordered(target).isHidden()
    assert [file.name for file in sorted(target.iterdir())] == ["run-0001.tdms", "run-0002.tdms"]
    (target / "run-0001.tdms").write_bytes(b"of somebody else")

    # a fault stands at its field, and the dialog with what was chosen stays
    wrong = ordered(tmp_path / "lab.toml" / "out")
    assert wrong.folder.fault.isVisible()
    assert wrong.folder.fault.text().startswith(f"Folder: {tmp_path / 'lab.toml' / 'out'} cannot be made: ")
    again = ordered(target)
    assert again.folder.fault.isVisible()
    assert "run-0001.tdms are there already" in again.folder.fault.text().replace(f", {target / 'run-0002.tdms'}", "")
    assert again.folder.fault.text().endswith("Choose another folder, or tick “Replace files that are there”.")
    assert (target / "run-0001.tdms").read_bytes() == b"of somebody else"
    again.replace.setChecked(True)
    assert again.folder.fault.isHidden()
    again.go.click()
    wait_for(lambda: not window.jobs.running and not window.work.busy)
    assert again.isHidden()
    assert not [notice for notice in window.board.notices if notice.level == "error"]
    original = read_recording(path / "run-0001.h5")
    np.testing.assert_array_equal(read_recording(target / "run-0001.tdms").volts(), original.volts())
    window.runs.table.selectRow(0)
    assert ordered(tmp_path / "one").isHidden()
    assert f"1 file written to {tmp_path / 'one'}" in [notice.text for notice in window.board.notices]


def test_the_run_that_is_chosen_is_called_as_in_the_list(window: MainWindow, wait_for: Any, tmp_path: Path) -> None:
    window.sessions.open(make_session(tmp_path / "data", 4, n_runs=2))
    wait_for(lambda: not window.jobs.running)
    window.runs.table.selectRow(1)
    wait_for(lambda: not window.jobs.running)
    for action in (window.actions_.export_samples, window.actions_.compare):
        action.trigger()
        assert dialog_of(window).what.itemText(0) == "The chosen run, drop 2 (run-0002, simulated)"


def test_cancelled_work_leaves_no_half_file(
    window: MainWindow, wait_for: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = make_session(tmp_path / "data", 4)
    window.sessions.open(path)
    wait_for(lambda: not window.jobs.running)
    window.actions_.export_samples.trigger()
    dialog = dialog_of(window)
    dialog.folder.line.setText(str(tmp_path / "out"))

    wait_for(lambda: not window.jobs.running)

    def cancelled(_task: object, _share: float) -> None:
        raise CancelledError

    monkeypatch.setattr("radargui.gui.background.Task.report", cancelled)
    dialog.go.click()
    wait_for(lambda: not window.jobs.running and not window.work.busy)
    assert not list((tmp_path / "out").iterdir())
    assert "cancelled" in window.board.notices[-1].text


def write_binary(path: Path, volts: Any) -> Path:
    """Write codes of 1 mV behind a header of 8 bytes, one column more than there are channels."""
    codes = np.rint(2048.0 + 1e3 * np.vstack([volts, np.zeros(volts.shape[1])])).astype("<u2")
    path.write_bytes(bytes(8) + codes.T.tobytes())
    return path


def test_plain_binary_is_looked_at_while_its_layout_is_told_and_then_imported(
    window: MainWindow, wait_for: Any, tmp_path: Path, volts: Any
) -> None:
    setup = tmp_path / "falling.toml"
    setup.write_text(dump_setup(SETUP), encoding="utf-8")
    dialog = import_dialog(window, [write_binary(tmp_path / "drop.bin", volts)], wait_for)
    assert dialog.binary.isChecked()
    raw = dialog.raw
    assert raw.isVisibleTo(dialog)
    raw.kind.setCurrentIndex(raw.kind.findData("u2"))
    raw.columns.setValue(7)
    raw.header.setValue(8)
    raw.scale.setText("volts")
    wait_for(lambda: not window.jobs.running)
    assert dialog.raw.faults["scale"].text().startswith('Scale: "volts", allowed: volts of one step')
    assert dialog.raw.faults["offset"].isHidden()
    assert dialog.files_fault.isHidden()
    assert not dialog.go.isEnabled()
    raw.scale.setText("1e-3")
    raw.offset.setText("-2.048")
    dialog.use_setup(setup)
    wait_for(lambda: not window.jobs.running)
    assert not dialog.go.isEnabled(), "a binary file says no rate: the import would fail behind the closed dialog"
    assert dialog.rate_fault.text().startswith("How many samples a second?")
    dialog.rate.setValue(2000.0)
    assert dialog.go.isEnabled()
    assert dialog.rate_fault.isHidden()
    wait_for(lambda: not window.jobs.running)
    assert dialog.mapping.names == ("0", "1", "2", "3", "4", "5")
    low, high = volts[0, :6000].min(), volts[0, :6000].max()
    ticks = [words for _, words in raw.plot.getPlotItem().getAxis("left")._tickLevels[0]]
    assert ticks[0].startswith("0 I1 ")
    assert [float(part) for part in ticks[0][5:].split(" … ")] == pytest.approx([low, high], abs=1.1e-3)
    assert ticks[6].startswith("6 0")
    dialog.mapping.boxes[0].setCurrentIndex(2)
    dialog.mapping.boxes[1].setCurrentIndex(1)
    for text in ("-2.048e0", "-2.0480"):
        raw.offset.setText(text)
        wait_for(lambda: not window.jobs.running)
    assert dialog.mapping.names == ("1", "0", "2", "3", "4", "5")
    dialog.process.setChecked(False)
    dialog.go.click()
    wait_for(lambda: not window.work.busy)
    assert window.control.session is not None, window.board.notices
    read = read_recording(window.control.session.path / "run-0001.h5")
    assert read.raw.dtype == np.int16
    np.testing.assert_allclose(read.volts(), volts[[1, 0, 2, 3, 4, 5]], atol=0.51e-3)
