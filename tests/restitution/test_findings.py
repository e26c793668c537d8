"""What sessions found: who counts and why not, the mean's budget, the site's g, sentences that can be quoted."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import pytest
from support.changed import changed

from radargui.model.drop import Drop, RunOrigin
from radargui.model.result import Bounce
from radargui.model.setup import read_setup
from radargui.model.uncertainty_budget import BudgetLine, UncertaintyBudget
from radargui.restitution.findings import SeriesRun, SeriesSession, findings_of
from radargui.system.resources import default_setup_path

SETUP = changed(read_setup(default_setup_path()), site={"g_m_s2": 9.81})
BUDGET = UncertaintyBudget(
    e=BudgetLine(1e-3, 3e-3, 4e-3, math.hypot(1e-3, 3e-3, 4e-3)),
    g_m_s2=BudgetLine(1e-3, 6e-3, 8e-3, math.hypot(1e-3, 6e-3, 8e-3)),
)


def run(number: int, e: float, *, speed: float = 2.26, **drop: Any) -> SeriesRun:
    g = 9.807 + 1e-4 * number
    figures = {"u_e_combined": BUDGET.e.combined, "u_g_m_s2": 1e-3, "u_g_combined_m_s2": BUDGET.g_m_s2.combined}
    impacts = (
        Bounce(0.5, speed, speed * e, e, 1e-3, "hand", valid=True),
        Bounce(0.8, 0.5 * speed, 0.5 * speed * e, e, 1e-3, "hand", valid=True),
    )
    one = Drop(
        f"run-{number:04d}",
        RunOrigin(samples=f"{number} {e} {speed}"),
        e,
        1e-3,
        g_m_s2=g,
        drop_height_m=0.26,
        **figures,
    )
    return SeriesRun(replace(one, impact_speed_m_s=speed, **drop), impacts=impacts, budget=BUDGET)


def session(name: str, *runs: SeriesRun, **about: Any) -> SeriesSession:
    return SeriesSession(name, SETUP, runs, **about)


FIVE = tuple(run(number, e) for number, e in enumerate((0.799, 0.800, 0.801, 0.8005, 0.7995), 1))


def test_the_mean_has_its_own_budget_in_which_what_all_share_does_not_average_out() -> None:
    (found,) = findings_of([session("a", *FIVE)]).sessions
    error = 7.905694e-4 / math.sqrt(5)
    assert found.e_budget.statistical == pytest.approx(error, rel=1e-5)
    assert (found.e_budget.calibration, found.e_budget.sphere) == (3e-3, 4e-3)
    assert found.e_budget.combined == pytest.approx(math.hypot(error, 5e-3), rel=1e-5)
    single = findings_of([session("a", FIVE[0])]).sessions[0]
    assert single.e_budget == BUDGET.e
    without = findings_of([session("a", replace(FIVE[0], budget=None), *FIVE[1:])]).sessions[0]
    assert without.e_budget.calibration is None


def test_the_mean_g_is_held_against_the_sites() -> None:
    (found,) = findings_of([session("a", *FIVE)]).sessions
    assert found.site is not None
    assert found.site.agrees
    assert "within 0." in found.site.verdict
    far = [replace(one, drop=replace(one.drop, g_m_s2=9.7)) for one in FIVE]
    (suspect,) = findings_of([session("a", *far)]).sessions
    assert suspect.site is not None
    assert "the calibration is suspect" in suspect.site.verdict


def test_every_run_that_is_not_in_the_mean_says_why() -> None:
    other = [
        replace(run(6, 0.9), status="rejected", reason="receiver 2 is dead", drop=Drop("run-0006")),
        replace(run(7, 0.9), status="no_motion", drop=Drop("run-0007")),
        run(8, 0.9, from_rest=False),
        run(9, 0.9, origin=RunOrigin("replay", file="a.h5", first_sample=3)),
        run(10, 0.9, origin=FIVE[1].drop.origin),
        replace(run(11, 0.9), drop=Drop("run-0011", preliminary=True)),
        replace(run(12, 0.9), status="failed", reason="damaged", drop=Drop("run-0012")),
    ]
    (found,) = findings_of([session("a", *FIVE, *other, set_aside={"run-0013": "bumped the table"})]).sessions
    assert found.series.e.n == 5
    assert {one.run: (one.kind, one.reason) for one in found.excluded} == {
        "run-0013": ("set aside", "bumped the table"),
        "run-0006": ("rejected", "receiver 2 is dead"),
        "run-0007": ("no motion", ""),
        "run-0008": ("release not seen", "the rest before the fall was not recorded"),
        "run-0009": ("replay", "a replay is no drop of its own"),
        "run-0010": ("twice", "the same drop as run-0002"),
        "run-0011": ("preliminary", "the final result is still to be computed"),
        "run-0012": ("failed", "damaged"),
    }
    assert found.preliminary == ("run-0011",)


def test_a_drop_copied_into_a_second_session_counts_once_and_simulations_not_beside_measurements() -> None:
    simulated = run(3, 0.7, origin=RunOrigin("simulated"))
    first, second = findings_of([session("a", *FIVE), session("b", FIVE[0], run(2, 0.81), simulated)]).sessions
    assert (first.series.e.n, second.series.e.n) == (5, 1)
    assert {one.run: one.kind for one in second.excluded} == {"run-0001": "twice", "run-0003": "simulated"}
    assert second.series.left_out["run-0001"] == "the same drop as a/run-0001"


def test_an_outlier_is_named_and_kept() -> None:
    (found,) = findings_of([session("a", *FIVE, run(6, 0.9))]).sessions
    assert found.series.outliers == ("run-0006",)
    assert found.series.e.n == 6


def test_the_sentence_can_be_quoted() -> None:
    found = findings_of([session("a", *FIVE, sample="steel\nsphere", target="glass")])
    assert found.sentence == (
        "Coefficient of restitution of steel sphere on glass: e = 0.8000(50) at 2.260 m/s, mean of 5 drops from "
        "260.0 mm (in parentheses the combined standard uncertainty; standard deviation 0.00079, "
        "standard error 0.00035)."
    )
    simulated = [replace(one, drop=replace(one.drop, origin=RunOrigin("simulated"))) for one in FIVE[:1]]
    assert "one simulated drop" in findings_of([session("a", *simulated)]).sentence
    assert findings_of([session("a")]).sentence == "No drop gave a valid coefficient of restitution."


def test_of_two_sessions_of_one_sample_the_one_that_gave_no_e_is_named() -> None:
    pair = [
        session("Monday", *FIVE, sample="steel", target="glass"),
        session("Tuesday", sample="steel", target="glass"),
    ]
    found = findings_of(pair)
    assert found.sentence.startswith("Coefficient of restitution of steel on glass: e = 0.8000(50)")
    assert found.sentence.endswith("Tuesday: No drop of steel on glass gave a valid coefficient of restitution.")


def test_samples_and_sessions_are_compared_and_sessions_of_one_sample_repeat_each_other() -> None:
    def day(name: str, sample: str, e: float) -> SeriesSession:
        return session(name, *(run(k, e + d) for k, d in enumerate((-1e-3, 0.0, 1.1e-3), 1)), sample=sample)

    found = findings_of([day("a", "steel", 0.80), day("b", "steel", 0.801), day("c", "brass", 0.6)], "constant")
    steel, brass = found.samples
    assert (steel.sessions, brass.sessions) == (("a", "b"), ("c",))
    assert steel.repeatability is not None
    assert steel.repeatability.repeatability_sd == pytest.approx(1.05e-3, rel=0.01)
    assert brass.repeatability is None
    assert steel.fit("constant").parameters[0].value == pytest.approx(0.8005, abs=1e-3)
    assert found.samples_compared is not None
    assert found.samples_compared.groups == ("steel", "brass")
    assert found.samples_compared.difference == pytest.approx(0.2005, abs=1e-4)
    assert found.sessions_compared is not None
    assert found.sessions_compared.test == "Welch's analysis of variance"
    assert found.cautions == ()
    assert "mean of 2 sessions e = 0.80053(50)" in found.sentence
    assert "constant: e0" in found.sentence


def test_sessions_of_different_heights_are_brought_to_one_speed_before_they_are_compared() -> None:
    def drop(number: int, speed: float) -> SeriesRun:
        e = 0.8 * speed**-0.1 + 1e-4 * (-1) ** number
        impacts = tuple(
            Bounce(0.5, v, 0.0, 0.8 * v**-0.1 + 1e-4 * (-1) ** number, 1e-4, "hand", valid=True)
            for v in (speed, 0.4 * speed)
        )
        return replace(run(number, e, speed=speed), impacts=impacts)

    high, low = (session(name, *(drop(k, v) for k in range(1, 5))) for name, v in (("high", 2.3), ("low", 1.2)))
    found = findings_of([high, low])
    (sample,) = found.samples
    assert sample.repeatability is not None
    assert sample.repeatability.mean == pytest.approx(0.8 * 1.75**-0.1, abs=2e-4)
    assert sample.repeatability.between_sd < 1e-4
    assert sample.reduced == "at 1.75 m/s (brought there by the power law)"
    assert any("impact speeds of the sessions differ" in one for one in found.cautions)


def test_other_antennas_are_a_caution() -> None:
    moved = changed(SETUP, transmitter={"distance_m": 0.71})
    found = findings_of([session("a", *FIVE), replace(session("b", run(1, 0.81), run(2, 0.82)), setup=moved)])
    assert any("same antennas" in one for one in found.cautions)
