"""A setup tried on its device without sampling: what the device will do, line by line."""

from __future__ import annotations

from dataclasses import dataclass

from radargui.model.daq import Daq
from radargui.model.digitisation import Digitisation, channel_skew
from radargui.model.setup import Setup
from radargui.sources.ni.checks import rate_sentence
from radargui.sources.ni.device import NiDevice
from radargui.sources.ni.source import NiSource
from radargui.sources.ni.task import InputTask


@dataclass(frozen=True, slots=True)
class SetupCheck:
    """What a device does with a setup, as read back from it.

    Attributes
    ----------
    device
        The device.
    digitisation
        Channels, rate and skew in force.
    lines
        The same for people: (what, how).
    """

    device: NiDevice
    digitisation: Digitisation
    lines: tuple[tuple[str, str], ...]


def check_setup(setup: Setup) -> SetupCheck:
    """Reserve and configure the device of a setup, read back what is in force, and release it.

    Raises
    ------
    DeviceError
        Driver, server or device missing, device in use, or settings that it does not have.
    """
    source = NiSource(setup)
    try:
        digitisation = source.open()
        device, task = source.device, source.task
        lines = () if device is None or task is None else _lines(setup, device, task, digitisation)
    finally:
        source.close()
    return SetupCheck(device or NiDevice(setup.daq.device), digitisation, lines)


def _lines(setup: Setup, device: NiDevice, task: InputTask, digitisation: Digitisation) -> tuple[tuple[str, str], ...]:
    settings = task.settings
    wiring = ", ".join(f"{name} {channel}" for name, channel in zip(settings.names, settings.channels, strict=True))
    buffer = task.buffer_samples or settings.buffer_samples
    start = settings.start
    lines = [
        ("device", digitisation.device),
        ("channels", wiring),
        ("terminal", settings.terminal),
        ("range", f"{settings.low_v:g} to {settings.high_v:g} V"),
        ("rate", rate_sentence(device, len(settings.names), task.rate_hz)),
        ("skew", _skew(device, task, digitisation, setup.daq)),
        ("samples", "16 bit codes with the device's scaling" if task.scaling else "volts"),
        ("buffer", f"{buffer} samples a channel, {buffer / task.rate_hz:.3g} s"),
        ("start", "at once" if start is None else f"at {start.title()}"),
    ]
    if start is not None and start.total_samples is not None:
        before_s, after_s = start.pretrigger_samples / task.rate_hz, start.posttrigger_samples / task.rate_hz
        lines.append(("run", f"{before_s:.3g} s before the edge and {after_s:.3g} s after it"))
    if setup.recording.restart_after_error:
        lines.append(("after an error", f"started again within {setup.recording.restart_within_s:g} s"))
    return tuple(lines)


def _skew(device: NiDevice, task: InputTask, digitisation: Digitisation, daq: Daq) -> str:
    if device.simultaneous:
        return "none: all channels are sampled at the same instant"
    skew = f"{channel_skew(digitisation, daq).delay_s * 1e6:.3g} us from channel to channel"
    return skew if task.convert_rate_hz else f"{skew}, from the setup: the device does not say"
