"""The hardware setup panel: setup file, source and its settings, recording, processing."""

from pathlib import Path

from PySide6.QtWidgets import QFileDialog, QLineEdit

from radargui.gui.background import Jobs
from radargui.gui.layout import Choice, FaultText, Group, PlainLabel, button, side_by_side
from radargui.gui.menus import Actions
from radargui.gui.setup.fields import FormPanel, SetupForm
from radargui.gui.setup.ni_form import FindDevices, NiForm, find_ni_devices
from radargui.gui.setup.setup_model import SetupModel
from radargui.gui.setup.words import called
from radargui.gui.theme import Theme
from radargui.sources.factory import SourceKind

SOURCES: dict[SourceKind, str] = {"simulated": "Simulated", "ni": "NI device", "replay": "Replay file"}
FILTER = "Recordings (*.h5 *.csv *.mat *.tdms *.sigmf-meta *.sigmf-data *.sigmf);;All files (*)"


class HardwarePanel(FormPanel):
    """Chooses the source and edits its settings; closed for changes while samples come in."""

    def __init__(
        self,
        model: SetupModel,
        theme: Theme,
        jobs: Jobs,
        does: Actions,
        *,
        source: SourceKind = "simulated",
        replay_file: Path | None = None,
        find_devices: FindDevices = find_ni_devices,
    ) -> None:
        super().__init__(model, theme)
        self._does = does
        self.source = Choice(SOURCES.items())
        self.source.setObjectName("source")
        group = Group("Source")
        group.row("Samples from", self.source)
        self.replay = ReplayForm(theme, replay_file)
        self.ni = NiForm(model, theme, jobs, find_devices)
        simulated = SetupForm("Simulated source", model, theme)
        simulated.choice("simulation.scene")
        simulated.number("simulation.drop_height_m", optional=True, hint="release to floor")
        simulated.numbers("simulation", "restitution", "lateral_speed_m_s", "snr_db", "mismatch")
        simulated.number("simulation.seed", whole=True)
        recording = SetupForm("Recording", model, theme)
        recording.number("daq.rate_hz")
        recording.numbers("recording", "pretrigger_s", "quiet_s", "maximum_s", "threshold")
        processing = SetupForm("Processing", model, theme)
        processing.choice("processing.correction")
        processing.choice("processing.geometry")
        self._forms: dict[str, Group] = {"simulated": simulated, "ni": self.ni, "replay": self.replay}
        self.lay_out(self._file_group(), group, *self._forms.values(), recording, processing)
        self.choose(source)
        self.source.currentIndexChanged.connect(self._show_form)
        model.changed.connect(self._name_file)
        self._show_form()
        self._name_file()

    @property
    def kind(self) -> SourceKind:
        """The chosen source."""
        kind: SourceKind = self.source.currentData()
        return kind

    def choose(self, kind: SourceKind) -> None:
        """Choose a source."""
        self.source.setCurrentIndex(self.source.findData(kind))

    def _file_group(self) -> Group:
        group = Group("Setup file")
        self._name = PlainLabel()
        does = self._does
        self._save_buttons = (button("Save", does.save_setup.trigger), button("Save as…", does.save_setup_as.trigger))
        self.undo_all = button("Undo all changes", does.undo_setup.trigger)
        opens = button("Open…", does.open_setup.trigger)
        for part in (self._name, side_by_side(opens, *self._save_buttons), self.undo_all):
            group.whole(part)
        return group

    def _name_file(self) -> None:
        path, changed = self._model.path, self._model.unsaved
        name = path.name if path else "not saved yet"
        kind = " (shipped)" if self._model.shipped else ""
        counted = f", {len(changed)} value{'s' if len(changed) > 1 else ''} changed" if changed else ""
        self._name.setText(f"{name}{kind}{counted}")
        self._name.setToolTip(str(path or ""))
        self.undo_all.setEnabled(self._model.modified)
        self.undo_all.setToolTip("\n".join(("Back to what the file says:", *map(called, changed))))
        for one in self._save_buttons:
            one.setEnabled(self._model.valid)

    def _show_form(self) -> None:
        for kind, form in self._forms.items():
            form.setVisible(kind == self.kind)
        self.refresh()


class ReplayForm(Group):
    """The file whose samples are played back in real time."""

    def __init__(self, theme: Theme, path: Path | None = None) -> None:
        super().__init__("Replay")
        self._line = QLineEdit(str(path) if path else "")
        self._line.setPlaceholderText("recording to play back")
        self._line.setObjectName("replay.file")
        self.fault = fault = FaultText(theme)
        self._line.textChanged.connect(lambda _text: fault.say(""))
        self.row("File", side_by_side(self._line, button("Choose…", self._browse)), fault=fault)
        self.whole(PlainLabel("Runs of RadarGUI, CSV, MATLAB, TDMS and SigMF files with channels I1, Q1, …"))

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
