"""Explain errors of NI-DAQmx: what happened, the likely reasons, and what to do."""

from collections.abc import Iterator
from contextlib import contextmanager

from radargui.model.errors import DeviceError
from radargui.sources.ni.driver import WORDS, device_error, driver_errors, load_nidaqmx

TIMEOUT = -200284
"""NI-DAQmx: some or all of the samples requested have not yet been acquired."""

_LONGEST_TEXT = 400
"""Characters of NI's own words: they must fit into one message."""
NOT_CONNECTED = -201003
"""NI-DAQmx: a device of the driver's list cannot be accessed."""
_BY_CODE = {code: words for words in WORDS["code"] for code in words["codes"]}
_BY_STATUS = {
    "PERMISSION_DENIED": ("refused this computer", "Allow this computer in the security settings of the server."),
    "UNIMPLEMENTED": ("is too old or has no NI-DAQmx part", "Install a current NI gRPC device server."),
}
_BY_STATUS["UNAUTHENTICATED"] = _BY_STATUS["PERMISSION_DENIED"]
"""What a status of gRPC means of a device server: fact, remedy."""
_GONE = ("UNAVAILABLE", "DEADLINE_EXCEEDED", "CANCELLED")


def of_code(code: int, device: str, more: str = "") -> DeviceError:
    """Return an error that NI-DAQmx knows by its code, with more of the fact behind it."""
    words = _BY_CODE[code]
    fact = words["fact"].format(device=device)
    return DeviceError(f"{fact}{more}.", reasons=words["reasons"], remedy=words["remedy"])


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
        return _no_driver(place)
    if isinstance(error, errors.DaqNotSupportedError):
        return device_error("no_such_system")
    if isinstance(error, errors.DaqFunctionNotSupportedError):
        return device_error("old_driver", place=place, said=_text(error))
    if isinstance(error, errors.DaqError) and (code := error_code(error)) in _BY_CODE:
        return of_code(code, device, f" (NI-DAQmx error {code})")
    if isinstance(error, errors.DaqError):
        return device_error("refused", device=device, doing=doing, code=code, said=_text(error))
    if hasattr(error, "rpc_code") or callable(getattr(error, "code", None)):
        return _of_connection(error, device, place, doing)
    return device_error("driver_failed", doing=doing, device=device, said=_text(error))


def _no_driver(place: str) -> DeviceError:
    return device_error("no_driver", place=place)


def _of_connection(error: Exception, device: str, place: str, doing: str) -> DeviceError:
    code = getattr(error, "rpc_code", None)
    if code is None:
        code = error.code()  # type: ignore[attr-defined]
    status = getattr(code, "name", str(code))
    if status == "NOT_FOUND":
        return _no_driver(place)
    if status in _BY_STATUS:
        fault, remedy = _BY_STATUS[status]
        return DeviceError(f"The NI gRPC device server at {place} {fault} ({status}).", remedy=remedy)
    if status not in _GONE:
        return device_error("server_failed", place=place, doing=doing, device=device, said=_text(error))
    return device_error("connection_lost", place=place, doing=doing, device=device, status=status)


def _text(error: Exception) -> str:
    """Return the driver's own words without its last lines of task name and status code."""
    lines = [line.strip() for line in str(error).splitlines()]
    kept = " ".join(line for line in lines if line and not line.startswith(("Task Name:", "Status Code:")))
    kept = kept if len(kept) <= _LONGEST_TEXT else kept[: _LONGEST_TEXT - 3] + "..."
    return kept if kept.endswith((".", "!", "?")) else kept + "."
