"""Load NI-DAQmx, as the local driver or through a remote device server, and explain why it cannot be loaded."""

import socket
import ssl
import sys
from contextlib import suppress
from pathlib import Path
from types import ModuleType
from typing import Any

from radargui.model.errors import DeviceError, in_words
from radargui.model.resources import resource_table

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
