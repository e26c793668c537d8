"""Settings of the NI device, and the search for devices that are there."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from PySide6.QtWidgets import QComboBox, QPushButton

from radargui.gui.background import Jobs
from radargui.gui.setup.fields import ChoiceField, ListField, NumberField, TextField
from radargui.gui.setup.form import Group, plain_label
from radargui.gui.setup.setup_model import SetupModel
from radargui.gui.theme import Theme

TERMINALS = {
    "differential": "Differential",
    "rse": "Referenced single-ended (RSE)",
    "nrse": "Non-referenced single-ended (NRSE)",
    "pseudodifferential": "Pseudodifferential",
    "default": "Default of the device",
}
FindDevices = Callable[[str | None], Sequence[Any]]


def find_ni_devices(remote: str | None) -> Sequence[Any]:
    """Ask the driver, or the device server `remote`, for its devices; the driver's package is loaded only now."""
    from radargui.sources.ni.discovery import find_devices

    return find_devices(remote)


class NiForm(Group):
    """Device, channels, terminal, range, rate."""

    def __init__(self, model: SetupModel, theme: Theme, jobs: Jobs, find: FindDevices = find_ni_devices) -> None:
        super().__init__("NI device")
        self._model = model
        self._jobs = jobs
        self._find = find
        self.row("Device", TextField(model, theme, "daq.device"), "Name in NI-DAQmx, for instance Dev1")
        self.row(
            "Device server",
            TextField(model, theme, "daq.remote", optional=True, hint="none: local driver"),
            "host:port of an NI gRPC device server; empty: the driver of this computer",
        )
        self.found = QComboBox()
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
        self.row("Terminal", ChoiceField(model, "daq.terminal", TERMINALS))
        self.row("Range [± V]", NumberField(model, theme, "daq.range_v"))
        self.row(
            "Channel skew [µs]",
            NumberField(model, theme, "daq.channel_skew_s", scale=1e6),
            "Delay of a channel against the one before; read from the device when live",
        )

    def search(self) -> None:
        """Look for devices without holding up the window."""
        remote = self._model.value("daq.remote")
        self.button.setEnabled(False)
        self._say("Searching for devices …")
        find = self._find
        self._jobs.start(
            "the search for devices", lambda: find(remote if isinstance(remote, str) else None), self._show, self._fail
        )

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
