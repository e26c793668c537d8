"""The way to NI-DAQmx: the package, loaded when first needed, and the local driver or a remote device server."""

import sys
from types import ModuleType
from typing import Any

from radargui.model.errors import DeviceError
from radargui.sources.ni.remote import open_channel


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
    except ModuleNotFoundError as error:
        if error.name != "nidaqmx":
            raise _broken_package(error) from error
        raise DeviceError(
            "The Python package nidaqmx is not installed, so no NI device can be used.",
            reasons=("RadarGUI was installed without its dependencies",),
            remedy="Install it into the same environment: python -m pip install 'nidaqmx[grpc]'.",
        ) from error
    except ImportError as error:
        raise _broken_package(error) from error
    return nidaqmx  # type: ignore[no-any-return]


def _broken_package(error: ImportError) -> DeviceError:
    return DeviceError(
        f"The Python package nidaqmx is installed but cannot be loaded: {error}.",
        reasons=("one of the packages it needs is missing or does not fit",),
        remedy="Install it again: python -m pip install --force-reinstall 'nidaqmx[grpc]'.",
    )


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
    """

    def __init__(self, remote: str | None = None, certificate: str | None = None) -> None:
        self.remote = remote
        self._nidaqmx = load_nidaqmx()
        self._channel: Any = None if remote is None else open_channel(remote, certificate)

    @property
    def place(self) -> str:
        """Where the devices are, for people."""
        return "this computer" if self.remote is None else self.remote

    def system(self) -> Any:
        """Return nidaqmx's System; on a computer without NI-DAQmx this raises nidaqmx's own DaqNotFoundError."""
        if self._channel is None:
            return self._nidaqmx.system.System.local()
        return self._nidaqmx.system.System.remote(self._options())

    def new_task(self) -> Any:
        """Return a new nidaqmx Task; whoever asks closes it."""
        if self._channel is None:
            return self._nidaqmx.Task()
        return self._nidaqmx.Task(grpc_options=self._options())

    def close(self) -> None:
        """Close the connection to a device server; idempotent."""
        if self._channel is not None:
            self._channel.close()

    def _options(self) -> Any:
        from nidaqmx.grpc_session_options import GrpcSessionOptions

        return GrpcSessionOptions(self._channel, "")
