"""Ask the driver which NI devices there are and what they can do.

Ask NI-DAQmx about one device, and remember what it answered before.

After a device was unplugged and plugged in again, NI-DAQmx may fail to tell its properties to a process that knew it
before, and tell them to any other (nidaqmx-python issue 818). A property that a device never had fails in the same way.
"""

from collections.abc import Callable
from contextlib import closing, suppress
from dataclasses import dataclass
from multiprocessing import get_context
from multiprocessing.connection import Connection
from typing import Any, Literal, TypeAlias, TypeVar

from radargui.model.errors import DeviceError
from radargui.sources.ni.driver import (
    NOT_CONNECTED,
    Driver,
    device_error,
    device_errors,
    error_code,
    load_nidaqmx,
    of_code,
)

_ANSWERED: set[tuple[str, str, str]] = set()
"""Place, device and property, of this process: the driver forgets them for the process."""
_LONGEST_S = 20.0
"""A process starts and loads the driver in two or three; chosen by hand for a slow disk."""

_Answer = TypeVar("_Answer")


class Questions:
    """Asks one device for its properties.

    Parameters
    ----------
    place
        Where the driver is: "this computer" or HOST:PORT.
    device
        Name of the device.

    Attributes
    ----------
    lost
        Properties that it told this process once, and does not tell any more.
    """

    def __init__(self, place: str, device: str) -> None:
        self._device = place, device
        self.lost: list[str] = []

    def ask(self, what: str, question: Callable[[], Any], default: Any = None) -> Any:
        """Return the answer of the driver, or the default where this device does not have that property."""
        key = (*self._device, what)
        try:
            answer = question()
        except load_nidaqmx().errors.DaqError:
            if key in _ANSWERED:
                self.lost.append(what)
            return default
        _ANSWERED.add(key)
        return answer

    def forgotten(self, title: str) -> DeviceError | None:
        """Return what is said of a device of that title where anything is lost."""
        if not self.lost:
            return None
        return device_error("forgotten", title=title, place=self._device[0], lost=", ".join(self.lost))


def asked_afresh(question: Callable[[str], _Answer], device: str) -> _Answer | None:
    """Return what a new process is told of a device; None where it is told nothing.

    Parameters
    ----------
    question
        A function of a module, asked with the device's name in the new process.
    device
        Name of the device.
    """
    context = get_context("spawn")
    answers, end = context.Pipe(duplex=False)
    # daemon: a driver that hangs must not keep the program from ending
    process = context.Process(target=_answer, args=(end, question, device), daemon=True)
    try:
        process.start()
        end.close()
        return answers.recv() if answers.poll(_LONGEST_S) else None
    except (EOFError, OSError):
        return None
    finally:
        answers.close()
        if process.pid is not None:
            process.kill()
            process.join()


def _answer(connection: Connection, question: Callable[[str], object], device: str) -> None:
    # who asks is told nothing, and says so
    with suppress(Exception):
        connection.send(question(device))


TerminalChoice: TypeAlias = Literal["differential", "rse", "nrse", "pseudodifferential"]
TERMINALS: dict[TerminalChoice, str] = {
    "differential": "DIFF",
    "rse": "RSE",
    "nrse": "NRSE",
    "pseudodifferential": "PSEUDO_DIFF",
}
"""What NI-DAQmx calls them."""


