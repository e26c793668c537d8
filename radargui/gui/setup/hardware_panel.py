"""The hardware setup panel: setup file, source and its settings, recording, processing."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QPushButton, QVBoxLayout, QWidget

from radargui.gui.background import Jobs
from radargui.gui.setup.error_line import ChangeLine, ErrorLine
from radargui.gui.setup.form import Choice, FormScroll, Group, hint, plain_label, side_by_side
from radargui.gui.setup.ni_form import FindDevices, NiForm, find_ni_devices
from radargui.gui.setup.processing_form import ProcessingForm, RecordingForm
from radargui.gui.setup.setup_model import SetupModel
from radargui.gui.setup.source_forms import ReplayForm, SimulatedForm
from radargui.gui.theme import Theme
from radargui.sources.factory import SourceKind

SOURCES: dict[SourceKind, str] = {"simulated": "Simulated", "ni": "NI device", "replay": "Replay file"}


class HardwarePanel(QWidget):
    """Chooses the source and edits its settings; closed for changes while samples come in."""

    open_asked = Signal()
    save_asked = Signal()
    save_as_asked = Signal()

    def __init__(
        self,
        model: SetupModel,
        theme: Theme,
        jobs: Jobs,
        *,
        source: SourceKind = "simulated",
        replay_file: Path | None = None,
        find_devices: FindDevices = find_ni_devices,
    ) -> None:
        super().__init__()
        self._model = model
        self._content = QWidget()
        column = QVBoxLayout(self._content)
        column.setContentsMargins(6, 6, 6, 6)
        column.addWidget(self._file_group())

        self.source = Choice()
        self.source.setObjectName("source")
        for kind, words in SOURCES.items():
            self.source.addItem(words, kind)
        group = Group("Source")
        group.row("Samples from", self.source)
        column.addWidget(group)

        self.replay = ReplayForm(replay_file)
        self.ni = NiForm(model, theme, jobs, find_devices)
        self._forms: dict[str, Group] = {
            "simulated": SimulatedForm(model, theme),
            "ni": self.ni,
            "replay": self.replay,
        }
        for form in self._forms.values():
            column.addWidget(form)
        column.addWidget(RecordingForm(model, theme))
        column.addWidget(ProcessingForm(model, theme))
        column.addStretch(1)

        outer = QVBoxLayout(self)
        outer.setContentsMargins(0, 0, 0, 0)
        outer.addWidget(FormScroll(self._content), 1)
        self._hint = hint("Stop to change the setup.")
        outer.addWidget(self._hint)
        outer.addWidget(ChangeLine(model))
        outer.addWidget(ErrorLine(model, theme))

        self.source.setCurrentIndex(self.source.findData(source))
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

    def set_running(self, running: bool) -> None:
        """Close or open the form for changes."""
        self._content.setEnabled(not running)
        self._hint.setVisible(running)

    def _file_group(self) -> Group:
        group = Group("Setup file")
        self._name = plain_label()
        group.whole(self._name)
        buttons = []
        for words, signal in (
            ("Open…", self.open_asked),
            ("Save", self.save_asked),
            ("Save as…", self.save_as_asked),
        ):
            button = QPushButton(words)
            button.clicked.connect(signal)
            buttons.append(button)
        self._save_buttons: list[QPushButton] = buttons[1:]
        group.whole(side_by_side(*buttons))
        self.undo_all = QPushButton("Undo all changes")
        self.undo_all.clicked.connect(lambda: self._model.undo())
        group.whole(self.undo_all)
        return group

    def _name_file(self) -> None:
        path = self._model.path
        name = path.name if path else "not saved yet"
        kind = " (shipped)" if self._model.shipped else ""
        changed = self._model.unsaved
        counted = f", {len(changed)} value{'s' if len(changed) > 1 else ''} changed" if changed else ""
        self._name.setText(f"{name}{kind}{counted}")
        self._name.setToolTip(str(path or ""))
        self.undo_all.setEnabled(self._model.modified)
        self.undo_all.setToolTip("\n".join(("Back to what the file says:", *changed)))
        for button in self._save_buttons:
            button.setEnabled(self._model.valid)

    def _show_form(self) -> None:
        for kind, form in self._forms.items():
            form.setVisible(kind == self.kind)
