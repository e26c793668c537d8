"""What people read of a drop: the combined uncertainty where it is known, the statistical one where it is asked for."""

from __future__ import annotations

import math

from radargui.model.drop import RunOrigin, drop_of, gravity_words, restitution_words
from radargui.model.result import Bounce
from radargui.model.uncertainty_budget import BudgetLine, variance_shares

SUMMARY: dict[str, object] = {
    "e": 0.79999,
    "u_e": 0.0000046,
    "u_e_combined": 0.00021,
    "g_m_s2": 9.8101,
    "u_g_m_s2": 0.0004,
    "u_g_combined_m_s2": 0.031,
}


def test_the_combined_uncertainty_stands_behind_the_value() -> None:
    assert restitution_words(SUMMARY) == "0.79999 ± 0.00021"
    assert gravity_words(SUMMARY, "m/s²") == "(9.810 ± 0.031) m/s²"
    assert drop_of("run-0001", RunOrigin(), SUMMARY).u_e_combined == 0.00021


def test_the_statistical_part_is_told_where_it_is_asked_for() -> None:
    assert restitution_words(SUMMARY, statistical=True) == "0.7999900 ± 0.0000046"
    assert gravity_words(SUMMARY, statistical=True) == "9.81010 ± 0.00040"


def test_a_summary_of_before_has_its_statistical_uncertainty() -> None:
    assert restitution_words({"e": 0.8, "u_e": 0.002}) == "0.8000 ± 0.0020"
    assert restitution_words({"e": 0.8, "u_e": 0.002, "u_e_combined": None}) == "0.8000 ± 0.0020"
    assert restitution_words(None) == "–"


def test_a_bounce_without_a_budget_states_its_own_uncertainty() -> None:
    bounce = Bounce(0.3, 2.0, 1.6, 0.8, 0.002, "flights", valid=True)
    assert bounce.u_stated == 0.002
    assert math.isnan(bounce.u_e_combined)


def test_shares_of_a_budget_are_of_the_squares() -> None:
    assert variance_shares(BudgetLine(3.0, 4.0, None, 5.0)) == {"statistical": 0.36, "calibration": 0.64, "sphere": 0.0}
    assert variance_shares(BudgetLine()) == {}
