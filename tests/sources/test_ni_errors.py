"""What the operator is told when the NI device, its driver or the way to it fails."""

from __future__ import annotations

import ast
import socket
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from string import Formatter

import grpc
import nidaqmx.errors
import numpy as np
import pytest
from hypothesis import given, strategies as st
from nidaqmx.error_codes import DAQmxErrors
from support.frozen_wire import wire_to
from support.ni_samples import code_recording, ni_setup
from support.ni_server import ByHand, NiServer, digital_only, serve, usb_6356

from radargui.model.errors import DeviceError
from radargui.sources.ni import driver
from radargui.sources.ni.discovery import driver_version, find_devices
from radargui.sources.ni.driver import explained
from radargui.sources.ni.source import EMPTY_READS, READ_SLICE_S, NiSource


def told(action: Callable[[], object]) -> str:
    """Return what the operator reads; every such error has a remedy and no trace of the program's inside."""
    with pytest.raises(DeviceError) as caught:
        action()
    assert caught.value.remedy
    text = str(caught.value)
    assert "\n" not in text
    assert "Traceback" not in text
    assert caught.value.message.endswith(".")
    return text


def started(server: NiServer, **daq: object) -> NiSource:
    source = NiSource(ni_setup(server.address, **daq))
    source.open()
    source.start()
    return source


def test_a_missing_package_is_told_with_the_command_that_installs_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "nidaqmx", None)
    text = told(NiSource(ni_setup(None)).open)
    assert "nidaqmx is not installed" in text
    assert "pip install 'nidaqmx[grpc]'" in text
    assert driver_version() is None


def test_a_broken_package_is_not_called_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "nidaqmx.errors", None)
    text = told(find_devices)
    assert "is installed but cannot be loaded" in text


def test_a_missing_grpc_package_is_told_when_a_device_server_is_wanted(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "grpc", None)
    assert "grpcio cannot be loaded" in told(NiSource(ni_setup("lab-pc:31763")).open)


def test_a_missing_driver_is_told_apart_from_a_missing_package(monkeypatch: pytest.MonkeyPatch) -> None:
    def no_driver(*_: object) -> None:
        raise nidaqmx.errors.DaqNotFoundError("Could not find an installation of NI-DAQmx.")

    monkeypatch.setattr("nidaqmx._library_interpreter.LibraryInterpreter.__init__", no_driver)
    text = told(NiSource(ni_setup(None)).open)
    assert "The NI-DAQmx driver is not installed on this computer." in text
    assert "daq.remote" in text
    assert told(find_devices) == text
    assert driver_version() is None


def test_a_wrong_name_is_told_with_the_devices_that_are_there() -> None:
    with serve(code_recording(10), [usb_6356("PXI1Slot2"), digital_only()]) as server:
        text = told(NiSource(ni_setup(server.address)).open)
        assert server.tasks == []
    assert "no NI device named Dev1 on 127.0.0.1" in text
    assert "NI-DAQmx 24.8.0 knows PXI1Slot2 (USB-6356), Dev4 (USB-6501)." in text
    assert "E Series devices (DAQPad-6015, PCI-6024E ...) are reported to need 19.x" in text


def test_no_device_at_all_is_told() -> None:
    with serve(code_recording(10), []) as server:
        text = told(NiSource(ni_setup(server.address)).open)
    assert "No NI device is connected to 127.0.0.1" in text
    assert "this version does not support it: E Series devices (DAQPad-6015, PCI-6024E ...)" in text


def test_a_device_that_is_known_but_unplugged_is_told() -> None:
    with serve(code_recording(10)) as server:
        server.remove("Dev1")
        assert "Dev1 cannot be reached any more" in told(NiSource(ni_setup(server.address)).open)


def test_a_device_without_analogue_inputs_is_told() -> None:
    with serve(code_recording(10), [digital_only("Dev1")]) as server:
        assert "Dev1 (USB-6501) has no analogue inputs." in told(NiSource(ni_setup(server.address)).open)


def test_a_device_in_use_is_told_and_no_task_is_left() -> None:
    with serve(code_recording(10)) as server:
        server.reserve("Dev1")
        text = told(NiSource(ni_setup(server.address)).open)
        assert server.tasks == []
    assert "Dev1 (DAQPad-6015) is in use by another program (NI-DAQmx error -50103)." in text


