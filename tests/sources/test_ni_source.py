"""Samples through the real nidaqmx client from a stand-in device server."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import pytest
from support.ni_samples import code_recording, ni_setup, volt_recording
from support.ni_server import ByHand, NiServer, RealTime, StandInDevice, delta_sigma, serve, usb_6356

from radargui.model.errors import DeviceError
from radargui.model.recording import Digitisation
from radargui.model.setup import Setup
from radargui.sources.ni.checks import checked_settings, rate_sentence
from radargui.sources.ni.discovery import NiDevice
from radargui.sources.ni.source import NiSource


@contextmanager
def running(setup: Setup) -> Iterator[tuple[NiSource, Digitisation]]:
    source = NiSource(setup)
    try:
        digitisation = source.open()
        source.start()
        yield source, digitisation
    finally:
        source.stop()
        source.close()


def read_all(source: NiSource, count: int) -> np.ndarray:
    blocks = []
    end = 0
    while end < count:
        block = source.read()
        assert block is not None
        assert block.first_index == end
        assert block.gap is None
        end = block.end_index
        blocks.append(block.samples)
    return np.concatenate(blocks, axis=1)[:, :count]


def test_six_channels_read_as_codes_equal_the_served_codes_bit_for_bit() -> None:
    recording = code_recording()
    with serve(recording) as server, running(ni_setup(server.address)) as (source, digitisation):
        samples = read_all(source, recording.n_samples)
        assert server.calls["ReadBinaryI16"] == recording.n_samples / 200
        assert server.calls["ReadAnalogF64"] == 0
    assert samples.dtype == np.int16
    np.testing.assert_array_equal(samples, recording.raw)
    assert digitisation.channel_names == ("I1", "Q1", "I2", "Q2", "I3", "Q3")


def test_the_scaling_of_each_channel_is_the_device_s_and_gives_the_served_volts() -> None:
    recording = code_recording(1000)
    with serve(recording) as server, running(ni_setup(server.address)) as (source, digitisation):
        samples = read_all(source, 1000)
    assert digitisation.scaling == recording.digitisation.scaling
    np.testing.assert_array_equal(digitisation.volts(samples), recording.volts())


def test_volts_served_are_read_as_codes_within_half_a_step() -> None:
    recording = volt_recording(1000)
    with serve(recording) as server, running(ni_setup(server.address)) as (source, digitisation):
        volts = digitisation.volts(read_all(source, 1000))
    assert np.max(np.abs(volts - recording.volts())) <= 0.501 * 10.0 / 65536.0


@pytest.mark.parametrize("device", [delta_sigma("Dev1"), StandInDevice(scaling_told=False)])
def test_a_device_without_16_bit_codes_or_without_scaling_is_read_as_volts(device: StandInDevice) -> None:
    recording = volt_recording(1000)
    with serve(recording, [device]) as server, running(ni_setup(server.address)) as (source, digitisation):
        samples = read_all(source, 1000)
        assert server.calls["ReadBinaryI16"] == 0
    assert digitisation.scaling is None
    np.testing.assert_array_equal(samples, recording.raw)


def test_the_channel_map_decides_which_input_is_i1() -> None:
    recording = code_recording(400)
    with serve(recording) as server:
        setup = ni_setup(server.address, channels=["ai5", "ai4", "AI3", "Dev1/ai2", "ai1", "ai7"])
        with running(setup) as (source, _):
            samples = read_all(source, 400)
    np.testing.assert_array_equal(samples[:5], recording.raw[[5, 4, 3, 2, 1]])
    assert not samples[5].any()


@pytest.mark.parametrize(("rate_hz", "skew_s"), [(10_000.0, 15e-6), (33_333.0, 5e-6)])
def test_the_skew_of_a_multiplexed_device_is_read_back(rate_hz: float, skew_s: float) -> None:
    with serve(code_recording(100)) as server, running(ni_setup(server.address, rate_hz=rate_hz)) as (_, digitisation):
        assert digitisation.channel_skew_s == pytest.approx(skew_s, rel=1e-5)


def test_a_simultaneous_device_has_no_skew_whatever_the_setup_says() -> None:
    with serve(code_recording(100), [usb_6356("Dev1")]) as server:
        setup = ni_setup(server.address, channel_skew_s=5e-6)
        with running(setup) as (_, digitisation):
            assert digitisation.channel_skew_s == 0.0


def test_the_skew_of_the_setup_counts_where_the_device_does_not_tell_its_convert_rate() -> None:
    with serve(code_recording(100)) as server:
        server.fail("GetTimingAttributeDouble", -200452, after=1)
        with running(ni_setup(server.address, channel_skew_s=7e-6)) as (_, digitisation):
            assert digitisation.channel_skew_s == 7e-6


def test_the_rate_is_the_one_in_force() -> None:
    with serve(code_recording(100)) as server, running(ni_setup(server.address, rate_hz=33_333.0)) as (_, digitisation):
        assert digitisation.sample_rate_hz == pytest.approx(20e6 / 600, rel=1e-12)
        assert digitisation.device == "DAQPad-6015, serial 0123ABCD"


def test_a_block_belongs_to_its_reader() -> None:
    recording = code_recording(2000)
    with serve(recording) as server, running(ni_setup(server.address)) as (source, _):
        first = source.read()
        assert first is not None
        kept = first.samples.copy()
        second = source.read()
    assert second is not None
    assert not np.shares_memory(first.samples, second.samples)
    np.testing.assert_array_equal(first.samples, kept)


def test_a_short_read_gives_what_came_with_the_channels_in_their_places() -> None:
    recording = code_recording()
    pace = ByHand()
    with serve(recording, pace=pace) as server, running(ni_setup(server.address)) as (source, _):
        pace.advance(130)
        samples = read_all(source, 130)
        pace.advance(200)
        block = source.read()
    np.testing.assert_array_equal(samples, recording.raw[:, :130])
    assert block is not None
    assert block.first_index == 130
    np.testing.assert_array_equal(block.samples, recording.raw[:, 130:330])


def test_the_backlog_is_what_waits_in_the_driver() -> None:
    pace = ByHand()
    with serve(code_recording(), pace=pace) as server, running(ni_setup(server.address)) as (source, _):
        pace.advance(1000)
        assert source.backlog() == 1000
        source.read()
        assert source.backlog() == 800
        source.stop()
        assert source.backlog() == 0


def test_samples_come_at_the_rate_of_the_clock() -> None:
    now = [5.0]
    recording = code_recording()
    with (
        serve(recording, pace=RealTime(lambda: now[0])) as server,
        running(ni_setup(server.address)) as (source, _),
    ):
        now[0] += 0.05015
        samples = np.concatenate([source.read().samples, source.read().samples], axis=1)  # type: ignore[union-attr]
        assert source.backlog() == 101
    np.testing.assert_array_equal(samples, recording.raw[:, :400])


def test_stop_from_another_thread_ends_a_blocked_read() -> None:
    pace = ByHand()
    with serve(code_recording(), pace=pace) as server, running(ni_setup(server.address)) as (source, _):
        results: list[object] = []
        reader = threading.Thread(target=lambda: results.append(source.read()))
        reader.start()
        assert pace.waiting.wait(5.0)
        source.stop()
        reader.join(5.0)
        assert results == [None]
        assert source.read() is None


def test_twenty_starts_and_stops_leave_no_task_and_no_running_sampling() -> None:
    recording = code_recording(400)
    with serve(recording) as server:
        source = NiSource(ni_setup(server.address))
        for _ in range(20):
            source.open()
            source.start()
            block = source.read()
            source.stop()
            source.stop()
            source.close()
            source.close()
            assert block is not None
            assert block.first_index == 0
            assert server.tasks == []
        assert server.calls["CreateTask"] == server.calls["ClearTask"] == 20
        assert server.calls["StopTask"] == 20


def test_a_stopped_source_starts_again_at_index_0() -> None:
    recording = code_recording(1000)
    with serve(recording) as server, running(ni_setup(server.address)) as (source, _):
        read_all(source, 600)
        source.stop()
        assert source.read() is None
        source.start()
        np.testing.assert_array_equal(read_all(source, 200), recording.raw[:, :200])


def test_an_unopened_source_cannot_start_and_gives_nothing() -> None:
    source = NiSource(ni_setup(None))
    with pytest.raises(DeviceError, match="not opened"):
        source.start()
    assert source.read() is None
    assert source.backlog() == 0
    assert source.truth(0, 1) is None
    source.stop()
    source.close()


def opened(server: NiServer, **daq: object) -> None:
    source = NiSource(ni_setup(server.address, **daq))
    try:
        source.open()
    finally:
        source.close()


@pytest.mark.parametrize(
    ("daq", "told"),
    [
        ({"rate_hz": 40_000.0}, "6 channels x 40 kS/s = 240 kS/s of 200 kS/s"),
        ({"rate_hz": 40_000.0}, "daq.rate_hz to 33333 or less"),
        ({"range_v": 12.0}, "no input range that covers +-12 V; it has +-0.05 V, +-0.5 V, +-5 V, +-10 V."),
        ({"channels": ["ai0", "ai1", "ai2", "ai3", "ai4", "ai16"]}, "no channel ai16; it has ai0 to ai15"),
        (
            {"channels": ["ai0", "ai1", "ai2", "ai3", "ai4", "ai8"]},
            "Dev1/ai8 of Dev1 (DAQPad-6015) cannot be",
        ),
        ({"terminal": "pseudodifferential"}, "cannot be pseudodifferential; it can be differential or rse or nrse."),
    ],
)
def test_settings_the_device_does_not_have_are_refused_before_a_task_is_made(daq: dict[str, object], told: str) -> None:
    with serve(code_recording(100)) as server:
        with pytest.raises(DeviceError) as caught:
            opened(server, **daq)
        assert server.calls["CreateTask"] == 0
    assert told in str(caught.value)


def test_a_rate_below_the_lowest_of_the_device_is_refused() -> None:
    with serve(volt_recording(100), [delta_sigma("Dev1")]) as server, pytest.raises(DeviceError) as caught:
        opened(server, rate_hz=50.0, read_interval_s=0.1)
    assert "its lowest rate is 100 S/s" in str(caught.value)


def test_the_smallest_range_that_covers_is_chosen() -> None:
    with serve(code_recording(100)) as server:
        source = NiSource(ni_setup(server.address, range_v=0.3))
        source.open()
        assert {(channel.low_v, channel.high_v) for channel in server.tasks[0].channels} == {(-0.5, 0.5)}
        source.close()


def test_the_use_of_the_rate_is_told_for_multiplexed_and_simultaneous_devices() -> None:
    shared = NiDevice("Dev1", max_rate_single_hz=200e3, max_rate_multi_hz=200e3)
    own = NiDevice("Dev2", max_rate_single_hz=1.25e6, max_rate_multi_hz=1.25e6, simultaneous=True)
    assert rate_sentence(shared, 6, 33_333.0) == "6 channels x 33.3 kS/s = 200 kS/s of 200 kS/s"
    assert rate_sentence(own, 6, 1e6) == "6 channels at 1 MS/s of 1.25 MS/s each"
    assert rate_sentence(NiDevice("Dev3"), 2, 100.0) == "2 channels x 100 S/s = 200 S/s"


def test_the_buffer_holds_whole_blocks_and_at_least_the_time_asked_for() -> None:
    device = NiDevice("Dev1", channels=tuple(f"ai{number}" for number in range(8)))
    settings = checked_settings(ni_setup(None, rate_hz=33_333.0, buffer_s=10.0), device)
    assert settings.block_samples == 667
    assert settings.buffer_samples >= 333_330
    assert settings.buffer_samples % (2 * settings.block_samples) == 0
