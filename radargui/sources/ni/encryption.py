"""The encrypted (TLS) way to an NI gRPC device server: its certificate, and what is wrong where it fails."""

from __future__ import annotations

import socket
import ssl
from pathlib import Path

from radargui.model.errors import DeviceError

_HOSTNAME_MISMATCH = (62, 64)
"""OpenSSL: the certificate is for another name, or for another address."""

_LARGEST = 1_000_000


def read_certificate(path: str) -> bytes:
    """Return the certificate file (PEM) by which a device server is known.

    Raises
    ------
    DeviceError
        The file cannot be read or holds no certificate.
    """
    remedy = "Set daq.remote_certificate (or --certificate) to the server's certificate, a .pem or .crt file with text."
    try:
        with Path(path).expanduser().open("rb") as file:
            content = file.read(_LARGEST)
    except (OSError, ValueError, RuntimeError) as error:
        reason = getattr(error, "strerror", None) or error
        raise DeviceError(f"The certificate file {path} cannot be read: {reason}.", remedy=remedy) from error
    try:
        _trusting(content)
    except (ssl.SSLError, ValueError) as error:
        raise DeviceError(
            f"The file {path} holds no certificate in PEM form.",
            reasons=("it is a key, a DER file or something else",),
            remedy=remedy,
        ) from error
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
            return DeviceError(
                f"The certificate of the NI gRPC device server at {address} is for another name: "
                f"{error.verify_message}.",
                remedy="Use the name in the certificate in daq.remote, or give the server a certificate for this name.",
            )
        return DeviceError(
            f"The NI gRPC device server at {address} has another certificate than the one given: "
            f"{error.verify_message}.",
            reasons=("the certificate of another server was given", "it has run out or was replaced on the server"),
            remedy="Copy the server's present certificate (server_cert in its configuration) to this computer.",
        )
    except OSError as error:
        return DeviceError(
            f"The NI gRPC device server at {address} does not answer encrypted: {_short(error)}.",
            reasons=("it runs without encryption", "it wants a certificate of this computer too (root_cert)"),
            remedy="Leave out daq.remote_certificate, or set server_cert and server_key in the server's configuration "
            "and leave root_cert empty.",
        )
    return None


def answers_encrypted(host: str, port: int, timeout_s: float) -> bool:
    """Return whether what listens there speaks TLS; its certificate is not checked and nothing is sent."""
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    context.check_hostname = False
    context.verify_mode = ssl.CERT_NONE
    try:
        _shake_hands(context, host, port, timeout_s)
    except OSError:
        return False
    return True


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
