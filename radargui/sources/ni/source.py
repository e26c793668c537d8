"""The NI device as a source of samples, and a trial of a setup on it without sampling.

The analogue input task of NI-DAQmx: it is configured, read in codes or volts, and always closed.
"""

import logging
import threading
from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass
from typing import Any

import numpy as np

from radargui.model.arrays import RawArray
from radargui.model.daq import Daq
from radargui.model.errors import DeviceError
from radargui.model.recording import Block, Digitisation, channel_skew
from radargui.model.setup import Setup
from radargui.sources.contract import SYSTEM_CLOCK, Clock, Source
from radargui.sources.ni.checks import StartEdge, TaskSettings, checked_settings, rate_sentence
from radargui.sources.ni.discovery import TERMINALS, NiDevice, Questions, find_device
from radargui.sources.ni.driver import (
    TIMEOUT,
    Driver,
    device_error,
    device_errors,
    driver_errors,
    error_code,
    explained,
    of_code,
)

_log = logging.getLogger(__name__)

_CODE_BITS = 16
"""Codes of another size would not fit int16: volts are read instead."""


class InputTask:
    """One task with all channels, continuous sampling.

    Parameters
    ----------
    driver
        The way to the device; stays the caller's.
    device, settings
        What is there and what is wanted, checked.

    Raises
    ------
    DeviceError
        The driver refuses, or the device is in use; no task is left behind.

    Attributes
    ----------
    settings
        What was asked for.
    rate_hz
        Rate in force, in S/s.
    convert_rate_hz
        Rate of the converter in force in conversions/s; None for simultaneous sampling and where it is not known.
    buffer_samples
        Samples of each channel that the driver keeps; None where it does not say.
    scaling
        Per channel the coefficients of volts = sum c_k code^k; None where samples come as volts.
    """

    def __init__(self, driver: Driver, device: NiDevice, settings: TaskSettings) -> None:
        self._driver = driver
        self._device = device
        self.settings = settings
        self._task: Any = None
        self._questions = Questions(driver.place, device.name)
        self._running = False
        self.rate_hz = settings.setup.daq.rate_hz
        self.convert_rate_hz: float | None = None
        self.buffer_samples: int | None = None
        self._left = settings.total_samples
        self.scaling: tuple[tuple[float, ...], ...] | None = None
        try:
            with self._errors("configuring"):
                self._configure()
        except DeviceError:
            self.close()
            raise

    def _errors(self, doing: str) -> Any:
        return device_errors(self._device.title, self._driver.place, doing)

    def _configure(self) -> None:
        from nidaqmx.constants import AcquisitionType, TaskMode, TerminalConfiguration

        settings, daq = self.settings, self.settings.setup.daq
        self._task = task = self._driver.new_task()
        terminal = TerminalConfiguration["DEFAULT" if daq.terminal == "default" else TERMINALS[daq.terminal]]
        channels = [
            task.ai_channels.add_ai_voltage_chan(
                physical,
                name_to_assign_to_channel=name,
                terminal_config=terminal,
                min_val=settings.low_v,
                max_val=settings.high_v,
            )
            for name, physical in zip(settings.setup.channel_names, settings.channels, strict=True)
        ]
        task.timing.cfg_samp_clk_timing(
            daq.rate_hz,
            sample_mode=AcquisitionType.CONTINUOUS if settings.total_samples is None else AcquisitionType.FINITE,
            samps_per_chan=settings.total_samples or settings.buffer_samples,
        )
        if daq.convert_rate_hz is not None:
            task.timing.ai_conv_rate = daq.convert_rate_hz
        if settings.start is not None:
            self._wait_for(settings.start)
        # reserves the device now: who else has it shows before the operator drops anything
        task.control(TaskMode.TASK_COMMIT)
        self.buffer_samples = self._questions.ask("buffer", lambda: int(task.in_stream.input_buf_size))
        # read back: clocks divide by whole numbers, so the rate in force is seldom the one asked for
        self.rate_hz = float(task.timing.samp_clk_rate)
        if not self._device.simultaneous:
            # 0 is no rate: the skew then comes from the setup
            what = f"convert rate of {len(channels)} channels"
            self.convert_rate_hz = self._questions.ask(what, lambda: float(task.timing.ai_conv_rate)) or None
        self.scaling = self._scaling(channels)
        # another skew or another scaling than before would be used without a word
        if (forgotten := self._questions.forgotten(self._device.title)) is not None:
            raise forgotten
        self._read_into = self._reader()

    def _wait_for(self, start: StartEdge) -> None:
        """Configure the edge at which sampling starts, or about which samples are kept."""
        from nidaqmx.constants import Edge, Slope

        triggers = self._task.triggers
        kept = (start.pretrigger_samples,) if start.pretrigger_samples else ()
        reference, begin = triggers.reference_trigger, triggers.start_trigger
        if start.daq.start == "digital":
            configure = reference.cfg_dig_edge_ref_trig if kept else begin.cfg_dig_edge_start_trig
            configure(start.source, *kept, Edge[start.daq.start_edge.upper()])
        else:
            configure = reference.cfg_anlg_edge_ref_trig if kept else begin.cfg_anlg_edge_start_trig
            configure(start.source, *kept, Slope[start.daq.start_edge.upper()], start.daq.start_level_v)

    def _scaling(self, channels: list[Any]) -> tuple[tuple[float, ...], ...] | None:
        # codes as the converter gave them are a quarter of the bytes, and their scaling goes into the file
        ask = self._questions.ask
        bits = ask("bits", lambda: {channel.ai_raw_samp_size for channel in channels})
        scaling = ask("scaling", lambda: tuple(tuple(map(float, channel.ai_dev_scaling_coeff)) for channel in channels))
        return scaling if bits == {_CODE_BITS} and scaling and all(scaling) else None

    def _reader(self) -> Any:
        from nidaqmx.stream_readers import AnalogMultiChannelReader, AnalogUnscaledReader

        codes = self.scaling is not None
        reader = (AnalogUnscaledReader if codes else AnalogMultiChannelReader)(self._task.in_stream)
        # the shape is right by construction; checking it would cost a call to the server for each block
        reader.verify_array_shape = False
        return reader.read_int16 if codes else reader.read_many_sample

    def start(self) -> None:
        """Begin to sample.

        Raises
        ------
        DeviceError
            The driver refuses.
        """
        with self._errors("starting"):
            self._task.start()
        self._left = self.settings.total_samples
        self._running = True

    @property
    def is_complete(self) -> bool:
        """Whether all samples of a run of a fixed length were read."""
        return self._left == 0

    def read(self, timeout_s: float) -> tuple[RawArray, DeviceError | None]:
        """Return the next samples, shape (n_channels, n), a new array; blocks for a block of them or `timeout_s`.

        Too few samples within the time are no error: n is then small or 0. After an error the samples that were read
        before it come with it.
        """
        n_channels, wanted = len(self.settings.channels), self.settings.block_samples
        if self._left is not None:
            wanted = min(wanted, self._left)
        shape = (n_channels, wanted)
        block: RawArray = np.empty(shape) if self.scaling is None else np.empty(shape, dtype=np.int16)
        failure = None
        try:
            n_read = int(self._read_into(block, number_of_samples_per_channel=wanted, timeout=timeout_s))
        except driver_errors() as error:
            n_read = int(getattr(error, "samps_per_chan_read", 0) or 0)
            # too few samples in time is no failure: the caller asks again
            if error_code(error) != TIMEOUT:
                failure = explained(error, self._device.title, self._driver.place, "reading")
                # a device server answers such an error without the samples
                n_read = 0 if self._driver.remote is not None else n_read
        if self._left is not None:
            self._left -= n_read
        return _packed(block, n_read), failure

    def available(self) -> int:
        """Return how many samples per channel wait in the driver; raises the driver's own error."""
        return int(self._task.in_stream.avail_samp_per_chan) if self._running else 0

    def stop(self) -> None:
        """End sampling; idempotent. A driver that repeats an old error here is not listened to: reading reported it."""
        if not self._running:
            return
        self._running = False
        self._quietly(self._task.stop, "stopping")

    def close(self) -> None:
        """Release the device; idempotent."""
        self.stop()
        task, self._task = self._task, None
        if task is not None:
            self._quietly(task.close, "closing")

    def _quietly(self, step: Callable[[], None], doing: str) -> None:
        try:
            step()
        except driver_errors() as error:
            _log.info("%s: %s: %s", self._device.title, doing, error)


