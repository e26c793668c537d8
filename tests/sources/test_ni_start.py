"""Sampling that starts at an edge, with and without samples from before it, on the stand-in device server."""

from __future__ import annotations

import threading
from collections.abc import Callable

import numpy as np
import pytest
from support.changed import changed
from support.fake_clock import FakeClock
from support.ni_samples import code_recording, ni_setup, volt_recording
from support.ni_server import ByHand, StandInDevice, delta_sigma, serve, usb_6356

from radargui.model.errors import DeviceError
from radargui.model.recording import Block, Recording
from radargui.model.setup import Setup
from radargui.sources.ni.checks import checked_settings
from radargui.sources.ni.discovery import NiDevice
from radargui.sources.ni.source import NiSource

PAD = NiDevice(
    "Dev1",
    channels=tuple(f"ai{number}" for number in range(16)),
    digital_trigger=True,
    reference_trigger=True,
    trigger_lines=("PFI0", "PFI1"),
)


def read_all(source: NiSource) -> list[Block]:
    blocks = []
    while (block := source.read()) is not None:
        blocks.append(block)
    return blocks


def joined(blocks: list[Block]) -> np.ndarray:
    return np.concatenate([block.samples for block in blocks], axis=1)


def in_another_thread(work: Callable[[], object]) -> tuple[threading.Thread, list[object]]:
    results: list[object] = []
    thread = threading.Thread(target=lambda: results.append(work()))
    thread.start()
    return thread, results


def test_sampling_begins_at_a_digital_edge_and_t_0_is_there() -> None:
    recording = code_recording(2000)
    pace = ByHand()
    with serve(recording, pace=pace) as server:
        source = NiSource(ni_setup(server.address, start="digital", start_source="PFI1"))
        source.open()
        source.start()
        assert source.is_waiting
        reader, results = in_another_thread(source.read)
        assert pace.waiting.wait(5.0)
        pace.advance(300)
        server.edge("/Dev1/PFI0")
        server.edge("/Dev1/PFI1")
        pace.advance(200)
        reader.join(5.0)
        source.close()
    (block,) = results
    assert isinstance(block, Block)
    assert not source.is_waiting
    assert (block.first_index, block.trigger_index) == (0, 0)
    np.testing.assert_array_equal(block.samples, recording.raw[:, 300:500])


def test_a_reference_trigger_gives_the_samples_before_and_after_the_edge_and_then_the_end() -> None:
    recording = code_recording(20_000)
    pace = ByHand()
    with serve(recording, pace=pace) as server:
        setup = changed(
            ni_setup(server.address, start="digital", start_source="/Dev1/pfi0", start_pretrigger=True),
            recording={"pretrigger_s": 0.05, "maximum_s": 0.123},
        )
        source = NiSource(setup)
        source.open()
        assert server.calls["CfgDigEdgeRefTrig"] == 1
        source.start()
        pace.advance(300)
        server.edge("/Dev1/PFI0")  # too early: 500 samples are wanted from before it
        pace.advance(3000)
        server.edge("/Dev1/PFI0")
        pace.advance(5000)
        blocks = read_all(source)
        assert source.read() is None
        source.close()
    samples = joined(blocks)
    np.testing.assert_array_equal(samples, recording.raw[:, 2800 : 2800 + 500 + 1230])
    assert [block.trigger_index for block in blocks] == [500] + [None] * (len(blocks) - 1)
    assert blocks[-1].end_index == 1730


@pytest.mark.parametrize("edge", ["rising", "falling"])
@pytest.mark.parametrize(("source_name", "channel"), [("I1", 0), ("ai3", 3), ("Dev1/ai5", 5)])
def test_sampling_begins_where_a_channel_crosses_the_level(edge: str, source_name: str, channel: int) -> None:
    recording = volt_recording(4000)
    volts = recording.raw[channel]
    above = volts >= 3.5 if edge == "rising" else volts <= -3.5
    first = int(np.flatnonzero(~above[:-1] & above[1:])[0]) + 1
    level_v = 3.5 if edge == "rising" else -3.5
    with serve(recording, [usb_6356("Dev1")]) as server:
        source = NiSource(
            ni_setup(server.address, start="analog", start_source=source_name, start_level_v=level_v, start_edge=edge)
        )
        digitisation = source.open()
        source.start()
        block = source.read()
        source.close()
    assert block is not None
    assert block.trigger_index == 0
    given = digitisation.volts(block.samples)
    np.testing.assert_allclose(given, recording.raw[:, first : first + 200], atol=2e-4)
    assert (given[channel, 0] >= 3.499) if edge == "rising" else (given[channel, 0] <= -3.499)