def test_two_sources_cannot_have_the_same_device_and_the_first_goes_on() -> None:
    with serve(code_recording(400)) as server:
        first = started(server)
        told(NiSource(ni_setup(server.address)).open)
        assert first.read() is not None
        first.close()
        second = started(server)
        assert second.read() is not None
        second.close()


def test_a_refusal_while_configuring_leaves_no_task() -> None:
    with serve(code_recording(10)) as server:
        server.fail("CfgSampClkTiming", -200077)
        text = told(NiSource(ni_setup(server.address)).open)
        assert server.tasks == []
    assert "refused while configuring (error -200077): Requested value is not a supported value" in text
    assert "Task Name" not in text


def test_a_refusal_at_the_start_is_told() -> None:
    with serve(code_recording(10)) as server:
        source = NiSource(ni_setup(server.address))
        source.open()
        server.fail("StartTask", -200081)
        assert "refuses the rate" in told(source.start)
        source.close()
        assert server.tasks == []


def test_an_overwritten_buffer_is_told_after_what_was_read_and_the_task_is_closed() -> None:
    recording = code_recording()
    pace = ByHand()
    with serve(recording, pace=pace) as server:
        source = started(server, buffer_s=0.5)
        pace.advance(200)
        block = source.read()
        pace.advance(10_400)
        text = told(source.read)
        assert told(source.read) == text
        source.stop()
        assert source.read() is None
        source.close()
        assert server.tasks == []
    assert block is not None
    np.testing.assert_array_equal(block.samples, recording.raw[:, :200])
    assert "the buffer was overwritten before it could be read (NI-DAQmx error -200279)." in text
    assert "daq.buffer_s" in text


def test_samples_that_the_local_driver_read_before_an_overflow_come_before_the_error() -> None:
    recording = code_recording(200)
    with serve(recording) as server:
        source = started(server)
        task = source.task
        assert task is not None

        def overflow(block: np.ndarray, **_: object) -> int:
            block.reshape(-1)[: 6 * 70] = recording.raw[:, :70].reshape(-1)
            raise nidaqmx.errors.DaqReadError("lost", -200279, 70)

        task._read_into = overflow
        task._driver.remote = None
        block = source.read()
        text = told(source.read)
        source.close()
    assert block is not None
    np.testing.assert_array_equal(block.samples, recording.raw[:, :70])
    assert "-200279" in text


def test_samples_a_device_server_read_but_did_not_send_are_not_made_up() -> None:
    with serve(code_recording(400)) as server:
        source = started(server)
        server.fail("ReadBinaryI16", -200361, samples_read=50)
        text = told(source.read)
        source.close()
    assert "the memory on the device overflowed (NI-DAQmx error -200361)." in text


def test_a_device_that_gives_no_samples_is_told_after_a_second() -> None:
    with serve(code_recording(400)) as server:
        source = started(server)
        assert source.read() is not None
        server.fail("ReadBinaryI16", -200284)
        text = told(source.read)
        source.close()
        assert server.tasks == []
    assert EMPTY_READS * READ_SLICE_S == 1.0
    assert "gives no samples: none arrived within 1 s (NI-DAQmx error -200284)." in text


def test_a_moment_without_samples_is_no_error() -> None:
    recording = code_recording(400)
    with serve(recording) as server:
        source = started(server)
        server.fail("ReadBinaryI16", -200284, times=EMPTY_READS - 1)
        block = source.read()
        source.close()
    assert block is not None
    np.testing.assert_array_equal(block.samples, recording.raw[:, :200])


def test_a_removed_device_is_told_after_what_was_read() -> None:
    recording = code_recording(400)
    with serve(recording) as server:
        source = started(server)
        block = source.read()
        server.remove("Dev1")
        text = told(source.read)
        source.close()
        server.plug_in("Dev1")
        assert server.tasks == []
        again = started(server)
        assert again.read() is not None
        again.close()
    assert block is not None
    assert "Dev1 (DAQPad-6015) cannot be reached any more (NI-DAQmx error -201003)." in text


def test_a_device_removed_during_a_blocked_read_ends_it() -> None:
    pace = ByHand()
    with serve(code_recording(400), pace=pace) as server:
        source = started(server)
        remover = threading.Thread(target=lambda: pace.waiting.wait(5.0) and server.remove("Dev1"))
        remover.start()
        text = told(source.read)
        remover.join()
        source.close()
    assert "-201003" in text


