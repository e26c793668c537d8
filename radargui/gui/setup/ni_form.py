"""Settings of the NI device, and the search for devices that are there."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from PySide6.QtWidgets import QFileDialog, QPushButton

from radargui.gui.background import Jobs
from radargui.gui.setup.device_start_form import DeviceStartForm
from radargui.gui.setup.fields import ChoiceField, ListField, NumberField, TextField
from radargui.gui.setup.form import Choice, Group, plain_label, side_by_side
from radargui.gui.setup.setup_model import SetupModel
from radargui.gui.theme import Theme
from radargui.model.setup import Setup

TERMINALS = {
    "differential": "Differential",
    "rse": "Referenced single-ended (RSE)",
    "nrse": "Non-referenced single-ended (NRSE)",
    "pseudodifferential": "Pseudodifferential",
    "default": "Default of the device",
}
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


class NiForm(Group):
    """Device, channels, terminal, range, start; the search for devices and the check of the setup.

    Attributes
    ----------
    check
        Tries a setup on its device; tests put another one here.
    """

    def __init__(self, model: SetupModel, theme: Theme, jobs: Jobs, find: FindDevices = find_ni_devices) -> None:
        super().__init__("NI device")
        self._model = model
        self._jobs = jobs
        self._find = find
        self.check: CheckSetup = check_on_device
        self.row("Device", TextField(model, theme, "daq.device"), "Name in NI-DAQmx, for instance Dev1")
        self.row(
            "Device server",
            TextField(model, theme, "daq.remote", optional=True, hint="none: local driver"),
            "host:port of an NI gRPC device server; empty: the driver of this computer",
        )
        self._certificate = TextField(model, theme, "daq.remote_certificate", optional=True, hint="none: no encryption")
        browse = QPushButton("Choose…")
        browse.clicked.connect(self._browse)
        self.row(
            "Certificate",
            side_by_side(self._certificate, browse),
            "File (PEM) that a device server with encryption (TLS) is known by; empty: no encryption",
        )
        self.found = Choice()
        self.found.setVisible(False)
        self.found.activated.connect(self._take)
        self.button = QPushButton("Find devices")
        self.button.clicked.connect(self.search)
        self.whole(self.button)
        self.whole(self.found)
        self.answer = plain_label()
        self.answer.setVisible(False)
        self.whole(self.answer)
        self.row(
            "Channels",
            ListField(model, theme, "daq.channels", optional=True, hint="ai0, ai1, …"),
            "In the order I1, Q1, I2, Q2, …; empty: ai0, ai1, …",
        )
        self.row("Terminal", ChoiceField(model, theme, "daq.terminal", TERMINALS))
        self.row("Range [± V]", NumberField(model, theme, "daq.range_v"))
        self.row(
            "Channel skew [µs]",
            NumberField(model, theme, "daq.channel_skew_s", scale=1e6),
            "Delay of a channel against the one before; read from the device when live",
        )
        self.start = DeviceStartForm(self, model, theme)
        self.check_button = QPushButton("Check this setup")
        self.check_button.setToolTip("Tries it on the device without sampling, and says what will be in force")
        self.check_button.clicked.connect(self.try_out)
        self.whole(self.check_button)
        self.checked = plain_label()
        self.checked.setVisible(False)
        self.whole(self.checked)
        model.changed.connect(self._setup_changed)

    def search(self) -> None:
        """Look for devices without holding up the window."""
        remote, certificate = self._text("daq.remote"), self._text("daq.remote_certificate")
        self.button.setEnabled(False)
        self._say("Searching for devices …")
        find = self._find
        self._jobs.start("the search for devices", lambda: find(remote, certificate), self._show, self._fail)

    def try_out(self) -> None:
        """Try the setup on its device without holding up the window."""
        setup, check = self._model.setup, self.check
        self.check_button.setEnabled(False)
        self._show_check("Asking the device …")
        self._jobs.start("the check of the setup", lambda: check(setup), self._passed, self._refused)

    def _passed(self, found: Any) -> None:
        lines = (f"{what.capitalize()}: {how}" for what, how in found.lines)
        self._show_check("\n".join((f"The setup works on {found.device.title}.", *lines)))
        self.check_button.setEnabled(self._model.valid)

    def _refused(self, error: BaseException) -> None:
        self._show_check(str(error) or type(error).__name__)
        self.check_button.setEnabled(self._model.valid)

    def _setup_changed(self) -> None:
        # what was found is about another setup
        self.checked.setVisible(False)
        self.check_button.setEnabled(self._model.valid)

    def _show_check(self, text: str) -> None:
        self.checked.setText(text)
        self.checked.setVisible(True)

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
            self._say("No device found. Is it plugged in and powered, and does NI MAX show it?")
            return
        self._say(f"{len(devices)} device{'s' if len(devices) > 1 else ''} found: choose one.")
        index = self.found.findData(self._model.value("daq.device"))
        self.found.setCurrentIndex(max(index, 0))
        if len(devices) == 1:
            self._take(0)

    def _fail(self, error: BaseException) -> None:
        self.button.setEnabled(True)
        self.found.setVisible(False)
        self._say(str(error) or type(error).__name__)

    def _take(self, index: int) -> None:
        self._model.assign("daq.device", self.found.itemData(index))

    def _say(self, text: str) -> None:
        self.answer.setText(text)
        self.answer.setVisible(True)


def describe_device(device: Any) -> str:
    """Return one line for a device found."""
    state = "" if device.connected else ", not connected"
    simulated = ", simulated by the driver" if device.simulated else ""
    return f"{device.title}{simulated}{state}"
