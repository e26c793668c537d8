"""Settings of the simulated source and of the replay."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from PySide6.QtWidgets import QFileDialog, QLineEdit, QPushButton

from radargui.gui.setup.fields import ChoiceField, NumberField
from radargui.gui.setup.form import Group, plain_label, side_by_side
from radargui.gui.setup.setup_model import SetupModel
from radargui.gui.theme import Theme

FILTER = "Recordings (*.h5 *.csv *.mat *.tdms *.sigmf-meta *.sigmf-data *.sigmf);;All files (*)"
SCENES = {
    "drop": "Free fall with bounces",
    "circle": "Circle",
    "pendulum": "Pendulum",
    "bed": "Stop in a granular bed",
    "rest": "At rest",
}


class SimulatedForm(Group):
    """Scene, sphere and signal of the simulation."""

    def __init__(self, model: SetupModel, theme: Theme) -> None:
        super().__init__("Simulated source")

        def number(name: str, **options: Any) -> NumberField:
            return NumberField(model, theme, f"simulation.{name}", **options)

        self.row("Scene", ChoiceField(model, theme, "simulation.scene", SCENES))
        self.row(
            "Drop height [mm]",
            number("drop_height_m", scale=1000.0, optional=True, hint="release to floor"),
            "From the release to the floor; empty: what the release position and the floor give",
        )
        self.row("Restitution e", number("restitution"), "Coefficient of restitution of each impact")
        self.row("Lateral speed [m/s]", number("lateral_speed_m_s"), "Horizontal speed of the sphere at its release")
        self.row("SNR [dB]", number("snr_db"), "Signal-to-noise ratio of the white noise")
        self.row(
            "Mismatch [% of amplitude]",
            number("mismatch", scale=100.0),
            "Size of every kind of IQ mismatch that the setup file does not set by itself",
        )
        self.row("Seed", number("seed", whole=True), "Same seed, same noise")


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
