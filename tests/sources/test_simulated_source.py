"""The simulated source keeps the contract of a source: blocks, pacing, stop, truth."""

from __future__ import annotations

import threading

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from support.fake_clock import FakeClock
from support.simulated_recording import simulate_recording
from support.simulated_setup import perfect_setup, simulated_setup

from radargui.model.errors import SourceError
from radargui.model.recording import Block
from radargui.model.setup import Setup
from radargui.sources.contract import Source
from radargui.sources.simulated.model import CHUNK, SimulatedRadar, SimulatedSource

LONGEST_S = 20.0


def _started(setup: Setup, **options: object) -> SimulatedSource:
    source = SimulatedSource(setup, **options)  # type: ignore[arg-type]
    source.open()
    source.start()
    return source


def _all(source: Source) -> list[Block]:
    blocks = []
    while (block := source.read()) is not None:
        blocks.append(block)
    return blocks


MISMATCHED = {"mismatch": 0.1, "daq": {"channel_skew_s": 5e-6, "rate_hz": 10000.0}, "lateral_speed_m_s": 0.05}


@pytest.mark.parametrize("read_interval_s", [0.005, 0.0173, 1.0])
def test_the_blocks_joined_are_the_recording_bit_for_bit(read_interval_s: float) -> None:
    daq = {"channel_skew_s": 5e-6, "rate_hz": 10000.0, "read_interval_s": read_interval_s}
    setup = simulated_setup(mismatch=0.1, daq=daq)
    recording, _ = simulate_recording(setup, run=3)
    blocks = _all(_started(setup, run=3))
    np.testing.assert_array_equal(np.concatenate([block.samples for block in blocks], axis=1), recording.raw)
    assert [block.first_index for block in blocks] == [0, *(block.end_index for block in blocks[:-1])]
    assert all(block.gap is None for block in blocks)


@given(first=st.integers(0, 4 * CHUNK), count=st.integers(1, 3 * CHUNK))
@settings(max_examples=15, deadline=None)
def test_any_piece_of_a_run_is_a_piece_of_the_whole(first: int, count: int) -> None:
    setup = simulated_setup(**MISMATCHED)
    whole = SimulatedRadar(setup).samples(0, 8 * CHUNK)
    piece = SimulatedRadar(setup).samples(first, count)
    np.testing.assert_array_equal(piece, whole[:, first : first + count])


def test_the_same_seed_gives_the_same_samples_and_another_seed_or_run_gives_others() -> None:
    setup = simulated_setup(seed=7)
    recording, _ = simulate_recording(setup, run=2)
    np.testing.assert_array_equal(recording.raw, simulate_recording(setup, run=2)[0].raw)
    assert (recording.raw != simulate_recording(setup, run=1)[0].raw).any()
    assert (recording.raw != simulate_recording(simulated_setup(seed=8), run=2)[0].raw).any()


def test_the_digitisation_tells_channels_rate_skew_and_the_scaling_of_the_codes() -> None:
    source = SimulatedSource(simulated_setup(**MISMATCHED))
    digitisation = source.open()
    assert digitisation.channel_names == ("I1", "Q1", "I2", "Q2", "I3", "Q3")
    assert digitisation.sample_rate_hz == 10000.0
    assert digitisation.channel_skew_s == 5e-6
    assert digitisation.scaling == ((0.0, 5.0 / 32768),) * 6
    assert digitisation.device == "simulated"
    source.start()
    block = source.read()
    assert block is not None
    assert block.samples.dtype == np.int16
    assert np.abs(digitisation.volts(block.samples)).max() == pytest.approx(1.0, abs=0.3)


def test_a_block_is_its_own_array_and_changing_it_changes_no_other() -> None:
    setup = simulated_setup()
    source = _started(setup)
    first = source.read()
    assert first is not None
    first.samples[:] = 0
    second = source.read()
    assert second is not None
    expected = simulate_recording(setup)[0].raw[:, second.first_index : second.end_index]
    np.testing.assert_array_equal(second.samples, expected)


def test_a_run_is_as_long_as_rest_scene_and_settling_and_then_gives_none_for_ever() -> None:
    setup = simulated_setup(scene="pendulum", rest_s=0.4, settle_s=0.3, turns=1.0)
    source = _started(setup)
    blocks = _all(source)
    period_s = 2 * np.pi * np.sqrt(0.5 / 9.81) * (1 + np.radians(8.0) ** 2 / 16)
    assert blocks[-1].end_index == pytest.approx((0.7 + period_s) * 10000.0, abs=2)
    assert [source.read() for _ in range(3)] == [None, None, None]


def test_the_truth_is_the_exact_motion_of_the_samples_asked_for() -> None:
    source = SimulatedSource(simulated_setup(**MISMATCHED))
    _, whole = simulate_recording(simulated_setup(**MISMATCHED))
    part = source.truth(5000, 8000)
    np.testing.assert_array_equal(part.position_m, whole.position_m[:, 5000:13000])
    np.testing.assert_array_equal(part.path_m, whole.path_m[:, 5000:13000])
    inside = (whole.impact_time_s >= 0.5) & (whole.impact_time_s < 1.3)
    assert inside.sum() >= 2
    np.testing.assert_allclose(part.impact_time_s, whole.impact_time_s[inside] - 0.5, atol=1e-12)


