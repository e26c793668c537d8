"""Drops measured by their flights: blind, with antennas off by what the setup says, on floors that reflect."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from benchmarks.gate.worker import setup_of_version
from benchmarks.world.kinds import PopulationRecord, draw
from support.changed import changed
from support.estimates import conditioned_of

from radargui.estimation.flights.drop_model import DropModel, Parts, evaluate, slopes_of
from radargui.estimation.flights.linear_part import ASIDE, LinearPart
from radargui.estimation.flights.prior import drop_model, flights_prior
from radargui.estimation.flights.setup_unknowns import setup_unknowns
from radargui.estimation.forward.bins import pool
from radargui.estimation.forward.sphere import polarised_sphere
from radargui.estimation.signals import scaled_signals
from radargui.model.finding import warn
from radargui.model.result import RunResult
from radargui.model.setup import Setup
from radargui.motion.flights import Flights
from radargui.processing.by_flights import measure_by_flights
from radargui.processing.process import process

USUAL: Mapping[str, Any] = {
    "rate_hz": 10000.0,
    "height_m": 0.2,
    "e": 0.6,
    "snr_db": 35.0,
    "walls": 0,
    "exchange": True,
    "told": True,
    "amplitude_v": 0.5,
    "exact": False,
}


def _scene(**held: Any) -> tuple[PopulationRecord, Setup]:
    scene = draw("modelled", 44, 0, {**USUAL, **held})
    setup, _ = setup_of_version(scene.setup)
    by_flights = setup.processing.model_copy(update={"correction": "flights"})
    return scene.record(), setup.model_copy(update={"processing": by_flights})


def _assert_right(record: PopulationRecord, result: RunResult, followed: int | None = None) -> None:
    """Hold the result against the truth; of impacts the first ones that are followed, else all."""
    assert result.status == "ok"
    assert result.corrected is not None
    assert result.corrected.method == "flights"
    end_s = record.recording.n_samples / record.recording.digitisation.sample_rate_hz - 0.03
    for time_s, _, after_m_s, e, _ in record.impacts[:followed]:
        if after_m_s > 0.15 and time_s < end_s:
            bounce = min(result.bounces.impacts, key=lambda one, at=time_s: abs(one.time_s - at))
            assert bounce.time_s == pytest.approx(time_s, abs=5e-4)
            assert bounce.valid
            assert bounce.e == pytest.approx(e, abs=4.0 * bounce.u_stated)
    assert all(min(abs(one.time_s - true[0]) for true in record.impacts) < 2e-3 for one in result.bounces.impacts)
    track = result.track
    assert track is not None
    assert track.u_combined_m is not None
    assert record.position_m is not None
    moving = track.valid & (track.time_s > record.start_s)
    error = (track.position_m - record.position_m)[:, moving]
    assert np.sqrt((error**2).mean()) < 3.0 * np.sqrt((track.u_combined_m[:, moving] ** 2).mean())


def _assert_right_in_g(record: PopulationRecord, result: RunResult) -> None:
    fall, budget = result.bounces.free_fall, result.uncertainty_budget
    assert fall is not None
    assert budget is not None
    assert budget.g_m_s2.combined is not None
    assert fall.g_m_s2 == pytest.approx(record.gravity_m_s2, abs=4.0 * budget.g_m_s2.combined)


@pytest.fixture(scope="module")
def usual() -> tuple[PopulationRecord, Setup, RunResult]:
    record, setup = _scene(floor=0.3)
    return record, setup, process(record.recording, setup)


def test_a_drop_is_measured_with_antennas_off_by_their_u(usual: tuple[PopulationRecord, Setup, RunResult]) -> None:
    record, _, result = usual
    _assert_right(record, result)
    assert result.findings == ()
    first = result.bounces.impacts[0]
    assert first.e == pytest.approx(record.impacts[0][3], rel=1e-3)
    assert first.u_stated < 1e-3
    _assert_right_in_g(record, result)


def test_offsets_that_drift_through_a_drop_are_no_misfit_of_its_flights() -> None:
    record, setup = _scene(floor=0.3, drift=0.3)
    result = process(record.recording, setup)
    _assert_right(record, result)
    assert result.findings == ()
    assert result.bounces.impacts[0].e == pytest.approx(record.impacts[0][3], rel=1e-3)


def test_air_that_brakes_a_small_light_sphere_neither_bends_its_flights_nor_moves_e() -> None:
    record, setup = _scene(
        floor=0.1, exchange=False, exact=True, diameter_m=0.005, density_kg_m3=1100.0, density_told=True
    )
    result = process(record.recording, setup)
    _assert_right(record, result)
    _assert_right_in_g(record, result)
    # with the drag curve held 4 in ten thousand were missing
    assert result.bounces.impacts[0].e == pytest.approx(record.impacts[0][3], rel=2e-4)


def test_what_follows_the_last_flight_is_not_known(usual: tuple[PopulationRecord, Setup, RunResult]) -> None:
    _, _, result = usual
    after = result.track.time_s > result.track.time_s[result.track.valid][-1]
    assert after.any()
    for values in (result.paths.change_m, result.paths.phase_rad, result.track.position_m, result.corrected.i):
        assert np.isfinite(values[:, result.track.valid]).all()
        assert np.isnan(values[:, after]).all()


def test_the_antennas_share_of_the_budget_is_apart(usual: tuple[PopulationRecord, Setup, RunResult]) -> None:
    budget = usual[2].uncertainty_budget
    assert budget is not None
    place = budget.position_m
    # a release known to a millimetre moves all of the track, and no noise does
    assert place.calibration is not None
    assert place.statistical is not None
    assert place.calibration > 3.0 * place.statistical


@pytest.mark.slow
def test_circles_that_a_floor_of_metal_bends_are_no_hindrance() -> None:
    record, setup = _scene(floor=0.9, amplitude_v=0.5, exact=True)
    result = process(record.recording, setup)
    # the start knows no exchange: it loses what bounces lower
    _assert_right(record, result, followed=3)
    assert abs(result.bounces.impacts[0].e / record.impacts[0][3] - 1.0) < 2e-4
    _assert_right_in_g(record, result)
    assert not {"flights_misfit", "residuals_above_noise"} & {one.code for one in result.findings}


@pytest.mark.slow
def test_a_strong_floor_hides_no_crosstalk() -> None:
    record, setup = _scene(floor=0.5, multiplexed=True, crosstalk=0.008)
    conditioned = conditioned_of(record.recording, setup)
    # the floor makes mixers that are nearly perfect look far off
    assert any(scaled_signals(conditioned).mixers)
    drop = measure_by_flights(conditioned, setup, lambda _: None, None)
    assert not any(drop.signals.mixers)
    estimate = drop.estimate
    assert estimate.at.values.theta[estimate.model.layout.crosstalk] == pytest.approx(0.008, abs=1e-3)


def test_the_g_that_is_expected_is_as_uncertain_as_buoyancy_and_the_clock_leave_it() -> None:
    _, setup = _scene(floor=0.3)
    told = changed(setup, site={"g_m_s2": 9.81, "u_g_m_s2": 2e-4}, daq={"u_clock_ppm": 0.0})

    def expected(setup: Setup) -> tuple[float, float]:
        mean, deviation = flights_prior(setup, 0.0)
        return float(mean[4]), float(deviation[4])

    steel, plastic = (expected(changed(told, tracer={"density_kg_m3": density})) for density in (7850.0, 1100.0))
    unknown = expected(changed(told, tracer={"density_kg_m3": None}))
    assert steel[1] == pytest.approx(2e-4, rel=1e-3)
    for known, _ in (steel, plastic):
        assert known == pytest.approx(unknown[0], abs=4.0 * unknown[1])
    # times that are longer by 50 ppm make g smaller by 100 ppm
    by_clock = expected(changed(told, daq={"u_clock_ppm": 50.0}, tracer={"density_kg_m3": 7850.0}))
    assert by_clock[1] == pytest.approx(np.hypot(2e-4, 1e-4 * 9.81), rel=1e-3)


@pytest.mark.slow
def test_the_joint_estimate_begins_from_the_flights_which_stand_meanwhile() -> None:
    record, setup = _scene(floor=0.8, exact=True)
    joint = setup.model_copy(update={"processing": setup.processing.model_copy(update={"correction": "joint"})})
    standing: list[RunResult] = []
    result = process(record.recording, joint, on_preliminary=standing.append)
    (meanwhile,) = standing
    assert meanwhile.preliminary
    _assert_right(record, meanwhile, followed=3)
    assert result.corrected is not None
    assert result.corrected.method == "joint"
    assert len([one for one in result.bounces.impacts if one.valid]) >= 5
    assert result.status == "ok"
    first = result.bounces.impacts[0]
    assert first.e == pytest.approx(record.impacts[0][3], rel=1e-3)
    assert first.e == pytest.approx(record.impacts[0][3], abs=4.0 * first.u_stated)


@pytest.mark.slow
def test_a_diameter_told_twice_as_large_is_named_and_a_right_one_is_not() -> None:
    scene = draw("mistaken", 55501, 2, {"which": "sphere/double", "rate_hz": 10_000.0})
    doubled, _ = setup_of_version(scene.setup)
    right = changed(doubled, tracer={"diameter_m": scene.facts["diameter_m"]})
    conditioned = conditioned_of(scene.record().recording, doubled)
    for stated in (right, doubled):
        drop = measure_by_flights(conditioned, stated, lambda _: None, None)
        # nobody asks where nothing is blamed
        assert drop.other_diameter(stated, replace(drop.motion, findings=())) is None
        blamed = drop.motion.said(warn("flights_misfit", misfit=3.0))
        other = drop.other_diameter(stated, blamed)
        cause = None if other is None else drop.wrong_diameter(other, stated, blamed)
        assert (cause is None) == (stated is right)
    assert cause is not None
    assert "likely tracer.diameter_m is wrong, adding diameter_m -10 mm would agree" in cause.text


@pytest.mark.slow
def test_a_dip_is_seen_in_what_the_flights_leave() -> None:
    record, setup = _scene(floor=0.3, height_m=0.1, rate_hz=5000.0)
    recording, begin_s = record.recording, record.start_s + 0.05
    rate_hz = recording.digitisation.sample_rate_hz
    raw, dip = recording.raw.copy(), slice(round(begin_s * rate_hz), round((begin_s + 0.01) * rate_hz))
    raw[2:4, dip] //= 3
    result = process(replace(recording, raw=raw), setup)
    _assert_right(record, result)
    told, *rest = result.findings
    assert (told.code, told.receiver) == ("dip_left_out", 2)
    assert {one.code for one in rest} <= {"some_samples_clipped", "few_samples_valid"}
    first, last = map(float, re.findall(r"\d\.\d{3}", told.text))
    assert first == pytest.approx(begin_s, abs=0.015)
    assert last == pytest.approx(begin_s + 0.01, abs=0.015)


@pytest.mark.slow
def test_a_rebound_that_is_none_ends_what_is_followed() -> None:
    # nothing falls here: what looked like a rebound goes down once it is fitted
    scene = draw("motions", 2344935333, 1, {})
    record, (setup, _) = scene.record(), setup_of_version(scene.setup)
    assert process(record.recording, setup).status == "ok"


def test_a_receiver_that_turns_backwards_is_named() -> None:
    record, setup = _scene(floor=0.1, exact=True)
    raw = record.recording.raw.copy()
    raw[3] = -raw[3]
    result = process(replace(record.recording, raw=raw), setup)
    assert any("receiver 2 turn backwards" in one.text for one in result.findings)
    assert result.corrected is None or result.corrected.method != "flights"


def test_a_fall_that_ends_dead_is_one_flight() -> None:
    record, setup = _scene(floor=0.3, e=0.0, exact=True)
    result = process(record.recording, setup)
    _assert_right(record, result)
    # nothing bounces, and no e is made up; why is said
    assert result.bounces.impacts == ()
    (told,) = result.findings
    assert told.code == "landed_dead"
    assert told.facts["at_s"] == pytest.approx(record.impacts[0][0], abs=1e-3)
    assert told.facts["most_e"] < 0.06
    fall = result.bounces.free_fall
    assert fall is not None
    assert fall.g_m_s2 == pytest.approx(record.gravity_m_s2, abs=5.0 * fall.u_g_m_s2)


@pytest.mark.slow
@pytest.mark.parametrize(("seed", "floor"), [(0, 0.1), (8, 0.3), (10, 0.55)])
def test_a_fall_that_ends_dead_is_not_bent_by_what_comes_after(seed: int, floor: float) -> None:
    scene = draw("modelled", 77, seed, {**USUAL, "e": 0.0, "floor": floor, "exact": seed == 0})
    setup, _ = setup_of_version(scene.setup)
    setup = setup.model_copy(update={"processing": setup.processing.model_copy(update={"correction": "flights"})})
    record = scene.record()
    track = process(record.recording, setup).track
    assert track is not None
    assert record.position_m is not None
    falling = track.valid & (track.time_s > record.start_s)
    assert track.time_s[falling][-1] < record.impacts[0][0]
    error = (track.position_m - record.position_m)[:, falling]
    # antennas off by their u move all of it, and by that much
    assert np.sqrt(((error - error.mean(axis=1, keepdims=True)) ** 2).mean()) < 5e-5


@pytest.mark.slow
def test_the_joint_estimate_makes_up_no_e_of_a_fall_that_ends_dead() -> None:
    scene = draw("modelled", 77, 10, {**USUAL, "e": 0.0, "floor": 0.55})
    setup, _ = setup_of_version(scene.setup)
    result = process(scene.record().recording, changed(setup, processing={"correction": "joint"}))
    assert "landed_dead" in {one.code for one in result.findings}
    assert result.bounces.impacts == ()
    assert result.uncertainty_budget is not None
    assert result.uncertainty_budget.e.combined is None


def test_what_rests_to_its_end_is_told_so() -> None:
    record, setup = _scene(floor=0.3, exact=True)
    # the sphere hangs somewhere else than the setup says, and what moves begins before the record does
    late = record.recording.n_samples - int((record.start_s + 0.1) * record.recording.digitisation.sample_rate_hz)
    result = process(replace(record.recording, raw=record.recording.raw[:, -late:]), setup)
    assert any(one.code == "no_flights" for one in result.findings)
    assert result.corrected is None or result.corrected.method == "adaptive"


def _model_of(usual: tuple[PopulationRecord, Setup, RunResult], linear: LinearPart) -> tuple[DropModel, Parts]:
    """Return the model of a drop with its first three flights, and where they are about."""
    record, setup, result = usual
    signals = scaled_signals(conditioned_of(record.recording, setup))
    bins, flights = pool(signals, 1e-3), flights_prior(setup, record.start_s)
    known = setup_unknowns(setup), polarised_sphere(setup)
    surface = float(setup.tracer.release_position_m[2]) - 0.21
    model = drop_model(signals, setup, bins, flights, surface, known, linear)
    values = model.mean
    for impact in result.bounces.impacts[:2]:
        model, values = model.with_flight(values, impact.time_s, np.array([0.01, -0.02, impact.speed_after_m_s]))
    return model, values


def test_what_is_foretold_of_a_stretch_is_what_the_whole_shows_there(
    usual: tuple[PopulationRecord, Setup, RunResult],
) -> None:
    model, values = _model_of(usual, LinearPart(True, 2))
    model = model.renewed(values)
    at = evaluate(model, model.unknowns(values))
    # a bounce lower than the fall: the functions of the height are those of the fall all the same
    stretch = np.flatnonzero(model.bins.time_s > values.flights[-1])[:40]
    part = model.of_bins(model.bins.of(stretch), values, foretold=True)
    again = evaluate(part, model.unknowns(values), coefficients=at.coefficients)
    np.testing.assert_allclose(again.value, at.value[..., stretch], atol=1e-12)


def test_a_floor_whose_reflection_changes_aside_is_explained(
    usual: tuple[PopulationRecord, Setup, RunResult],
) -> None:
    model, values = _model_of(usual, LinearPart(False, 2, n_uneven=1, n_aside=ASIDE))
    values.theta[model.layout.transmitter_reflection] = 0.3, 0.0
    unknowns = model.unknowns(values)
    model = model.renewed(values)
    at = evaluate(model, unknowns)
    # each receiver's way by T grows as the sphere flies along x: by 5 % of the echo where it is half a fall aside
    pairs = np.zeros((model.n_receivers, 3, model.linear.n_floor, 2))
    pairs[:, 0, model.linear.n_uneven, 0] = 0.05
    at.coefficients[:, model.linear.uneven] = pairs.reshape(model.n_receivers, -1)
    shown = evaluate(model, unknowns, coefficients=at.coefficients)
    plain = at.coefficients.copy()
    plain[:, model.linear.uneven] = 0.0
    none = evaluate(model, unknowns, coefficients=plain)
    release = model.mean.setup[model.setup.release]
    place = Flights.of(values.flights).position_m(model.bins.time_s)
    there = np.abs(place[0] - release[0]) > 1e-9
    assert np.abs(shown.value - none.value)[..., there].max() > 0.0
    np.testing.assert_array_equal(shown.value[..., ~there], none.value[..., ~there])
    np.testing.assert_allclose(
        model.aside[0] * 0.5 * (model.heights_m[0] - model.heights_m[1]), place[0] - release[0], atol=1e-12
    )


@pytest.mark.parametrize("free_ways", [True, False])
def test_derivatives_are_those_of_differences(
    usual: tuple[PopulationRecord, Setup, RunResult], free_ways: bool
) -> None:
    model, _ = _model_of(
        usual, LinearPart(free_ways, 2, n_uneven=0 if free_ways else 2, n_aside=0 if free_ways else ASIDE)
    )
    bins = model.bins
    unknowns = 0.02 * np.random.default_rng(1).standard_normal(model.n_unknowns)
    model = model.renewed(model.values(unknowns))
    at = evaluate(model, unknowns)
    # what a mixer makes of the echo counts as constant: a thousandth of it, not a third as for these random unknowns
    at.coefficients[:, model.linear.offsets.stop : model.linear.uneven.start] = 0.0
    # some per cent of what comes over the floor, whose functions of the place count as constant too
    at.coefficients[:, model.linear.uneven] = 0.02
    slopes = slopes_of(model, at)
    edges = Flights.of(at.values.flights).begin_s
    away = (np.abs(bins.time_s[:, None] - edges).min(axis=1) > 3e-3) & (bins.time_s < edges[-1] + 0.1)
    step, kappa = 1e-5, model.layout.crosstalk.start
    for number in range(model.n_unknowns):
        sides = []
        for sign in (step, -step):
            moved = unknowns.copy()
            moved[number] += sign
            there = evaluate(model, moved, coefficients=at.coefficients)
            share = there.values.theta[kappa] if model.multiplexer is not None else 0.0
            sides.append(there.value + share * at.excess)
        difference = (sides[0] - sides[1])[..., away] / (2.0 * step)
        # what antennas and place do to lobes and amplitudes counts as constant: distances are known by little else
        off = np.linalg.norm(slopes[..., number][..., away] - difference)
        assert off < 0.05 * np.linalg.norm(difference) + 0.008
