"""Errors of NI-DAQmx and of the way to it: what happened, likely why, and what to do."""

from collections.abc import Iterator
from contextlib import contextmanager

from radargui.model.errors import DeviceError
from radargui.sources.ni.driver import driver_errors, load_nidaqmx

TIMEOUT = -200284
"""NI-DAQmx: some or all of the samples requested have not yet been acquired."""

_LONGEST_TEXT = 400
"""Characters of NI's own words: they must fit into one message."""


_UNREACHABLE = (-201003, -200324, -200045, -200220, -50405, -50804)
"""NI-DAQmx: a device of the driver's list cannot be accessed."""
_BY_CODES: dict[tuple[int, ...], tuple[str, tuple[str, ...], str]] = {
    (-50103, -200022, -201105, -89137, -200369): (
        "{device} is in use by another program",
        (
            "another window of RadarGUI, NI MAX, LabVIEW or another task has its analogue inputs",
            "a program that crashed still holds it",
        ),
        "Close the other program, or reset the device in NI MAX.",
    ),
    _UNREACHABLE: (
        "{device} cannot be reached any more",
        ("its cable was pulled or its power is off", "it was reset by another program"),
        "Plug it in, wait until NI MAX shows it, then start again.",
    ),
    (-200279, -200283): (
        "Samples of {device} were lost: the buffer was overwritten before it could be read",
        ("this computer was too busy to read in time", "the rate is too high for it"),
        "Raise daq.buffer_s, lower daq.rate_hz, or close other programs.",
    ),
    (-200361, -200010, -209829, -200004, -200019): (
        "Samples of {device} were lost: the memory on the device overflowed",
        ("the bus (USB, network) could not carry the samples in time", "the rate is too high for it"),
        "Plug the device directly into the computer without a hub, or lower daq.rate_hz.",
    ),
    (TIMEOUT,): (
        "{device} gives no samples",
        ("no clock or no trigger arrives", "the device hangs"),
        "Check the trigger and clock wiring, or reset the device in NI MAX.",
    ),
    (-200081,): (
        "{device} refuses the rate for this number of channels",
        ("all channels of a multiplexed device share its highest rate",),
        "Lower daq.rate_hz or use fewer channels.",
    ),
    (-201250, -201251, -201252, -201253, -201390, -201420, -201388): (
        "The network device {device} cannot be reached",
        ("it is off or its network cable is out", "another computer has reserved it"),
        "Check its power and network, and reserve it for this computer in NI MAX.",
    ),
}
"""What a code of NI-DAQmx means: fact, likely reasons, remedy."""
_BY_CODE = {code: words for codes, words in _BY_CODES.items() for code in codes}
_BY_STATUS = {
    "PERMISSION_DENIED": ("refused this computer", "Allow this computer in the security settings of the server."),
    "UNIMPLEMENTED": ("is too old or has no NI-DAQmx part", "Install a current NI gRPC device server."),
}
_BY_STATUS["UNAUTHENTICATED"] = _BY_STATUS["PERMISSION_DENIED"]
"""What a status of gRPC means of a device server: fact, remedy."""
_GONE = ("UNAVAILABLE", "DEADLINE_EXCEEDED", "CANCELLED")


def _of_code(code: int, device: str, more: str = "") -> DeviceError:
    message, reasons, remedy = _BY_CODE[code]
    return DeviceError(message.format(device=device) + f"{more}.", reasons=reasons, remedy=remedy)


@contextmanager
def device_errors(device: str, place: str, doing: str) -> Iterator[None]:
    """Turn an error of the driver or of the connection inside the block into a DeviceError.

    Parameters
    ----------
    device
        Name of the device.
    place
        Where it is: "this computer" or HOST:PORT.
    doing
        What was being done, as in "while ...".

    Raises
    ------
    DeviceError
        The driver or the connection failed inside the block.
    """
    try:
        yield
    except driver_errors() as error:
        raise explained(error, device, place, doing) from error


def error_code(error: Exception) -> int:
    """Return the NI-DAQmx code of an error, 0 where it has none."""
    code = getattr(error, "error_code", 0)
    return code if isinstance(code, int) else 0