@pytest.mark.parametrize("rate_hz", [10.0, 10000.0])
def test_real_time_gives_a_block_when_its_last_sample_is_taken(rate_hz: float) -> None:
    clock = FakeClock()
    source = _started(simulated_setup(daq={"rate_hz": rate_hz}), realtime=True, clock=clock)
    began = clock.now()
    while (block := source.read()) is not None:
        assert clock.now() - began == pytest.approx(block.end_index / rate_hz, abs=1e-9)
    assert source.backlog() == 0


def test_a_late_reader_gets_the_waiting_samples_at_once_and_sees_them_in_the_backlog() -> None:
    clock = FakeClock()
    source = _started(simulated_setup(), realtime=True, clock=clock)
    clock.advance(1.00005)
    assert source.backlog() == 10000
    for _ in range(50):
        block = source.read()
    assert block is not None
    assert block.end_index == 10000
    assert clock.waits == []
    assert source.backlog() == 0


def test_a_reader_later_than_the_buffer_loses_the_oldest_samples_and_is_told_so() -> None:
    clock = FakeClock()
    setup = simulated_setup(daq={"rate_hz": 10000.0, "buffer_s": 0.5})
    source = _started(setup, realtime=True, clock=clock)
    assert source.read() is not None
    clock.advance(1.00005)
    block = source.read()
    assert block is not None
    assert block.gap is not None
    assert (block.gap.first_index, block.gap.count) == (200, block.first_index - 200)
    assert block.first_index == 10200 - 5000
    np.testing.assert_array_equal(
        block.samples, simulate_recording(setup)[0].raw[:, block.first_index : block.end_index]
    )
    following = source.read()
    assert following is not None
    assert following.gap is None


def test_as_fast_as_asked_never_waits() -> None:
    clock = FakeClock()
    _all(_started(simulated_setup(), realtime=False, clock=clock))
    assert clock.waits == []


class HourlongClock:
    """Time stands still: a wait lasts an hour unless it is interrupted."""

    def __init__(self) -> None:
        self.waiting = threading.Event()

    def now(self) -> float:
        return 0.0

    def wait(self, seconds: float, interrupt: threading.Event) -> bool:
        self.waiting.set()
        return interrupt.wait(3600.0)


def test_stop_from_another_thread_ends_a_waiting_read_at_once() -> None:
    setup = simulated_setup(daq={"rate_hz": 10.0, "read_interval_s": 1.0})
    clock = HourlongClock()
    source = _started(setup, realtime=True, clock=clock)
    answers: list[Block | None] = []
    reader = threading.Thread(target=lambda: answers.append(source.read()))
    reader.start()
    assert clock.waiting.wait(LONGEST_S)
    source.stop()
    reader.join(LONGEST_S)
    assert answers == [None]


def test_stop_and_close_may_be_called_any_number_of_times_and_a_stopped_source_may_start_again() -> None:
    source = _started(simulated_setup())
    first = source.read()
    for _ in range(2):
        source.stop()
    assert source.read() is None
    source.start()
    again = source.read()
    assert first is not None
    assert again is not None
    assert again.first_index == 0
    np.testing.assert_array_equal(again.samples, first.samples)
    for _ in range(2):
        source.close()
    assert source.read() is None


def test_reading_before_start_and_starting_before_open_are_refused() -> None:
    source = SimulatedSource(simulated_setup())
    with pytest.raises(SourceError, match="not started"):
        source.read()
    with pytest.raises(SourceError, match="not open"):
        source.start()


def test_a_repeating_source_goes_on_without_a_jump_of_phase_over_three_rounds() -> None:
    setup = perfect_setup(rest_s=0.1, settle_s=0.1, restitution=0.3, lateral_speed_m_s=0.1)
    radar = SimulatedRadar(setup, repeat=True)
    assert radar.n_samples is None
    period = round(10000 * (SimulatedRadar(setup).scene.duration_s or 0.0)) + 15000
    volts = radar.samples(0, 3 * period)
    phase = np.arctan2(volts[1::2], volts[::2])
    step = np.abs(np.angle(np.exp(1j * np.diff(phase))))
    fastest = np.sqrt(2 * 9.81 * 0.26) + 0.1
    assert step.max() <= 2 * fastest / 0.0299792458 * 2 * np.pi / 10000.0
    source = _started(setup, repeat=True)
    for _ in range(2 * period // 200):
        block = source.read()
        assert block is not None


@pytest.mark.parametrize("n_receivers", [1, 2, 3, 4])
def test_any_number_of_receivers_gives_a_pair_each(n_receivers: int) -> None:
    recording, truth = simulate_recording(simulated_setup(n_receivers=n_receivers, mismatch=0.1))
    assert recording.raw.shape[0] == 2 * n_receivers
    assert truth.path_m.shape[0] == n_receivers