def test_a_killed_server_is_told_and_stop_and_close_still_work() -> None:
    with serve(code_recording(400)) as server:
        source = started(server)
        assert source.read() is not None
        server.kill()
        text = told(source.read)
        assert source.backlog() == 0
        source.stop()
        source.close()
        assert "connection was refused" in told(NiSource(ni_setup(server.address)).open)
    assert f"The connection to the NI gRPC device server at {server.address} was lost while reading" in text


def test_a_server_killed_during_a_blocked_read_ends_it() -> None:
    pace = ByHand()
    with serve(code_recording(400), pace=pace) as server:
        source = started(server)
        killer = threading.Thread(target=lambda: pace.waiting.wait(5.0) and server.kill())
        killer.start()
        assert "was lost while reading" in told(source.read)
        killer.join()
        source.close()


def test_a_dead_network_ends_a_blocked_read(monkeypatch: pytest.MonkeyPatch) -> None:
    connected = grpc.insecure_channel

    def soon(remote: str, options: tuple[tuple[str, int], ...]) -> grpc.Channel:
        quick = [(name, min(value, 700) if name.endswith("_ms") else value) for name, value in options]
        return connected(remote, options=quick)

    monkeypatch.setattr(grpc, "insecure_channel", soon)
    with serve(code_recording(400)) as server, wire_to(server.address) as wire:
        source = NiSource(ni_setup(wire.address))
        source.open()
        source.start()
        assert source.read() is not None
        wire.cut()
        assert "was lost while reading" in told(source.read)
        source.close()


def test_an_unknown_computer_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    def unknown(*_: object, **__: object) -> None:
        raise socket.gaierror(-2, "Name or service not known")

    monkeypatch.setattr(socket, "create_connection", unknown)
    assert "The computer lab-pc is not known here" in told(lambda: find_devices("lab-pc:31763"))


def test_a_computer_that_does_not_answer_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    def silent(*_: object, **__: object) -> None:
        raise TimeoutError("timed out")

    monkeypatch.setattr(socket, "create_connection", silent)
    assert "at lab-pc:31763 does not answer: timed out." in told(lambda: driver_version("lab-pc:31763"))


def test_something_else_on_the_port_is_told() -> None:
    with socket.create_server(("127.0.0.1", 0)) as other:
        address = f"127.0.0.1:{other.getsockname()[1]}"
        assert f"Something listens at {address}, but it does not answer" in told(
            lambda: driver.open_channel(address, connect_s=0.3)
        )


@pytest.mark.parametrize("address", ["lab-pc", ":31763", "lab-pc:", "lab-pc:99999", "lab-pc:0", "lab-pc:x", "a:²"])
def test_an_address_that_is_none_is_told(address: str) -> None:
    assert "HOST:PORT" in told(lambda: find_devices(address))


@pytest.mark.parametrize(
    ("error", "text"),
    [
        (nidaqmx.errors.RpcError(grpc.StatusCode.NOT_FOUND, "no library"), "driver is not installed on lab-pc:31763"),
        (nidaqmx.errors.RpcError(grpc.StatusCode.PERMISSION_DENIED, ""), "refused this computer (PERMISSION_DENIED)"),
        (nidaqmx.errors.RpcError(grpc.StatusCode.UNIMPLEMENTED, ""), "too old or has no NI-DAQmx part"),
        (
            nidaqmx.errors.RpcError(grpc.StatusCode.INTERNAL, "it broke"),
            "while reading Dev1: StatusCode.INTERNAL",
        ),
        (nidaqmx.errors.RpcError(grpc.StatusCode.UNAVAILABLE, ""), "was lost while reading Dev1 (UNAVAILABLE)"),
        (nidaqmx.errors.DaqNotSupportedError("no"), "does not exist for this operating system"),
        (nidaqmx.errors.DaqFunctionNotSupportedError("no such call"), "is too old: no such call."),
        (nidaqmx.errors.DaqError("odd\n\nTask Name: a", -1), "Dev1: NI-DAQmx refused while reading (error -1): odd."),
        (nidaqmx.errors.DaqError("x" * 1000, -1), "xxx..."),
        (OSError("no such library"), "NI-DAQmx failed while reading Dev1: no such library."),
    ],
)
def test_every_way_to_fail_has_its_own_sentence(error: Exception, text: str) -> None:
    def fail() -> None:
        raise explained(error, "Dev1", "lab-pc:31763", "reading")

    assert text in told(fail)


