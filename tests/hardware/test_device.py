"""Tests on a real NI device; skipped unless asked for.

What is needed: NI-DAQmx (or an NI gRPC device server in reach), and a device with at least six analogue inputs that
no other program uses. What is connected to the inputs does not matter, except where a test says so.

    python3 packaging/dev.py test --hardware -n 0 tests/hardware

The setup is taken from the file named in RADARGUI_HARDWARE_SETUP (its `[daq]` names device, channels, range and
rate, and `remote` where the device is behind a device server); without it the shipped default is used: Dev1, ai0 to
ai5, differential, +-5 V, 33333 S/s.
"""

from __future__ import annotations

import os
import time
from pathlib import Path

import numpy as np
import pytest
from nidaqmx.stream_readers import AnalogMultiChannelReader
from support.changed import changed

from radargui.acquisition.acquisition import Acquisition
from radargui.model.errors import DeviceError
from radargui.model.setup import Setup, read_setup
from radargui.sources.factory import make_source
from radargui.sources.ni.discovery import find_devices
from radargui.sources.ni.source import NiSource, check_setup
from radargui.system.resources import default_setup_path

pytestmark = [pytest.mark.hardware, pytest.mark.timeout(300)]


@pytest.fixture
def setup() -> Setup:
    """The setup of the laboratory, with sampling that begins at once."""
    path = os.environ.get("RADARGUI_HARDWARE_SETUP")
    chosen = read_setup(Path(path) if path else default_setup_path())
    return changed(chosen, daq={"start": "now", "start_source": None, "start_pretrigger": False})


def test_the_device_of_the_setup_is_found_with_its_properties(setup: Setup) -> None:
    """Compare what is printed (-s) with NI MAX: product, serial number, inputs, ranges, rates, trigger lines."""
    devices = find_devices(setup.daq.remote, setup.daq.remote_certificate)
    print(*devices, sep="\n")
    (device,) = [device for device in devices if device.name.casefold() == setup.daq.device.casefold()]
    assert device.connected
    assert device.product_type
    assert len(device.channels) >= 2 * setup.n_receivers
    assert device.ranges_v
    assert device.max_rate_multi_hz


def test_the_setup_is_taken_and_the_skew_read_back(setup: Setup) -> None:
    """Compare what is printed (-s) with the manual: "AI Convert Clock"; a DAQPad-6015 says 5 us at 6 x 33.3 kS/s."""
    check = check_setup(setup)
    print(*check.lines, sep="\n")
    assert check.digitisation.sample_rate_hz == pytest.approx(setup.daq.rate_hz, rel=1e-3)
    if not check.device.simultaneous:
        assert 0.0 < check.digitisation.channel_skew_s <= 1.0 / (2 * setup.n_receivers * setup.daq.rate_hz) * 1.001


def test_a_minute_is_read_without_a_lost_sample_at_the_rate_of_the_clock(setup: Setup) -> None:
    """Leave the computer alone meanwhile. The device's clock and the computer's may differ by some 100 ppm."""
    acquisition = Acquisition(make_source("ni", setup), setup)
    acquisition.start()
    try:
        while acquisition.health.samples_read == 0 and not acquisition.wait(0.0):
            time.sleep(0.01)
        first, began = acquisition.health.samples_read, time.perf_counter()
        time.sleep(60.0)
        health, elapsed = acquisition.health, time.perf_counter() - began
    finally:
        acquisition.stop()
    assert acquisition.error is None
    assert health.samples_lost == 0
    assert health.sample_rate_hz is not None
    assert (health.samples_read - first) / elapsed == pytest.approx(health.sample_rate_hz, rel=2e-3)


def test_codes_with_the_device_s_scaling_are_the_volts_of_the_driver(setup: Setup) -> None:
    """Connect a battery or a steady voltage to the first input: both ways of reading must tell the same volts."""
    source = NiSource(setup)
    digitisation = source.open()
    try:
        if digitisation.scaling is None:
            pytest.skip("this device gives volts, not 16 bit codes")
        source.start()
        blocks = [source.read() for _ in range(20)]
        assert source.task is not None
        driver_v = np.empty((digitisation.n_channels, 2000))
        reader = AnalogMultiChannelReader(source.task._task.in_stream)
        reader.verify_array_shape = False
        reader.read_many_sample(driver_v, number_of_samples_per_channel=2000)
    finally:
        source.close()
    ours_v = digitisation.volts(np.concatenate([block.samples for block in blocks if block], axis=1))
    noise_v = ours_v.std(axis=1) + 1e-3
    assert (np.abs(ours_v.mean(axis=1) - driver_v.mean(axis=1)) < noise_v).all()


def test_the_device_is_free_after_twenty_starts_and_stops(setup: Setup) -> None:
    """Nothing to do; a device that stays reserved makes the next start fail."""
    for _ in range(20):
        source = NiSource(setup)
        source.open()
        source.start()
        assert source.read() is not None
        source.close()


def test_a_device_in_use_is_told(setup: Setup) -> None:
    """Nothing to do: the test itself is the other program."""
    first = NiSource(setup)
    first.open()
    try:
        with pytest.raises(DeviceError, match="in use"):
            NiSource(setup).open()
    finally:
        first.close()


def test_an_unplugged_device_is_told_and_found_again(setup: Setup) -> None:
    """Start with -s. When asked, pull the device's cable, wait five seconds, and plug it in again."""
    patient = changed(setup, recording={"restart_after_error": True, "restart_within_s": 60.0})
    source = make_source("ni", patient)
    source.open()
    source.start()
    print("\nPull the cable now, wait five seconds, plug it in again.")
    deadline = time.perf_counter() + 90.0
    gap = None
    try:
        while gap is None and time.perf_counter() < deadline:
            block = source.read()
            assert block is not None
            gap = block.gap
    finally:
        source.close()
    assert gap is not None
    print(gap)
    assert gap.count > setup.daq.rate_hz


def test_a_digital_edge_starts_a_run_with_samples_from_before_it(setup: Setup) -> None:
    """Connect PFI0 to a push button that pulls it from 0 to 5 V. Start with -s and press when asked, after a second."""
    edged = changed(
        setup,
        daq={"start": "digital", "start_source": "PFI0", "start_pretrigger": True},
        recording={"pretrigger_s": 0.5, "maximum_s": 1.0, "wait_s": 60.0},
    )
    source = NiSource(edged)
    digitisation = source.open()
    source.start()
    print("\nPress the button, after a second.")
    blocks = []
    try:
        while (block := source.read()) is not None:
            blocks.append(block)
    finally:
        source.close()
    assert blocks[0].trigger_index == pytest.approx(0.5 * digitisation.sample_rate_hz, rel=1e-3)
    assert blocks[-1].end_index == pytest.approx(1.5 * digitisation.sample_rate_hz, rel=1e-3)
