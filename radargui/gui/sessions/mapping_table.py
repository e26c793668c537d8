"""Which channel of a file is I1, Q1, ...: guessed, shown, corrected by the operator."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QSignalBlocker, Signal
from PySide6.QtWidgets import QComboBox, QHeaderView, QSpinBox, QTableWidget, QTableWidgetItem, QVBoxLayout, QWidget

from radargui.experiment.importing import FilesLook
from radargui.files.reading import LARGEST
from radargui.files.signals import ChannelInfo
from radargui.gui.layout import Choice, PlainLabel, fill, side_by_side
from radargui.model.digitisation import iq_names

_BASIS = {
    "names": "The names tell which is which.",
    "order": "Guessed from the order only: look at it.",
    "remembered": "As chosen for such files before.",
    "nothing": "No pairs of channels could be guessed: choose them.",
}


class MappingTable(QWidget):
    """A line for each of I1, Q1, ... with the channel that it is."""

    changed = Signal()

    def __init__(self) -> None:
        super().__init__()
        self._infos: tuple[ChannelInfo, ...] = ()
        self._boxes: list[QComboBox] = []
        self.words = PlainLabel("Choose files first.")
        self.count = QSpinBox()
        self.count.setRange(1, LARGEST)
        self.count.setAccessibleName("Receivers")
        self.count.setMaximumWidth(70)
        self.count.valueChanged.connect(lambda _count: self._fill(self.names))
        self.table = QTableWidget(0, 2)
        self.table.setHorizontalHeaderLabels(["Channel", "Column or variable of the file"])
        self.table.verticalHeader().hide()
        self.table.horizontalHeader().setSectionResizeMode(1, QHeaderView.ResizeMode.Stretch)
        self.table.setMinimumHeight(200)
        fill(QVBoxLayout(self), side_by_side(PlainLabel("Receivers"), self.count, self.words), (self.table, 1))

    @property
    def names(self) -> tuple[str, ...]:
        """The chosen channels as I1, Q1, ...; empty texts where none is chosen."""
        return tuple(box.currentData() or "" for box in self._boxes)

    @property
    def complete(self) -> bool:
        """Whether every channel is chosen, none twice."""
        names = self.names
        return bool(names) and all(names) and len(set(names)) == len(names)

    def box(self, row: int) -> QComboBox:
        """Return the choice of a row."""
        return self._boxes[row]

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
        self.table.setRowCount(0)
        self._boxes.clear()
        self.changed.emit()

    def _fill(self, names: Sequence[str]) -> None:
        targets = iq_names(self.count.value()) if self._infos else []
        self.table.setRowCount(len(targets))
        self._boxes.clear()
        for row, target in enumerate(targets):
            self.table.setItem(row, 0, QTableWidgetItem(target))
            box = Choice((("", "not chosen"), *((info.name, _described(info)) for info in self._infos)))
            box.setAccessibleName(target)
            box.setCurrentIndex(max(box.findData(names[row]) if row < len(names) else 0, 0))
            box.currentIndexChanged.connect(lambda _index: self.changed.emit())
            self.table.setCellWidget(row, 1, box)
            self._boxes.append(box)
        self.changed.emit()


def _described(info: ChannelInfo) -> str:
    facts = filter(None, (f"{info.count} samples", info.unit))
    return f"{info.name}  ({', '.join(facts)})"
