"""The stand-in server as a test uses it: started with a recording, told which faults to make, ended."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path

import grpc
from nidaqmx._stubs import nidaqmx_pb2, nidaqmx_pb2_grpc
from support.ni_server.devices import StandInDevice, daqpad_6015
from support.ni_server.faults import Fault
from support.ni_server.meter import Meter
from support.ni_server.pace import AsFastAsPossible, Pace
from support.ni_server.precomputed import Precomputed, encoded
from support.ni_server.service import DaqService
from support.ni_server.signal import AtEnd, Signal
from support.ni_server.task import StandInTask

from radargui.model.recording import Recording

CERTIFICATES = Path(__file__).resolve().parents[1] / "certificates"


class NiServer:
    """A running stand-in server."""

    def __init__(
        self,
        recording: Recording,
        devices: Sequence[StandInDevice],
        pace: Pace,
        at_end: AtEnd,
        made: Precomputed | None = None,
        credentials: grpc.ServerCredentials | None = None,
    ) -> None:
        self._service = DaqService(Signal(recording, at_end), tuple(devices), pace, made)
        self._workers = ThreadPoolExecutor(max_workers=8)
        self._server = grpc.server(self._workers)
        # before the others of the service: the first handler of a call answers it
        self._server.add_generic_rpc_handlers((_reads(self._service),))
        nidaqmx_pb2_grpc.add_NiDAQmxServicer_to_server(self._service, self._server)
        where = "127.0.0.1:0"
        secure, plain = self._server.add_secure_port, self._server.add_insecure_port
        port = plain(where) if credentials is None else secure(where, credentials)
        self._server.start()
        self.address = f"127.0.0.1:{port}"

    @property
    def meter(self) -> Meter:
        """What was counted while streaming."""
        return self._service.meter

    @property
    def calls(self) -> Counter[str]:
        """How often each call was made."""
        return self._service.calls

    @property
    def tasks(self) -> list[StandInTask]:
        """Tasks that are not cleared."""
        return list(self._service.tasks.values())

    def fail(
        self, rpc: str, code: int, *, after: int = 0, times: int = 1_000_000, samples_read: int | None = None
    ) -> None:
        """Let a call fail with an NI-DAQmx error code, after some calls that work, so many times."""
        with self._service.pace.condition:
            self._service.faults.add(Fault(rpc, code, after, times, samples_read))

    def remove(self, device: str) -> None:
        """Pull the cable of a device: NI-DAQmx keeps its name and cannot reach it."""
        with self._service.pace.condition:
            self._service.absent.add(device)
            for task in self._service.tasks.values():
                task.stop()

    def plug_in(self, device: str) -> None:
        """Plug a removed device in again."""
        with self._service.pace.condition:
            self._service.absent.discard(device)

    def edge(self, terminal: str) -> None:
        """Let an edge come at a terminal, /Dev1/PFI0, after the samples that were acquired until now."""
        with self._service.pace.condition:
            for task in self._service.tasks.values():
                task.edge_at(terminal)
            self._service.pace.condition.notify_all()

    def reserve(self, device: str) -> None:
        """Let another program have a device."""
        with self._service.pace.condition:
            self._service.reserved_elsewhere.add(device)

    def kill(self) -> None:
        """End the server at once, calls under way included; idempotent."""
        ended = self._server.stop(0)
        with self._service.pace.condition:
            for task in self._service.tasks.values():
                task.stop()
        ended.wait()
        self._workers.shutdown(wait=True)


def _reads(service: DaqService) -> grpc.GenericRpcHandler:
    """Answer reads of codes with what was encoded before, where it was."""
    handler = grpc.unary_unary_rpc_method_handler(
        service.ReadBinaryI16,
        request_deserializer=nidaqmx_pb2.ReadBinaryI16Request.FromString,
        response_serializer=encoded,
    )
    return grpc.method_handlers_generic_handler("nidaqmx_grpc.NiDAQmx", {"ReadBinaryI16": handler})


def _credentials(name: str) -> grpc.ServerCredentials:
    pair = tuple((CERTIFICATES / f"{name}{suffix}").read_bytes() for suffix in (".key", ".pem"))
    return grpc.ssl_server_credentials((pair,))


@contextmanager
def serve(
    recording: Recording,
    devices: Sequence[StandInDevice] | None = None,
    *,
    pace: Pace | None = None,
    at_end: AtEnd = "hold",
    certificate: str | None = None,
) -> Iterator[NiServer]:
    """Serve a recording's samples on the inputs of the devices (default: a DAQPad-6015 named Dev1).

    Codes of an int16 recording are served bit for bit with its own scaling. `pace`: AsFastAsPossible (default),
    RealTime or ByHand. `at_end`: hold the last sample for ever, repeat the recording, or give no more samples.
    `certificate`: name of one in tests/support/certificates; the server then speaks TLS.
    """
    found = (daqpad_6015(),) if devices is None else devices
    credentials = None if certificate is None else _credentials(certificate)
    server = NiServer(recording, found, pace or AsFastAsPossible(), at_end, credentials=credentials)
    try:
        yield server
    finally:
        server.kill()