def test_an_analogue_reference_trigger_keeps_what_was_before_the_crossing() -> None:
    ramp = np.tile(np.linspace(-4.0, 4.0, 8001), (6, 1))
    recording = Recording("ramp", ramp, volt_recording(2).digitisation)
    with serve(recording, [usb_6356("Dev1")]) as server:
        setup = changed(
            ni_setup(server.address, start="analog", start_source="Q2", start_level_v=2.0, start_pretrigger=True),
            recording={"pretrigger_s": 0.1, "maximum_s": 0.1},
        )
        source = NiSource(setup)
        digitisation = source.open()
        source.start()
        blocks = read_all(source)
        source.close()
    volts = digitisation.volts(joined(blocks))
    assert volts.shape == (6, 2000)
    assert blocks[0].trigger_index == 1000
    assert volts[3, 1000] == pytest.approx(2.0, abs=2e-3)
    assert volts[3, 0] == pytest.approx(1.0, abs=2e-3)


def test_an_edge_that_never_comes_is_told_after_the_longest_wait() -> None:
    class Ticking(FakeClock):
        def now(self) -> float:
            self.advance(1.0)
            return super().now()

    with serve(code_recording(400)) as server:
        setup = changed(ni_setup(server.address, start="digital", start_source="PFI0"), recording={"wait_s": 20.0})
        source = NiSource(setup, clock=Ticking())
        source.open()
        source.start()
        with pytest.raises(DeviceError, match=r"no rising edge at /Dev1/PFI0 came within 20 s") as caught:
            source.read()
        source.close()
        assert server.tasks == []
    assert "daq.start_edge" in caught.value.remedy


def test_stop_ends_the_wait_for_an_edge() -> None:
    pace = ByHand()
    with serve(code_recording(400), pace=pace) as server:
        source = NiSource(ni_setup(server.address, start="digital", start_source="PFI0"))
        source.open()
        source.start()
        reader, results = in_another_thread(source.read)
        assert pace.waiting.wait(5.0)
        source.stop()
        reader.join(5.0)
        source.close()
    assert results == [None]


def test_a_source_that_was_stopped_waits_for_its_edge_again() -> None:
    recording = code_recording(2000)
    pace = ByHand()
    with serve(recording, pace=pace) as server:
        source = NiSource(ni_setup(server.address, start="digital", start_source="PFI0"))
        source.open()
        for _ in range(2):
            source.start()
            assert source.is_waiting
            server.edge("/Dev1/PFI0")
            pace.advance(200)
            block = source.read()
            assert block is not None
            assert block.trigger_index == 0
            source.stop()
        source.close()


@pytest.mark.parametrize(
    ("device", "daq", "told"),
    [
        (StandInDevice(), {"start": "digital", "start_source": "PFI7"}, "has no trigger line PFI7; it has PFI0, PFI1"),
        (StandInDevice(), {"start": "analog", "start_source": "I1"}, "cannot start on an analogue edge"),
        (StandInDevice(trigger_lines=()), {"start": "digital", "start_source": "PFI0"}, "cannot start on a digital"),
        (
            StandInDevice(trigger_usage=8),
            {"start": "digital", "start_source": "PFI0", "start_pretrigger": True},
            "it has no reference trigger. Set daq.start_pretrigger = false",
        ),
        (usb_6356("Dev1"), {"start": "analog", "start_source": "I9"}, "is no analogue trigger source"),
        (usb_6356("Dev1"), {"start": "analog", "start_source": "I1", "start_level_v": 6.0}, "outside the range"),
    ],
)
def test_a_start_that_the_device_does_not_have_is_refused_before_a_task_is_made(
    device: StandInDevice, daq: dict[str, object], told: str
) -> None:
    with serve(code_recording(100), [device]) as server:
        with pytest.raises(DeviceError) as caught:
            NiSource(ni_setup(server.address, **daq)).open()
        assert server.calls["CreateTask"] == 0
    assert told in str(caught.value)
    assert caught.value.remedy


