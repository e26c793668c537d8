"""The import dialog: files, which channel is which, rate, setup."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from PySide6.QtCore import Signal
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QDialog,
    QDoubleSpinBox,
    QFileDialog,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from radargui.files.formats import SUFFIXES
from radargui.gui.background import Jobs
from radargui.gui.sessions.import_look import FilesLook, inputs_of, look_into
from radargui.gui.sessions.import_work import ImportOrder
from radargui.gui.sessions.mapping_table import MappingTable
from radargui.gui.setup.form import Group, plain_label, side_by_side
from radargui.model.errors import RadarGuiError
from radargui.model.setup import Setup
from radargui.model.setup_file import read_setup

_FILTER = f"Recordings ({' '.join('*' + suffix for suffix in SUFFIXES)});;All files (*)"
_FASTEST_HZ = 1e9
SetupNow = Callable[[], tuple[Setup, Path | None]]


class ImportDialog(QDialog):
    """Asks what to import; files are looked into in the background."""

    ordered = Signal(object)

    def __init__(self, jobs: Jobs, setup_now: SetupNow, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setWindowTitle("Import recordings")
        self.resize(720, 620)
        self._jobs = jobs
        self._setup_now = setup_now
        self._files: tuple[Path, ...] = ()
        self._look: FilesLook | None = None
        self._other: tuple[Setup, Path] | None = None
        self._named = plain_label("none")
        choose = QPushButton("Choose files…")
        choose.setAutoDefault(False)
        choose.clicked.connect(self._choose)
        self.together = QCheckBox("The files together are one run: each holds some of its channels")
        self.together.setEnabled(False)
        self.together.toggled.connect(lambda _on: self._look_again())
        self.mapping = MappingTable()
        self.rate = QDoubleSpinBox()
        self.rate.setRange(0.0, _FASTEST_HZ)
        self.rate.setDecimals(3)
        self.rate.setGroupSeparatorShown(False)
        self.setup = QComboBox()
        self.setup.currentIndexChanged.connect(lambda _index: self._show_fault())
        other = QPushButton("Another setup file…")
        other.setAutoDefault(False)
        other.clicked.connect(self._choose_setup)
        self.process = QCheckBox("Process the runs")
        self.process.setChecked(True)
        self.fault = plain_label()
        self.go = QPushButton("Import as a session")
        self.go.setDefault(True)
        self.go.clicked.connect(self._order)
        cancel = QPushButton("Cancel")
        cancel.setAutoDefault(False)
        cancel.clicked.connect(self.reject)
        self.mapping.changed.connect(self._show_fault)

        files, columns, how = Group("Files"), Group("Which channel is which"), Group("Session")
        files.row("Chosen", side_by_side(self._named, choose))
        files.whole(self.together)
        columns.whole(self.mapping)
        how.row("Sample rate [Hz]", self.rate, "Where the file does not say it, or says it wrong")
        how.row("Setup", side_by_side(self.setup, other), "Antennas and processing")
        how.whole(self.process)
        column = QVBoxLayout(self)
        for part in (files, columns, how):
            column.addWidget(part)
        column.addWidget(self.fault)
        column.addWidget(side_by_side(self.go, cancel))
        self._show_rate()
        self._show_setups()

    def choose(self, files: list[Path]) -> None:
        """Look into files."""
        self._files = tuple(files)
        self._named.setText(", ".join(file.name for file in files))
        self.together.setEnabled(len(files) > 1)
        self._look_again()

    def _choose(self) -> None:
        start = str(self._files[0].parent) if self._files else ""
        names, _ = QFileDialog.getOpenFileNames(self, "Recordings to import", start, _FILTER)
        if names:
            self.choose([Path(name) for name in names])

    def _choose_setup(self) -> None:
        name, _ = QFileDialog.getOpenFileName(self, "Setup", "", "Setup files (*.toml);;All files (*)")
        if name:
            self.use_setup(Path(name))

    def use_setup(self, path: Path) -> None:
        """Import with the setup in a file."""
        try:
            self._other = (read_setup(path), path)
        except RadarGuiError as error:
            self.fault.setText(str(error))
            return
        self._show_setups("other")

    def _look_again(self) -> None:
        if not self._files:
            return
        files, together = self._files, self.together.isChecked()
        self._look = None
        self.mapping.clear("Looking into the files …")
        self._jobs.start(
            "looking into files",
            lambda: look_into(files, together=together),
            lambda look: self._show_look(look, together),
            self._not_read,
        )

    def _show_look(self, look: FilesLook, together: bool) -> None:
        if look.files != self._files or together != self.together.isChecked():
            return
        self._look = look
        self.mapping.show_look(look)
        self._show_rate()
        self._show_setups("own" if look.setup is not None else "window")

    def _not_read(self, error: BaseException) -> None:
        self.mapping.clear("The files cannot be read.")
        self.fault.setText(str(error))

    def _show_rate(self) -> None:
        rate = self._look.rate_hz if self._look else None
        self.rate.setSpecialValueText(f"as in the file: {rate:g}" if rate else "as in the file, if it says so")

    def _show_setups(self, wanted: str = "window") -> None:
        self.setup.blockSignals(True)
        self.setup.clear()
        self.setup.addItem("Setup in the window", "window")
        if self._look is not None and self._look.setup is not None:
            self.setup.addItem("Setup that the file brings", "own")
        if self._other is not None:
            self.setup.addItem(self._other[1].name, "other")
        self.setup.setCurrentIndex(max(self.setup.findData(wanted), 0))
        self.setup.blockSignals(False)
        self._show_fault()

    def _chosen_setup(self) -> tuple[Setup, Path | None]:
        kind = self.setup.currentData()
        if kind == "other" and self._other is not None:
            return self._other
        if kind == "own" and self._look is not None and self._look.setup is not None:
            return self._look.setup, None
        return self._setup_now()

    def _show_fault(self) -> None:
        words = ""
        wanted, there = self._chosen_setup()[0].n_receivers, len(self.mapping.names) // 2
        if self._look is not None and not self.mapping.complete:
            words = "Choose one channel of the file for each of I1, Q1, ...; none twice."
        elif self._look is not None and wanted != there:
            words = f"The setup has {wanted} receivers, {there} are chosen: choose as many, or another setup."
        self.fault.setText(words)
        self.go.setEnabled(self._look is not None and not words)

    def _order(self) -> None:
        look = self._look
        if look is None:
            return
        setup, file = self._chosen_setup()
        names, rate_hz = self.mapping.names, self.rate.value() or None
        self.ordered.emit(
            ImportOrder(lambda: inputs_of(look, names, rate_hz), setup, file, process=self.process.isChecked())
        )
        self.accept()