@dataclass(frozen=True, slots=True)
class NiDevice:
    """One device known to NI-DAQmx.

    Attributes
    ----------
    name
        Name in NI-DAQmx: Dev1.
    product_type
        Product: DAQPad-6015; empty where the driver does not say.
    serial_number
        Hexadecimal, as printed on the device; empty where there is none.
    channels
        Analogue inputs without the device's name: ai0, ai1, ...
    terminals
        Terminal configurations of each of `channels`, in the same order.
    ranges_v
        Input ranges, (lowest, highest) in V.
    max_rate_single_hz
        Highest rate of a single channel in S/s; None where not known.
    max_rate_multi_hz
        Highest rate with several channels in S/s: of all channels together on a multiplexed device, of each channel on
        a simultaneous one; None where not known.
    min_rate_hz
        Lowest rate in S/s; None where not known.
    simultaneous
        True: all channels are sampled at the same instant. False: one after another.
    digital_trigger, analog_trigger
        A start on a digital or on an analogue edge is supported.
    reference_trigger
        Samples from before an edge can be kept by the device.
    trigger_lines
        Terminals that can take a digital edge, without the device's name: PFI0, ...
    simulated
        A device that NI-DAQmx simulates.
    connected
        False: configured in NI-DAQmx but not reachable now.
    """

    name: str
    product_type: str = ""
    serial_number: str = ""
    channels: tuple[str, ...] = ()
    terminals: tuple[tuple[TerminalChoice, ...], ...] = ()
    ranges_v: tuple[tuple[float, float], ...] = ()
    max_rate_single_hz: float | None = None
    max_rate_multi_hz: float | None = None
    min_rate_hz: float | None = None
    simultaneous: bool = False
    digital_trigger: bool = False
    analog_trigger: bool = False
    reference_trigger: bool = False
    trigger_lines: tuple[str, ...] = ()
    simulated: bool = False
    connected: bool = True

    @property
    def title(self) -> str:
        """Name and product for people: Dev1 (DAQPad-6015)."""
        return f"{self.name} ({self.product_type})" if self.product_type else self.name


_UNREACHABLE = (-201003, -200324, -200045, -88705, -88709, -88710, -201250, -201251, -201252, -201253, -201390)
"""NI-DAQmx: the device is configured, but it cannot be accessed."""

_TRIGGER_LINES = ("PFI", "RTSI", "PXI_Trig")


def find_devices(remote: str | None = None, certificate: str | None = None) -> tuple[NiDevice, ...]:
    """Return the NI devices of this computer, or of a device server at HOST:PORT, in the driver's order.

    `certificate`: file with the certificate of a device server with encryption.

    Raises
    ------
    DeviceError
        The package or the driver is missing, or the device server cannot be reached.
    """
    with closing(Driver(remote, certificate)) as driver, device_errors("the devices", driver.place, "looking for"):
        return tuple(_known(driver, device)[0] for device in driver.system().devices)


def driver_version(remote: str | None = None, certificate: str | None = None) -> str | None:
    """Return the version of NI-DAQmx; None where the package or the local driver is missing.

    `certificate`: file with the certificate of a device server with encryption.

    Raises
    ------
    DeviceError
        `remote` is given and that device server cannot be reached.
    """
    try:
        nidaqmx = load_nidaqmx()
    except DeviceError:
        return None
    with closing(Driver(remote, certificate)) as driver:
        try:
            with device_errors("the driver", driver.place, "asking the version of"):
                version = driver.system().driver_version
        except DeviceError as error:
            if isinstance(error.__cause__, (nidaqmx.errors.DaqNotFoundError, nidaqmx.errors.DaqNotSupportedError)):
                return None
            raise
    return _numbers(version)


def find_device(driver: Driver, name: str) -> NiDevice:
    """Return the device of that NI-DAQmx name (upper or lower case).

    Raises
    ------
    DeviceError
        There is no device, none of that name (the error names those that are there), it is not connected, or the
        driver has forgotten what it can do.
    """
    with device_errors(name, driver.place, "looking for"):
        system = driver.system()
        devices = list(system.devices)
        for device in devices:
            if device.name.casefold() == name.casefold():
                found, forgotten = _known(driver, device)
                if not found.connected:
                    raise of_code(NOT_CONNECTED, found.title)
                if forgotten is not None:
                    raise forgotten
                return found
        there = [_title(driver, one) for one in devices]
        version = _numbers(system.driver_version)
    if not there:
        raise no_device(driver.place, version)
    raise device_error("no_such_device", name=name, place=driver.place, version=version, there=", ".join(there))


