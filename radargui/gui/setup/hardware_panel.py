"""The hardware setup panel: setup file, source and its settings, the search for NI devices, recording, processing."""

import re
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from PySide6.QtWidgets import QFileDialog, QProgressBar, QWidget

from radargui.experiment.importing import valid_setup_of
from radargui.gui.background import Jobs, Then, Work
from radargui.gui.layout import (
    Answer,
    Choice,
    FaultText,
    Group,
    OneLine,
    PathField,
    PlainLabel,
    button,
    having,
    side_by_side,
)
from radargui.gui.panels import Actions
from radargui.gui.services import Services
from radargui.gui.setup.fields import FormPanel, ModelGroup, SetupForm
from radargui.gui.setup.setup_model import MAX_NAMED, SetupModel, named
from radargui.gui.setup_words import FORMS, called, in_words
from radargui.model.errors import DeviceError
from radargui.model.plugins import plugins
from radargui.model.setup import MEASURING, Setup
from radargui.model.setup_error import changed_settings
from radargui.model.words import counted, percent
from radargui.sources.factory import SourceKind
from radargui.sources.ni.checks import check_rate, rate_limit_hz, rate_sentence
from radargui.sources.ni.discovery import NiDevice
from radargui.sources.ni.source import check_setup

CERTIFICATES = "Certificates (*.pem *.crt *.cer);;All files (*)"
FindDevices = Callable[[str | None, str | None], Sequence[Any]]
_UNKNOWN = "“Find devices” or “Check this setup” tells the limit of the device."


class RateView(ModelGroup):
    """The aggregate rate of the setup against the limit of its device, where that is known.

    Attributes
    ----------
    fault
        Why the device cannot sample so; empty while it can, or nobody knows.
    """

    def __init__(self, model: SetupModel) -> None:
        self._known: dict[tuple[str | None, str], NiDevice] = {}
        self.fault = ""
        self.words, self.bar, self.wrong = PlainLabel(), QProgressBar(maximum=1000, textVisible=False), FaultText()
        self.bar.setFixedHeight(10)
        super().__init__("Rate of all channels", model, self.words, self.bar, self.wrong)

    def take(self, *devices: NiDevice) -> None:
        """Remember what devices can do, each at the place where it was asked for."""
        place = self._model.setup.daq.remote
        self._known |= {(place, one.name.casefold()): one for one in devices if isinstance(one, NiDevice)}
        self.refresh()

    def refresh(self) -> None:
        """Show what the setup asks for, and what there is."""
        setup, daq = self._model.setup, self._model.setup.daq
        device, count = self._known.get((daq.remote, daq.device.casefold())), 2 * setup.n_receivers
        limit_hz = None if device is None else rate_limit_hz(device, count)
        said = rate_sentence(device or NiDevice(daq.device), count, daq.rate_hz)
        self.fault = ""
        if device is None:
            said = f"{said}. {_UNKNOWN}"
        else:
            how = "simultaneous: each has a" if device.simultaneous else "multiplexed: they share one"
            said = f"{said} ({device.title}, {how} converter)"
            try:
                check_rate(setup, device, count)
            except DeviceError as error:
                self.fault = in_words(str(error))
        self.words.setText(said)
        self.wrong.say(self.fault)
        self.bar.setVisible(limit_hz is not None)
        if limit_hz is not None:
            share = daq.rate_hz / limit_hz
            self.bar.setValue(round(1000.0 * min(1.0, share)))
            self.bar.setToolTip(f"{percent(share)} of the highest rate that the device has for {count} channels, S/s")
        colour = "bright-text" if self.fault else "highlight"
        self.bar.setStyleSheet(f"QProgressBar::chunk {{ background: palette({colour}); }}")


FILTER = "Recordings (*.h5 *.csv *.mat *.tdms *.sigmf-meta *.sigmf-data *.sigmf);;All files (*)"


