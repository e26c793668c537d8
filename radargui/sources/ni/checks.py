"""Check the settings of a setup, also a start on an edge, against a device before anything starts."""

from dataclasses import dataclass

import numpy as np

from radargui.model.daq import Daq
from radargui.model.errors import DeviceError
from radargui.model.setup import Setup
from radargui.sources.ni.discovery import NiDevice
from radargui.sources.ni.driver import device_error


@dataclass(frozen=True, slots=True)
class StartEdge:
    """The edge that a task waits for.

    Attributes
    ----------
    daq
        Its kind, direction and level.
    source
        As NI-DAQmx wants it: a terminal, /Dev1/PFI0, or the name of a channel in the task, I1.
    pretrigger_samples
        Samples of each channel before the edge; 0: sampling begins at the edge.
    posttrigger_samples
        Samples of each channel from the edge on; 0: until it is stopped.
    """

    daq: Daq
    source: str
    pretrigger_samples: int = 0
    posttrigger_samples: int = 0

    @property
    def total_samples(self) -> int | None:
        """Samples of each channel in all; None: until it is stopped."""
        return self.pretrigger_samples + self.posttrigger_samples if self.pretrigger_samples else None

    def title(self) -> str:
        """Return the edge for people: a rising edge at /Dev1/PFI0."""
        level = f" through {self.daq.start_level_v:g} V" if self.daq.start == "analog" else ""
        return f"a {self.daq.start_edge} edge{level} at {self.source}"


def checked_start(setup: Setup, device: NiDevice) -> StartEdge | None:
    """Return the edge that the setup wants to start at; None: at once.

    Raises
    ------
    DeviceError
        The device has no such trigger, or not at this terminal; the error says what it has.
    """
    daq = setup.daq
    if daq.start == "now":
        return None
    source = _terminal(setup, device) if daq.start == "digital" else _analog_source(setup, device)
    if not daq.start_pretrigger:
        return StartEdge(daq, source)
    if not device.reference_trigger:
        raise device_error("no_reference_trigger", device=device)
    limits = setup.recording
    # NI-DAQmx wants two at least
    return StartEdge(daq, source, *(max(2, round(s * daq.rate_hz)) for s in (limits.pretrigger_s, limits.maximum_s)))


def _terminal(setup: Setup, device: NiDevice) -> str:
    if not device.digital_trigger:
        raise device_error("no_digital_edge", device=device)
    wanted = (setup.daq.start_source or "").rpartition("/")[2]
    known = {line.casefold(): line for line in device.trigger_lines}
    if known and wanted.casefold() not in known:
        raise device_error("no_trigger_line", device=device, wanted=wanted, lines=", ".join(device.trigger_lines))
    return f"/{device.name}/{known.get(wanted.casefold(), wanted)}"


def _analog_source(setup: Setup, device: NiDevice) -> str:
    if not device.analog_trigger:
        raise device_error("no_analog_edge", device=device)
    wanted = setup.daq.start_source or ""
    bare = wanted.rpartition("/")[2]
    if bare.casefold().startswith("apfi"):
        return f"/{device.name}/{bare.upper()}"
    inputs = [channel.rpartition("/")[2].casefold() for channel in setup.physical_channels]
    for name, channel in zip(setup.channel_names, inputs, strict=True):
        if bare.casefold() in (name.casefold(), channel):
            if abs(setup.daq.start_level_v) >= setup.daq.range_v:
                raise device_error("level_outside_range", daq=setup.daq, device=device)
            return name
    raise device_error("no_analog_source", wanted=wanted, device=device, names=", ".join(setup.channel_names))


_ROUNDING = 1e-6
"""Relative: 6 x 33333.334 Hz is 200 kHz for every practical purpose."""

LARGEST_BUFFER_BYTES = 1_000_000_000
"""NI-DAQmx holds its buffer in memory that cannot be swapped out."""

_BYTES = 2
"""Of a sample in the buffer of the driver."""


