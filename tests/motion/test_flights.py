"""Flights against numerical integration, and their derivatives against differences."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from radargui.motion.flights import FlightLayout, Flights

DROP = Flights(
    0.25,
    np.array([0.01, -0.02, 0.12]),
    9.81,
    0.03,
    0.25,
    np.array([[0.01, 0.02, -0.05], [0.05, -0.03, 1.6], [0.02, 0.04, 1.2]]),
    np.array([0.475, 0.79]),
)


@pytest.mark.parametrize(("k", "slow", "off_m"), [(0.06, 0.0, 1e-5), (0.008, 0.3, 2e-6)])
def test_a_flight_with_drag_obeys_its_equation_of_motion(k: float, slow: float, off_m: float) -> None:
    g = 9.81
    start, velocity = np.array([0.0, 0.0, 0.1]), np.array([0.08, -0.05, 1.9])

    def rate(_t: float, s: np.ndarray) -> np.ndarray:
        speed = np.linalg.norm(s[3:])
        return np.concatenate([s[3:], -k * (speed + slow) * s[3:] - [0.0, 0.0, g]])

    time = np.linspace(0.0, 0.4, 41)
    true = solve_ivp(rate, (0.0, 0.4), np.append(start, velocity), t_eval=time, rtol=1e-11, atol=1e-13).y
    flights = Flights(0.0, start, g, k, slow, velocity[None], np.empty(0))
    # the path counts as vertical: sideways speed of 1/20 makes it 0.1 per cent longer, of drag's tenth of a millimetre
    assert flights.position_m(time) == pytest.approx(true[:3], abs=off_m)
    assert flights.velocity_at(time) == pytest.approx(true[3:], abs=2e-4)


def test_the_body_rests_before_the_onset_and_flights_meet_at_impacts() -> None:
    early = DROP.position_m(np.array([0.0, 0.2, 0.25]))
    assert early == pytest.approx(np.repeat(DROP.start_m[:, None], 3, axis=1))
    for impact in DROP.impact_s:
        before, after = DROP.position_m(np.array([impact - 1e-9, impact + 1e-9])).T
        assert before == pytest.approx(after, abs=1e-7)
    before = DROP.velocity_at(DROP.impact_s - 1e-9).T
    assert DROP.velocity_before_m_s() == pytest.approx(before, abs=1e-6)


def test_unknowns_go_there_and_back() -> None:
    again = Flights.of(DROP.unknowns)
    assert again.unknowns == pytest.approx(DROP.unknowns)
    assert DROP.unknowns.size == FlightLayout(3).size


@pytest.mark.parametrize("drag", [0.0, 0.05, -0.01])
def test_derivatives_are_those_of_differences(drag: float) -> None:
    unknowns = DROP.unknowns
    unknowns[DROP.layout.drag] = drag
    # away from the kinks, where a difference would mix two flights
    time = np.concatenate([np.linspace(0.0, 0.24, 5), np.linspace(0.26, 0.47, 9), np.linspace(0.48, 1.0, 40)])
    time = time[np.abs(time - 0.79) > 1e-3]
    _, slopes = Flights.of(unknowns).position_and_slopes(time)
    by_speed = Flights.of(unknowns).velocity_before_slopes()
    for number in range(unknowns.size):
        step = 1e-6
        more, less = unknowns.copy(), unknowns.copy()
        more[number] += step
        less[number] -= step
        difference = (Flights.of(more).position_m(time) - Flights.of(less).position_m(time)) / (2.0 * step)
        assert slopes[number] == pytest.approx(difference, abs=2e-7)
        ends = (Flights.of(more).velocity_before_m_s() - Flights.of(less).velocity_before_m_s()) / (2.0 * step)
        assert by_speed[:, :, number] == pytest.approx(ends, abs=1e-6)


@pytest.mark.parametrize("drag", [0.0, 0.05])
def test_derivatives_of_velocity_and_acceleration_are_those_of_differences(drag: float) -> None:
    unknowns = DROP.unknowns
    unknowns[DROP.layout.drag] = drag
    time = np.array([0.26, 0.35, 0.47, 0.48, 0.6, 0.78, 0.8, 0.95])
    velocity, slopes = Flights.of(unknowns).velocity_and_slopes(time)
    assert velocity == pytest.approx(Flights.of(unknowns).velocity_at(time))
    bends = Flights.of(unknowns).acceleration_slopes(velocity, slopes)
    for number in range(unknowns.size):
        step = 1e-6
        more, less = unknowns.copy(), unknowns.copy()
        more[number] += step
        less[number] -= step
        faster, slower = (Flights.of(one).velocity_at(time) for one in (more, less))
        assert slopes[number] == pytest.approx((faster - slower) / (2.0 * step), abs=1e-6)
        pulled = Flights.of(more).acceleration(faster) - Flights.of(less).acceleration(slower)
        assert bends[number] == pytest.approx(pulled / (2.0 * step), abs=1e-5)
