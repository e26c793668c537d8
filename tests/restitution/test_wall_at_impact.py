"""Impacts at which a wall was met, too, on motions made for them."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from support.normal_matrices import even_information

from radargui.estimation.forward.motion_spline import SplineMotion, make_spline
from radargui.estimation.posterior.free_motion import FreeMotion
from radargui.estimation.solve.break_velocities import BreakVelocities
from radargui.model.gravity import NOMINAL_GRAVITY_M_S2 as G_M_S2
from radargui.restitution.flight_fit import FlightFit, fit_flights
from radargui.restitution.flight_unknowns import FlightPlan
from radargui.restitution.wall_at_impact import walls_at_impacts

UP = np.array([0.0, 0.0, 1.0])
G, E, IMPACT_S, END_S = 9.81, 0.7, 0.2, 0.4


def bounced(late_s: float, back_m_s: float = -0.08, moved_m: tuple[float, float] = (0.0, 0.0)) -> FreeMotion:
    """Return a fall from rest with a bounce at 0.2 s, thrown back along x by a wall that is met so much later.

    All after the bounce may be moved along x and y besides, as a mirror that is not in the model moves it.
    """
    spline = make_spline(0.0, END_S, np.array([IMPACT_S]))
    time = np.sort(np.concatenate([np.linspace(0.0, END_S, 4001), spline.edge_s]))
    after = np.maximum(time - IMPACT_S, 0.0)
    height = -G / 2.0 * np.minimum(time, IMPACT_S) ** 2 + E * G * IMPACT_S * after - G / 2.0 * after**2
    met_s = IMPACT_S + late_s
    aside = 0.1 * np.minimum(time, met_s) + back_m_s * np.maximum(time - met_s, 0.0)
    moved = np.outer(moved_m, time > IMPACT_S - 0.001)
    place = np.stack([aside + moved[0], moved[1], height], axis=1)
    coefficients = np.linalg.lstsq(spline.design(time).toarray(), place, rcond=None)[0]
    return FreeMotion(SplineMotion(spline, coefficients), np.zeros(3), G_M_S2)


def flights_of(free: FreeMotion, u_m: float) -> FlightFit:
    """Return the flights fitted to a motion whose coefficients are known to u."""
    return fit_flights(even_information(free, u_m**-2.0), FlightPlan(2, 3))


def breaks_of(time_s: list[float], before: list[list[float]], after: list[list[float]]) -> BreakVelocities:
    covariance = np.tile(1e-8 * np.eye(6), (len(time_s), 1, 1))
    return BreakVelocities(np.array(time_s), np.array(before), np.array(after), covariance, G_M_S2)


@pytest.mark.parametrize(("late_s", "together"), [(0.0, False), (-0.0015, True), (0.0015, True)])
def test_flights_that_meet_a_millisecond_beside_their_impact_met_a_wall(late_s: float, *, together: bool) -> None:
    free = bounced(late_s)
    speed = G * IMPACT_S
    breaks = breaks_of([IMPACT_S], [[0.1, 0.0, -speed]], [[-0.08, 0.0, E * speed]])
    posterior = SimpleNamespace(breaks=breaks, free=free, kicks_beside=lambda _: np.zeros(0, dtype=np.intp))
    assert walls_at_impacts(posterior, flights_of(free, 1e-5), UP).tolist() == [together]
    # what is known too badly says nothing, and without flights lines do
    assert not walls_at_impacts(posterior, flights_of(free, 1e-3), UP).any()
    posterior.kicks_beside = lambda _: np.array([0])
    assert walls_at_impacts(posterior, None, UP).tolist() == [True]


@pytest.mark.parametrize(("back_m_s", "moved_m"), [(0.1, (0.0, 1e-4)), (0.09, (1e-4, 0.0)), (-0.08, (0.0, 1e-4))])
def test_flights_that_are_moved_across_their_kick_or_without_one_met_no_wall(
    back_m_s: float, moved_m: tuple[float, float]
) -> None:
    free = bounced(0.0, back_m_s, moved_m)
    breaks = breaks_of([IMPACT_S], [[0.1, 0.0, -2.0]], [[back_m_s, 0.0, 1.4]])
    posterior = SimpleNamespace(breaks=breaks, free=free, kicks_beside=lambda _: np.zeros(0, dtype=np.intp))
    assert walls_at_impacts(posterior, flights_of(free, 1e-5), UP).tolist() == [False]


def test_flights_that_antennas_elsewhere_would_move_so_met_no_wall() -> None:
    """All after the impact lies 0.1 mm back along x, as an antenna known to that would make it."""
    moved_m = 1e-4
    free = bounced(0.0, moved_m=(moved_m, 0.0))
    breaks = breaks_of([IMPACT_S], [[0.1, 0.0, -2.0]], [[-0.08, 0.0, 1.4]])
    posterior = SimpleNamespace(breaks=breaks, free=free, kicks_beside=lambda _: np.zeros(0, dtype=np.intp))
    fit = flights_of(free, 1e-5)
    assert walls_at_impacts(posterior, fit, UP).tolist() == [True]
    size = free.motion.spline.size
    first = free.segments[0].stop_coefficient - 2
    shift = np.zeros((size, 3))
    shift[first:, 0] = moved_m
    for u, together in ((1.0, False), (0.01, True)):
        # the slope of -ln L that moves the motion so
        slope = -fit.information.form.times(u * np.append(shift.ravel(), 0.0))
        response: Any = SimpleNamespace(slope=np.append(slope, 0.0))
        inputs = fit.inputs([response], np.ones(1))
        assert walls_at_impacts(posterior, fit, UP, inputs).tolist() == [together]
    assert fit.inputs([], np.ones(0)) is None


@pytest.mark.parametrize(
    ("place_m", "after_m_s", "together"),
    [
        (0.0, -0.08, True),
        (0.0, 0.02, False),  # rubbed by the floor, not turned back
        (0.01, -0.08, False),  # turned back, but away from the wall
        (-0.002, -0.08, True),
    ],
)
def test_a_body_that_is_turned_back_where_a_wall_stands_met_it(
    place_m: float, after_m_s: float, *, together: bool
) -> None:
    breaks = breaks_of([0.1, 0.3], [[0.1, 0.0, 1.0], [0.1, 0.0, -2.0]], [[-0.09, 0.0, 0.98], [after_m_s, 0.0, 1.4]])
    place = np.array([[0.0, place_m], [0.0, 0.01], [0.1, 0.0]])
    posterior = SimpleNamespace(
        breaks=breaks,
        free=SimpleNamespace(position_m=lambda _: place),
        kicks_beside=lambda _: np.zeros(0, dtype=np.intp),
    )
    assert walls_at_impacts(posterior, None, UP).tolist() == [False, together]