@dataclass(frozen=True, slots=True)
class TaskSettings:
    """Everything a task needs, checked.

    Attributes
    ----------
    setup
        Names of the channels, terminal configuration, and the rates asked for.
    channels
        Physical channels with the device's name, in the order of the setup's names.
    low_v, high_v
        Input range of the device that is used, in V.
    buffer_samples
        Samples per channel that the driver keeps for us.
    block_samples
        Samples per channel read at a time.
    start
        Edge that sampling waits for; None: it begins at once.
    total_samples
        Samples of each channel in all; None: until it is stopped.
    """

    setup: Setup
    channels: tuple[str, ...]
    low_v: float
    high_v: float
    buffer_samples: int
    block_samples: int
    start: StartEdge | None
    total_samples: int | None


def checked_settings(setup: Setup, device: NiDevice) -> TaskSettings:
    """Return the settings of a task on this device.

    Raises
    ------
    DeviceError
        The device has no such channel, terminal configuration or range, or is too slow or too fast; the error says what
        it has.
    """
    channels = _channels(setup, device)
    _check_terminal(setup, device, channels)
    low_v, high_v = _range(setup, device)
    check_rate(setup, device, len(channels))
    rate_hz = setup.daq.rate_hz
    block = max(1, round(rate_hz * setup.daq.read_interval_s))
    _check_convert_rate(setup, device, len(channels))
    start = checked_start(setup, device)
    # whole blocks: some devices want an even number of samples
    buffer = 2 * block * max(1, int(np.ceil(rate_hz * setup.daq.buffer_s / (2 * block))))
    total = None if start is None else start.total_samples
    _check_buffer(setup, device, total, buffer)
    physical = tuple(f"{device.name}/{channel}" for channel in channels)
    return TaskSettings(setup, physical, low_v, high_v, buffer, block, start, total)


def rate_limit_hz(device: NiDevice, n_channels: int) -> float | None:
    """Return the highest rate of each of `n_channels` channels in S/s; None where the device does not say."""
    single, multi = device.max_rate_single_hz, device.max_rate_multi_hz
    if n_channels == 1:
        return single
    # a converter a channel: the rate of each is that of one
    if device.simultaneous:
        return min((rate for rate in (single, multi) if rate), default=None)
    # one converter for all: they share its rate
    return None if not multi else min(multi / n_channels, single or multi)


def rate_sentence(device: NiDevice, n_channels: int, rate_hz: float) -> str:
    """Return how much of the device's rate is used: "6 channels x 33.3 kS/s = 200 kS/s of 200 kS/s"."""
    limit_hz = rate_limit_hz(device, n_channels)
    if device.simultaneous:
        limit = f" of {format_rate(limit_hz)} each" if limit_hz else ""
        return f"{n_channels} channels at {format_rate(rate_hz)}{limit}"
    limit = f" of {format_rate(n_channels * limit_hz)}" if limit_hz else ""
    return f"{n_channels} channels x {format_rate(rate_hz)} = {format_rate(n_channels * rate_hz)}{limit}"


def format_rate(rate_hz: float) -> str:
    """Return a rate with three significant digits: 33.3 kS/s."""
    for factor, prefix in ((1e6, "M"), (1e3, "k")):
        if rate_hz >= 0.9995 * factor:
            return f"{float(f'{rate_hz / factor:.3g}'):g} {prefix}S/s"
    return f"{float(f'{rate_hz:.3g}'):g} S/s"


def _channels(setup: Setup, device: NiDevice) -> tuple[str, ...]:
    if not device.channels:
        raise device_error("no_inputs", device=device)
    known = {channel.casefold(): channel for channel in device.channels}
    wanted = [channel.rpartition("/")[2] for channel in setup.physical_channels]
    missing = [channel for channel in wanted if channel.casefold() not in known]
    if missing:
        raise device_error(
            "no_channel",
            device=device,
            missing=", ".join(missing),
            there=_shortened(device.channels),
            count=len(wanted),
            names=", ".join(setup.channel_names),
        )
    return tuple(known[channel.casefold()] for channel in wanted)


def _shortened(channels: tuple[str, ...]) -> str:
    return ", ".join(channels) if len(channels) <= 8 else f"{channels[0]} to {channels[-1]}"


