"""How much of the device's rate the channels take together: in words, as a bar, and refused before Start."""

from PySide6.QtWidgets import QProgressBar

from radargui.gui.layout import FaultText, Group, PlainLabel, follow
from radargui.gui.setup.setup_model import SetupModel
from radargui.gui.setup.words import in_words
from radargui.model.errors import DeviceError
from radargui.sources.ni.checks import check_rate, rate_limit_hz, rate_sentence
from radargui.sources.ni.discovery import NiDevice

_UNKNOWN = "“Find devices” or “Check this setup” tells the limit of the device."


class RateView(Group):
    """The aggregate rate of the setup against the limit of its device, where that is known.

    Attributes
    ----------
    fault
        Why the device cannot sample so; empty while it can, or nobody knows.
    """

    def __init__(self, model: SetupModel) -> None:
        super().__init__("Rate of all channels")
        self._model = model
        self._known: dict[tuple[str | None, str], NiDevice] = {}
        self.fault = ""
        self.words, self.bar, self.wrong = PlainLabel(), QProgressBar(maximum=1000, textVisible=False), FaultText()
        self.bar.setFixedHeight(10)
        for part in (self.words, self.bar, self.wrong):
            self.whole(part)
        follow(model.changed, self.refresh)

    def take(self, *devices: NiDevice) -> None:
        """Remember what devices can do, each at the place where it was asked for."""
        place = self._model.setup.daq.remote
        self._known |= {(place, one.name.casefold()): one for one in devices if isinstance(one, NiDevice)}
        self.refresh()

    def refresh(self) -> None:
        """Show what the setup asks for, and what there is."""
        setup, daq = self._model.setup, self._model.setup.daq
        device, count, rate_hz = (
            self._known.get((daq.remote, daq.device.casefold())),
            setup.n_receivers * 2,
            daq.rate_hz,
        )
        limit_hz = None if device is None else rate_limit_hz(device, count)
        said = rate_sentence(device or NiDevice(setup.daq.device), count, rate_hz)
        self.fault = ""
        if device is None:
            said = f"{said}. {_UNKNOWN}"
        else:
            how = (
                "simultaneous: each has a converter" if device.simultaneous else "multiplexed: they share one converter"
            )
            said = f"{said} ({device.title}, {how})"
            try:
                check_rate(setup, device, count)
            except DeviceError as error:
                self.fault = in_words(str(error))
        self.words.setText(said)
        self.wrong.say(self.fault)
        self.bar.setVisible(limit_hz is not None)
        if limit_hz is not None:
            self.bar.setValue(round(1000.0 * min(1.0, rate_hz / limit_hz)))
            self.bar.setToolTip(
                f"{rate_hz / limit_hz:.0%} of the highest rate that the device has for {count} channels, S/s"
            )
        self.bar.setStyleSheet(
            f"QProgressBar::chunk {{ background: palette({'bright-text' if self.fault else 'highlight'}); }}"
        )
