"""What the joint estimate chooses: impacts, walls, and what it leaves open."""

from __future__ import annotations

import numpy as np
import pytest
from benchmarks.scenes.draw import draw_scene
from benchmarks.scenes.scene import SceneRecord, make_record

from radargui.correction.adaptive.found import adaptive_rounds
from radargui.correction.adaptive.rough import rough_phases
from radargui.correction.adaptive.rounds import best_round, next_round
from radargui.correction.hum import without_hum
from radargui.correction.joint.breaks import BreakSpeeds
from radargui.correction.joint.estimate import JointEstimate, estimate_joint
from radargui.correction.joint.hyper import spans_together
from radargui.correction.joint.motion_spline import make_spline
from radargui.correction.signals import read_signals
from radargui.motion.segment import find_segment, floor_of_noise
from radargui.restitution.flight_plan import fit_free_flights
from radargui.restitution.flight_rivals import fit_with_rivals


def made(seed: int, kind: str) -> SceneRecord:
    return make_record(draw_scene(seed, kind))


def errors_and_u(record: SceneRecord, estimate: JointEstimate) -> tuple[np.ndarray, np.ndarray]:
    moving = estimate.time_s > record.scene.motion.motion_start_s
    assert estimate.position_m is not None
    assert estimate.u_position_m is not None
    return (estimate.position_m - record.truth.position_m)[:, moving], estimate.u_position_m[:, moving]


def speeds(time_s: list[float], before: list[float], after: list[float]) -> BreakSpeeds:
    return BreakSpeeds(np.array(time_s), np.array(before), np.array(after), np.full(len(time_s), 1e-3))


def test_after_the_last_impact_the_body_lands_again_and_again_with_the_same_coefficient() -> None:
    g, e, t, v, times = 9.81, 0.5, 1.0, 2.0, []
    for _ in range(3):
        v *= e
        t += 2.0 * v / g
        times.append(t)
    found = speeds([1.0, 1.0 + 2.0 / g], [-2.0, -1.0], [1.0, 0.5]).expected_impacts(3.0)
    assert found[:2] == pytest.approx(times[1:3], abs=1e-12)
    assert (np.diff(found) >= 0.010).all()
    assert speeds([1.0], [0.0], [1.0]).expected_impacts(3.0).size == 0
    assert speeds([1.0], [-2.0], [1.0]).expected_impacts(1.1).size == 0


def test_what_no_body_does_is_no_impact() -> None:
    held_by_nothing = speeds([1.0, 1.006, 1.1], [-0.2, -36.0, -0.3], [36.0, 0.1, 0.2])
    assert held_by_nothing.are_impacts().tolist() == [False, False, True]
    assert speeds([1.0, 1.05], [-0.5, -0.25], [0.24, 0.15]).are_impacts().tolist() == [True, True]


def test_spans_of_the_release_and_of_the_fall_stay_apart() -> None:
    spline = make_spline(0.0, 0.5, np.array([0.3]))
    _, middle, _ = spline.jerk()
    parts = spans_together(spline, middle, 0.055)
    assert [middle[part].min() > 0.055 for part in parts] == [False, True, True]
    assert np.concatenate([middle[part] for part in parts]) == pytest.approx(middle)
    assert max(middle[parts[1]]) < 0.3 < min(middle[parts[2]])


def test_a_bounce_between_two_short_flights_is_not_missed() -> None:
    record = made(4037, "generic")
    seen = [impact for impact in record.scene.motion.impacts if impact.after_m_s[2] > 0.15]
    estimate = estimate_joint(record.recording, record.setup)
    for impact in seen:
        assert np.abs(estimate.impact_s - impact.time_s).min() < 1e-3


def test_a_slow_circle_keeps_its_count_of_fringes_where_the_range_law_loses_some() -> None:
    record = made(4091, "generic")
    found = adaptive_rounds(record.recording, record.setup)
    true = (record.truth.path_m - record.truth.path_m[:, :1]) * 2.0 * np.pi / record.setup.radar.wavelength_m

    def worst(phase: np.ndarray) -> float:
        at = found.ground.bins.time_s
        here = [np.interp(at, record.recording.time_s(), row) for row in true]
        return float(np.abs(phase - here).max())

    by_range_law_alone = best_round(found.ground, next_round(found.ground, found.first, 0.15))
    assert worst(by_range_law_alone.phase_rad) > np.pi
    assert worst(found.last.phase_rad) < 0.1


def test_a_receiver_that_sees_a_tenth_of_a_turn_gets_a_circle_as_large_as_the_others() -> None:
    record = made(5023, "physical")
    path = (record.truth.path_m - record.truth.path_m[:, :1]) / record.setup.radar.wavelength_m
    assert np.ptp(path, axis=1).min() < 0.1
    signals = read_signals(record.recording, record.setup.radar.phase_sign)
    rough = rough_phases(signals, 0.3)
    turns = (rough.phase_rad - rough.phase_rad[:, rough.time_s < 0.25].mean(axis=1)[:, None]) / (2.0 * np.pi)
    for found, true in zip(turns, path, strict=True):
        assert np.sqrt(((found - np.interp(rough.time_s, signals.time_s, true)) ** 2).mean()) < 0.05


def test_the_slow_beginning_of_a_pendulum_is_not_taken_for_a_hum() -> None:
    record = made(4042, "generic")
    volts, rate = record.recording.volts(), record.scene.rate_hz
    segment = find_segment(volts, rate)
    assert segment is not None
    assert segment.first / rate > record.scene.motion.motion_start_s + 0.1
    cleaned = without_hum(volts, rate, segment, floor_of_noise(volts))
    assert np.abs(cleaned - volts).max() < 0.005 * volts.std()


def test_a_wall_is_found_where_it_stands() -> None:
    record = made(4057, "physical")
    true = record.scene.planes[1]
    estimate = estimate_joint(record.recording, record.setup)
    solution = estimate.chosen.solution
    wall = solution.problem.stage.planes[1]
    image = wall.image(np.zeros(3), solution.state.theta[solution.problem.layout.planes][3:6])
    outward = image / np.linalg.norm(image)
    assert wall.name == "wall"
    assert -outward @ true.normal > np.cos(np.radians(6.0))
    assert np.linalg.norm(image) / 2.0 == pytest.approx(-true.distance_m, abs=0.015)
    error, _ = errors_and_u(record, estimate)
    assert np.sqrt((error**2).sum(axis=0).mean()) < 1e-4


def test_a_wall_that_cannot_be_told_from_noise_counts_in_the_uncertainty() -> None:
    record = made(4036, "physical")
    assert len(record.scene.planes) == 2
    estimate = estimate_joint(record.recording, record.setup)
    assert [plane.name for plane in estimate.chosen.solution.problem.stage.planes] == ["floor"]
    error, u = errors_and_u(record, estimate)
    assert (np.abs(error) < 2.0 * u).mean() > 0.9
    normal = np.array([0.0, 0.0, 1.0])
    alone = fit_free_flights(estimate.chosen.solution, normal, estimate.onset_s)
    together = fit_with_rivals(estimate.chosen, normal, estimate.onset_s)
    assert alone is not None
    assert together is not None
    assert together.g_m_s2 == alone.g_m_s2
    assert together.u_g() > alone.u_g()
