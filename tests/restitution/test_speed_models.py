"""e against the impact speed: known laws come back, intervals hold, and what the data cannot say is refused."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from radargui.restitution.speed_models import (
    MODELS,
    ImpactPoint,
    ModelName,
    SpeedFit,
    fit_speed_model,
    fit_speed_models,
    preferred,
)

TRUE = {"constant": (0.8,), "power": (0.7, 0.1), "johnson": (0.65,), "viscoelastic": (0.3,)}


def points_of(
    e_at: Callable[[float], float],
    rng: np.random.Generator,
    *,
    runs: int = 8,
    scatter: float = 0.0,
    between: float = 0.0,
    u: float = 1e-3,
    bounces: int = 4,
) -> list[ImpactPoint]:
    """Drops from heights that differ a little, each bounce with its own scatter, each run with an offset of its own."""
    points = []
    for run in range(runs):
        v, offset = float(rng.uniform(1.8, 2.4)), between * rng.standard_normal()
        for _ in range(bounces):
            e = e_at(v) + offset + scatter * rng.standard_normal()
            points.append(ImpactPoint(f"{run}", v, e + u * rng.standard_normal(), u, math.hypot(u, 2e-3)))
            v *= e
    return points


def model_e(name: ModelName) -> Callable[[float], float]:
    return lambda v: float(MODELS[name].e(np.array([v]), *TRUE[name])[0])


@pytest.mark.parametrize("name", TRUE)
def test_each_model_finds_the_parameters_of_its_own_impacts(name: ModelName) -> None:
    points = [replace(one, u_e=1e-5) for one in points_of(model_e(name), np.random.default_rng(1), u=1e-9)]
    fit = fit_speed_model(points, name)
    assert [one.value for one in fit.parameters] == pytest.approx(TRUE[name], rel=1e-6)
    assert fit.scatter == 0.0
    e, u = fit.e(np.array([1.0, 2.0]))
    assert e == pytest.approx([model_e(name)(1.0), model_e(name)(2.0)], rel=1e-6)
    assert (u < 1e-5).all()


def test_the_viscoelastic_series_has_the_second_coefficient_of_theory() -> None:
    a = 1e-3
    e = float(MODELS["viscoelastic"].e(np.array([1.0]), a)[0])
    assert e == pytest.approx(1.0 - 1.15344 * a + 0.6 * 1.15344**2 * a**2, abs=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("between", [0.0, 0.006])
def test_the_intervals_of_the_power_law_hold_with_what_runs_share(between: float) -> None:
    rng = np.random.default_rng(2)
    n, held, flagged = 120, np.zeros(2), 0
    for _ in range(n):
        fit = fit_speed_model(points_of(model_e("power"), rng, scatter=0.004, between=between), "power")
        held += [
            one.interval_low <= true <= one.interval_high
            for one, true in zip(fit.parameters, TRUE["power"], strict=True)
        ]
        flagged += not fit.describes
    assert (held / n >= 0.90).all()
    assert (held / n <= 0.99).all()
    # a right model is refused in 5 of 100
    assert 0.005 <= flagged / n <= 0.11


def test_one_more_impact_lies_where_the_band_says() -> None:
    rng, held, n = np.random.default_rng(12), 0, 200
    for _ in range(n):
        *points, new = points_of(model_e("power"), rng, scatter=0.004, runs=9, bounces=1)
        speeds = np.array([new.speed_m_s])
        fit = fit_speed_model(points, "constant")
        held += bool(abs(new.e - fit.e(speeds)[0]) <= fit.prediction(speeds))
    # 95 % of 200 within three standard deviations of the count; the speeds of one height hardly change e
    assert 0.90 <= held / n <= 0.99


def test_chi_square_judges_the_stated_uncertainties_and_the_shape_test_allows_for_scatter() -> None:
    rng = np.random.default_rng(3)
    honest = [fit_speed_model(points_of(model_e("power"), rng), "power").p or 0.0 for _ in range(80)]
    assert 0.35 < np.mean(honest) < 0.65
    scattered = points_of(model_e("power"), rng, scatter=0.004)
    power, constant = (fit_speed_model(scattered, name) for name in ("power", "constant"))
    assert power.p is not None
    assert power.p < 1e-4
    assert power.describes
    assert constant.describes is False


def test_the_scatter_of_a_model_far_from_the_impacts_is_what_it_leaves() -> None:
    """The parameters differ: the impacts that are known best would draw the wrong law to themselves."""
    rng = np.random.default_rng(6)
    points = points_of(model_e("constant"), rng, u=1e-4, bounces=12)
    fit = fit_speed_model(points, "johnson")
    left = np.array([one.e for one in points]) - fit.e(np.array([one.speed_m_s for one in points]))[0]
    assert fit.scatter == pytest.approx(float(np.sqrt(np.mean(left**2))), rel=0.01)
    # likelihood and residuals agree: -2 ln L of n impacts whose variance is that of what is left
    assert fit.aicc == pytest.approx(len(points) * (np.log(2.0 * np.pi * fit.scatter**2) + 1.0) + 4.0, abs=1.0)


def test_akaike_prefers_the_model_the_impacts_were_made_with() -> None:
    rng = np.random.default_rng(4)
    for name in ("constant", "johnson"):
        best = [preferred(fit_speed_models(points_of(model_e(name), rng, scatter=0.003)))[0].model for _ in range(10)]
        # the power law holds both
        assert set(best) <= {name, "power"}
        assert best.count(name) >= 6


def test_speeds_that_hardly_differ_give_no_slope() -> None:
    rng = np.random.default_rng(5)
    points = []
    for run in range(10):
        # an error of v goes into e = v' / v with the opposite sign: fitted, it would look like n = 1
        error = 1e-3 * rng.standard_normal()
        points.append(ImpactPoint(f"{run}", 2.26 * (1.0 + error), 0.8 * (1.0 - error), 8e-4))
    power, constant = (fit_speed_model(points, name) for name in ("power", "constant"))
    assert power.parameters == ()
    assert "other heights" in power.problem
    assert constant.parameters[0].value == pytest.approx(0.8, abs=1e-3)


def test_what_all_impacts_share_stays_whole() -> None:
    points = points_of(model_e("constant"), np.random.default_rng(6), u=1e-4, runs=20)
    (e0,) = fit_speed_model(points, "constant").parameters
    assert e0.u < 2e-4
    assert e0.u_combined == pytest.approx(math.hypot(e0.u, 2e-3), rel=1e-3)
    (unknown,) = fit_speed_model([replace(one, u_e_combined=None) for one in points], "constant").parameters
    assert unknown.u_combined is None


def test_two_runs_have_the_uncertainty_of_least_squares_and_no_test_of_the_shape() -> None:
    fit = fit_speed_model(points_of(model_e("power"), np.random.default_rng(7), runs=2), "power")
    assert "too few runs" in fit.u_from
    assert fit.trend_p is None
    assert fit.describes is None
    assert 0.0 < fit.parameters[1].u < 0.01


@pytest.mark.parametrize(
    ("name", "e", "count", "reason"),
    [("viscoelastic", 0.4, 8, "too small for the series"), ("power", 0.8, 1, "4 valid impacts are needed")],
)
def test_what_cannot_be_fitted_says_why(name: ModelName, e: float, count: int, reason: str) -> None:
    points = points_of(lambda _: e, np.random.default_rng(8), runs=count, bounces=2)
    fit = fit_speed_model(points, name)
    assert fit.parameters == ()
    assert reason in fit.problem
    assert reason in fit.words


impacts = st.builds(
    ImpactPoint,
    st.sampled_from(["a", "b", "c", "d"]),
    st.floats(0.01, 10.0),
    st.floats(0.0, 1.0),
    st.floats(1e-5, 0.2),
    st.none() | st.floats(0.2, 0.4),
)


@settings(max_examples=20, deadline=None)
@given(st.lists(impacts, max_size=14))
def test_any_impacts_give_finite_numbers_or_a_reason(points: list[ImpactPoint]) -> None:
    for fit in fit_speed_models(points):
        assert bool(fit.problem) != bool(fit.parameters)
        assert fit.words
        for one in fit.parameters:
            assert math.isfinite(one.value)
            assert one.interval_low <= one.value <= one.interval_high
            assert one.u >= 0.0
        if fit.parameters:
            assert 0.0 <= (fit.p or 0.0) <= 1.0
            assert fit.trend_p is None or 0.0 <= fit.trend_p <= 1.0


def test_no_impact_is_no_fit() -> None:
    fits: tuple[SpeedFit, ...] = fit_speed_models([])
    assert all(fit.problem and fit.aicc is None for fit in fits)
    assert preferred(fits) == ()