@pytest.mark.parametrize(
    ("code", "text"),
    [
        (-88705, "Dev1 cannot be reached any more (NI-DAQmx error -88705)"),
        (-88709, "Dev1 was reset, or taken out of the system, while it was in use (NI-DAQmx error -88709)"),
        (-88710, "Dev1 was reset, or taken out of the system, while it was in use (NI-DAQmx error -88710)"),
        (-50808, "The USB connection to Dev1 failed (NI-DAQmx error -50808)"),
        (-50401, "The USB connection to Dev1 failed (NI-DAQmx error -50401)"),
        (-200714, "Sampling of Dev1 was stopped by its driver"),
        (-50352, "There is no memory left for the samples of Dev1 (NI-DAQmx error -50352)"),
    ],
)
def test_what_a_usb_device_fails_with_is_told_by_name(code: int, text: str) -> None:
    def fail() -> None:
        raise explained(nidaqmx.errors.DaqError("as NI says it", code), "Dev1", "this computer", "reading")

    assert text in told(fail)


def test_every_code_is_one_of_nis_and_has_one_meaning() -> None:
    codes = [code for words in driver.WORDS["code"] for code in words["codes"]]
    assert {DAQmxErrors(code).value for code in codes} == set(codes)
    assert len(set(codes)) == len(codes)


@pytest.mark.parametrize("code", [-88705, -88709, -88710])
def test_a_device_that_left_the_system_is_listed_as_not_connected(code: int) -> None:
    with serve(code_recording(10)) as server:
        server.fail("GetDeviceAttributeString", code)
        (device,) = find_devices(server.address)
    assert not device.connected


def test_a_driver_that_is_too_old_is_told_which_is_the_newest_for_the_device() -> None:
    def fail() -> None:
        raise explained(nidaqmx.errors.DaqFunctionNotSupportedError("no such call"), "Dev1", "lab-pc", "reading")

    assert "19.x for an E Series device (DAQPad-6015, PCI-6024E ...), the current one for later series" in told(fail)


@pytest.mark.parametrize("call", ["GetDeviceAttributeDouble", "GetTimingAttributeDouble", "GetChanAttributeUInt32"])
def test_what_a_device_server_has_forgotten_after_a_replug_is_told(call: str) -> None:
    with serve(code_recording(400)) as server:
        started(server).close()
        server.fail(call, -200197, after=1 if call == "GetTimingAttributeDouble" else 0)
        text = told(NiSource(ni_setup(server.address)).open)
        assert server.tasks == []
    assert "does not tell any more what it told of Dev1 (DAQPad-6015) before: " in text
    assert "start its NI gRPC device server again" in text


@given(st.text(max_size=30))
def test_any_text_is_an_address_or_told_to_be_none(text: str) -> None:
    try:
        host, port = driver.split_address(text)
    except DeviceError as error:
        assert "HOST:PORT" in str(error)  # noqa: PT017  most texts end here
    else:
        assert text == f"{host}:{text.rpartition(':')[2]}"
        assert 1 <= port <= 65535


@given(st.text(min_size=1, max_size=30), st.integers(1, 65535))
def test_any_host_with_a_port_is_an_address(host: str, port: int) -> None:
    assert driver.split_address(f"{host}:{port}") == (host, port)


def test_every_error_has_words_with_a_place_for_each_fact_and_no_words_are_left_over() -> None:
    calls = [
        node
        for file in Path(driver.__file__).parent.glob("*.py")
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8")))
        if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "device_error"
    ]
    told = {call.args[0].value: {one.arg for one in call.keywords} for call in calls}
    assert len(told) == len(calls), "each error is told at one place"
    assert set(told) == set(driver.WORDS) - {"code"}
    for name, facts in told.items():
        text = " ".join((driver.WORDS[name]["fact"], driver.WORDS[name].get("remedy", "")))
        fields = {field.partition(".")[0] for _, field, *_ in Formatter().parse(text) if field}
        assert fields == facts, name