def no_device(place: str, version: str) -> DeviceError:
    """Return what is said where a driver of that version knows no device at all."""
    return device_error("no_device", place=place, version=version)


def _numbers(version: Any) -> str:
    return f"{version.major_version}.{version.minor_version}.{version.update_version}"


def _title(driver: Driver, device: Any) -> str:
    product = Questions(driver.place, device.name).ask("product", lambda: device.product_type, "")
    return NiDevice(device.name, product_type=product).title


def _known(driver: Driver, device: Any) -> tuple[NiDevice, DeviceError | None]:
    """Return a device, and what is said where the driver does not tell all of it any more, not to a new process either.

    A device server's driver is in its process: there is no other to ask.
    """
    questions = Questions(driver.place, device.name)
    found = _describe(questions, device)
    if not questions.lost or not found.connected:
        return found, None
    afresh = asked_afresh(_described_here, device.name) if driver.remote is None else None
    return (found, questions.forgotten(found.title)) if afresh is None else (afresh, None)


def _described_here(name: str) -> NiDevice:
    """Describe a device of this computer; in a process of its own."""
    with closing(Driver()) as driver:
        (device,) = (one for one in driver.system().devices if one.name == name)
        return _describe(Questions(driver.place, name), device)


def _describe(questions: Questions, device: Any) -> NiDevice:
    # devices without analogue inputs know none of these properties, and say so by an error
    ask = questions.ask
    limits = ask("ranges", lambda: list(device.ai_voltage_rngs), ())
    channels = ask("inputs", lambda: list(device.ai_physical_chans), ())
    lines = ask("terminals", lambda: list(device.terminals), ())
    serial = ask("serial number", lambda: device.serial_num, 0)
    usages = ask("triggers", lambda: list(device.ai_trig_usage), ())
    return NiDevice(
        name=device.name,
        product_type=ask("product", lambda: device.product_type, ""),
        serial_number=f"{serial:08X}" if serial else "",
        channels=tuple(_bare(channel.name) for channel in channels),
        terminals=tuple(_terminals(questions, channel) for channel in channels),
        # low, high, low, high, ...
        ranges_v=tuple(zip(limits[0::2], limits[1::2], strict=False)),
        max_rate_single_hz=ask("highest rate of one channel", lambda: device.ai_max_single_chan_rate),
        max_rate_multi_hz=ask("highest rate", lambda: device.ai_max_multi_chan_rate),
        min_rate_hz=ask("lowest rate", lambda: device.ai_min_rate),
        simultaneous=ask("simultaneous sampling", lambda: device.ai_simultaneous_sampling_supported, default=False),
        digital_trigger=ask("digital trigger", lambda: device.dig_trig_supported, default=False),
        analog_trigger=ask("analogue trigger", lambda: device.anlg_trig_supported, default=False),
        reference_trigger="REFERENCE" in {usage.name for usage in usages},
        trigger_lines=tuple(bare for line in lines if (bare := _bare(line)).startswith(_TRIGGER_LINES)),
        simulated=ask("simulated", lambda: device.is_simulated, default=False),
        connected=_is_connected(device),
    )


def _bare(name: str) -> str:
    """Return a channel or terminal without its device: /Dev1/PFI0 -> PFI0."""
    return name.rpartition("/")[2]


def _terminals(questions: Questions, channel: Any) -> tuple[TerminalChoice, ...]:
    chosen = questions.ask(f"terminal configurations of {channel.name}", lambda: list(channel.ai_term_cfgs), ())
    offered = {configuration.name for configuration in chosen}
    return tuple(ours for ours, theirs in TERMINALS.items() if theirs in offered)


def _is_connected(device: Any) -> bool:
    try:
        _ = device.ai_physical_chans.channel_names
        _ = device.product_type
    except load_nidaqmx().errors.DaqError as error:
        return error_code(error) not in _UNREACHABLE
    return True