def _packed(block: RawArray, n_read: int) -> RawArray:
    """Return the first samples of a block that was not filled.

    NI-DAQmx packs a short read at the front of the buffer: channel k starts at k * n_read,
    not at k * (length of a row).
    """
    n_channels, wanted = block.shape
    if n_read >= wanted:
        return block
    return block.reshape(-1)[: n_channels * n_read].reshape(n_channels, n_read).copy()


READ_SLICE_S = 0.25
"""How long one call to the driver may block: a stop is seen at least as often."""

EMPTY_READS = 4
"""Calls without a single sample after which the device is said to give none."""

_STOP_WAIT_S = 2.0
"""Eight slices of a read: a reader that needs longer hangs in a dead connection."""


class NiSource(Source):
    """Samples of an NI device, local or behind an NI gRPC device server; keeps the contract of a source.

    Parameters
    ----------
    setup
        `daq` says which device, channels, range, rate and start.
    clock
        For the longest wait for the edge that sampling starts at.

    Attributes
    ----------
    device, task
        The device in use, and the task as configured; None before `open`.
    is_waiting
        Whether sampling was started and the edge it begins at has not come yet.
    """

    is_waiting = False
    restarts = 0

    def __init__(self, setup: Setup, *, clock: Clock = SYSTEM_CLOCK) -> None:
        self._setup = setup
        self._clock = clock
        self._start: StartEdge | None = None
        self._driver: Driver | None = None
        self.device: NiDevice | None = None
        self.task: InputTask | None = None
        self._stopping = threading.Event()
        self._reading = threading.Lock()
        self._using = threading.RLock()
        self._index = 0
        self._backlog = 0
        self._error: DeviceError | None = None
        self._started_s = 0.0

    def open(self) -> Digitisation:
        """Reserve and configure the device; return how samples will be digitised, rate and skew as in force.

        Raises
        ------
        DeviceError
            Package, driver, server or device missing, device in use, or settings that it does not have.
        """
        self.close()
        with self._using:
            daq = self._setup.daq
            self._driver = driver = Driver(daq.remote, daq.remote_certificate)
            try:
                self.device = device = find_device(driver, daq.device)
                settings = checked_settings(self._setup, device)
                self._start = settings.start
                self.task = task = InputTask(driver, device, settings)
            except DeviceError:
                self._release()
                raise
        _log.info(
            "%s: %s, range %g to %g V, buffer of %s samples a channel, converter at %s conversions/s",
            device.title,
            rate_sentence(device, len(self._setup.channel_names), task.rate_hz),
            settings.low_v,
            settings.high_v,
            task.buffer_samples,
            task.convert_rate_hz,
        )
        serial = f", serial {device.serial_number}" if device.serial_number else ""
        return Digitisation(
            channel_names=self._setup.channel_names,
            sample_rate_hz=task.rate_hz,
            scaling=task.scaling,
            channel_skew_s=self._skew_s(device, task),
            device=f"{device.product_type or device.name}{serial}",
        )

    def _skew_s(self, device: NiDevice, task: InputTask) -> float:
        if device.simultaneous:
            return 0.0
        if task.convert_rate_hz is None:
            return self._setup.daq.channel_skew_s
        # converted one after the other: the delay from channel to channel
        return 1.0 / task.convert_rate_hz

    def start(self) -> None:
        """Begin to sample; index 0 is the first sample after this call.

        Raises
        ------
        DeviceError
            Not open, or the driver refuses.
        """
        with self._using:
            if self.task is None:
                raise DeviceError("The NI device was not opened before it was started.", remedy="Start again.")
            self._stopping.clear()
            self._index = 0
            self._error = None
            self.is_waiting = self._start is not None
            self.task.start()
            self._started_s = self._clock.now()

    def read(self) -> Block | None:
        """Return the next block, or None after `stop` and after the last sample of a run of a fixed length.

        Raises
        ------
        DeviceError
            Samples were lost, none came, the device was removed, the server went away; once what was read before has
            been returned.
        """
        with self._reading:
            empty = 0
            while not self._stopping.is_set() and (task := self.task) is not None and not task.is_complete:
                if self._error is not None:
                    raise self._error
                samples, self._error = task.read(READ_SLICE_S)
                if samples.shape[1]:
                    return self._block(samples)
                empty += 1
                if self._error is None and not self._stopping.is_set():
                    self._error = self._silence(empty)
            return None

    def _block(self, samples: RawArray) -> Block:
        # with the first block only; index 0 is the first sample kept from before the edge
        trigger = None if self._index or self._start is None else self._start.pretrigger_samples
        block = Block(samples, self._index, trigger_index=trigger)
        self._index = block.end_index
        self.is_waiting = False
        return block

    def _silence(self, empty_reads: int) -> DeviceError | None:
        """Return what is wrong where nothing comes; None where that may be."""
        title = self.device.title if self.device else self._setup.daq.device
        if self.is_waiting and self._start is not None:
            wait_s = self._setup.recording.wait_s
            late = self._clock.now() > self._started_s + wait_s
            edge = self._start.title().removeprefix("a ")
            return device_error("no_edge", device=title, edge=edge, seconds=wait_s) if late else None
        said = f": none arrived within {EMPTY_READS * READ_SLICE_S:g} s (NI-DAQmx error {TIMEOUT})"
        return of_code(TIMEOUT, title, said) if empty_reads >= EMPTY_READS else None

    def stop(self) -> None:
        """End sampling; idempotent, from any thread. A blocked `read` returns None within `READ_SLICE_S`."""
        self._stopping.set()
        # a reader in the driver leaves soon; one that hangs in a dead connection is not waited for
        free = self._reading.acquire(timeout=_STOP_WAIT_S)
        try:
            with self._using:
                if self.task is not None:
                    self.task.stop()
        finally:
            if free:
                self._reading.release()

    def close(self) -> None:
        """Release the device and the connection; idempotent."""
        self.stop()
        self._release()

    def _release(self) -> None:
        with self._using:
            parts = self.task, self._driver
            self.task = self._driver = None
            for part in parts:
                if part is not None:
                    part.close()

    def backlog(self) -> int:
        """Return how many samples per channel wait in the driver; the last known number while that cannot be asked."""
        # never waits: the screen asks, and a reader in the driver may be slow
        if self._using.acquire(blocking=False):
            try:
                self._backlog = 0 if self.task is None or self._stopping.is_set() else self.task.available()
            except driver_errors() as error:
                _log.debug("backlog: %s", error)
            finally:
                self._using.release()
        return self._backlog


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
    with closing(NiSource(setup)) as source:
        digitisation = source.open()
        device, task = source.device, source.task
        lines = () if device is None or task is None else _lines(setup, device, task, digitisation)
    return SetupCheck(device or NiDevice(setup.daq.device), digitisation, lines)


def _lines(setup: Setup, device: NiDevice, task: InputTask, digitisation: Digitisation) -> tuple[tuple[str, str], ...]:
    settings = task.settings
    wiring = ", ".join(map("{} {}".format, setup.channel_names, settings.channels))
    buffer = task.buffer_samples or settings.buffer_samples
    start = settings.start
    lines = [
        ("device", digitisation.device),
        ("channels", wiring),
        ("terminal", setup.daq.terminal),
        ("range", f"{settings.low_v:g} to {settings.high_v:g} V"),
        ("rate", rate_sentence(device, len(setup.channel_names), task.rate_hz)),
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
