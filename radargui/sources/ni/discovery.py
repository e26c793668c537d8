"""Which NI devices are there and what they can do, as the driver says."""

from collections.abc import Callable
from contextlib import closing, suppress
from dataclasses import dataclass
from functools import partial
from typing import Any, Literal, TypeAlias

from radargui.model.errors import DeviceError
from radargui.sources.ni.driver import Driver, device_error, load_nidaqmx
from radargui.sources.ni.explain import NOT_CONNECTED, device_errors, error_code, of_code

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


_UNREACHABLE = (-201003, -200324, -200045, -201250, -201251, -201252, -201253, -201390)
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
        return tuple(_describe(device) for device in driver.system().devices)


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
    return f"{version.major_version}.{version.minor_version}.{version.update_version}"


def find_device(driver: Driver, name: str) -> NiDevice:
    """Return the device of that NI-DAQmx name (upper or lower case).

    Raises
    ------
    DeviceError
        There is no device, none of that name (the error names those that are there), or it is not connected.
    """
    with device_errors(name, driver.place, "looking for"):
        devices = list(driver.system().devices)
        for device in devices:
            if device.name.casefold() == name.casefold():
                found = _describe(device)
                if not found.connected:
                    raise of_code(NOT_CONNECTED, found.title)
                return found
        there = [
            NiDevice(one.name, product_type=_ask(partial(getattr, one, "product_type"), "")).title for one in devices
        ]
    if not there:
        raise device_error("no_device", driver=driver)
    raise device_error("no_such_device", name=name, driver=driver, there=", ".join(there))


def _describe(device: Any) -> NiDevice:
    # devices without analogue inputs know none of these properties, and say so by an error
    limits = _ask(lambda: list(device.ai_voltage_rngs), ())
    channels = _ask(lambda: list(device.ai_physical_chans), ())
    lines = _ask(lambda: list(device.terminals), ())
    serial = _ask(lambda: device.serial_num, 0)
    return NiDevice(
        name=device.name,
        product_type=_ask(lambda: device.product_type, ""),
        serial_number=f"{serial:08X}" if serial else "",
        channels=tuple(_bare(channel.name) for channel in channels),
        terminals=tuple(_terminals(channel) for channel in channels),
        # low, high, low, high, ...
        ranges_v=tuple(zip(limits[0::2], limits[1::2], strict=False)),
        max_rate_single_hz=_ask(lambda: device.ai_max_single_chan_rate),
        max_rate_multi_hz=_ask(lambda: device.ai_max_multi_chan_rate),
        min_rate_hz=_ask(lambda: device.ai_min_rate),
        simultaneous=_ask(lambda: device.ai_simultaneous_sampling_supported, default=False),
        digital_trigger=_ask(lambda: device.dig_trig_supported, default=False),
        analog_trigger=_ask(lambda: device.anlg_trig_supported, default=False),
        reference_trigger="REFERENCE" in {usage.name for usage in _ask(lambda: list(device.ai_trig_usage), ())},
        trigger_lines=tuple(bare for line in lines if (bare := _bare(line)).startswith(_TRIGGER_LINES)),
        simulated=_ask(lambda: device.is_simulated, default=False),
        connected=_is_connected(device),
    )


def _bare(name: str) -> str:
    """Return a channel or terminal without its device: /Dev1/PFI0 -> PFI0."""
    return name.rpartition("/")[2]


def _terminals(channel: Any) -> tuple[TerminalChoice, ...]:
    offered = {configuration.name for configuration in _ask(lambda: list(channel.ai_term_cfgs), ())}
    return tuple(ours for ours, theirs in TERMINALS.items() if theirs in offered)


def _is_connected(device: Any) -> bool:
    try:
        _ = device.ai_physical_chans.channel_names
        _ = device.product_type
    except load_nidaqmx().errors.DaqError as error:
        return error_code(error) not in _UNREACHABLE
    return True


def _ask(question: Callable[[], Any], default: Any = None) -> Any:
    """Return the answer of the driver, or the default where this device does not have that property."""
    with suppress(load_nidaqmx().errors.DaqError):
        return question()
    return default