def _check_terminal(setup: Setup, device: NiDevice, channels: tuple[str, ...]) -> None:
    wanted = setup.daq.terminal
    offers = dict(zip(device.channels, device.terminals, strict=False))
    for channel in channels:
        offered = offers.get(channel, ())
        if wanted == "default" or not offered or wanted in offered:
            continue
        able = tuple(name for name, choices in offers.items() if wanted in choices)
        raise DeviceError(
            f"{device.name}/{channel} of {device.title} cannot be {wanted}; it can be {' or '.join(offered)}.",
            reasons=("a differential channel uses up a second input as its negative terminal",)
            if wanted == "differential"
            else (),
            remedy=f"Use channels that can be {wanted} ({_shortened(able)}) in daq.channels, or change daq.terminal."
            if able
            else "Change daq.terminal: no channel of this device can be that.",
        )


def _range(setup: Setup, device: NiDevice) -> tuple[float, float]:
    wanted = setup.daq.range_v
    covering = [(low, high) for low, high in device.ranges_v if low <= -wanted and high >= wanted]
    if covering:
        # the smallest range that covers has the finest step
        return min(covering, key=lambda limits: limits[1] - limits[0])
    if not device.ranges_v:
        return -wanted, wanted
    known = device.ranges_v
    ranges = ", ".join(f"+-{high:g} V" if low == -high else f"{low:g} to {high:g} V" for low, high in known)
    raise device_error("no_range", device=device, wanted=wanted, ranges=ranges)


def check_rate(setup: Setup, device: NiDevice, n_channels: int) -> None:
    """Let a rate pass that the device has for so many channels.

    Raises
    ------
    DeviceError
        It is too high, or too low.
    """
    rate_hz = setup.daq.rate_hz
    limit_hz = rate_limit_hz(device, n_channels)
    if limit_hz is not None and rate_hz > limit_hz * (1.0 + _ROUNDING):
        raise device_error(
            "too_fast", device=device, rates=rate_sentence(device, n_channels, rate_hz), limit_hz=np.floor(limit_hz)
        )
    if device.min_rate_hz and rate_hz < device.min_rate_hz:
        raise device_error("too_slow", device=device, rate=format_rate(rate_hz), lowest=format_rate(device.min_rate_hz))


def _check_convert_rate(setup: Setup, device: NiDevice, n_channels: int) -> None:
    convert_hz, rate_hz = setup.daq.convert_rate_hz, setup.daq.rate_hz
    if convert_hz is None:
        return
    if device.simultaneous:
        raise device_error("no_convert_clock", device=device)
    # all channels must be converted within one sample
    if convert_hz < n_channels * rate_hz * (1.0 - _ROUNDING):
        raise device_error(
            "too_few_conversions",
            conversions=format_rate(convert_hz),
            rates=rate_sentence(device, n_channels, rate_hz),
            least_hz=np.ceil(n_channels * rate_hz),
        )
    limit_hz = device.max_rate_multi_hz
    if limit_hz and convert_hz > limit_hz * (1.0 + _ROUNDING):
        raise device_error(
            "converts_too_fast",
            device=device,
            conversions=format_rate(convert_hz),
            limit=format_rate(limit_hz),
            limit_hz=np.floor(limit_hz),
        )


def _check_buffer(setup: Setup, device: NiDevice, total: int | None, buffer: int) -> None:
    # a run about an edge is held whole by the driver, any other by `buffer_s`
    n_bytes = len(setup.channel_names) * _BYTES * (buffer if total is None else total)
    if n_bytes <= LARGEST_BUFFER_BYTES:
        return
    what, keys = (
        (f"daq.buffer_s = {setup.daq.buffer_s:g}", "daq.buffer_s")
        if total is None
        else ("A run with samples from before its start", "recording.pretrigger_s or recording.maximum_s")
    )
    raise device_error(
        "buffer_too_large",
        what=what,
        device=device,
        size_gb=n_bytes / 1e9,
        most_gb=LARGEST_BUFFER_BYTES / 1e9,
        keys=keys,
    )
