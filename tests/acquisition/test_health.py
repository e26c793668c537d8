"""Health tells levels, clipping, rate and losses; a source that breaks its contract is told."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from support.controlled_source import digitisation
from support.fake_clock import FakeClock

from radargui.acquisition.health import Health, hardly_seen
from radargui.acquisition.run_output import levels
from radargui.acquisition.run_plan import AcquisitionState
from radargui.acquisition.stream import Reading
from radargui.model.errors import SourceError
from radargui.model.recording import Block


def test_the_level_of_codes_is_in_volts_and_rail_values_clip() -> None:
    samples = np.array([[0, 16384, -8192], [-32768, 0, 0]], dtype=np.int16)
    quiet, clipping = levels(samples, digitisation(1))
    assert quiet.peak_v == pytest.approx(5.0)
    assert quiet.lowest_v == pytest.approx(-2.5)
    assert quiet.full_scale_v == pytest.approx(10.0, rel=1e-3)
    assert (quiet.clipped, clipping.clipped) == (False, True)
    assert Health(AcquisitionState.RUNNING, levels=(quiet, clipping)).clipped == ("Q1",)


def test_the_level_of_volts_leaves_nan_out() -> None:
    samples = np.array([[0.1, np.nan, -0.3], [np.nan, np.nan, np.nan]])
    first, second = levels(samples, digitisation(1, codes=False))
    assert first.peak_v == pytest.approx(0.3)
    assert np.isnan(second.peak_v)
    assert first.full_scale_v is None
    assert levels(samples[:, :0], digitisation(1, codes=False)) == ()


def test_the_read_rate_is_what_really_came_and_falls_when_nothing_comes() -> None:
    clock = FakeClock()
    reading = Reading(digitisation(1), clock)
    assert reading.rate_hz() is None
    for number in range(11):
        reading.take(Block(np.zeros((2, 100), dtype=np.int16), 100 * number))
        clock.advance(0.1)
    assert reading.rate_hz() == pytest.approx(1000.0)
    clock.advance(8.9)
    assert reading.rate_hz() == pytest.approx(100.0)


def test_a_block_that_was_fetched_late_does_not_change_the_rate() -> None:
    clock = FakeClock()
    promised = digitisation(1)
    reading, rate_hz = Reading(promised, clock), promised.sample_rate_hz
    begin_s = clock.now()
    for number in range(60):
        # the first two wait for a busy computer
        late_s = 0.04 if number < 2 else 0.0
        clock.advance(max(begin_s + 100 * (number + 1) / rate_hz + late_s - clock.now(), 0.0))
        reading.take(Block(np.zeros((2, 100), dtype=np.int16), 100 * number))
    assert reading.rate_hz() == pytest.approx(rate_hz, rel=1e-3)


def test_lost_samples_are_counted_also_where_the_source_does_not_tell_them() -> None:
    reading = Reading(digitisation(1), FakeClock())
    reading.take(Block(np.zeros((2, 10), dtype=np.int16), 0))
    reading.take(Block(np.zeros((2, 10), dtype=np.int16), 15))
    assert reading.counts == (20, 5, 1)


@pytest.mark.parametrize(
    ("wrong", "told"),
    [
        (Block(np.zeros((3, 10), dtype=np.int16), 10), "promised 2 channels and gave a block of shape (3, 10)"),
        (Block(np.zeros((2, 10), dtype=np.int16), 5), "gave sample 5 again after sample 9"),
    ],
)
def test_a_block_that_does_not_fit_is_a_fault_of_the_source(wrong: Block, told: str) -> None:
    reading = Reading(digitisation(1), FakeClock())
    reading.take(Block(np.zeros((2, 10), dtype=np.int16), 0))
    with pytest.raises(SourceError, match=re.escape(told)):
        reading.take(wrong)


def test_the_backlog_is_asked_for_now_and_then_only() -> None:
    clock = FakeClock()
    reading = Reading(digitisation(1), clock)
    due = []
    for number in range(10):
        reading.take(Block(np.zeros((2, 10), dtype=np.int16), 10 * number))
        due.append(reading.backlog_is_due())
        clock.advance(0.0625)
    assert due == [True, False, False, False, True, False, False, False, True, False]


def test_the_line_names_what_is_wrong_and_only_that() -> None:
    well = Health(AcquisitionState.RUNNING, samples_read=1000, read_rate_hz=33333.0)
    assert well.line() == "1000 samples, 33.3 kS/s, none lost"
    ill = Health(
        AcquisitionState.RUNNING,
        samples_read=5,
        samples_lost=2,
        samples_not_written=3,
        writer_queue_samples=1,
        writer_queue_capacity_samples=4,
        live_skipped_samples=9,
        disk_left_s=600.0,
    )
    assert ill.line() == "5 samples, 2 lost, 3 not written, writer queue 25 %, live skipped 9, disk for 10 min"


def test_what_is_bad_is_told_by_name() -> None:
    well = Health(AcquisitionState.RUNNING, 1000.0, 990.0, samples_read=2000, live_lag_s=0.4)
    assert not any(bad for _, bad in well.figures.values())
    queue = {"writer_queue_samples": 3, "writer_queue_capacity_samples": 4}
    ill = replace(well, read_rate_hz=970.0, samples_lost=2, gaps=1, live_lag_s=0.6, **queue)
    assert [name for name, (_, bad) in ill.figures.items() if bad] == ["rate", "lost", "queue", "lag"]
    assert ill.figures["lost"] == ("2 lost in 1 gap", True)
    assert not replace(ill, samples_read=500).figures["rate"][1], "in its first second a rate means nothing"


def test_the_line_says_last_why_a_fall_may_not_start_the_run() -> None:
    why = hardly_seen("the noise is loud")
    assert why.startswith("A fall may not start the run: the noise is loud. Look whether ")
    assert why.endswith("or lower recording.threshold.")
    assert hardly_seen("") == ""
    assert Health(AcquisitionState.RUNNING, hardly_seen=why).line() == f"0 samples, none lost. {why[:-1]}"
