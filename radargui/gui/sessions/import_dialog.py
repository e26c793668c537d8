"""The import dialog: files, which channel is which, rate, setup; of a file without a header what its bytes are."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from PySide6 import QtWidgets
from PySide6.QtCore import QSignalBlocker, Signal
from PySide6.QtWidgets import QLineEdit, QSpinBox

from radargui.experiment.importing import FilesLook, ImportOrder, inputs_of, look_into
from radargui.files.formats import SUFFIXES
from radargui.files.raw_file import LARGEST_BYTES, TYPES, RawLayout, first_seconds, parse_raw_layout
from radargui.files.signals import MAX_CHANNELS, ChannelInfo
from radargui.gui.background import Then, Work
from radargui.gui.dialog import Dialog, fit_screen
from radargui.gui.layout import Choice, FaultText, FormScroll, Group, PlainLabel, button, fill, having, side_by_side
from radargui.gui.plots.plot import Plot
from radargui.gui.services import Services
from radargui.gui.setup.session_panel import SessionPanel
from radargui.gui.setup.setup_model import SetupModel
from radargui.gui.theme import Theme
from radargui.model.arrays import FloatArray
from radargui.model.errors import RadarGuiError, UsageError
from radargui.model.radar import MAX_RECEIVERS
from radargui.model.recording import iq_names
from radargui.model.setup import Setup, read_setup

PREVIEW_S = 3.0
"""Long enough for a step or a swing of a hand, short enough to see single fringes."""
PREVIEW_SAMPLES = 200_000
"""Of each column at most; drawn in a few ms, for the plot shows lowest and highest of each pixel only."""
_LARGEST_FIELD = min(LARGEST_BYTES, 2**31 - 1)
"""The second is the largest number of a QSpinBox, which counts in 32 bits with sign."""
_SIGNS = {"i": "signed", "u": "unsigned", "f": "floating point"}
_LANE = 0.45
"""Half the height of a column in the preview, where the next one lies 1 below."""


class RawForm(Group):
    """Fields for each key of `--raw` but the rate, and the first seconds of each column below one another."""

    changed = Signal()

    def __init__(self, theme: Theme) -> None:
        super().__init__("Layout of the binary file")
        kinds = ((name, f"{8 * int(name[1])} bit, {_SIGNS[name[0]]} ({name})") for name in TYPES)
        self.kind = Choice(kinds, "i2")
        self.order = Choice((("le", "lowest byte first (le)"), ("be", "highest byte first (be)")))
        self.columns = QSpinBox(minimum=1, maximum=MAX_CHANNELS, value=2)
        self.header, self.skip = (QSpinBox(maximum=_LARGEST_FIELD) for _ in range(2))
        self.scale = QLineEdit(placeholderText="not known: codes are taken as they are")
        self.offset = QLineEdit("0")
        self.words = PlainLabel()
        self.plot = Plot(theme, "time [s]")
        self.plot.setMinimumSize(280, 200)
        self.faults = {"scale": FaultText(), "offset": FaultText()}
        self.put(("Numbers", self.kind), ("Bytes", self.order), ("Columns", self.columns))
        self.put(("Header [bytes]", self.header), ("Skip [samples]", self.skip))
        self.put(("Scale [V]", self.scale), self.faults["scale"], ("Offset [V]", self.offset), self.faults["offset"])
        self.put(self.plot, self.words)
        for choice in (self.kind, self.order):
            choice.currentIndexChanged.connect(self.changed)
        for count in (self.columns, self.header, self.skip):
            count.valueChanged.connect(self.changed)
        for line in (self.scale, self.offset):
            line.textChanged.connect(self.changed)
        self._ranges: list[str] = []
        self._curves: list[Any] = []

    def stated_layout(self) -> RawLayout | None:
        """Return the layout that the fields tell; None where one cannot be used, which is said at that field."""
        scale, offset = self.scale.text().strip(), self.offset.text().strip()
        counts = {"channels": self.columns, "header": self.header, "skip": self.skip}
        stated = {"dtype": f"{self.kind.currentData()}{self.order.currentData()}", "scale": scale, "offset": offset}
        stated |= {key: str(box.value()) for key, box in counts.items()}
        try:
            layout = parse_raw_layout(",".join(f"{key}={value}" for key, value in stated.items() if value))
        except UsageError as error:
            layout = None
            key, _, said = error.message.removeprefix("--raw: ").partition(" = ")
        for name, fault in self.faults.items():
            fault.say(f"{name.capitalize()}: {said}" if layout is None and name == key else "")
        return layout

    def show_preview(self, columns: FloatArray, rate_hz: float | None) -> None:
        """Show the beginning of each column, shape (columns, n), each as high as the others."""
        self.clear_preview()
        item = self.plot.getPlotItem()
        item.setLabel("bottom", "time [s]" if rate_hz else "sample")
        time = np.arange(columns.shape[1]) / (rate_hz or 1.0)
        for place, values in enumerate(columns):
            finite = values[np.isfinite(values)]
            low, high = (float(finite.min()), float(finite.max())) if finite.size else (0.0, 0.0)
            self._ranges.append(f"{low:.4g} … {high:.4g}")
            middle, half = 0.5 * (low + high), 0.5 * (high - low) or 1.0
            self._curves.append(self.plot.still_line("faint"))
            self._curves[-1].setData(time, (values - middle) / half * _LANE - place)
        item.setYRange(-columns.shape[0] + 0.5, 0.5, padding=0.0)
        item.setXRange(0.0, float(time[-1]) if time.size else 1.0, padding=0.0)
        self.words.setText("Real channels are smooth; jumps all over mean another layout.")

    def name_columns(self, targets: Mapping[str, str]) -> None:
        """Write beside each column its number, what it is chosen as, and its lowest and highest value; colour those."""
        ticks = []
        for place, (curve, span) in enumerate(zip(self._curves, self._ranges, strict=True)):
            target = targets.get(str(place), "")
            curve.setPen(self.plot.colour(target[0].lower() if target else "faint"))
            ticks.append((-place, " ".join(filter(None, (str(place), target, span)))))
        self.plot.getPlotItem().getAxis("left").setTicks([ticks])

    def clear_preview(self) -> None:
        """Show nothing: the layout does not fit the file."""
        self.plot.take_all_out()
        self._curves.clear()
        self._ranges.clear()
        self.name_columns({})
        self.words.setText("")


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
        self.count = QtWidgets.QSpinBox(minimum=1, maximum=MAX_RECEIVERS)
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
