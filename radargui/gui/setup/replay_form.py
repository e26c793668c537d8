"""Settings of the replay: which file."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtWidgets import QFileDialog, QLineEdit, QPushButton

from radargui.gui.setup.form import Group, plain_label, side_by_side

FILTER = "Recordings (*.h5 *.csv *.mat *.tdms *.sigmf-meta *.sigmf-data *.sigmf);;All files (*)"


class ReplayForm(Group):
    """The file whose samples are played back in real time."""

    def __init__(self, path: Path | None = None) -> None:
        super().__init__("Replay")
        self._line = QLineEdit(str(path) if path else "")
        self._line.setPlaceholderText("recording to play back")
        self._line.setObjectName("replay.file")
        browse = QPushButton("Choose…")
        browse.clicked.connect(self._browse)
        self.row("File", side_by_side(self._line, browse))
        self.whole(plain_label("Runs of RadarGUI, CSV, MATLAB, TDMS and SigMF files with channels I1, Q1, …"))

    @property
    def path(self) -> Path | None:
        """The chosen file."""
        text = self._line.text().strip().strip('"')
        return Path(text) if text else None

    def choose(self, path: Path) -> None:
        """Take a file."""
        self._line.setText(str(path))

    def _browse(self) -> None:
        start = str(self.path.parent) if self.path else ""
        name, _ = QFileDialog.getOpenFileName(self, "File to replay", start, FILTER)
        if name:
            self.choose(Path(name))
