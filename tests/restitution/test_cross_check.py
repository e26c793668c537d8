"""The two other ways to e, under drag, against flights integrated numerically."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from radargui.model.result import Bounce, Bounces
from radargui.restitution.cross_check import (
    TimesOfFlights,
    cross_check,
    disagreements,
    floor_and_wall,
    walls_met,
    with_e_by_times,
    without_checks_by_walls,
)

G, BEFORE, AFTER = 9.81, 2.0, 1.6


@pytest.mark.parametrize(("drag_1_m", "slow_m_s"), [(0.0, 0.0), (0.06, 0.0), (0.05, 0.25)])
def test_duration_and_height_of_a_flight_give_the_speed_it_began_with(drag_1_m: float, slow_m_s: float) -> None:
    def rate(_t: float, s: np.ndarray) -> list[float]:
        return [s[1], -G - drag_1_m * (abs(s[1]) + slow_m_s) * s[1]]

    def lands(_t: float, s: np.ndarray) -> float:
        return float(s[0])

    lands.terminal, lands.direction = True, -1.0  # type: ignore[attr-defined]
    flight = solve_ivp(rate, (0.0, 1.0), [1e-12, AFTER], events=lands, rtol=1e-11, atol=1e-13, dense_output=True)
    end = float(flight.t_events[0][0])
    time = np.linspace(0.0, end, 2000)
    e = AFTER / BEFORE
    impacts = tuple(Bounce(at, BEFORE, AFTER, e, 1e-4, "made", valid=True) for at in (0.0, end))
    first, last = cross_check(Bounces(impacts), time, flight.sol(time)[0], G, drag_1_m, slow_m_s).impacts
    assert first.e_flight_time == pytest.approx(e, rel=3e-4)
    assert first.e_height == pytest.approx(e, rel=2e-3 if drag_1_m else 1e-6)
    assert np.isnan(last.e_flight_time)
    if drag_1_m:
        blind = cross_check(Bounces(impacts), time, flight.sol(time)[0], G).impacts[0]
        assert abs(blind.e_flight_time - e) > 5.0 * abs(first.e_flight_time - e)


@pytest.mark.parametrize("known", [True, False])
def test_a_flight_is_compared_by_its_duration_where_the_impact_that_ends_it_is_known(*, known: bool) -> None:
    first = Bounce(0.0, BEFORE, AFTER, AFTER / BEFORE, 1e-4, "made", valid=True, e_flight_time=0.9)
    last = Bounce(0.3, AFTER, 1.3, 1.3 / AFTER, 0.2, "made", valid=known)
    assert len(disagreements(Bounces((first, last)))) == known


@pytest.mark.parametrize(("e_flight_time", "told"), [(1.7, True), (49.8, False)])
def test_a_sphere_that_lay_until_it_was_dropped_again_made_no_flight(e_flight_time: float, *, told: bool) -> None:
    first = Bounce(0.0, BEFORE, AFTER, AFTER / BEFORE, 1e-4, "made", valid=True, e_flight_time=e_flight_time)
    again = Bounce(9.0, BEFORE, AFTER, AFTER / BEFORE, 1e-4, "made", valid=True)
    assert bool(disagreements(Bounces((first, again)))) is told


@pytest.mark.parametrize("met", [True, False])
def test_a_flight_that_meets_a_wall_is_not_compared(*, met: bool) -> None:
    first = Bounce(0.0, BEFORE, AFTER, AFTER / BEFORE, 1e-4, "made", valid=True, e_flight_time=0.9, e_height=0.9)
    last = Bounce(0.3, AFTER, 1.3, 1.3 / AFTER, 0.2, "made", valid=True)
    bounces = Bounces((first, last), walls_s=(0.2,) if met else (0.4,))
    left = without_checks_by_walls(bounces)
    assert [np.isnan(one) for one in (left.impacts[0].e_flight_time, left.impacts[0].e_height)] == [met, met]
    assert bool(disagreements(left)) is not met
    assert ("0.200 s" in walls_met(bounces)[0]) is met
    assert walls_met(Bounces((first, last))) == ()


def test_an_impact_on_floor_and_wall_is_told_by_its_number() -> None:
    impacts = tuple(Bounce(at, BEFORE, AFTER, 0.8, 1e-4, "made", valid=at < 0.2) for at in (0.1, 0.3))
    assert floor_and_wall(Bounces(impacts)) == []
    (finding,) = floor_and_wall(Bounces(impacts, with_walls_s=(0.3,)))
    assert finding.text.startswith("impact 2: a wall was met together with the floor")


@pytest.mark.parametrize(("drag_1_m", "slow_m_s"), [(0.0, 0.0), (0.05, 0.4)])
def test_e_from_times_alone_needs_no_length_and_has_the_uncertainty_of_the_times(
    drag_1_m: float, slow_m_s: float
) -> None:
    e, height_m = 0.8, 0.3

    def slopes(_: float, state: np.ndarray) -> list[float]:
        return [state[1], -G - drag_1_m * (abs(state[1]) + slow_m_s) * state[1]]

    def lands(_: float, state: np.ndarray) -> float:
        return float(state[0])

    lands.terminal, lands.direction = True, -1.0  # type: ignore[attr-defined]
    times, state = [0.1], [height_m, 0.0]
    for _ in range(3):
        flight = solve_ivp(slopes, (0.0, 2.0), state, events=lands, rtol=1e-10, atol=1e-12)
        times.append(times[-1] + float(flight.t_events[0][0]))
        state = [1e-9, -e * float(flight.y_events[0][0][1])]
    u_s = 1e-5
    measured = TimesOfFlights(np.array(times), u_s**2 * np.eye(4), G, drag_1_m, slow_m_s)
    impacts = tuple(Bounce(at, BEFORE, AFTER, e, 1e-4, "made", valid=True) for at in times[1:])
    found = with_e_by_times(Bounces(impacts), measured).impacts
    assert [one.e_times for one in found[:2]] == pytest.approx([e, e], rel=1e-3)
    assert np.isnan(found[2].e_times)
    # e = T / 2 t of the first
    fall, flight_s = np.diff(times)[:2]
    by_times = np.array([1.0, -1.0 - fall / flight_s, fall / flight_s]) * e / fall
    assert found[0].u_e_times == pytest.approx(u_s * float(np.linalg.norm(by_times)), rel=0.02)
