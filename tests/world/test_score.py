"""Scores of results that are wrong by a known amount."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from benchmarks.scoring.laboratory import Score, score
from benchmarks.scoring.table import table
from benchmarks.world.draw import draw
from benchmarks.world.scene import Record, make_record

from radargui.model.finding import as_stored
from radargui.model.result import Bounce, Bounces, FreeFall, RunResult, Track
from radargui.model.uncertainty_budget import BudgetLine, UncertaintyBudget

U_M = 1e-5


@pytest.fixture(scope="module")
def record() -> Record:
    return make_record(draw(11, rate_hz=2000.0, snr_db=35.0, walls=0))


def result_of(record: Record, off_m: float, *, e_off: float = 0.0, g_off: float = 0.0) -> RunResult:
    """The truth, with x wrong by so much and e and g wrong too; u 1e-5 m, 1e-4 of e, 1e-3 m/s^2."""
    time_s, position_m = record.recording.time_s(), record.truth.position_m.copy()
    position_m[0] += off_m
    impacts = tuple(
        Bounce(one.time_s, one.before_m_s, one.after_m_s, one.e + e_off, 1e-4, "speeds", valid=True)
        for one in record.scene.drop.impacts
        if one.after_m_s > 0.0
    )
    g = record.scene.body.acceleration_m_s2 + g_off
    fall = FreeFall(g, 1e-3, 0.2, 0.4, 0.1, 0.2, (0.1, 0.0, -g / 2.0), 1e-6)
    everywhere = np.ones(time_s.size, dtype=np.bool_)
    track = Track(time_s, position_m, np.full_like(position_m, U_M), everywhere, "exact")
    setup = record.scene.setup
    return RunResult(record.recording, setup, "ok", track=track, bounces=Bounces(impacts, fall))


def scored(record: Record, **off: float) -> Score:
    return score(record, result_of(record, **off), 1.0)


def test_the_truth_has_no_error_and_lies_inside(record: Record) -> None:
    one = scored(record, off_m=0.0)
    assert one.rms_3d_mm < 1e-6  # the table is written to the nanometre
    assert (one.inside_2u, one.missed, one.false, one.silent) == (1.0, 0, 0, False)
    assert len(one.e) == sum(impact.after_m_s > 0.0 for impact in record.scene.drop.impacts)
    assert one.first_e.error_percent == pytest.approx(0.0, abs=1e-8)
    assert one.g.error_percent == pytest.approx(0.0, abs=1e-8)


def test_errors_are_told_in_millimetres_in_percent_and_in_u(record: Record) -> None:
    one = scored(record, off_m=4e-5, e_off=3e-4, g_off=-5e-3)
    assert one.rms_3d_mm == pytest.approx(0.04, rel=1e-4)
    assert one.inside_2u == pytest.approx(2.0 / 3.0)
    assert np.median(one.error_over_u.reshape(3, -1)[0]) == pytest.approx(4.0, rel=1e-3)
    assert one.ratio == pytest.approx(4.0 / np.sqrt(3.0), rel=1e-3)
    assert one.first_e.in_u == pytest.approx(3.0, rel=1e-6)
    assert one.g.in_u == pytest.approx(-5.0, rel=1e-6)
    assert one.g.error_percent == pytest.approx(-0.5 / record.scene.body.acceleration_m_s2)


def test_an_uncertainty_too_small_by_far_is_silent_unless_a_warning_says_so(record: Record) -> None:
    wrong = result_of(record, off_m=1e-4)
    assert score(record, wrong, 1.0).silent
    assert not score(record, replace(wrong, findings=(as_stored("Two answers are as likely."),)), 1.0).silent
    assert not scored(record, off_m=2e-5).silent


def test_impacts_not_found_and_found_where_none_was_are_counted(record: Record) -> None:
    right = result_of(record, off_m=0.0)
    first, *others = right.bounces.impacts
    moved = Bounces((replace(first, time_s=first.time_s - 0.02), *others), right.bounces.free_fall)
    one = score(record, replace(right, bounces=moved), 1.0)
    assert (one.missed, one.false, one.first_e) == (1, 1, None)


def test_a_rejected_run_has_no_figures_and_the_table_says_so(record: Record) -> None:
    rejected = RunResult(record.recording, record.scene.setup, "rejected", findings=(as_stored("noise", "refuse"),))
    one = score(record, rejected, 1.0)
    assert (one.rms_3d_mm, one.inside_2u, one.g, one.e) == (None, None, None, ())
    assert "without track 1" in table([one])


def test_combined_uncertainties_are_read_beside_the_statistical_ones(record: Record) -> None:
    wrong = result_of(record, off_m=4e-5, e_off=3e-4, g_off=-5e-3)
    track = replace(wrong.track, u_combined_m=np.full_like(wrong.track.position_m, 4.0 * U_M))
    impacts = tuple(replace(one, u_e_combined=3e-4) for one in wrong.bounces.impacts)
    budget = UncertaintyBudget(g_m_s2=BudgetLine(statistical=1e-3, combined=2e-3))
    told = replace(wrong, track=track, bounces=replace(wrong.bounces, impacts=impacts), uncertainty_budget=budget)
    one = score(record, told, 1.0)
    assert (one.inside_2u, one.inside_2u_combined) == (pytest.approx(2.0 / 3.0), 1.0)
    assert one.ratio_combined == pytest.approx(one.ratio / 4.0, rel=1e-3)
    assert one.first_e.in_combined == pytest.approx(1.0, rel=1e-6)
    assert one.g.in_combined == pytest.approx(-2.5, rel=1e-6)
    assert score(record, wrong, 1.0).g.in_combined is None
    further = replace(track, position_m=track.position_m + 6e-5)  # 7.6 times the statistical, 1.9 times the combined
    assert not score(record, replace(told, track=further), 1.0).silent


@pytest.fixture(scope="module")
def staged() -> Record:
    return make_record(draw(12, motion="stage", rate_hz=2000.0, snr_db=35.0, walls=0))


def moved_result(record: Record, off_m: float, share: float, u_m: float = U_M) -> RunResult:
    """The truth, with x wrong by so much over a share of the motion, from its end."""
    result = result_of(record, 0.0)
    position_m = result.track.position_m.copy()
    moving = position_m.shape[1] - int(record.scene.drop.start_s * record.scene.converter.rate_hz)
    position_m[0, position_m.shape[1] - int(share * moving) :] += off_m
    track = replace(result.track, position_m=position_m, u_position_m=np.full_like(position_m, u_m))
    return replace(result, track=track, bounces=Bounces())


def test_a_motion_is_wrong_where_a_part_that_matters_is_off_by_a_millimetre_and_three_u(staged: Record) -> None:
    wrong = score(staged, moved_result(staged, 2e-3, 0.05, 5e-4), 1.0)
    assert (wrong.wrong, wrong.silent) == (True, True)
    assert wrong.ratio < 2.5
    assert wrong.far_share == pytest.approx(0.05, abs=2e-3)
    assert wrong.largest_over_u == pytest.approx(4.0, rel=1e-3)
    short = score(staged, moved_result(staged, 2e-3, 0.01, 5e-4), 1.0)
    admitted = score(staged, moved_result(staged, 2e-3, 0.05, 8e-4), 1.0)
    small = score(staged, moved_result(staged, 9e-4, 0.05, 2e-4), 1.0)
    for one in (short, admitted, small):
        assert (one.wrong, one.silent) == (False, False)


def test_a_wrong_motion_is_not_silent_where_a_warning_stands_but_stays_wrong(staged: Record) -> None:
    result = replace(moved_result(staged, 2e-3, 0.05, 5e-4), findings=(as_stored("Cover what reflects."),))
    one = score(staged, result, 1.0)
    assert (one.wrong, one.silent) == (True, False)
    assert f"wrong {one.scene}" in table([one])


def test_u_that_is_not_told_excuses_no_error(staged: Record) -> None:
    one = score(staged, moved_result(staged, 2e-3, 0.05, float("nan")), 1.0)
    assert one.wrong


def test_g_of_a_motion_that_falls_nowhere_and_impacts_of_one_without_are_false(staged: Record) -> None:
    right = score(staged, moved_result(staged, 0.0, 0.0), 1.0)
    assert (right.false_fall, right.false, right.missed, right.known_share) == (False, 0, 0, 1.0)
    fall = FreeFall(0.4, 1e-3, 0.2, 0.4, 0.1, 0.2, (0.1, 0.0, -0.2), 1e-6)
    hit = Bounce(staged.scene.drop.start_s + 0.2, 1.0, 0.5, 0.5, 1e-3, "speeds", valid=True)
    one = score(staged, replace(moved_result(staged, 0.0, 0.0), bounces=Bounces((hit,), fall)), 1.0)
    assert (one.false_fall, one.g, one.false) == (True, None, 1)
    assert f"g of no fall {one.scene}" in table([one])


def test_a_coefficient_is_wrong_that_is_far_off_or_of_no_impact() -> None:
    record = make_record(draw(13, motion="edge", rate_hz=2000.0, snr_db=35.0, walls=0))
    right = result_of(record, 0.0)
    assert (score(record, right, 1.0).wrong_e, score(record, right, 1.0).baseless_e) == (False, 0)
    far = score(record, result_of(record, 0.0, e_off=1e-3), 1.0)
    assert far.worst_e_in_u == pytest.approx(10.0, rel=1e-3)
    assert (far.wrong_e, far.silent, far.wrong) == (True, True, False)
    assert not score(
        record, replace(result_of(record, 0.0, e_off=1e-3), findings=(as_stored("It leans."),)), 1.0
    ).silent
    hit = Bounce(record.scene.drop.start_s + 0.05, 1.0, 0.5, 0.5, 1e-3, "speeds", valid=True)
    beside = score(record, replace(right, bounces=Bounces((hit, *right.bounces.impacts))), 1.0)
    assert (beside.baseless_e, beside.wrong_e) == (1, True)
    doubted = Bounces((replace(hit, valid=False), *right.bounces.impacts))
    assert score(record, replace(right, bounces=doubted), 1.0).baseless_e == 0
