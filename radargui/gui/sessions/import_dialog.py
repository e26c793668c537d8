"""The import dialog: files, which channel is which, rate, setup."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

from PySide6 import QtWidgets
from PySide6.QtCore import QSignalBlocker, Signal

from radargui.experiment.importing import FilesLook, ImportOrder, inputs_of, look_into
from radargui.files.formats import SUFFIXES
from radargui.files.raw_file import first_seconds
from radargui.files.signals import ChannelInfo
from radargui.gui.background import Then, Work
from radargui.gui.dialog import Dialog, fit_screen
from radargui.gui.layout import Choice, FaultText, FormScroll, Group, PlainLabel, button, fill, having, side_by_side
from radargui.gui.services import Services
from radargui.gui.sessions.raw_form import PREVIEW_S, PREVIEW_SAMPLES, RawForm
from radargui.gui.setup.session_panel import SessionPanel
from radargui.gui.setup.setup_model import SetupModel
from radargui.model.arrays import FloatArray
from radargui.model.errors import RadarGuiError
from radargui.model.radar import MOST_RECEIVERS
from radargui.model.recording import iq_names
from radargui.model.setup import Setup, read_setup

_BASIS = {
    "names": "The names tell which is which.",
    "order": "Guessed from the order only: look at it.",
    "remembered": "As chosen for such files before.",
    "nothing": "No pairs of channels could be guessed: choose them.",
}


class MappingForm(Group):
    """A line for each of I1, Q1, ... with the channel that it is; what is wrong with them stands above."""

    changed = Signal()

    def __init__(self) -> None:
        super().__init__("Which channel is which")
        self._infos: tuple[ChannelInfo, ...] = ()
        self.boxes: list[QtWidgets.QComboBox] = []
        self.words, self.fault = PlainLabel("Choose files first."), FaultText()
        self.count = QtWidgets.QSpinBox(minimum=1, maximum=MOST_RECEIVERS)
        having(self.count, maximumWidth=70, accessibleName="Receivers")
        self.count.valueChanged.connect(lambda _count: self._fill(self.names))
        self.put(("Receivers", side_by_side(self.count, self.words)), self.fault)

    @property
    def names(self) -> tuple[str, ...]:
        """The chosen channels as I1, Q1, ...; empty texts where none is chosen."""
        return tuple(box.currentData() or "" for box in self.boxes)

    @property
    def complete(self) -> bool:
        """Whether every channel is chosen, none twice."""
        names = self.names
        return bool(names) and all(names) and len(set(names)) == len(names)

    def show_look(self, look: FilesLook) -> None:
        """Show other files with what was guessed for them."""
        self._infos = look.infos
        self.words.setText(_BASIS[look.basis])
        with QSignalBlocker(self.count):
            self.count.setValue(max(len(look.names) // 2, 1))
        self._fill(look.names)

    def clear(self, words: str) -> None:
        """Show that there is nothing to choose from."""
        self._infos = ()
        self.words.setText(words)
        self._fill(())

    def _fill(self, names: Sequence[str]) -> None:
        for box in self.boxes:
            self.rows.removeRow(box)
        self.boxes = []
        for row, target in enumerate(iq_names(self.count.value()) if self._infos else ()):
            facts = ((one.name, filter(None, (f"{one.count} samples", one.unit))) for one in self._infos)
            offered = (("", "not chosen"), *((name, f"{name}  ({', '.join(said)})") for name, said in facts))
            box = Choice(offered, names[row] if row < len(names) else "")
            box.currentIndexChanged.connect(lambda _index: self.changed.emit())
            self.row(target, box)
            # else Tab would come to what was made later at last
            self.setTabOrder(self.boxes[-1] if self.boxes else self.count, box)
            self.boxes.append(box)
        self.changed.emit()


_FILTER = (
    f"Recordings ({' '.join('*' + suffix for suffix in SUFFIXES)});;Plain binary (*.bin *.dat *.raw);;All files (*)"
)
_FASTEST_HZ = 1e9
"""No converter of 16 bits samples faster."""
_SIZE = (560, 640)
"""Of the dialog at first; twice as wide with the layout of a binary file."""


class ImportDialog(Dialog):
    """Asks what to import; files are looked into in the background."""

    ordered = Signal(object)

    def __init__(self, services: Services, model: SetupModel, panel: SessionPanel) -> None:
        super().__init__("Import recordings", _SIZE, services.parent)
        self._jobs, self._model, self._panel = services.jobs, model, panel
        self._files: tuple[Path, ...] = ()
        self._look: FilesLook | None = None
        self._n_looks = 0
        self._chosen: tuple[str, ...] = ()
        self._other: tuple[Setup, Path] | None = None
        self._named = PlainLabel("none")
        self.together = QtWidgets.QCheckBox("The files together are one run: each holds some of its channels")
        having(self.together, enabled=False).toggled.connect(self._renew_look)
        self.binary = QtWidgets.QCheckBox("Plain binary: its layout stands beside")
        self.raw = RawForm(services.theme)
        self.binary.toggled.connect(self._show_raw)
        self.raw.changed.connect(self._renew_look)
        self.mapping = MappingForm()
        self.rate = QtWidgets.QDoubleSpinBox(maximum=_FASTEST_HZ, decimals=3)
        self.setup = having(Choice(), accessibleName="Setup")
        self.setup.currentIndexChanged.connect(lambda _index: self._show_fault())
        self.process = having(QtWidgets.QCheckBox("Process the runs"), checked=True)
        self.files_fault, self.rate_fault, self.setup_fault = FaultText(), FaultText(), FaultText()
        self.go = button("Import as a session", self._order, default=True)
        self.mapping.changed.connect(self._show_fault)
        self.rate.editingFinished.connect(self._preview)
        self.rate.valueChanged.connect(lambda _hz: self._show_fault())

        chosen = side_by_side(self._named, button("Choose files…", self._choose))
        files = Group("Files", ("Chosen", chosen), self.files_fault, self.together, self.binary)
        setup = side_by_side(self.setup, button("Another setup file…", self._choose_setup))
        how = Group("Session", ("Sample rate [Hz]", self.rate), self.rate_fault)
        how.put(("Setup", setup), self.setup_fault, self.process)
        self._beside = FormScroll(self.raw)
        self._beside.hide()
        sides = fill(QtWidgets.QHBoxLayout(), (FormScroll(files, self.mapping, how), 1), (self._beside, 1), spacing=6)
        self.lay_out((sides, 1), side_by_side(self.go, button("Cancel", self.reject)))
        self._show_rate()
        self._show_setups()

    def choose(self, files: list[Path]) -> None:
        """Look into files."""
        self._look, self._chosen, self._files = None, (), tuple(files)
        self._named.setText(", ".join(file.name for file in files))
        self.together.setEnabled(len(files) > 1)
        with QSignalBlocker(self.binary):
            self.binary.setChecked(bool(files) and files[0].suffix.lower() not in SUFFIXES)
        self._show_raw()

    def _show_raw(self) -> None:
        shown = self.binary.isChecked()
        if shown != self._beside.isVisibleTo(self):
            self._beside.setVisible(shown)
            fit_screen(self, _SIZE[0] * (2 if shown else 1), _SIZE[1])
        self._renew_look()

    def _choose(self) -> None:
        start = str(self._files[0].parent) if self._files else ""
        names, _ = QtWidgets.QFileDialog.getOpenFileNames(self, "Recordings to import", start, _FILTER)
        if names:
            self.choose([Path(name) for name in names])

    def _choose_setup(self) -> None:
        name, _ = QtWidgets.QFileDialog.getOpenFileName(self, "Setup", "", "Setup files (*.toml);;All files (*)")
        if name:
            self.use_setup(Path(name))

    def use_setup(self, path: Path) -> None:
        """Import with the setup in a file."""
        try:
            self._other = (read_setup(path), path)
        except RadarGuiError as error:
            self.setup_fault.say(str(error))
            return
        self._show_setups("other")

    def _renew_look(self) -> None:
        if not self._files:
            return
        if self._look is not None and self.mapping.names != self._look.names:
            self._chosen = self.mapping.names
        self._look = None
        self.mapping.clear("Looking into the files …")
        self._n_looks += 1
        raw = self.raw.stated_layout() if self.binary.isChecked() else None
        if self.binary.isChecked() and raw is None:
            self._not_read()
            return
        self._ask(partial(look_into, self._files, together=self.together.isChecked(), raw=raw), self._show_look)

    def _ask(self, work: Work, then: Then) -> None:
        """Look into the files; what was looked at before something else was chosen does not count."""
        number = self._n_looks
        self._jobs.start("looking into files", work, then, self._not_read, lambda: number == self._n_looks)

    def _preview(self) -> None:
        """Show the first seconds of the first file as its layout makes them."""
        look = self._look
        if look is None or look.raw is None:
            return
        rate_hz = self.rate.value() or None
        layout = look.raw.model_copy(update={"rate_hz": rate_hz})

        def show(columns: FloatArray) -> None:
            self.raw.show_preview(columns, rate_hz)
            self._show_fault()

        self._ask(partial(first_seconds, look.files[0], layout, PREVIEW_S, PREVIEW_SAMPLES), show)

    def _show_look(self, look: FilesLook) -> None:
        if self._chosen and look.raw is not None and {info.name for info in look.infos}.issuperset(self._chosen):
            # what was chosen for this layout stays while another field of it is corrected
            look = replace(look, names=self._chosen, basis="remembered")
        else:
            self._chosen = ()
        self._look = look
        self.mapping.show_look(look)
        self._show_rate()
        # none is taken for all of them without being chosen
        self._show_setups("" if look.setups_differ else "own" if look.setup is not None else "window")
        self._preview()

    def _not_read(self, error: BaseException | None = None) -> None:
        """Show nothing of the files; why is said at their names, or already at the field that is wrong."""
        self.raw.clear_preview()
        self.mapping.clear("The files cannot be read.")
        self.files_fault.say(str(error or ""))

    def _show_rate(self) -> None:
        rate = self._look.rate_hz if self._look else None
        # plain binary says nothing
        unsaid = "not known" if self._look and self._look.raw else "as in the file, if it says so"
        self.rate.setSpecialValueText(f"as in the file: {rate:g}" if rate else unsaid)

    def _show_setups(self, wanted: str = "window") -> None:
        offered = {"window": "Setup in the window"}
        if self._look is not None and self._look.setup is not None:
            offered["own"] = "Setup that the file brings"
        if self._other is not None:
            offered["other"] = self._other[1].name
        self.setup.offer(offered.items(), wanted)
        if not wanted:
            self.setup.setCurrentIndex(-1)
        self._show_fault()

    def _chosen_setup(self) -> tuple[Setup, Path | None]:
        kind = self.setup.currentData()
        if kind == "other" and self._other is not None:
            return self._other
        if kind == "own" and self._look is not None and self._look.setup is not None:
            return self._look.setup, None
        return self._model.setup, self._model.path

    def _show_fault(self) -> None:
        looked, names = self._look is not None, self.mapping.names
        wanted, there = self._chosen_setup()[0].n_receivers, len(names) // 2
        complete = self.mapping.complete
        incomplete = "Choose one channel of the file for each of I1, Q1, ...; none twice." if not complete else ""
        self.mapping.fault.say(incomplete if looked else "")
        others = (
            f"Not as many receivers as in the setup: {there} chosen, {wanted} needed. Choose as many, or another setup."
        )
        differ = self._look.setups_differ if self._look and self.setup.currentIndex() < 0 else ""
        self.setup_fault.say(differ or (others if looked and complete and wanted != there else ""))
        no_rate = bool(self._look and self._look.raw and not self.rate.value())
        self.rate_fault.say("How many samples a second? A plain binary file does not say." if no_rate else "")
        if looked:
            self.files_fault.say("")
        self.raw.name_columns(dict(zip(names, iq_names(there), strict=False)))
        self.go.setEnabled(looked and complete and wanted == there and not differ and not no_rate)

    def _order(self) -> None:
        look = self._look
        if look is None:
            return
        setup, file = self._chosen_setup()
        names, rate_hz, panel = self.mapping.names, self.rate.value() or None, self._panel
        inputs, process = partial(inputs_of, look, names, rate_hz), self.process.isChecked()
        operator = panel.details.operator
        self.ordered.emit(ImportOrder(inputs, setup, file, panel.data_folder, operator, process=process))
        self.accept()
