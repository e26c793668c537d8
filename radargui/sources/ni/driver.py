"""Load NI-DAQmx, as the local driver or through a remote device server, and explain why it cannot be loaded.

Explain errors of NI-DAQmx: what happened, the likely reasons, and what to do.
"""

import socket
import ssl
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from types import ModuleType
from typing import Any

from radargui.model.errors import DeviceError, in_words
from radargui.system.resources import resource_table

WORDS = resource_table("ni/errors")


def device_error(name: str, /, **facts: object) -> DeviceError:
    """Return the error of a name, with facts in the places that its words leave for them."""
    return in_words(DeviceError, WORDS[name], facts)


_HOSTNAME_MISMATCH = (62, 64)
"""OpenSSL: the certificate is for another name, or for another address."""

_LARGEST = 1_000_000  # bytes read of a certificate file: a chain of some has 10 kB (chosen by hand)


def read_certificate(path: str) -> bytes:
    """Return the certificate file (PEM) by which a device server is known.

    Raises
    ------
    DeviceError
        The file cannot be read or holds no certificate.
    """
    try:
        with Path(path).expanduser().open("rb") as file:
            content = file.read(_LARGEST)
    except (OSError, ValueError, RuntimeError) as error:
        reason = getattr(error, "strerror", None) or error
        raise device_error("unreadable_certificate", path=path, reason=reason) from error
    try:
        _trusting(content)
    except (ssl.SSLError, ValueError) as error:
        raise device_error("no_certificate", path=path) from error
    return content


def check_encryption(host: str, port: int, certificate: bytes, timeout_s: float) -> DeviceError | None:
    """Try an encrypted connection and return what is wrong with it, None where it is good.

    Parameters
    ----------
    host, port
        Of the device server; it listens there.
    certificate
        Content of the certificate file.
    timeout_s
        Longest wait.
    """
    address = f"{host}:{port}"
    try:
        _shake_hands(_trusting(certificate), host, port, timeout_s)
    except ssl.SSLCertVerificationError as error:
        if error.verify_code in _HOSTNAME_MISMATCH:
            return device_error("certificate_of_another_name", address=address, error=error)
        return device_error("other_certificate", address=address, error=error)
    except OSError as error:
        return device_error("no_encryption", address=address, said=_short(error))
    return None


def answers_encrypted(host: str, port: int, timeout_s: float) -> bool:
    """Return whether what listens there speaks TLS; its certificate is not checked and nothing is sent."""
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    # only whether it speaks TLS at all; nothing is sent
    context.check_hostname = False
    context.verify_mode = ssl.CERT_NONE
    with suppress(OSError):
        _shake_hands(context, host, port, timeout_s)
        return True
    return False


def _shake_hands(context: ssl.SSLContext, host: str, port: int, timeout_s: float) -> None:
    """Connect, encrypted as gRPC does it, and leave; an OSError (an SSLError is one) where that fails."""
    context.set_alpn_protocols(["h2"])
    name = host.strip("[]")
    with (
        socket.create_connection((name, port), timeout=timeout_s) as plain,
        context.wrap_socket(plain, server_hostname=name),
    ):
        pass


def _trusting(certificate: bytes) -> ssl.SSLContext:
    """Return a context that trusts this certificate alone; an SSLError or a ValueError where it is none."""
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    context.load_verify_locations(cadata=certificate.decode("ascii"))
    # the server's own certificate may be trusted without the authority that signed it
    context.verify_flags |= ssl.VerifyFlags.VERIFY_X509_PARTIAL_CHAIN
    return context


def _short(error: OSError) -> str:
    if isinstance(error, ssl.SSLError) and error.reason:
        return error.reason.lower().replace("_", " ")
    return str(error.strerror or error)


CONNECT_S = 5.0
"""For each try; a server in a laboratory answers at once. Chosen by hand: shorter, a slow network counts as none."""
DEFAULT_PORT = 31763
"""Of NI's gRPC device server."""

_PROBE = "/grpc.health.v1.Health/Check"

_OPTIONS = (
    # a block of many fast channels is larger than gRPC's 4 MB
    ("grpc.max_receive_message_length", -1),
    # an unplugged network cable fails a call after some seconds instead of never
    ("grpc.keepalive_time_ms", 5000),
    ("grpc.keepalive_timeout_ms", 5000),
    ("grpc.http2.max_pings_without_data", 0),
    # the probe that gRPC sends with data counts too, and waits a minute by default
    ("grpc.http2.ping_timeout_ms", 5000),
    # how long one attempt to connect again may take: 20 s otherwise
    ("grpc.min_reconnect_backoff_ms", 2000),
    # a laboratory's device server is not behind the web proxy
    ("grpc.enable_http_proxy", 0),
)
"""Of gRPC; times in ms, chosen by hand so that a lost connection is told within about ten seconds."""


