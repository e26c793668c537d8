"""Replay gives a recording back as it was, gaps and all."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from support.fake_clock import FakeClock

from radargui.model.errors import SourceError
from radargui.model.recording import Block, Digitisation, Gap, Recording, iq_names
from radargui.sources.contract import ReplaySource, Source

RATE_HZ = 1000.0


def _recording(n_samples: int, gaps: tuple[Gap, ...] = ()) -> Recording:
    raw = np.arange(2 * n_samples, dtype=np.int16).reshape(2, n_samples)
    return Recording("old", raw, Digitisation(iq_names(1), RATE_HZ, ((0.0, 1e-3),) * 2), gaps)


def _replayed(recording: Recording, **options: object) -> list[Block]:
    source: Source = ReplaySource(recording, **options)  # type: ignore[arg-type]
    source.open()
    source.start()
    blocks = []
    while (block := source.read()) is not None:
        blocks.append(block)
    source.close()
    return blocks


def _index(blocks: list[Block]) -> np.ndarray:
    return np.concatenate([np.arange(block.first_index, block.end_index) for block in blocks])


def test_the_blocks_joined_are_the_recording() -> None:
    recording = _recording(995)
    blocks = _replayed(recording)
    np.testing.assert_array_equal(np.concatenate([block.samples for block in blocks], axis=1), recording.raw)
    assert {block.count for block in blocks[:-1]} == {20}
    assert blocks[0].samples.dtype == np.int16
    assert all(block.gap is None for block in blocks)


def test_a_gap_is_told_with_the_block_after_it_and_no_block_spans_it() -> None:
    gap = Gap(310, 45, "overflow")
    blocks = _replayed(_recording(600, (gap,)))
    after = next(block for block in blocks if block.gap is not None)
    assert after.gap == gap
    assert after.first_index == 355
    assert [block.end_index for block in blocks if block.first_index < 310][-1] == 310


@given(
    pieces=st.lists(st.tuples(st.integers(0, 50), st.integers(0, 30)), max_size=6),
    tail=st.integers(1, 60),
    block_s=st.floats(0.001, 0.1),
)
@settings(max_examples=60, deadline=None)
def test_samples_and_their_indices_are_those_of_the_recording_whatever_its_gaps(
    pieces: list[tuple[int, int]], tail: int, block_s: float
) -> None:
    gaps, index = [], 0
    for samples, lost in pieces:
        gaps.append(Gap(index + samples, lost))
        index += samples + lost
    recording = _recording(sum(samples for samples, _ in pieces) + tail, tuple(gaps))
    blocks = _replayed(recording, block_s=block_s)
    np.testing.assert_array_equal(np.concatenate([block.samples for block in blocks], axis=1), recording.raw)
    np.testing.assert_array_equal(_index(blocks), recording.index())
    told = sum(block.gap.count for block in blocks if block.gap is not None)
    assert told == sum(lost for _, lost in pieces)


def test_a_gap_after_the_last_sample_ends_the_replay() -> None:
    blocks = _replayed(_recording(100, (Gap(100, 50),)))
    assert blocks[-1].end_index == 100


def test_a_replayed_block_is_a_copy() -> None:
    recording = _recording(100)
    blocks = _replayed(recording)
    blocks[0].samples[:] = -1
    assert recording.raw[0, 0] == 0


def test_in_real_time_lost_samples_take_their_time_too() -> None:
    clock = FakeClock()
    source = ReplaySource(_recording(300, (Gap(100, 500),)), realtime=True, clock=clock)
    source.open()
    source.start()
    began = clock.now()
    while (block := source.read()) is not None:
        assert clock.now() - began == pytest.approx(block.end_index / RATE_HZ, abs=1e-9)
    assert clock.now() - began == pytest.approx(0.8)


def test_the_backlog_counts_samples_whose_time_has_come() -> None:
    clock = FakeClock()
    source = ReplaySource(_recording(300), realtime=True, clock=clock)
    source.open()
    source.start()
    clock.advance(0.1005)
    assert source.backlog() == 100
    source.read()
    assert source.backlog() == 80
    clock.advance(10.0)
    assert source.backlog() == 280
    source.stop()
    assert source.backlog() == 0


def test_a_stopped_replay_gives_none_and_starts_again_at_the_first_sample() -> None:
    source = ReplaySource(_recording(300, (Gap(10, 5),)))
    source.open()
    source.start()
    source.read()
    source.read()
    source.stop()
    assert source.read() is None
    source.start()
    first = source.read()
    assert first is not None
    assert (first.first_index, first.count, first.gap) == (0, 10, None)


def test_a_replay_has_no_truth_and_names_its_recording() -> None:
    source = ReplaySource(_recording(30))
    assert source.open().device == "replay of old"
    assert source.truth(0, 30) is None


def test_an_empty_recording_and_a_wrong_order_of_calls_are_refused() -> None:
    with pytest.raises(SourceError, match="no samples"):
        ReplaySource(_recording(0)).open()
    source = ReplaySource(_recording(30))
    with pytest.raises(SourceError, match="not open"):
        source.start()
    with pytest.raises(SourceError, match="not started"):
        source.read()
