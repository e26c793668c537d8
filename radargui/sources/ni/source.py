"""The NI device as a source of samples, and a trial of a setup on it without sampling."""

import logging
import threading
from contextlib import closing
from dataclasses import dataclass

from radargui.model.arrays import RawArray
from radargui.model.daq import Daq
from radargui.model.errors import DeviceError
from radargui.model.recording import Block, Digitisation, channel_skew
from radargui.model.setup import Setup
from radargui.sources.contract import SYSTEM_CLOCK, Clock, Source
from radargui.sources.ni.checks import StartEdge, checked_settings, rate_sentence
from radargui.sources.ni.discovery import NiDevice, find_device
from radargui.sources.ni.driver import Driver, device_error, driver_errors
from radargui.sources.ni.explain import TIMEOUT, of_code
from radargui.sources.ni.task import InputTask

_log = logging.getLogger(__name__)

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
