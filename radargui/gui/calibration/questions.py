"""The first two steps of a calibration: recordings with what is known of each, and what is unknown."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QAbstractItemView, QCheckBox, QFileDialog, QHBoxLayout, QVBoxLayout, QWidget

from radargui.calibration.unknowns import U_UNSTATED, USUAL
from radargui.experiment.calibrating import FALL
from radargui.files.formats import SUFFIXES
from radargui.gui.layout import TIPS, Group, Paragraph, PlainLabel, button, fill
from radargui.gui.setup.words import called, words_of
from radargui.gui.table import RowModel, RowTable
from radargui.model.assumed import uncertain_inputs
from radargui.model.calibrated_setup import unit_of
from radargui.model.resources import resources_folder
from radargui.model.setup import Setup

_RECORDINGS = f"Recordings ({' '.join('*' + suffix for suffix in SUFFIXES)});;All files (*)"
_PATHS = "Known motions (*.toml *.csv);;All files (*)"
GROUPS = {
    "tilt": ("Tilt of each receiver", (".tilt_deg",)),
    "azimuth": ("Azimuth of each receiver", (".azimuth_deg",)),
    "distance": ("Distance of each antenna", (".distance_m",)),
    "transmitter": ("Place of the transmitter, also off the axis", ()),
    "release": ("Place of the release", ("release_position_m[3]",)),
    "gravity": ("Direction of gravity against z", ()),
    "polarization": ("Polarisation of each antenna", (".polarization_deg",)),
}
"""What may be unknown, in words, and which values of the setup are its priors."""


@dataclass(frozen=True, slots=True)
class Recorded:
    """A recording, and what is known of its motion: `fall`, or the file that says it."""

    file: Path
    known: str = FALL

    @property
    def words(self) -> str:
        """What is known, for people."""
        return "free fall" if self.known == FALL else Path(self.known).name


class RecordingList(QWidget):
    """Recordings to calibrate from; what is known is set of those that are chosen, of all where none is."""

    changed = Signal()

    def __init__(self) -> None:
        super().__init__()
        columns = {
            "Recording": lambda one: one.file.name,
            "What is known of it": lambda one: one.words,
            "Folder": lambda one: str(one.file.parent),
        }
        self.rows = RowModel[Recorded](columns, lambda one: str(one.file))
        self.table = RowTable(self.rows, "calibration.recordings")
        self.table.setSelectionMode(QAbstractItemView.SelectionMode.ExtendedSelection)
        self.table.setAccessibleName("Recordings")
        self.add = button("Add recordings…", self._ask_files)
        self.fall = button("Known: free fall", lambda: self.say_known(FALL), "Gravity is known, and straight")
        self.path = button("Known: path…", self._ask_path, "A stage, turntable or pendulum (TOML), or a table (CSV)")
        self.remove = button("Remove", lambda: self._replace(one for one in self.entries if one not in self._chosen))
        buttons = fill(QHBoxLayout(), self.add, self.fall, self.path, 1, self.remove, spacing=6)
        words = (
            "Drops of a session are a calibration by themselves, best from several places and heights. With a stage, a "
            f"turntable or a pendulum say how it moves: ready files to copy lie in {resources_folder() / 'paths'}."
        )
        fill(QVBoxLayout(self), Paragraph(words), (self.table, 1), buttons, spacing=6)
        self._show_buttons()

    @property
    def entries(self) -> list[Recorded]:
        """The recordings in order."""
        return self.rows.entries

    def put(self, files: Iterable[Path], known: str = FALL) -> None:
        """Add recordings that are not there yet."""
        there = {one.file for one in self.entries}
        self._replace([*self.entries, *(Recorded(file, known) for file in files if file not in there)])

    def clear(self) -> None:
        """Take all out."""
        self._replace(())

    def say_known(self, known: str) -> None:
        """Say what is known of the chosen recordings."""
        chosen = self._chosen or self.entries
        self._replace([replace(one, known=known) if one in chosen else one for one in self.entries])

    @property
    def _chosen(self) -> list[Recorded]:
        return [self.entries[index.row()] for index in self.table.selectionModel().selectedRows()]

    def _replace(self, entries: Iterable[Recorded]) -> None:
        self.table.show_rows(entries)
        self._show_buttons()
        self.changed.emit()

    def _show_buttons(self) -> None:
        for one in (self.fall, self.path, self.remove):
            one.setEnabled(bool(self.entries))

    def _ask_files(self) -> None:
        names, _ = QFileDialog.getOpenFileNames(self, "Recordings to calibrate from", "", _RECORDINGS)
        self.put(map(Path, names))

    def _ask_path(self) -> None:
        name, _ = QFileDialog.getOpenFileName(self, "How it moved", str(resources_folder() / "paths"), _PATHS)
        if name:
            self.say_known(name)


class UnknownsForm(QWidget):
    """What the calibration may change, with what the setup knows of it."""

    changed = Signal()

    def __init__(self) -> None:
        super().__init__()
        group = Group("Unknown")
        self.boxes: dict[str, QCheckBox] = {}
        self._priors: dict[str, PlainLabel] = {}
        for name, (words, _) in GROUPS.items():
            box, prior = QCheckBox(words), PlainLabel()
            box.setToolTip(TIPS["fields"].get(words, ""))
            box.setChecked(name in USUAL)
            box.toggled.connect(self.changed)
            self.boxes[name], self._priors[name] = box, prior
            group.rows.addRow(box, prior)
        words = (
            "What is not checked stays as the setup has it. Each unknown begins with the setup's value and "
            "uncertainty; where the setup gives none a wide one is taken."
        )
        fill(QVBoxLayout(self), Paragraph(words), group, 1, spacing=6)

    @property
    def free(self) -> tuple[str, ...]:
        """The groups that are checked."""
        return tuple(name for name, box in self.boxes.items() if box.isChecked())

    def show_setup(self, setup: Setup) -> None:
        """Show what a setup knows of each group."""
        plain = setup.model_copy(update={"calibration": type(setup.calibration)()})
        given = [one for one in uncertain_inputs(plain) if not one.assumed]
        for name, (_, ends) in GROUPS.items():
            own = [one for one in given if ends and one.key.endswith(ends)]
            said = [f"{called(one.key).partition(':')[0]} ± {words_of(one.key).with_unit(one.u)}" for one in own]
            if ends and not said:
                # of the first receiver: all are written in one unit
                key = f"receiver[1]{ends[0]}" if ends[0].startswith(".") else "tracer.u_release_m"
                unit, scale = unit_of(key)
                said = [f"no uncertainty given: ± {U_UNSTATED[name] * scale:g} {unit} taken"]
            self._priors[name].setText(", ".join(said))
