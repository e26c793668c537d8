"""Fitted flights against motions whose g, drag and impacts are known in closed form or by numerical integration."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from support.normal_matrices import even_information

from radargui.estimation.forward.motion_spline import SplineMotion, make_spline
from radargui.estimation.posterior.free_motion import FreeMotion
from radargui.model.gravity import NOMINAL_GRAVITY_M_S2 as G_M_S2
from radargui.restitution.flight_fit import FlightFit, fit_flights
from radargui.restitution.flight_unknowns import FlightPlan, FlightUnknowns, UnknownLayout, impact_rows

RELEASE = np.array([0.01, -0.02, 0.12])
UP = np.array([0.0, 0.0, 1.0])
G, E, IMPACT_S, END_S = 9.79, 0.7, 0.2, 0.42
SIDE_M_S = np.array([0.05, -0.03])
WEIGHT = 1e12


def integrated(drag_1_m: float) -> FreeMotion:
    """Return a fall from rest at t = 0 with one impact at 0.2 s, integrated numerically and put on a spline."""

    def rate(_t: float, s: np.ndarray) -> np.ndarray:
        return np.concatenate([s[3:], [0.0, 0.0, -G] - drag_1_m * np.linalg.norm(s[3:]) * s[3:]])

    spline = make_spline(0.0, END_S, np.array([IMPACT_S]))
    time = np.sort(np.concatenate([np.linspace(0.0, END_S, 3000), spline.edge_s]))
    exact = {"rtol": 1e-11, "atol": 1e-13, "dense_output": True}
    fall = solve_ivp(rate, (0.0, IMPACT_S), [0.0, 0.0, 0.0, *SIDE_M_S, 0.0], **exact)
    rebound = fall.y[:, -1] * np.array([1.0, 1.0, 1.0, 1.0, 1.0, -E])
    rise = solve_ivp(rate, (IMPACT_S, END_S), rebound, **exact)
    place = np.where(time < IMPACT_S, fall.sol(np.minimum(time, IMPACT_S)), rise.sol(np.maximum(time, IMPACT_S)))[:3]
    coefficients = np.linalg.lstsq(spline.design(time).toarray(), place.T, rcond=None)[0]
    return FreeMotion(SplineMotion(spline, coefficients), RELEASE, G_M_S2)


def fitted(drag_1_m: float) -> FlightFit:
    return fit_flights(even_information(integrated(drag_1_m), WEIGHT), FlightPlan(2, 3))


def test_parabolas_give_their_g_and_the_velocities_of_the_closed_form() -> None:
    fit = fitted(0.0)
    assert fit.g_m_s2 == pytest.approx(G, rel=1e-6)
    assert fit.drag_1_m == pytest.approx(0.0, abs=1e-5)
    assert fit.impact_s == pytest.approx([IMPACT_S], abs=1e-8)
    assert fit.before_m_s[0] == pytest.approx([*SIDE_M_S, -G * IMPACT_S], abs=1e-6)
    assert fit.after_m_s[0] == pytest.approx([*SIDE_M_S, E * G * IMPACT_S], abs=1e-6)
    assert fit.apex_s == pytest.approx([0.0, IMPACT_S + E * IMPACT_S], abs=1e-6)
    assert fit.is_good
    assert fit.widened().covariance == pytest.approx(fit.covariance)


def test_drag_is_found_in_a_motion_integrated_numerically() -> None:
    fit = fitted(0.06)
    assert fit.drag_1_m == pytest.approx(0.06, rel=0.02)
    assert fit.g_m_s2 == pytest.approx(G, rel=2e-4)
    assert fit.after_m_s[0] @ UP / -(fit.before_m_s[0] @ UP) == pytest.approx(E, rel=1e-4)


def test_the_flights_follow_a_changed_likelihood_as_a_new_fit_does() -> None:
    information, plan = even_information(integrated(0.0), WEIGHT), FlightPlan(2, 3)
    fit = fit_flights(information, plan)
    size = np.full(information.x0.size, np.sqrt(WEIGHT))
    slope = 1e-3 * size * np.random.default_rng(2).standard_normal(size.size)
    changed = fit_flights(replace(information, slope=information.slope + slope), plan)
    followed = fit.response @ slope
    assert followed == pytest.approx(changed.values - fit.values, rel=0.02, abs=0.01 * np.abs(followed).max())


def test_what_parts_flights_and_motion_is_counted_at_the_same_instant_though_the_impact_moves_the_knots() -> None:
    free = integrated(0.0)
    moved = 1e-4
    spline = free.motion.spline.with_breaks(np.array([IMPACT_S + moved]))
    grid = np.linspace(0.0, END_S, 3000)
    # the same motion to begin with, on knots that are elsewhere
    shifted = np.linalg.lstsq(
        spline.design(grid).toarray(), free.motion.spline.offset(grid, free.motion.coefficients), rcond=None
    )[0]
    off = np.append((shifted - free.motion.coefficients).ravel(), moved)
    fit = replace(fitted(0.0), off=off)
    away = grid[np.abs(grid - IMPACT_S) > 0.02]
    truly = spline.offset(away, shifted) - free.motion.spline.offset(away, free.motion.coefficients)
    found = fit.bend_over_u(away, np.ones((3, away.size)))
    by_coefficients_alone = np.sqrt((free.motion.spline.offset(away, shifted - free.motion.coefficients) ** 2).mean())
    # over a u of three units, and where the knots stay
    still = replace(fit, off=np.append(off[:-1], 0.0))
    assert still.bend_over_u(away, np.full((3, away.size), 3.0)) == pytest.approx(by_coefficients_alone / 3.0, rel=1e-3)
    assert np.sqrt((truly**2).mean()) < 1e-6
    assert by_coefficients_alone > 3e-5
    assert found < 1e-6


def test_derivatives_are_those_of_finite_differences() -> None:
    unknowns = FlightUnknowns(even_information(integrated(0.06), WEIGHT), FlightPlan(2, 3))
    q = unknowns.start()
    slopes = unknowns.slopes(q)
    for column in range(q.size):
        step = np.where(np.arange(q.size) == column, 1e-5, 0.0)
        more, less = unknowns.motion(q + step), unknowns.motion(q - step)
        assert (more.x - less.x) / 2e-5 == pytest.approx(slopes.x[:, column], abs=2e-6)
        assert (more.results - less.results) / 2e-5 == pytest.approx(slopes.results[:, column], abs=2e-6)


@pytest.mark.parametrize(("flights", "breaks"), [(1, 0), (1, 1), (3, 2), (3, 3)])
def test_every_unknown_has_one_place(flights: int, breaks: int) -> None:
    layout = UnknownLayout(flights, breaks, 4)
    places = [layout.gravity, layout.drag, layout.apex_height]
    spans = [layout.start_place, layout.breaks, layout.free]
    for number in range(flights):
        places.append(layout.apex_time(number))
        spans.append(layout.velocity(number))
    for span in spans:
        places += range(span.start, span.stop)
    assert sorted(places) == list(range(layout.size))
    assert layout.of_flight(0)[-2:].tolist() == [-1, layout.breaks.start if breaks else -1]
    assert layout.of_flight(flights - 1)[2] == layout.apex_time(flights - 1)


def test_every_result_has_one_place() -> None:
    results = np.arange(2.0 + 3 * 7)
    rows = impact_rows(results)
    places = [*results[:2], *rows[:, 0], *rows[:, 1:4].ravel(), *rows[:, 4:].ravel()]
    assert sorted(places) == results.tolist()
    assert np.shares_memory(rows, results)