def explained(error: Exception, device: str, place: str, doing: str) -> DeviceError:
    """Return an error of the driver or of the connection as a DeviceError; parameters as of `device_errors`."""
    errors = load_nidaqmx().errors
    if isinstance(error, errors.DaqNotFoundError):
        return no_driver(place)
    if isinstance(error, errors.DaqNotSupportedError):
        return DeviceError(
            "NI-DAQmx does not exist for this operating system, so no NI device can be used here.",
            remedy="Put it on a computer with Windows or Linux that runs an NI gRPC device server (daq.remote).",
        )
    if isinstance(error, errors.DaqFunctionNotSupportedError):
        return DeviceError(
            f"The NI-DAQmx driver of {place} is too old: {_text(error)}",
            remedy="Install a current NI-DAQmx driver.",
        )
    if isinstance(error, errors.DaqError) and (code := error_code(error)) in _BY_CODE:
        return _of_code(code, device, f" (NI-DAQmx error {code})")
    if isinstance(error, errors.DaqError):
        return DeviceError(
            f"{device}: NI-DAQmx refused while {doing} (error {code}): {_text(error)}",
            remedy="Check the device and the [daq] settings; NI MAX can test the device by itself.",
        )
    if hasattr(error, "rpc_code") or callable(getattr(error, "code", None)):
        return _of_connection(error, device, place, doing)
    return DeviceError(
        f"NI-DAQmx failed while {doing} {device}: {_text(error)}",
        remedy="Check the NI-DAQmx installation with NI MAX.",
    )


def no_driver(place: str) -> DeviceError:
    """Return the error of a computer without the NI-DAQmx driver."""
    return DeviceError(
        f"The NI-DAQmx driver is not installed on {place}.",
        reasons=("the Python package nidaqmx alone is not enough: it needs the driver from NI",),
        remedy="Install NI-DAQmx from NI and restart, or set daq.remote to a computer that has it.",
    )


def no_samples(device: str, seconds: float) -> DeviceError:
    """Return the error of a running device that gave no sample for some seconds (-200284)."""
    return _of_code(TIMEOUT, device, f": none arrived within {seconds:g} s (NI-DAQmx error {TIMEOUT})")


def no_edge(device: str, edge: str, seconds: float) -> DeviceError:
    """Return the error of a device that waited in vain for the edge it starts at."""
    return DeviceError(
        f"{device} did not start: no {edge.removeprefix('a ')} came within {seconds:g} s.",
        reasons=("the signal is not connected there", "its edge goes the other way or does not reach the level"),
        remedy="Check the wire and daq.start_source, daq.start_edge and daq.start_level_v, or raise recording.wait_s.",
    )


def not_connected(device: str) -> DeviceError:
    """Return the error of a device that NI-DAQmx knows by name but cannot reach."""
    return _of_code(_UNREACHABLE[0], device)


def _of_connection(error: Exception, device: str, place: str, doing: str) -> DeviceError:
    code = getattr(error, "rpc_code", None)
    if code is None:
        code = error.code()  # type: ignore[attr-defined]
    status = getattr(code, "name", str(code))
    if status == "NOT_FOUND":
        return no_driver(place)
    if status in _BY_STATUS:
        fault, remedy = _BY_STATUS[status]
        return DeviceError(f"The NI gRPC device server at {place} {fault} ({status}).", remedy=remedy)
    if status not in _GONE:
        return DeviceError(
            f"The NI gRPC device server at {place} failed while {doing} {device}: {_text(error)}",
            remedy="Start the server again (ni_grpc_device_server); its log may say more.",
        )
    return DeviceError(
        f"The connection to the NI gRPC device server at {place} was lost while {doing} {device} ({status}).",
        reasons=("the server was stopped", "that computer or the network went down"),
        remedy="Start the server again (ni_grpc_device_server) and check the network.",
    )


def _text(error: Exception) -> str:
    """Return the driver's own words without its last lines of task name and status code."""
    lines = [line.strip() for line in str(error).splitlines()]
    kept = " ".join(line for line in lines if line and not line.startswith(("Task Name:", "Status Code:")))
    kept = kept if len(kept) <= _LONGEST_TEXT else kept[: _LONGEST_TEXT - 3] + "..."
    return kept if kept.endswith((".", "!", "?")) else kept + "."