class ReplayForm(Group):
    """The file whose samples are played back in real time; it says where the setup is not that of the recording."""

    def __init__(self, model: SetupModel, jobs: Jobs, path: Path | None) -> None:
        super().__init__("Replay")
        self._model, self._jobs = model, jobs
        self._own: Setup | None = None
        self.file = PathField("File to replay", path, FILTER)
        having(self.file.line, placeholderText="recording to play back", objectName="replay.file")
        said = PlainLabel("Runs of RadarGUI, CSV, MATLAB, TDMS and SigMF files with channels I1, Q1, …")
        self.other, self.take_own = PlainLabel(), button("Use the recording's setup", self._take)
        self.put(("File", self.file), said, self.other, self.take_own)
        self.file.line.textChanged.connect(self._look)
        model.changed.connect(self._compare)
        self._look()

    def _look(self) -> None:
        self._found(None)
        path = self.file.path
        # a name that is being typed is no file yet
        if path is not None and path.suffix:
            what, work = "the setup of the recording", partial(valid_setup_of, path)
            # what is wrong with the file is said when it is played
            self._jobs.start(what, work, self._found, lambda _: self._found(None), lambda: path == self.file.path)

    def _found(self, setup: Setup | None) -> None:
        self._own = setup
        self._compare()

    def _compare(self) -> None:
        changed = () if self._own is None else changed_settings(self._own, self._model.setup)
        keys = [one.key for one in changed if re.split(r"[.\[]", one.key)[0] in MEASURING]
        other = "This recording was made with another setup, and is computed with the one here"
        self.other.setText(f"{other}: {named(keys)}{'' if len(keys) > MAX_NAMED else '.'}")
        for part in (self.other, self.take_own):
            part.setVisible(bool(keys))
        # what was edited and stands in no file would be lost
        self.take_own.setEnabled(not self._model.unsaved)

    def _take(self) -> None:
        if self._own is not None:
            self._model.replace(self._own)


class NiForm(SetupForm):
    """Device, channels, terminal, range, start; the search for devices and the check of the setup.

    Attributes
    ----------
    check
        Tries a setup on its device; tests put another one here.
    """

    def __init__(self, model: SetupModel, jobs: Jobs, rates: RateView, find: FindDevices) -> None:
        super().__init__("ni", model)
        self._jobs, self._find, self._rates = jobs, find, rates
        self.check: Callable[[Setup], Any] = check_setup
        self.add("daq.remote_certificate", beside=[button("Choose…", self._browse)])
        self.found = having(Choice(), toolTip="The NI devices that answered: the one chosen here is used")
        self.found.activated.connect(self._take)
        self.button = button("Find devices", self.search)
        self.answer, self.checked = Answer(), Answer()
        self.put(self.button, self.found, self.answer)
        self.found.hide()
        self.add(*FORMS["ni_inputs"]["keys"])
        start = self.fields["daq.start"]
        if isinstance(start, Choice):
            start.activated.connect(lambda _index: self._settle(start.currentData()))
        self.check_button = button("Check this setup", self.try_out)
        self.put(self.check_button, self.checked)
        model.changed.connect(self._setup_changed)
        self._setup_changed()

    def _settle(self, start: str) -> None:
        """Let what goes with a start that was just chosen be there, and nothing that cannot go with it."""
        if start == "now":
            self._model.assign("daq.start_pretrigger", None)
        elif self._model.value("daq.start_source") is None:
            self._model.assign("daq.start_source", "PFI0" if start == "digital" else "I1")

    def _setup_changed(self) -> None:
        # what was found is about another setup
        self.checked.say("")
        self.check_button.setEnabled(self._model.valid)
        # what does not belong to the chosen start is hidden
        start = self._model.value("daq.start")
        shown = dict.fromkeys(("daq.start_source", "daq.start_edge", "daq.start_pretrigger"), start != "now")
        shown["daq.start_level_v"] = start == "analog"
        shown["recording.restart_within_s"] = self._model.value("recording.restart_after_error") is True
        for key, visible in shown.items():
            self.rows.setRowVisible(self.fields[key], visible)

    def search(self) -> None:
        """Look for devices without holding up the window."""
        asked = (self._model.value(key) or None for key in ("daq.remote", "daq.remote_certificate"))
        work = partial(self._find, *asked)
        self.found.setVisible(False)
        self._ask("the search for devices", self.button, self.answer, "Searching for devices …", work, self._show)

    def try_out(self) -> None:
        """Try the setup on its device without holding up the window."""
        work = partial(self.check, self._model.setup)
        self._ask("the check of the setup", self.check_button, self.checked, "Asking the device …", work, self._passed)

    def _ask(self, what: str, asks: QWidget, answer: Answer, said: str, work: Work, then: Then) -> None:
        """Ask the device in the background; what keeps it from answering stands where the answer would."""
        asks.setEnabled(False)
        answer.say(said)

        def refuse(error: BaseException) -> None:
            answer.say(in_words(str(error)) or type(error).__name__)

        def ended(take: Then, value: Any) -> None:
            take(value)
            asks.setEnabled(asks is not self.check_button or self._model.valid)

        self._jobs.start(what, work, partial(ended, then), partial(ended, refuse))

    def _passed(self, found: Any) -> None:
        self._rates.take(found.device)
        lines = (f"{what.capitalize()}: {how}" for what, how in found.lines)
        self.checked.say("\n".join((f"The setup works on {found.device.title}.", *lines)))

    def _browse(self) -> None:
        name, _ = QFileDialog.getOpenFileName(self, "Certificate of the device server", "", CERTIFICATES)
        if name:
            self._model.assign("daq.remote_certificate", name)

    def _show(self, devices: Sequence[Any]) -> None:
        self._rates.take(*devices)
        titles = []
        for one in devices:
            facts = {"simulated by the driver": one.simulated, "not connected": not one.connected}
            titles.append((one.name, ", ".join((one.title, *(words for words, holds in facts.items() if holds)))))
        self.found.offer(titles, self._model.value("daq.device"))
        self.found.setVisible(bool(devices))
        if not devices:
            self.answer.say(
                "No device found. Is it plugged in and powered, does NI MAX show it, does this NI-DAQmx support it? "
                "E Series devices (DAQPad-6015 ...) are reported to need 19.x: see Help, The NI device."
            )
            return
        self.answer.say(f"{counted(len(devices), 'device')} found: choose one.")
        if len(devices) == 1:
            self._take(0)

    def _take(self, index: int) -> None:
        self._model.assign("daq.device", self.found.itemData(index))


