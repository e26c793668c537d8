"""Settings of the NI device, and the search for devices that are there."""

from collections.abc import Callable, Sequence
from typing import Any

from PySide6.QtWidgets import QFileDialog

from radargui.gui.background import Jobs
from radargui.gui.layout import Answer, Choice, button
from radargui.gui.setup.fields import SetupForm
from radargui.gui.setup.setup_model import SetupModel
from radargui.gui.theme import Theme
from radargui.model.setup import Setup

CERTIFICATES = "Certificates (*.pem *.crt *.cer);;All files (*)"
FindDevices = Callable[[str | None, str | None], Sequence[Any]]
CheckSetup = Callable[[Setup], Any]


def find_ni_devices(remote: str | None, certificate: str | None = None) -> Sequence[Any]:
    """Ask the driver, or the device server `remote`, for its devices; the driver's package is loaded only now."""
    from radargui.sources.ni.discovery import find_devices

    return find_devices(remote, certificate)


def check_on_device(setup: Setup) -> Any:
    """Try a setup on its device without sampling; the driver's package is loaded only now."""
    from radargui.sources.ni.source import check_setup

    return check_setup(setup)


class NiForm(SetupForm):
    """Device, channels, terminal, range, start; the search for devices and the check of the setup.

    Attributes
    ----------
    check
        Tries a setup on its device; tests put another one here.
    """

    def __init__(self, model: SetupModel, theme: Theme, jobs: Jobs, find: FindDevices = find_ni_devices) -> None:
        super().__init__("NI device", model, theme)
        self._model, self._jobs, self._find = model, jobs, find
        self.check: CheckSetup = check_on_device
        self.text("daq.device")
        self.text("daq.remote", optional=True, hint="none: local driver")
        browse = button("Choose…", self._browse)
        self.text("daq.remote_certificate", browse, optional=True, hint="none: no encryption")
        self.found = Choice()
        self.found.setVisible(False)
        self.found.activated.connect(self._take)
        self.button = button("Find devices", self.search)
        self.answer, self.checked = Answer(), Answer()
        for part in (self.button, self.found, self.answer):
            self.whole(part)
        self.texts("daq.channels", optional=True, hint="ai0, ai1, …")
        self.choice("daq.terminal")
        self.number("daq.range_v")
        self.number("daq.channel_skew_s")
        self._add_start()
        tip = "Tries it on the device without sampling, and says what will be in force"
        self.check_button = button("Check this setup", self.try_out, tip)
        self.whole(self.check_button)
        self.whole(self.checked)
        model.changed.connect(self._setup_changed)
        model.changed.connect(self._show_start)
        self._show_start()

    def _add_start(self) -> None:
        """Add what says when a run starts, and what happens after an error."""
        start = self.choice("daq.start")
        self._source = self.text("daq.start_source", optional=True, hint="PFI0, or I1 where analogue")
        self._edge = self.choice("daq.start_edge")
        self._level = self.number("daq.start_level_v")
        self._pretrigger = self.yes_no("daq.start_pretrigger")
        self.yes_no("recording.restart_after_error")
        self._within = self.number("recording.restart_within_s")
        start.activated.connect(lambda _index: self._settle(start.currentData()))

    def _settle(self, start: str) -> None:
        """Let what goes with a start that was just chosen be there, and nothing that cannot go with it."""
        if start == "now":
            self._model.assign("daq.start_pretrigger", None)
        elif self._model.value("daq.start_source") is None:
            self._model.assign("daq.start_source", "PFI0" if start == "digital" else "I1")

    def _show_start(self) -> None:
        """Hide what does not belong to the chosen start."""
        start = self._model.value("daq.start")
        for field in (self._source, self._edge, self._pretrigger):
            self.rows.setRowVisible(field, start != "now")
        self.rows.setRowVisible(self._level, start == "analog")
        self.rows.setRowVisible(self._within, self._model.value("recording.restart_after_error") is True)

    def search(self) -> None:
        """Look for devices without holding up the window."""
        remote, certificate = self._text("daq.remote"), self._text("daq.remote_certificate")
        self.button.setEnabled(False)
        self.answer.say("Searching for devices …")
        find = self._find
        self._jobs.start("the search for devices", lambda: find(remote, certificate), self._show, self._fail)

    def try_out(self) -> None:
        """Try the setup on its device without holding up the window."""
        setup, check = self._model.setup, self.check
        self.check_button.setEnabled(False)
        self.checked.say("Asking the device …")
        self._jobs.start("the check of the setup", lambda: check(setup), self._passed, self._refused)

    def _passed(self, found: Any) -> None:
        lines = (f"{what.capitalize()}: {how}" for what, how in found.lines)
        self.checked.say("\n".join((f"The setup works on {found.device.title}.", *lines)))
        self.check_button.setEnabled(self._model.valid)

    def _refused(self, error: BaseException) -> None:
        self.checked.say(str(error) or type(error).__name__)
        self.check_button.setEnabled(self._model.valid)

    def _setup_changed(self) -> None:
        # what was found is about another setup
        self.checked.say("")
        self.check_button.setEnabled(self._model.valid)

    def _browse(self) -> None:
        name, _ = QFileDialog.getOpenFileName(self, "Certificate of the device server", "", CERTIFICATES)
        if name:
            self._model.assign("daq.remote_certificate", name)

    def _text(self, key: str) -> str | None:
        value = self._model.value(key)
        return value if isinstance(value, str) and value else None

    def _show(self, devices: Sequence[Any]) -> None:
        self.button.setEnabled(True)
        self.found.clear()
        for device in devices:
            self.found.addItem(describe_device(device), device.name)
        self.found.setVisible(bool(devices))
        if not devices:
            self.answer.say("No device found. Is it plugged in and powered, and does NI MAX show it?")
            return
        self.answer.say(f"{len(devices)} device{'s' if len(devices) > 1 else ''} found: choose one.")
        index = self.found.findData(self._model.value("daq.device"))
        self.found.setCurrentIndex(max(index, 0))
        if len(devices) == 1:
            self._take(0)

    def _fail(self, error: BaseException) -> None:
        self.button.setEnabled(True)
        self.found.setVisible(False)
        self.answer.say(str(error) or type(error).__name__)

    def _take(self, index: int) -> None:
        self._model.assign("daq.device", self.found.itemData(index))


def describe_device(device: Any) -> str:
    """Return one line for a device found."""
    state = "" if device.connected else ", not connected"
    simulated = ", simulated by the driver" if device.simulated else ""
    return f"{device.title}{simulated}{state}"
