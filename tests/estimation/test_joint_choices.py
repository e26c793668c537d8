"""What the joint estimate chooses: counts of fringes, sizes of circles, walls."""

from __future__ import annotations

import numpy as np
import pytest
from benchmarks.world.broken.drops import make_drop
from benchmarks.world.generic.draw import draw_scene
from benchmarks.world.generic.scene import SceneRecord, make_record
from support.estimates import conditioned_of, joint_of, rounds_of

from radargui.estimation.adaptive.rough import rough_phases
from radargui.estimation.adaptive.rounds import best_round, next_round
from radargui.estimation.signals import scaled_signals
from radargui.model.front_end import FrontEnd
from radargui.physics.path_length import path_lengths, place_antennas


def made(seed: int, kind: str) -> SceneRecord:
    return make_record(draw_scene(seed, kind))


def test_a_slow_circle_keeps_its_count_of_fringes_where_the_range_factor_loses_some() -> None:
    record = make_record(draw_scene(5007, "generic", "circle"))
    found = rounds_of(record.recording, record.setup)
    true = (record.truth.path_m - record.truth.path_m[:, :1]) * 2.0 * np.pi / record.setup.radar.wavelength_m

    def worst(phase: np.ndarray) -> float:
        at = found.data.bins.time_s
        here = [np.interp(at, record.recording.time_s(), row) for row in true]
        return float(np.abs(phase - here).max())

    by_range_factor_alone = best_round(found.data, next_round(found.data, found.first, 0.15))
    assert worst(by_range_factor_alone.phase_rad) > np.pi
    assert worst(found.last.phase_rad) < 0.1


def test_a_receiver_that_sees_a_tenth_of_a_turn_gets_a_circle_as_large_as_the_others() -> None:
    record = made(5023, "physical")
    path = (record.truth.path_m - record.truth.path_m[:, :1]) / record.setup.radar.wavelength_m
    assert np.ptp(path, axis=1).min() < 0.1
    signals = scaled_signals(conditioned_of(record.recording, record.setup))
    rough = rough_phases(signals, 0.3)
    turns = (rough.phase_rad - rough.phase_rad[:, rough.time_s < 0.25].mean(axis=1)[:, None]) / (2.0 * np.pi)
    for found, true in zip(turns, path, strict=True):
        assert np.sqrt(((found - np.interp(rough.time_s, signals.time_s, true)) ** 2).mean()) < 0.05


def test_a_weak_echo_that_went_round_is_not_taken_for_a_short_arc_of_a_strong_one() -> None:
    drop = make_drop(9, "whole", 3)
    signals = scaled_signals(conditioned_of(drop.recording, drop.setup))
    rough = rough_phases(signals, signals.onset_s)
    assert set(rough.seen) == {2}
    path = path_lengths(drop.position_m, place_antennas(drop.setup)) / drop.setup.radar.wavelength_m
    turns = 2.0 * np.pi * (path - path[:, :1])

    def worst(time_s: np.ndarray, phase_rad: np.ndarray) -> float:
        true = np.array([np.interp(time_s, drop.recording.time_s(), row) for row in turns])
        return float(np.abs(phase_rad - phase_rad[:, :20].mean(axis=1)[:, None] - true).max())

    assert worst(rough.time_s, rough.phase_rad) > 50.0
    assert worst(rough.time_s, rough.as_seen(2).phase_rad) < 1.0
    found = rounds_of(drop.recording, drop.setup)
    assert worst(found.data.bins.time_s, found.last.phase_rad) < 0.3


@pytest.mark.parametrize(("seed", "kind", "right_m"), [(703, "generic", 1.6e-3), (712, "physical", 1.0e-3)])
def test_the_fits_tell_a_short_arc_from_a_small_circle(seed: int, kind: str, right_m: float) -> None:
    """Pendulums: in the first the completed arc is right, in the second what the samples say by themselves.

    The other choice is 3.3 and 25 mm wrong; the first bound is half of that.
    """
    record = make_record(draw_scene(seed, kind, "pendulum"))
    found = rounds_of(record.recording, record.setup)
    change = found.last.phase_rad * record.setup.radar.wavelength_m / (2.0 * np.pi)
    true = record.truth.path_m - record.truth.path_m[:, :1]
    here = np.array([np.interp(found.data.bins.time_s, record.recording.time_s(), row) for row in true])
    assert np.sqrt(((change - here) ** 2).mean()) < right_m


def test_the_slow_beginning_of_a_pendulum_is_not_taken_for_a_hum() -> None:
    record = made(4042, "generic")
    conditioned = conditioned_of(record.recording, record.setup)
    assert conditioned.segment.first / record.scene.rate_hz > record.scene.motion.motion_start_s + 0.1
    # nothing was taken off; the sign of Q is the wiring's
    np.testing.assert_array_equal(conditioned.volts[0::2], record.recording.volts()[0::2, conditioned.samples])


@pytest.mark.slow
def test_a_wall_is_found_where_it_stands() -> None:
    short = {"moving_s": 0.4, "rate_hz": 2500.0, "snr_db": 40.0, "flicker": 0.0}
    record = make_record(draw_scene(4057, "physical", **short))
    true = record.scene.planes[1]
    estimate = joint_of(record.recording, record.setup)
    solution = estimate.chosen.solution
    wall = solution.problem.inputs.planes[1]
    image = wall.image(np.zeros(3), solution.state.theta[solution.problem.layout.planes][3:6])
    outward = image / np.linalg.norm(image)
    assert wall.name == "wall"
    assert -outward @ true.normal > np.cos(np.radians(6.0))
    assert np.linalg.norm(image) / 2.0 == pytest.approx(-true.distance_m, abs=0.015)
    moving = estimate.time_s > record.scene.motion.motion_start_s
    assert estimate.position_m is not None
    error = (estimate.position_m - record.truth.position_m)[:, moving]
    assert np.sqrt((error**2).sum(axis=0).mean()) < 1e-4


def test_a_sample_before_a_channels_own_first_one_is_not_used_where_the_front_end_is_taken_off() -> None:
    record = make_record(draw_scene(9, "generic", "drop", rate_hz=5000.0, snr_db=35.0, skew_s=2e-5))
    conditioned = conditioned_of(record.recording, record.setup)
    assert conditioned.delay_s.any()
    assert scaled_signals(conditioned).usable.all()
    signals = scaled_signals(conditioned, lambda _: FrontEnd(1.5, 0.01, 0.0, 0.1))
    assert all(signals.mixers)
    assert not signals.usable[0]
    assert signals.usable[1:].all()


def test_a_signal_that_is_a_mean_tells_how_its_samples_are_spread() -> None:
    record = make_record(draw_scene(9, "generic", "drop", rate_hz=200000.0, snr_db=35.0, skew_s=0.0))
    conditioned = conditioned_of(record.recording, record.setup)
    assert conditioned.size > 1
    samples_s = np.arange(conditioned.size) / record.recording.digitisation.sample_rate_hz
    assert scaled_signals(conditioned).spread_s == pytest.approx(np.std(samples_s))
