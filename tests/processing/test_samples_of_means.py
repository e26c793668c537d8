"""Results at every sample of the recording, worked out at the rate of the Doppler band."""

from __future__ import annotations

import numpy as np
import pytest
from support.changed import changed
from support.simulated_recording import simulate_recording
from support.small_setups import quick_setup

from radargui.model.result import CorrectedIQ, RunResult
from radargui.processing.process import process
from radargui.processing.whole import interpolate
from radargui.signals.band import band_signals


@pytest.mark.parametrize("size", [2, 3, 8])
@pytest.mark.parametrize("left_over", [0, 1])
def test_a_line_through_means_is_that_line_in_every_sample(size: int, left_over: int) -> None:
    count = 5 * size + left_over
    line = 3.0 - 0.25 * np.arange(count)
    means = line[: 5 * size].reshape(5, size).mean(axis=1)
    out = np.full((2, count), np.nan)
    interpolate(np.stack([means, -means]), size, out)
    assert np.allclose(out, [line, -line], rtol=0.0, atol=1e-12)


def test_a_sample_beside_an_unknown_mean_is_neither_valid_nor_a_number() -> None:
    known, values = np.array([True, True, False, True, True]), np.array([0.0, 1.0, np.nan, 3.0, 4.0])
    valid, out = np.empty(20, dtype=np.bool_), np.empty(20)
    interpolate(known, 4, valid)
    interpolate(values, 4, out)
    assert np.array_equal(valid, np.isfinite(out))
    assert valid.any()
    assert not valid[8:12].any()


@pytest.mark.parametrize("correction", ["published", "adaptive"])
def test_a_drop_taken_fast_gives_what_it_gives_taken_slowly(correction: str) -> None:
    setup = changed(
        quick_setup(),
        processing={"correction": correction},
        daq={"rate_hz": 100_000.0, "channel_skew_s": 0.0},
        simulation={"drop_height_m": 0.2, "snr_db": 35.0},
    )
    recording, truth = simulate_recording(setup)
    size = band_signals(recording, slice(0, recording.n_samples), 0, setup).size
    assert size >= 16
    result = process(recording, setup)
    assert result.status == "ok"
    assert result.track is not None
    assert result.corrected is not None
    assert result.segment is not None
    assert result.track.position_m.shape == (3, recording.n_samples)
    assert np.array_equal(result.track.time_s, recording.time_s())
    # half of a mean later or earlier would be 2 m/s x 0.12 ms = 0.24 mm where it falls fastest
    falling = (truth.position_m[2] < truth.position_m[2, 0] - 0.1) & (
        recording.time_s() < truth.impact_time_s[0] - 0.005
    )
    off = result.track.position_m[2, falling] - truth.position_m[2, falling]
    u = result.track.u_position_m[2, falling]
    assert np.abs(off).mean() < 2.0 * u.mean()
    found = np.array([one.time_s for one in result.bounces.impacts])
    assert np.abs(found[:4] - truth.impact_time_s[:4]).max() < 3e-5
    # noise is that of a sample as it was recorded, not of a mean of 24
    assert [one.snr_db for one in result.corrected.channels] == pytest.approx([35.0] * 3, abs=2.0)


def test_values_of_a_result_are_made_once_when_they_are_asked_for() -> None:
    recording, _ = simulate_recording(changed(quick_setup(), simulation={"drop_height_m": 0.1}))
    made: list[int] = []
    nothing = np.empty((3, 0))

    def corrected() -> CorrectedIQ:
        made.append(1)
        return CorrectedIQ(nothing[0], nothing, nothing, nothing > 0.0, nothing, "none", ())

    result = RunResult(recording, quick_setup(), "ok", corrected=corrected)
    assert not made
    assert result.track is None
    assert result.corrected is result.corrected
    assert len(made) == 1
