"""Where the live track cannot know the place, it says so and shows none."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from benchmarks.world.draw import draw
from benchmarks.world.scene import make_record
from support.changed import changed
from support.controlled_source import codes, digitisation as as_sampled
from support.simulated_once import simulate_once
from support.simulated_recording import simulate_recording

from radargui.live.processor import LiveMemory, LiveProcessor
from radargui.live.track import LiveEstimate
from radargui.model.arrays import FloatArray, RawArray
from radargui.model.recording import Digitisation, Truth
from radargui.model.setup import Setup, read_setup
from radargui.system.resources import default_setup_path

BLOCK_S = 0.04
FAR_M = 5e-3


@pytest.fixture(scope="module")
def setup() -> Setup:
    return changed(read_setup(default_setup_path()), simulation={"restitution": 0.6, "rest_s": 0.9, "settle_s": 0.4})


def followed(
    setup: Setup, digitisation: Digitisation, raw: RawArray, memory: LiveMemory | None = None
) -> list[LiveEstimate]:
    """Feed samples in the blocks of the worker."""
    live = LiveProcessor(setup, digitisation, memory)
    block = round(BLOCK_S * digitisation.sample_rate_hz)
    return [live.push(raw[:, begin : begin + block], begin) for begin in range(0, raw.shape[1], block)]


def sure_and_far_s(estimates: list[LiveEstimate], truth: Truth, rate_hz: float, first: int = 0) -> float:
    """Return for how long a place was shown without a word that is far from the true one."""
    wrong = 0.0
    for one in estimates:
        if one.index.size and not one.began_anew:
            away = np.linalg.norm(one.position_m - truth.position_m[:, one.index + first], axis=0)
            wrong += float((away > FAR_M).mean()) * BLOCK_S
    return wrong


def doubts(estimates: list[LiveEstimate]) -> set[str]:
    return {one.doubt for one in estimates} - {""}


def without(row: slice, first: int = 0) -> Callable[[RawArray], RawArray]:
    def dead(raw: RawArray) -> RawArray:
        out = raw.copy()
        quiet = np.random.default_rng(0).normal(0.0, 3.0, out[row, first:].shape)
        out[row, first:] = quiet.astype(np.int16)
        return out

    return dead


def swapped(raw: RawArray) -> RawArray:
    return np.asarray(raw[[0, 1, 3, 2, 4, 5]])


def copied(raw: RawArray) -> RawArray:
    return np.asarray(raw[[0, 1, 0, 1, 4, 5]])


@pytest.mark.parametrize(
    ("fault", "warm", "said"),
    [
        (without(slice(2, 4)), False, "no whole circle yet of receiver 2"),
        (without(slice(2, 4)), True, "receiver 2 shows no motion"),
        (without(slice(3, 4)), True, "receiver 2 shows no circle"),
        (without(slice(2, 4), 36000), False, "receiver 2 shows no circle"),
        (swapped, False, "receiver 2 falls upwards: are I and Q swapped?"),
        (copied, False, "receivers 1 and 2 have one cable"),
    ],
)
def test_a_fault_of_a_receiver_is_named_within_a_sixth_of_a_second(
    setup: Setup, fault: Callable[[RawArray], RawArray], warm: bool, said: str
) -> None:
    recording, truth = simulate_once(setup)
    memory = LiveMemory()
    if warm:
        followed(setup, recording.digitisation, recording.raw, memory)
    estimates = followed(setup, recording.digitisation, fault(recording.raw), memory)
    assert said in doubts(estimates)
    assert sure_and_far_s(estimates, truth, setup.daq.rate_hz) < 1.0 / 6.0


def test_a_map_that_went_astray_does_not_lead_the_next_motion(setup: Setup) -> None:
    recording, truth = simulate_once(setup)
    memory = LiveMemory()
    followed(setup, recording.digitisation, recording.raw, memory)
    followed(setup, recording.digitisation, without(slice(3, 4))(recording.raw), memory)
    assert not memory.is_warm
    estimates = followed(setup, recording.digitisation, recording.raw, memory)
    assert doubts(estimates) == set()
    assert sure_and_far_s(estimates, truth, setup.daq.rate_hz) == 0.0


@pytest.mark.parametrize("channels", [slice(None), slice(2, 3)])
def test_no_turns_are_counted_over_samples_that_are_no_numbers(setup: Setup, channels: slice) -> None:
    recording, truth = simulate_once(setup)
    volts = recording.digitisation.volts(recording.raw)
    fallen = int(np.argmax(truth.position_m[2] < truth.position_m[2, 0] - 0.1))
    volts[channels, fallen : fallen + 600] = np.nan
    estimates = followed(setup, replace(recording.digitisation, scaling=None), volts)
    assert doubts(estimates) == {"a channel gave no numbers"}
    assert sure_and_far_s(estimates, truth, setup.daq.rate_hz) == 0.0


def test_single_samples_that_are_no_numbers_do_no_harm(setup: Setup) -> None:
    recording, truth = simulate_once(setup)
    volts = recording.digitisation.volts(recording.raw)
    volts[:, np.random.default_rng(0).random(volts.shape[1]) < 0.01] = np.nan
    estimates = followed(setup, replace(recording.digitisation, scaling=None), volts)
    assert doubts(estimates) == set()
    assert sure_and_far_s(estimates, truth, setup.daq.rate_hz) == 0.0


def test_what_moves_as_the_first_samples_come_is_not_at_its_release(setup: Setup) -> None:
    recording, truth = simulate_once(setup)
    fallen = int(np.argmax(truth.position_m[2] < truth.position_m[2, 0] - 0.1))
    estimates = followed(setup, recording.digitisation, recording.raw[:, fallen:])
    assert "it moved, or the voltages drifted, as the first samples came" in doubts(estimates)
    assert sure_and_far_s(estimates, truth, setup.daq.rate_hz, fallen) < 0.6
    assert estimates[-1].began_anew


@pytest.mark.parametrize(
    "simulation",
    [{"snr_db": 0.0}, {"snr_db": 3.0}, {"mismatch": 0.2}, {"mismatch": 0.5}, {"mismatch": 0.5, "snr_db": 30.0}],
    ids=str,
)
@pytest.mark.parametrize("seed", [1, 2])
def test_a_fall_in_noise_or_a_hum_is_never_called_a_rest(setup: Setup, simulation: dict[str, float], seed: int) -> None:
    changed_setup = changed(setup, simulation={**simulation, "seed": seed})
    recording, truth = simulate_recording(changed_setup)
    estimates = followed(changed_setup, recording.digitisation, recording.raw)
    away = np.linalg.norm(truth.position_m - truth.position_m[:, :1], axis=0)
    rate_hz = recording.digitisation.sample_rate_hz
    assert sure_and_far_s(estimates, truth, rate_hz) < 0.05 < 0.1 * (away > FAR_M).sum() / rate_hz


def test_who_would_not_see_a_fall_does_not_call_it_a_rest(setup: Setup) -> None:
    still = changed(setup, simulation={"scene": "rest", "mains": 0.4, "mains_frequency_hz": 180.0})
    recording, _ = simulate_recording(still)
    estimates = followed(still, recording.digitisation, recording.raw)
    assert doubts(estimates) == {"a motion would be lost in a hum or a vibration"}
    assert np.isnan(estimates[-1].position_m).all()
    assert not estimates[-1].moving


def laboratory(seed: int, **held: object) -> tuple[list[LiveEstimate], Truth, float, FloatArray]:
    """Return estimates of a scene that rests for a second, its truth, its rate and how far the sphere went."""
    record = make_record(draw(seed, rest=1.0, **held))
    recording, truth = record.recording, record.truth
    estimates = followed(record.scene.setup, recording.digitisation, recording.raw)
    away = np.linalg.norm(truth.position_m - truth.position_m[:, :1], axis=0)
    return estimates, truth, recording.digitisation.sample_rate_hz, away


@pytest.mark.parametrize("seed", [3, 9, 17])
def test_over_a_floor_that_reflects_no_turn_is_lost_in_silence(seed: int) -> None:
    estimates, truth, rate_hz, _ = laboratory(seed)
    assert sure_and_far_s(estimates, truth, rate_hz) == 0.0


def test_a_motion_too_slow_for_the_trigger_is_no_rest() -> None:
    estimates, truth, rate_hz, away = laboratory(3, motion="circle")
    assert away.max() > 0.05
    assert sure_and_far_s(estimates, truth, rate_hz) < 0.1
    # once it has gone a fringe and a half, all of its way is known
    last = estimates[-1]
    assert np.linalg.norm(last.position_m - truth.position_m[:, last.index], axis=0).max() < FAR_M


def lost_on_the_floor(setup: Setup) -> tuple[LiveProcessor, RawArray, int]:
    """Return a processor that lost a drop which now lies on the floor, the samples there, and the next index."""
    recording, _ = simulate_once(setup)
    warm = LiveMemory()
    followed(setup, recording.digitisation, recording.raw, warm)
    live = LiveProcessor(setup, recording.digitisation, warm)
    fallen = 33000
    for begin in range(0, fallen, 1000):
        live.push(recording.raw[:, begin : begin + 1000], begin)
    at = fallen + 3000
    for begin in range(at, recording.n_samples - 1000, 1000):
        assert live.push(recording.raw[:, begin : begin + 1000], begin).began_anew
    return live, recording.raw[:, -4000:], recording.n_samples - recording.n_samples % 1000


def test_a_track_lost_in_a_drop_is_not_at_its_release_before_a_hand_has_moved_it(setup: Setup) -> None:
    live, floor, at = lost_on_the_floor(setup)
    live.fallen()
    for begin in range(at, at + 20000, 4000):
        assert live.push(floor, begin).began_anew
    # somebody knocked at the table: set aside as a hand is
    live.at_release()
    assert live.push(floor, at + 20000).began_anew


def test_a_track_lost_in_a_drop_is_at_its_release_after_a_hand_in_which_it_was_lost_too(setup: Setup) -> None:
    live, floor, at = lost_on_the_floor(setup)
    live.fallen()
    hand = simulate_once(setup)[0].raw[:, 33000:40000]
    live.push(hand, at)
    live.push(hand[:, 4000:], at + 11000)
    assert live.push(floor, at + 14000).doubt == "samples were lost"
    live.at_release()
    estimate = live.push(floor, at + 18000)
    assert not estimate.began_anew
    assert estimate.position_m[:, -1] == pytest.approx(setup.tracer.release_position_m)


def test_one_followed_to_another_place_counts_as_hung_up_and_that_is_said(setup: Setup) -> None:
    recording, truth = simulate_once(setup)
    live = LiveProcessor(setup, recording.digitisation)
    # at the top of the first bounce
    struck = int(truth.impact_time_s[0] * setup.daq.rate_hz)
    apex = struck + int(np.argmax(truth.position_m[2, struck : struck + 12000]))
    for begin in range(0, apex, 500):
        live.push(recording.raw[:, begin : begin + 500], begin)
    live.at_release()
    estimate = live.push(recording.raw[:, :500])
    assert estimate.began_anew
    assert estimate.position_m[:, -1] == pytest.approx(setup.tracer.release_position_m, abs=5e-3)


def test_a_drop_that_no_circle_was_seen_of_is_not_at_its_release_though_it_was_set_aside(setup: Setup) -> None:
    raw = without(slice(2, 4))(simulate_once(setup)[0].raw)
    live = LiveProcessor(setup, simulate_once(setup)[0].digitisation)
    rests = np.concatenate([raw, *[raw[:, -4000:]] * 8], axis=1)
    for begin in range(0, rests.shape[1], 1000):
        live.push(rests[:, begin : begin + 1000], begin)
    live.at_release()
    assert live.push(raw[:, -4000:]).began_anew


@pytest.mark.parametrize("block", [40, 200, 1000])
def test_after_a_gap_in_a_motion_a_rest_is_a_rest_also_where_no_direct_voltage_is_passed(block: int) -> None:
    setup = changed(read_setup(default_setup_path()), daq={"rate_hz": 10000.0})
    live = LiveProcessor(setup, as_sampled())
    first, second = codes(12000, moving=slice(8000, 12000)), codes(2000, seed=2, moving=slice(0, 2000))
    said: list[LiveEstimate] = []
    for samples, begin in ((first, 0), (second, 13500), (codes(24000, seed=3), 15500)):
        for at in range(0, samples.shape[1], block):
            said.append(live.push(samples[:, at : at + block], begin + at))
    assert said[7000 // block].doubt == "a motion would be lost in noise", "nothing was seen yet"
    assert {one.doubt for one in said if one.moving} == {"", "samples were lost"}, "this motion is not lost in noise"
    rest = said[-20000 // block :]
    assert all(one.began_anew and not one.doubt for one in rest)
    assert all(np.isfinite(one.position_m).all() for one in rest[1:])