def split_address(remote: str) -> tuple[str, int]:
    """Return host and port of HOST:PORT.

    Raises
    ------
    DeviceError
        It is not of that form, or the port is not 1 to 65535.
    """
    host, colon, port = remote.rpartition(":")
    if not colon or not host or not port.isascii() or not port.isdigit() or not 0 < int(port) < 65536:
        raise device_error("no_address", remote=remote, port=DEFAULT_PORT)
    return host, int(port)


def open_channel(remote: str, certificate: str | None = None, connect_s: float = CONNECT_S) -> Any:
    """Return a gRPC channel that is connected to a server at HOST:PORT.

    Parameters
    ----------
    remote
        HOST:PORT.
    certificate
        File with the certificate (PEM) by which the server is known; None: the connection is not encrypted.
    connect_s
        Given to each try.

    Raises
    ------
    DeviceError
        The package grpcio is missing, the certificate cannot be read, the name is unknown, nothing listens there, or
        what listens is no gRPC server or not the one of that certificate.
    """
    host, port = split_address(remote)
    try:
        import grpc
    except ImportError as error:
        raise device_error("no_grpc", remote=remote, error=error) from error
    known_by = None if certificate is None else read_certificate(certificate)
    _knock(host, port, connect_s)
    if known_by is None:
        channel = grpc.insecure_channel(remote, options=_OPTIONS)
    else:
        wrong = check_encryption(host, port, known_by, connect_s)
        if wrong is not None:
            raise wrong
        channel = grpc.secure_channel(remote, grpc.ssl_channel_credentials(known_by), options=_OPTIONS)
    try:
        # any answer, be it "unknown method", shows that a gRPC server is there
        channel.unary_unary(_PROBE)(b"", timeout=connect_s, wait_for_ready=True)
    except grpc.RpcError as error:
        if error.code() not in (grpc.StatusCode.DEADLINE_EXCEEDED, grpc.StatusCode.UNAVAILABLE):
            return channel
        channel.close()
        if known_by is None and answers_encrypted(host, port, connect_s):
            raise device_error("encrypted_only", remote=remote) from error
        raise device_error("no_device_server", remote=remote) from error
    return channel


def _knock(host: str, port: int, connect_s: float) -> None:
    """Try the address with a plain connection: the operating system tells why it fails, gRPC does not."""
    address = f"{host}:{port}"
    try:
        socket.create_connection((host.strip("[]"), port), timeout=connect_s).close()
    except (socket.gaierror, UnicodeError) as error:
        raise device_error("unknown_computer", host=host) from error
    except ConnectionRefusedError as error:
        raise device_error("connection_refused", address=address) from error
    except OSError as error:
        raise device_error("no_answer", address=address, said=error.strerror or error) from error


def load_nidaqmx() -> ModuleType:
    """Return the nidaqmx package.

    Raises
    ------
    DeviceError
        It is not installed, or installed and broken.
    """
    try:
        import nidaqmx
        import nidaqmx.errors
        import nidaqmx.system
    except ImportError as error:
        # missing itself, or something in it
        if isinstance(error, ModuleNotFoundError) and error.name == "nidaqmx":
            raise device_error("no_package") from error
        raise device_error("broken_package", error=error) from error
    return nidaqmx  # type: ignore[no-any-return]


def driver_errors() -> tuple[type[Exception], ...]:
    """Return the exceptions that a call through nidaqmx can raise, local or remote."""
    kinds: tuple[type[Exception], ...] = (load_nidaqmx().errors.Error, OSError)
    grpc = sys.modules.get("grpc")
    return kinds if grpc is None else (*kinds, grpc.RpcError)


class Driver:
    """One way to the devices: the local NI-DAQmx driver, or an NI gRPC device server on another computer.

    Parameters
    ----------
    remote
        HOST:PORT of the device server; None for the local driver.
    certificate
        File with the certificate of a device server with encryption; None: not encrypted.

    Raises
    ------
    DeviceError
        The package is missing, or no device server answers there.

    Attributes
    ----------
    remote
        As given.
    place
        Where the devices are, for people.
    """

    def __init__(self, remote: str | None = None, certificate: str | None = None) -> None:
        self.remote = remote
        self.place = "this computer" if remote is None else remote
        self._nidaqmx = load_nidaqmx()
        self._channel: Any = None if remote is None else open_channel(remote, certificate)

    def system(self) -> Any:
        """Return nidaqmx's System; on a computer without NI-DAQmx this raises nidaqmx's own DaqNotFoundError."""
        system, options = self._nidaqmx.system.System, self._options()
        return system.local() if options is None else system.remote(options)

    def new_task(self) -> Any:
        """Return a new nidaqmx Task; whoever asks closes it."""
        return self._nidaqmx.Task(grpc_options=self._options())

    def close(self) -> None:
        """Close the connection to a device server; idempotent."""
        if self._channel is not None:
            self._channel.close()

    def _options(self) -> Any:
        if self._channel is None:
            return None
        from nidaqmx.grpc_session_options import GrpcSessionOptions

        return GrpcSessionOptions(self._channel, "")


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