def test_an_analogue_terminal_is_given_to_the_driver_by_its_full_name() -> None:
    device = NiDevice("Dev2", channels=PAD.channels, analog_trigger=True)
    setup = ni_setup(None, device="Dev2", start="analog", start_source="apfi0", start_level_v=7.0)
    start = checked_settings(setup, device).start
    assert start is not None
    assert start.source == "/Dev2/APFI0"
    assert start.title() == "a rising edge through 7 V at /Dev2/APFI0"


@pytest.mark.parametrize(
    ("daq", "told"),
    [
        ({"start": "digital"}, 'daq.start = "digital", allowed: with daq.start_source, for example PFI0'),
        ({"start_pretrigger": True}, "daq.start_pretrigger = true, allowed: with daq.start"),
    ],
)
def test_a_start_that_makes_no_sense_is_refused_by_the_setup(daq: dict[str, object], told: str) -> None:
    with pytest.raises(ValueError, match=told):
        ni_setup(None, **daq)


def with_convert(rate_hz: float | None, **daq: object) -> Setup:
    return ni_setup(None, convert_rate_hz=rate_hz, **daq)


def test_the_convert_clock_asked_for_is_set_and_the_skew_read_back_is_its_inverse() -> None:
    with serve(code_recording(100)) as server:
        source = NiSource(ni_setup(server.address, convert_rate_hz=125_000.0))
        assert source.open().channel_skew_s == pytest.approx(8e-6)
        assert server.calls["SetTimingAttributeDouble"] == 1
        assert server.calls["GetBufferAttributeUInt32"] == 1
        source.close()


@pytest.mark.parametrize(
    ("device", "daq", "told"),
    [
        (StandInDevice(), {"convert_rate_hz": 50e3}, "50 kS/s of conversions are too few for 6 channels x 10 kS/s"),
        (StandInDevice(), {"convert_rate_hz": 250e3}, "cannot convert as fast as 250 kS/s: its fastest is 200 kS/s"),
        (usb_6356("Dev1"), {"convert_rate_hz": 100e3}, "has no convert clock"),
        (delta_sigma("Dev1"), {"convert_rate_hz": 100e3, "terminal": "pseudodifferential"}, "has no convert clock"),
        (usb_6356("Dev1"), {"rate_hz": 1e6, "buffer_s": 600.0}, "buffer for Dev1 (USB-6356) 7.2 GB; 1 GB is the most"),
    ],
)
def test_a_convert_clock_or_a_buffer_that_cannot_be_is_refused(
    device: StandInDevice, daq: dict[str, object], told: str
) -> None:
    with serve(code_recording(100), [device]) as server, pytest.raises(DeviceError) as caught:
        NiSource(ni_setup(server.address, **daq)).open()
    assert told in str(caught.value)


@pytest.mark.parametrize("pairs", [1, 2, 3, 4])
def test_one_to_four_iq_pairs_are_read_each_from_its_own_inputs(pairs: int) -> None:
    recording = code_recording(400, n_channels=8)
    channels = [f"ai{number}" for number in reversed(range(2 * pairs))]
    with serve(recording, [usb_6356("Dev1")]) as server:
        source = NiSource(ni_setup(server.address, pairs, channels=channels))
        digitisation = source.open()
        source.start()
        block = source.read()
        source.close()
    assert digitisation.channel_names[-2:] == (f"I{pairs}", f"Q{pairs}")
    assert block is not None
    np.testing.assert_array_equal(block.samples, recording.raw[: 2 * pairs][::-1, :200])
