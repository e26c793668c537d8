"""The export dialog: the chosen run or the whole session, format, folder."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QCheckBox, QComboBox, QDialog, QFileDialog, QLineEdit, QPushButton, QVBoxLayout, QWidget

from radargui.files.export import EXPORT_FORMATS, ExportFormat
from radargui.gui.setup.form import Group, side_by_side
from radargui.session.export import FOLDER


@dataclass(frozen=True, slots=True)
class ExportOrder:
    """What the operator wants: a session folder or a run file, written in a format to a folder."""

    what: Path
    kind: ExportFormat
    folder: Path
    force: bool


class ExportDialog(QDialog):
    """Asks what to export."""

    ordered = Signal(object)

    def __init__(self, session: Path, run: Path | None, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setWindowTitle("Export samples")
        self.setMinimumWidth(520)
        self.what = QComboBox()
        if run is not None:
            self.what.addItem(f"The chosen run, {run.stem}", run)
        self.what.addItem(f"All runs of the session {session.name}", session)
        self.kind = QComboBox()
        for kind in EXPORT_FORMATS.values():
            self.kind.addItem(f"{kind.title} ({', '.join(kind.suffixes)})", kind.name)
        self.folder = QLineEdit(str(session / FOLDER))
        browse = QPushButton("Choose…")
        browse.setAutoDefault(False)
        browse.clicked.connect(self._browse)
        self.replace = QCheckBox("Replace files that are there")
        go = QPushButton("Export")
        go.setDefault(True)
        go.clicked.connect(self._order)
        self.go = go
        cancel = QPushButton("Cancel")
        cancel.setAutoDefault(False)
        cancel.clicked.connect(self.reject)
        group = Group()
        group.row("What", self.what)
        group.row("Format", self.kind, "Each file carries the settings and units")
        group.row("Folder", side_by_side(self.folder, browse))
        group.whole(self.replace)
        column = QVBoxLayout(self)
        column.addWidget(group)
        column.addWidget(side_by_side(go, cancel))
        self.folder.textChanged.connect(lambda text: go.setEnabled(bool(text.strip())))

    def _browse(self) -> None:
        name = QFileDialog.getExistingDirectory(self, "Export to", self.folder.text())
        if name:
            self.folder.setText(name)

    def _order(self) -> None:
        folder = Path(self.folder.text().strip().strip('"')).expanduser()
        kind = EXPORT_FORMATS[self.kind.currentData()]
        self.ordered.emit(ExportOrder(Path(self.what.currentData()), kind, folder, self.replace.isChecked()))
        self.accept()
