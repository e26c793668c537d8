"""Which NI devices are found and what is told of them; and when nidaqmx is loaded."""

from __future__ import annotations

import subprocess
import sys

import pytest
from support.ni_samples import code_recording
from support.ni_server import daqpad_6015, delta_sigma, digital_only, serve, usb_6356

from radargui.sources.ni.discovery import NiDevice, driver_version, find_devices


def test_devices_are_told_with_all_they_can_do() -> None:
    devices = [daqpad_6015(), usb_6356(), delta_sigma(), digital_only()]
    with serve(code_recording(10), devices) as server:
        pad, simultaneous, slow, digital = find_devices(server.address)
    assert pad == NiDevice(
        name="Dev1",
        product_type="DAQPad-6015",
        serial_number="0123ABCD",
        channels=tuple(f"ai{number}" for number in range(16)),
        terminals=(("differential", "rse", "nrse"),) * 8 + (("rse", "nrse"),) * 8,
        ranges_v=((-0.05, 0.05), (-0.5, 0.5), (-5.0, 5.0), (-10.0, 10.0)),
        max_rate_single_hz=200e3,
        max_rate_multi_hz=200e3,
        min_rate_hz=0.0119,
        simultaneous=False,
        digital_trigger=True,
        analog_trigger=False,
        reference_trigger=True,
        trigger_lines=("PFI0", "PFI1", "PFI2"),
    )
    assert pad.title == "Dev1 (DAQPad-6015)"
    assert simultaneous.simultaneous
    assert simultaneous.analog_trigger
    assert simultaneous.terminals == (("differential",),) * 8
    assert slow.terminals[0] == ("differential", "pseudodifferential")
    assert digital == NiDevice(name="Dev4", product_type="USB-6501", serial_number="01A00002")


def test_an_unplugged_device_is_listed_as_not_connected() -> None:
    with serve(code_recording(10), [daqpad_6015(), usb_6356()]) as server:
        server.remove("Dev1")
        assert [(device.name, device.connected) for device in find_devices(server.address)] == [
            ("Dev1", False),
            ("Dev2", True),
        ]


def test_no_device_is_an_answer() -> None:
    with serve(code_recording(10), []) as server:
        assert find_devices(server.address) == ()


def test_the_version_of_a_remote_driver_is_told() -> None:
    with serve(code_recording(10)) as server:
        assert driver_version(server.address) == "24.8.0"


@pytest.mark.parametrize("module", ["radargui.sources.ni.source", "radargui.sources.factory"])
def test_nidaqmx_and_grpc_are_not_loaded_before_a_device_is_asked_for(module: str) -> None:
    code = (
        f"import sys; import {module}; import radargui.sources.ni.source\n"
        "from radargui.system.resources import shipped_setups\n"
        "from radargui.model.setup import read_setup\n"
        "radargui.sources.ni.source.NiSource(read_setup(shipped_setups()[0]))\n"
        "sys.exit(bool({'nidaqmx', 'grpc'} & set(sys.modules)))"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False, timeout=60).returncode == 0