class SetupFileGroup(ModelGroup):
    """Names the setup file and how far the setup has left it; opens and saves it."""

    def __init__(self, model: SetupModel, does: Actions) -> None:
        self._name = OneLine()
        self._save_buttons = (button("Save", does.save_setup.trigger), button("Save as…", does.save_setup_as.trigger))
        self.undo_all = button("Undo all changes", does.undo_setup.trigger)
        line = side_by_side(button("Open…", does.open_setup.trigger), *self._save_buttons)
        super().__init__("Setup file", model, self._name, line, self.undo_all)

    def refresh(self) -> None:
        """Show what is unlike the file."""
        path, changed = self._model.path, () if self._model.reviewed else self._model.unsaved
        name = (
            path.name if path else f"of {self._model.reviewed}, read only" if self._model.reviewed else "not saved yet"
        )
        kind = " (shipped)" if self._model.shipped else ""
        edited = f", {counted(len(changed), 'value')} changed" if changed else ""
        having(self._name, text=f"{name}{kind}{edited}", toolTip=str(path or ""))
        self.undo_all.setEnabled(self._model.modified)
        self.undo_all.setToolTip("\n".join(("Back to what the file says:", *map(called, changed))))
        for one in self._save_buttons:
            one.setEnabled(self._model.valid)


SOURCES: dict[SourceKind, str] = {"simulated": "Simulated", "ni": "NI device", "replay": "Replay file"}


class HardwarePanel(FormPanel):
    """Chooses the source and edits its settings; closed for changes while samples come in."""

    def __init__(
        self, model: SetupModel, does: Actions, services: Services, source: SourceKind, find_devices: FindDevices
    ) -> None:
        super().__init__(model, does.take_over.trigger)
        self.source = Choice([*SOURCES.items(), *((name, name) for name in plugins("sources"))])
        group = Group("Source", ("Samples from", having(self.source, objectName="source")))
        self.replay = ReplayForm(model, services.jobs, services.settings.path("replay_file"))
        self.rates = RateView(model)
        self.only_shows = (self.rates,)
        self.ni = NiForm(model, services.jobs, self.rates, find_devices)
        simulated, recording, processing, signal = (
            SetupForm(name, model) for name in ("simulated", "recording", "processing", "simulated_signal")
        )
        self._forms: dict[str, Group] = {"simulated": simulated, "ni": self.ni, "replay": self.replay}
        self.file = SetupFileGroup(model, does)
        self.no_setup = (self.file, group, self.replay)
        sections = {"Source": (group, *self._forms.values(), self.rates), "Recording": (recording,)}
        self.lay_out(self.file, {**sections, "Processing": (processing,), "Advanced": (signal,)})
        self.choose(source)
        self.source.currentIndexChanged.connect(self._show_form)
        self._show_form()

    @property
    def kind(self) -> SourceKind:
        """The chosen source."""
        kind: SourceKind = self.source.currentData()
        return kind

    def check(self) -> str:
        """Return why the source chosen cannot be started, also said at its field; empty where nothing is known."""
        if self.kind == "ni":
            return self.rates.fault
        missing = self.kind == "replay" and self.replay.file.path is None
        self.replay.file.refuse("No file to replay is chosen" if missing else "")
        return "No file to replay is chosen. Choose one under Hardware setup." if missing else ""

    def choose(self, kind: SourceKind) -> None:
        """Choose a source."""
        self.source.setCurrentIndex(self.source.findData(kind))

    def _show_form(self) -> None:
        for kind, form in self._forms.items():
            form.setVisible(kind == self.kind)
        self.sections.offer("Advanced", wanted=self.kind == "simulated")
        # a simulation and a file have no limit
        self.rates.setVisible(self.kind == "ni")
        self.refresh()
