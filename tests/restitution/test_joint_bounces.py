"""e, g and their checks from joint estimates with known truth: drag, a tilted floor, grains without a rebound."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from benchmarks.world.draw import draw
from benchmarks.world.generic.draw import draw_scene
from benchmarks.world.generic.motion import GRAVITY_M_S2
from benchmarks.world.generic.scene import SceneRecord, make_record
from benchmarks.world.scene import make_record as laboratory_record
from support.changed import changed
from support.estimates import joint_of
from support.normal_matrices import dense_normal
from support.simulated_recording import simulate_recording
from threadpoolctl import threadpool_limits

from radargui.estimation.joint import JointEstimate
from radargui.estimation.posterior.motion_posterior import AlternativeMotion, MotionPosterior
from radargui.estimation.solve.assemble import assemble
from radargui.estimation.solve.minimise import MinimiseSettings, minimise, solved_at
from radargui.estimation.solve.problem import Start, State
from radargui.model.radar import Floor
from radargui.model.setup import Setup, read_setup
from radargui.restitution.cross_check import disagreements, found_tilt
from radargui.restitution.flight_fit import fit_flights
from radargui.restitution.flight_unknowns import FlightPlan, FlightUnknowns
from radargui.restitution.joint_bounces import fit_free_flights, fit_with_alternatives, joint_bounces
from radargui.system.resources import default_setup_path

TILT_DEG, E = 5.0, 0.4


def estimated(record: SceneRecord) -> JointEstimate:
    with threadpool_limits(limits=1, user_api="blas"):
        return joint_of(record.recording, record.setup)


@pytest.fixture(scope="module")
def drop() -> tuple[SceneRecord, JointEstimate]:
    fixed = {"rate_hz": 2500.0, "snr_db": 40.0, "skew_s": 0.0, "floor": 0.0, "wall": 0.0, "flicker": 0.0}
    record = make_record(draw_scene(9, "physical", "drop", drag=0.06, e=0.7, height_m=0.2, **fixed))
    return record, estimated(record)


def test_flights_are_fitted_on_the_exact_marginal_of_the_whole_problem(
    drop: tuple[SceneRecord, JointEstimate],
) -> None:
    solution = drop[1].chosen.solution
    spline, posterior = solution.at.spline, drop[1].posterior
    plan = FlightPlan(2, posterior.free.first_coefficient_from(drop[1].onset_s + 0.01))
    information = plan.information(posterior)
    problem, layout, rows = solution.problem, solution.problem.layout, solution.at.equation.rows
    # the equation of the first two flights is lifted: each of its rows weighs nothing
    last = sum(spline.spans[:2])
    lifted = (rows.span >= plan.first_coefficient) & (rows.span < last)
    assert rows.is_flight[lifted].all()
    free = replace(problem, equation_sd=np.where(lifted, np.inf, problem.equation_sd))
    blocks, held = (assemble(one, solution.state, solution.at) for one in (free, problem))
    size, n_motion = 3 * information.size, len(blocks.normal.coupling)
    assert size < n_motion
    whole = dense_normal(blocks.normal)
    x = np.concatenate([np.arange(size), n_motion + np.arange(information.n_breaks)])
    rest = np.setdiff1d(np.arange(n_motion + layout.size), x)
    through = np.linalg.solve(whole[np.ix_(rest, rest)], whole[np.ix_(rest, x)])
    dense = whole[np.ix_(x, x)] - whole[np.ix_(x, rest)] @ through
    # an impact is where two flights meet: its prior is lifted, too
    precision = problem.prior.sd[layout.breaks] ** -2.0
    dense[size:, size:] -= np.diag(precision[: information.n_breaks])
    scale = np.sqrt(np.outer(np.diag(dense), np.diag(dense)))
    # the equation of later flights, as stiff as 1 mm/s^2, is eliminated: both ways keep about eight digits
    assert np.abs((information.form.times(np.eye(x.size)) - dense) / scale).max() < 1e-7
    # with the equation goes its pull; a break's balance may be a kink, and counts as one
    pull, at_breaks = blocks.slope.copy(), n_motion + np.arange(layout.breaks.stop)
    pull[at_breaks] -= held.slope[at_breaks]
    moved = solution.state.theta[layout.breaks] - problem.prior.mean[layout.breaks]
    slope = pull[x] - through.T @ pull[rest]
    slope[size:] -= (precision * moved)[: information.n_breaks]
    assert information.slope == pytest.approx(slope, rel=1e-6, abs=1e-6 * np.abs(slope).max())
    fit = fit_flights(information, plan)
    assert fit.misfit[0] < 1.5 * fit.misfit[1] + 20.0


def test_flights_that_the_samples_do_not_determine_are_not_good(drop: tuple[SceneRecord, JointEstimate]) -> None:
    fit = fit_free_flights(drop[1].posterior, np.array([0.0, 0.0, 1.0]))
    assert fit is not None
    assert fit.is_good
    assert fit.impact_s.size > 1
    assert not replace(fit, misfit=(-21.0, 100)).is_good
    assert replace(fit, misfit=(-1e-3, 100)).is_good


def test_motions_of_other_evidence_widen_what_the_flights_say_and_do_not_move_it(
    drop: tuple[SceneRecord, JointEstimate],
) -> None:
    estimate, normal = drop[1], np.array([0.0, 0.0, 1.0])
    posterior, solution = estimate.posterior, estimate.chosen.solution
    best = fit_free_flights(posterior, normal)
    assert best is not None
    alike = fit_with_alternatives(posterior, [AlternativeMotion(posterior, 0.5)], normal)
    assert alike is not None
    # times what the maps cannot follow
    np.testing.assert_allclose(alike.covariance, 1.2**2 * best.covariance, rtol=1e-9)
    # a motion that rises higher by a thousandth has other speeds and another g
    higher = State(solution.state.coefficients * np.array([1.0, 1.0, 1.001]), solution.state.theta)
    elsewhere = MotionPosterior(solved_at(Start(solution.problem, higher)), estimate.onset_s)
    fit = fit_with_alternatives(posterior, [AlternativeMotion(elsewhere, 0.5)], normal)
    assert fit is not None
    assert fit.values.tolist() == best.values.tolist()
    wider = np.diag(fit.covariance) / np.diag(best.covariance)
    assert (wider > 0.9 * 1.2**2).all()
    assert wider.max() > 2.0 * 1.2**2


def test_flights_are_those_of_the_minimum_where_a_solution_is_not_quite_there(
    drop: tuple[SceneRecord, JointEstimate],
) -> None:
    # what the last step has left, 0.0003 in ln L, made 27 of chi-square where the equation that held it was lifted
    solution, normal = drop[1].chosen.solution, np.array([0.0, 0.0, 1.0])
    exact = minimise(Start(solution.problem, solution.state), 40, MinimiseSettings(close=1e-9, nothing=1e-11))
    here, there = (fit_free_flights(MotionPosterior(one, drop[1].onset_s), normal) for one in (solution, exact))
    assert here is not None
    assert there is not None
    assert here.misfit[0] == pytest.approx(there.misfit[0], abs=1.0)
    assert here.g_m_s2 == pytest.approx(there.g_m_s2, abs=0.02 * there.u_g_m_s2)


def test_each_flight_is_moved_by_the_unknowns_of_the_flights_before_it(drop: tuple[SceneRecord, JointEstimate]) -> None:
    posterior = drop[1].posterior
    plan = FlightPlan(3, posterior.free.first_coefficient_from(drop[1].onset_s + 0.01))
    unknowns = FlightUnknowns(plan.information(posterior), plan)
    q = unknowns.start()
    slopes = unknowns.slopes(q)
    for column in range(q.size):
        step = np.where(np.arange(q.size) == column, 1e-5, 0.0)
        more, less = unknowns.motion(q + step), unknowns.motion(q - step)
        assert (more.x - less.x) / 2e-5 == pytest.approx(slopes.x[:, column], abs=2e-6)
        assert (more.results - less.results) / 2e-5 == pytest.approx(slopes.results[:, column], abs=2e-6)


def test_drag_is_taken_out_of_the_two_other_ways_to_e(drop: tuple[SceneRecord, JointEstimate]) -> None:
    record, estimate = drop
    bounces, fit = joint_bounces(estimate, record.setup)
    assert fit is not None
    # the quadratic part of a drag that is 0.06 v^2 at 2 m/s
    assert fit.drag_1_m == pytest.approx(0.053, abs=0.01)
    first = bounces.impacts[0]
    assert first.e_flight_time == pytest.approx(first.e, rel=5e-4)
    assert first.e_height == pytest.approx(first.e, rel=3e-3)
    assert np.isnan(bounces.impacts[-1].e_flight_time)
    assert disagreements(bounces) == []
    assert bounces.normal == pytest.approx((0.0, 0.0, 1.0), abs=1e-3)


@pytest.fixture(scope="module")
def tilted() -> tuple[Setup, JointEstimate]:
    tilt = np.radians(TILT_DEG)
    normal = [float(np.sin(tilt) * 0.8), float(np.sin(tilt) * 0.6), float(np.cos(tilt))]
    setup = changed(
        read_setup(default_setup_path()),
        floor={"height_m": None, "normal": normal},
        daq={"rate_hz": 5000.0},
        simulation={
            "drop_height_m": 0.2,
            "restitution": E,
            "rest_s": 0.3,
            "settle_s": 0.1,
            "mismatch": 0.005,
            "reflection": 0.0,
            "beamwidth_deg": 90.0,
        },
    )
    recording, _ = simulate_recording(setup)
    with threadpool_limits(limits=1, user_api="blas"):
        return setup, joint_of(recording, setup)


def with_normal(setup: Setup, normal: tuple[float, float, float] | None) -> Setup:
    plain = setup.model_dump(by_alias=True, exclude_unset=True)
    return Setup.model_validate({**plain, "floor": {} if normal is None else {"normal": normal}})


def test_e_is_along_the_normal_that_the_impacts_say_where_the_setup_says_none(
    tilted: tuple[Setup, JointEstimate],
) -> None:
    setup, estimate = tilted
    found, _ = joint_bounces(estimate, with_normal(setup, None))
    assert found.normal is not None
    assert found.u_tilt_deg is not None
    between = np.degrees(np.arccos(np.dot(found.normal, setup.floor.normal)))
    assert between < 2.0 * found.u_tilt_deg
    first = found.impacts[0]
    assert first.e == pytest.approx(E, rel=1e-3)
    assert abs(first.e - E) < 2.0 * first.u_e
    (sentence,) = found_tilt(found)
    assert "The floor is tilted by" in sentence
    assert not any("tilted" in one for one in disagreements(found)), "speeds are along it: nothing to warn of"
    upright, _ = joint_bounces(estimate, with_normal(setup, (0.0, 0.0, 1.0)))
    assert abs(upright.impacts[0].e - E) > 0.02 * E
    assert abs(upright.impacts[0].e_flight_time - E) < 0.002
    given, _ = joint_bounces(estimate, setup)
    assert given.impacts[0].e == pytest.approx(E, rel=3e-4)
    assert given.impacts[0].u_e < first.u_e
    assert given.u_tilt_deg is None
    assert found_tilt(given) == ()


def test_g_comes_from_one_fall_into_grains_and_no_impact_is_invented() -> None:
    record = make_record(draw_scene(6003, "generic", "bed", rate_hz=2000.0, snr_db=35.0, moving_s=0.45))
    bounces, fit = joint_bounces(estimated(record), record.setup)
    fall = bounces.free_fall
    assert bounces.impacts == ()
    assert fit is not None
    assert fall is not None
    assert abs(fall.g_m_s2 - GRAVITY_M_S2) < 2.0 * fall.u_g_m_s2
    assert fall.u_g_m_s2 < 0.03
    height = record.truth.position_m[2]
    begins_to_brake = record.recording.time_s()[int(np.argmin(np.gradient(height)))]
    assert begins_to_brake - 0.06 < fall.last_time_s < begins_to_brake
    assert np.isnan(fall.drop_height_m)


@pytest.mark.slow
def test_a_sphere_that_is_thrown_flies_from_where_the_hand_lets_go() -> None:
    # pushed up for 70 ms: from 10 ms after the onset on it obeys the equation only once the hand has let go
    record = laboratory_record(draw(1306, "exact", motion="throw"))
    with threadpool_limits(limits=1, user_api="blas"):
        estimate = joint_of(record.recording, record.scene.setup)
        bounces, fit = joint_bounces(estimate, record.scene.setup)
    assert fit is not None
    assert fit.is_good
    assert fit.first_begin_s > estimate.onset_s + 0.05
    assert abs(fit.g_m_s2 - record.scene.body.acceleration_m_s2) < 3.0 * fit.u_g_m_s2
    true = [impact.e for impact in record.scene.drop.impacts][: len(bounces.impacts)]
    assert len(true) > 3
    for one, e in zip(bounces.impacts, true, strict=True):
        assert one.u_e < 0.001
        assert abs(one.e - e) < 3.0 * one.u_e


def test_what_rolls_down_a_rail_against_a_stop_has_no_flights_and_no_g() -> None:
    held = {"mode": "stopper", "lean_deg": 35.0, "size_m": 0.2, "e": 0.5, "stops": True, "start_m": [-0.08, 0.0, 0.06]}
    quiet = {"rate_hz": 4000.0, "snr_db": 38.0, "skew_s": 0.0, "floor": 0.0, "wall": False, "crosstalk": 0.0}
    record = laboratory_record(draw(7, "exact", motion="incline", **held, **quiet))
    # nobody says that it leans: along the vertical it comes down and goes up as a drop does
    setup = record.scene.setup.model_copy(update={"floor": Floor()})
    with threadpool_limits(limits=1, user_api="blas"):
        estimate = joint_of(record.recording, setup)
    bounces, fit = joint_bounces(estimate, setup)
    assert fit is None
    assert bounces.free_fall is None
    assert len(bounces.impacts) >= 2
    assert disagreements(bounces) == []
