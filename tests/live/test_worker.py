"""The live worker follows the ring, skips when it is too slow, and fills a track that the screen pulls from."""

from __future__ import annotations

import threading

import numpy as np
import pytest
from hypothesis import given, strategies as st
from support.changed import changed
from support.controlled_source import codes, digitisation

from radargui.acquisition.ring import Ring
from radargui.acquisition.stream import LiveWorker
from radargui.live.processor import LiveProcessor
from radargui.live.track import LiveEstimate, LiveTrack
from radargui.model.arrays import RawArray
from radargui.model.recording import Block, Gap
from radargui.model.setup import read_setup
from radargui.system.resources import default_setup_path


def estimate(first: int, count: int, step: int = 1) -> LiveEstimate:
    index = np.arange(first, first + count * step, step, dtype=np.intp)
    row = index.astype(np.float64)
    return LiveEstimate(index, row[None], row[None] + 0.1, row[None] + 0.2, np.stack([row + 0.3] * 3), moving=True)


class RememberingProcessor:
    def __init__(self) -> None:
        self.seen: list[tuple[int, int]] = []

    def push(self, samples: RawArray, first_index: int) -> LiveEstimate:
        self.seen.append((first_index, samples.shape[1]))
        return estimate(first_index, samples.shape[1])


def worker(longest_lag: int = 100, length: int = 1000) -> tuple[LiveWorker, Ring, RememberingProcessor, LiveTrack]:
    ring = Ring(2, length, np.float64)
    processor, track = RememberingProcessor(), LiveTrack(1, 1000.0, 1.0)
    return LiveWorker(ring, processor, track, longest_lag), ring, processor, track


def block(first: int, count: int, gap: Gap | None = None) -> Block:
    return Block(np.zeros((2, count)), first, gap)


def test_every_sample_is_estimated_once_while_the_worker_keeps_up() -> None:
    live, ring, processor, track = worker()
    for first in range(0, 300, 50):
        ring.append(block(first, 50))
        live.catch_up()
    assert processor.seen == [(first, 50) for first in range(0, 300, 50)]
    assert live.skipped == live.lag == 0
    assert track.latest == 300


def test_a_worker_that_is_too_slow_skips_to_the_newest_samples_and_says_how_many() -> None:
    live, ring, processor, _ = worker(longest_lag=100)
    ring.append(block(0, 50))
    live.catch_up()
    ring.append(block(50, 400))
    assert live.lag == 400
    live.catch_up()
    assert processor.seen == [(0, 50), (425, 25)]
    assert live.skipped == 375
    assert live.lag == 0


def test_a_worker_that_the_ring_has_lapped_goes_on_with_what_is_there() -> None:
    live, ring, processor, _ = worker(longest_lag=10**9, length=200)
    ring.append(block(0, 1000))
    live.catch_up()
    assert processor.seen == [(975, 25)]
    assert live.skipped == 975


def test_a_gap_is_no_skip_but_a_jump_of_the_index() -> None:
    live, ring, processor, _ = worker()
    ring.append(block(0, 40))
    ring.append(block(60, 20, Gap(40, 20)))
    live.catch_up()
    assert processor.seen == [(0, 40), (60, 20)]
    assert live.skipped == 0


def test_the_worker_runs_until_it_is_told_to_finish() -> None:
    live, ring, processor, _ = worker()
    thread = threading.Thread(target=live.run)
    thread.start()
    ring.append(block(0, 30))
    live.wake()
    live.finish()
    thread.join(20.0)
    assert not thread.is_alive()
    assert processor.seen in ([(0, 30)], [])


@given(st.lists(st.tuples(st.integers(0, 30), st.integers(0, 20), st.integers(1, 3)), max_size=12), st.integers(0, 400))
def test_the_track_gives_what_is_new_since_any_index(pieces: list[tuple[int, int, int]], since: int) -> None:
    track = LiveTrack(1, 1000.0, 0.05)
    kept: list[int] = []
    end = 0
    for skipped, count, step in pieces:
        piece = estimate(end + skipped, count, step)
        track.append(piece)
        kept += piece.index.tolist()
        end += skipped + count * step
    kept = kept[-50:]
    span = track.since(since)
    expected = [index for index in kept if index >= since]
    assert span.index.tolist() == expected
    np.testing.assert_allclose(span.q[0], np.array(expected) + 0.1)
    np.testing.assert_allclose(span.position_m[2], np.array(expected) + 0.3)
    np.testing.assert_allclose(span.time_s, np.array(expected) / 1000.0)
    assert track.latest == (kept[-1] + 1 if kept else 0)


def test_asking_for_what_follows_a_span_gives_nothing_twice() -> None:
    track = LiveTrack(1, 1000.0, 1.0)
    track.append(estimate(0, 20))
    first = track.since(0)
    track.append(estimate(20, 5))
    assert track.since(int(first.index[-1]) + 1).index.tolist() == [20, 21, 22, 23, 24]
    assert track.moving


def test_the_worker_is_told_when_the_tracer_hangs_at_its_release_again() -> None:
    calls: list[object] = []

    class Told:
        def push(self, samples: RawArray, first_index: int) -> LiveEstimate:
            calls.append(first_index)
            return estimate(first_index, samples.shape[1])

        def at_release(self) -> None:
            calls.append("release")

    ring = Ring(2, 1000, np.int16)
    worker = LiveWorker(ring, Told(), LiveTrack(1, 1000.0, 1.0), 900)
    ring.append(Block(np.zeros((2, 100), dtype=np.int16), 0))
    worker.at_release(100)
    worker.catch_up()
    ring.append(Block(np.zeros((2, 50), dtype=np.int16), 100))
    worker.catch_up()
    ring.append(Block(np.zeros((2, 50), dtype=np.int16), 150))
    worker.catch_up()
    assert calls == [0, "release", 100, 150]


@pytest.mark.parametrize("away", [(0, 0), (0, 121), (10, 70), (45, 90), (59, 62), (60, 121), (61, 110), (80, 121)])
def test_a_gap_in_a_motion_ends_in_a_rest_that_starts_anew_whenever_the_worker_is_away(away: tuple[int, int]) -> None:
    setup = changed(read_setup(default_setup_path()), daq={"rate_hz": 10000.0})
    ring, track = Ring(6, 100_000, np.int16, digitisation()), LiveTrack(3, 10000.0, 10.0)
    live = LiveWorker(ring, LiveProcessor(setup, digitisation()), track, longest_lag=20000, together=400)
    first, second = codes(12000, moving=slice(8000, 12000), hangs=True), codes(2000, moving=slice(0, 2000), hangs=True)
    blocks = [Block(first[:, at : at + 200], at) for at in range(0, 12000, 200)]
    blocks.append(Block(second, 13500, Gap(12000, 1500)))
    rest = codes(12000, seed=3, hangs=True)
    blocks += [Block(rest[:, at : at + 200], 15500 + at) for at in range(0, 12000, 200)]
    for number, block in enumerate(blocks):
        ring.append(block)
        if not away[0] <= number < away[1]:
            live.catch_up()
    live.catch_up()
    assert not track.moving
    assert track.began_anew
    assert track.doubt == ""
