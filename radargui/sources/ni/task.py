"""The analogue input task of NI-DAQmx: it is configured, read in codes or volts, and always closed."""

import logging
from collections.abc import Callable
from typing import Any

import numpy as np

from radargui.model.arrays import RawArray
from radargui.model.errors import DeviceError
from radargui.sources.ni.checks import StartEdge, TaskSettings
from radargui.sources.ni.discovery import TERMINALS, NiDevice
from radargui.sources.ni.driver import Driver, driver_errors
from radargui.sources.ni.explain import TIMEOUT, device_errors, error_code, explained
from radargui.sources.ni.questions import Questions

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
