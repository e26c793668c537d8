"""How e is distributed and what it depends on: known shapes and slopes come back, intervals hold."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from radargui.restitution.dependence import dependences
from radargui.restitution.distribution import LEVELS, distribution_of
from radargui.restitution.speed_models import ImpactPoint, fit_speed_model
from radargui.restitution.statistics import statistics_of


def test_quantiles_skewness_and_density_are_those_of_the_values() -> None:
    rng = np.random.default_rng(1)
    # gamma of shape 4: skewness 2 / sqrt(4)
    drops = 0.7 + 0.01 * rng.gamma(4.0, size=4000)
    found = distribution_of(drops, [2e-3] * drops.size)
    assert found is not None
    assert found.quantiles == pytest.approx(np.quantile(drops, LEVELS), abs=1e-4)
    assert found.skewness == pytest.approx(1.0, abs=0.15)
    assert sum(found.counts) == found.n == 4000
    assert np.trapezoid(found.density, found.at) == pytest.approx(1.0, abs=2e-3)
    mode = found.at[int(np.argmax(found.density))]
    assert mode == pytest.approx(0.7 + 0.01 * 3.0, abs=4e-3)
    assert found.measured == pytest.approx(2e-3)
    assert "(skewed)" in found.words
    assert "u of each 0.0020" in found.words


def test_a_normal_series_is_skewed_by_chance_alone_and_the_next_drop_lies_where_it_is_told() -> None:
    rng, n, held, within = np.random.default_rng(2), 400, 0, 0
    for _ in range(n):
        drops = 0.8 + 0.004 * rng.standard_normal(9)
        found = distribution_of(drops[:-1])
        assert found is not None
        held += found.prediction_low <= drops[-1] <= found.prediction_high
        within += abs(found.skewness) <= 2.0 * found.u_skewness
    # 95 % of 400 within three standard deviations of the count
    assert 0.917 <= held / n <= 0.983
    assert within / n >= 0.9


def test_few_or_equal_values_have_no_shape() -> None:
    assert distribution_of([0.8, 0.81, 0.79]) is None
    assert distribution_of([0.8] * 12) is None
    assert distribution_of([0.8, None, math.nan, 0.81, 0.79]) is None


@settings(max_examples=80, deadline=None)
@given(st.lists(st.floats(0.0, 1.5) | st.none(), max_size=30))
def test_any_values_give_finite_numbers_in_order_or_nothing(values: list[float | None]) -> None:
    found = distribution_of(values)
    if found is not None:
        assert sum(found.counts) == found.n == statistics_of(values).n
        assert list(found.quantiles) == sorted(found.quantiles)
        assert found.prediction_low < found.prediction_high
        assert np.isfinite([*found.edges, *found.at, *found.density, found.skewness, found.u_skewness]).all()
        assert found.words


def drops(
    rng: np.random.Generator, *, by_angle: float = 0.0, by_drop: float = 0.0, runs: int = 12, diameters: int = 1
) -> list[ImpactPoint]:
    """Impacts of a power law that lean by angles of their own; each run has an offset, and later ones wear."""
    points = []
    for run in range(runs):
        v, offset = float(rng.uniform(1.8, 2.4)), 0.002 * rng.standard_normal()
        for _ in range(3):
            angle = float(rng.uniform(0.0, 30.0))
            e = 0.8 * v**-0.1 * (1.0 + by_angle * angle) + by_drop * run + offset + 1e-3 * rng.standard_normal()
            points.append(ImpactPoint(f"{run}", v, e, 1e-3, None, angle, 0.008 + 0.002 * (run % diameters), run + 1.0))
            v *= e
    return points


def test_a_slope_along_the_angle_comes_back_though_later_impacts_are_slower() -> None:
    rng, true = np.random.default_rng(3), 4e-4
    held = 0
    for _ in range(60):
        points = drops(rng, by_angle=true)
        found = next(one for one in dependences(points, fit_speed_model(points, "power")) if one.on == "angle_deg")
        assert "power law" in found.reduced
        assert found.interval_low is not None
        assert found.interval_high is not None
        # de over the angle at the mean speed, of e there without an angle
        speed = float(np.mean([one.speed_m_s for one in points]))
        held += found.interval_low <= true * 0.8 * speed**-0.1 <= found.interval_high
    assert held >= 52


def test_chance_is_called_a_dependence_in_five_of_a_hundred() -> None:
    rng, told = np.random.default_rng(4), []
    for _ in range(100):
        points = drops(rng)
        told.append([(one.p or 1.0) < 0.05 for one in dependences(points, fit_speed_model(points, "power"))])
    by_angle, _, by_drop, _ = np.mean(told, axis=0)
    assert by_angle <= 0.12
    assert by_drop <= 0.12


def test_wear_is_seen_along_the_number_of_the_drop() -> None:
    points = drops(np.random.default_rng(5), by_drop=-2e-3)
    worn = next(one for one in dependences(points, fit_speed_model(points, "power")) if one.on == "drop")
    assert (worn.p or 1.0) < 1e-3
    assert "depends on it" in worn.words
    assert worn.line(np.array([1.0, 12.0]))[1] < worn.line(np.array([1.0, 12.0]))[0]


def test_e_t_along_the_angle_stands_by_itself_as_measured() -> None:
    rng, true, n, held = np.random.default_rng(8), 2e-3, 200, 0
    for _ in range(n):
        points = [
            replace(one, e_t=5.0 / 7.0 + true * one.angle_deg + 0.01 * rng.standard_normal(), u_e_t=0.01)
            for one in drops(rng)
        ]
        (found,) = (one for one in dependences(points, None) if one.on == "e_t")
        assert found.interval_low is not None
        assert found.interval_high is not None
        held += found.interval_low <= true <= found.interval_high
    # 95 % of 200 within three standard deviations of the count
    assert 0.90 <= held / n <= 0.99
    (found,) = (one for one in dependences(points, fit_speed_model(points, "power")) if one.on == "e_t")
    assert not found.reduced
    assert found.words.startswith("e_t against the angle of incidence: slope 0.00")
    # of impacts straight down e_t has no value, and they tell nothing
    level = [replace(one, e_t=math.nan) for one in points]
    assert next(one for one in dependences(level, None) if one.on == "e_t").problem.startswith("no impact tells its")


def test_what_no_impact_tells_is_said() -> None:
    points = drops(np.random.default_rng(6))
    unknown = [ImpactPoint(one.run, one.speed_m_s, one.e, one.u_e) for one in points]
    said = {one.on: one.problem for one in dependences(unknown, None)}
    assert said["angle_deg"] == "no impact tells its angle of incidence"
    assert {one.on: one.problem for one in dependences(points, None)}["diameter_m"] == "all impacts have one diameter"
    # two spheres are two values, however many drops
    two, three = (
        next(one for one in dependences(drops(np.random.default_rng(7), diameters=n), None) if one.on == "diameter_m")
        for n in (2, 3)
    )
    assert two.problem == "3 diameters are needed"
    assert three.n_groups == 3
    assert three.slope is not None


@settings(max_examples=60, deadline=None)
@given(
    st.lists(
        st.builds(
            ImpactPoint,
            st.sampled_from(["a", "b", "c", "d"]),
            st.floats(0.01, 10.0),
            st.floats(0.0, 1.2),
            st.floats(1e-5, 0.2),
            st.none(),
            st.just(math.nan) | st.floats(0.0, 89.0),
            st.sampled_from([0.004, 0.006, 0.01]),
            st.integers(1, 9).map(float),
        ),
        max_size=14,
    )
)
def test_any_impacts_give_a_slope_or_a_reason(points: list[ImpactPoint]) -> None:
    for one in dependences(points, None):
        assert (one.slope is None) == bool(one.problem)
        assert one.words
        if one.slope is not None:
            assert np.isfinite([one.slope, one.u_slope, one.at, one.e_at]).all()
            assert one.p is None or 0.0 <= one.p <= 1.0
