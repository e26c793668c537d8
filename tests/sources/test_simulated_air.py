"""A simulated fall through air obeys a = g - k |v| v, to the nanometre and the nanosecond."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from scipy.integrate import solve_ivp
from support.simulated_recording import simulate_recording
from support.simulated_setup import perfect_setup

from radargui.model.setup import Setup
from radargui.sources.simulated.scene import Scene, contact_plane

G = 9.81
HEIGHT_M = 0.26
TILTED = {"height_m": -0.14, "normal": [0.12, -0.05, 1.0]}


def _velocity(scene: Scene, time_s: float, side: int, step_s: float = 1e-5) -> np.ndarray:
    """One-sided velocity, exact up to the third derivative of the position."""
    places = scene.position_m(time_s + side * step_s * np.arange(4.0))
    return side * places @ np.array([-11.0, 18.0, -9.0, 2.0]) / (6.0 * step_s)


def _vertical_impacts_s(k: float, e: float, count: int) -> list[float]:
    """Closed form: fall v = sqrt(g/k) tanh(sqrt(g k) t), rise v = sqrt(g/k) tan(sqrt(g k) (t_apex - t))."""
    rate = np.sqrt(G * k)
    impacts = [float(np.arccosh(np.exp(k * HEIGHT_M)) / rate)]
    speed = np.sqrt(G / k * -np.expm1(-2.0 * k * HEIGHT_M))
    while len(impacts) < count:
        rebound = e * speed
        height = np.log1p(k * rebound**2 / G) / (2.0 * k)
        flight = np.arctan(rebound * np.sqrt(k / G)) + np.arccosh(np.exp(k * height))
        impacts.append(impacts[-1] + float(flight / rate))
        speed = np.sqrt(G / k * -np.expm1(-2.0 * k * height))
    return impacts


@pytest.mark.parametrize(("k", "e"), [(0.005, 0.92), (0.06, 0.8), (0.2, 0.5)])
def test_a_vertical_fall_and_all_its_impacts_come_as_the_closed_form_tells(k: float, e: float) -> None:
    scene = Scene(perfect_setup(rest_s=0.0, drag_per_m=k, restitution=e))
    impacts = scene.impacts_s(0.0, 100.0)
    np.testing.assert_allclose(impacts, _vertical_impacts_s(k, e, len(impacts)), rtol=0.0, atol=1e-9)
    time = np.linspace(0.0, impacts[0], 3001)
    fallen = np.log(np.cosh(np.sqrt(G * k) * time)) / k
    position = scene.position_m(time)
    np.testing.assert_allclose(position[2], 0.12 - fallen, rtol=0.0, atol=1e-12)
    assert not position[:2].any()


def test_a_vertical_rise_reaches_the_height_of_the_closed_form() -> None:
    k, e = 0.1, 0.9
    scene = Scene(perfect_setup(rest_s=0.0, drag_per_m=k, restitution=e))
    first, second = scene.impacts_s(0.0, 100.0)[:2]
    rebound = e * np.sqrt(G / k * -np.expm1(-2.0 * k * HEIGHT_M))
    highest = scene.position_m(np.linspace(first, second, 20001))[2].max()
    assert highest + 0.14 == pytest.approx(np.log1p(k * rebound**2 / G) / (2.0 * k), abs=1e-9)


def _integrated(setup: Setup, count: int) -> tuple[list[float], np.ndarray, np.ndarray]:
    """Impacts, times and places by an eighth-order integration with error control."""
    simulation, plane = setup.simulation, contact_plane(setup)
    gravity = np.array([0.0, 0.0, -simulation.gravity_m_s2])
    azimuth = np.radians(simulation.lateral_azimuth_deg)
    heading = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
    heading -= (heading @ plane.normal) * plane.normal
    push = simulation.lateral_speed_m_s * heading / np.linalg.norm(heading) / 0.01
    state = np.array([*setup.tracer.release_position_m, 0.0, 0.0, 0.0])
    time, impacts, times, places = 0.0, [], [], []

    def touches(_time: float, state: np.ndarray) -> float:
        return float(plane.normal @ state[:3] - plane.distance_m)

    touches.terminal, touches.direction = True, -1  # type: ignore[attr-defined]
    while len(impacts) < count:
        force = gravity + push if time < 0.01 else gravity

        def rate(_time: float, state: np.ndarray, force: np.ndarray = force) -> np.ndarray:
            velocity, slow = state[3:], simulation.drag_slow_m_s
            return np.r_[
                velocity,
                force - simulation.drag_per_m * (np.sqrt(velocity @ velocity) + slow) * velocity,
            ]

        end = 0.01 if time < 0.01 else 100.0
        flown = solve_ivp(
            rate,
            (time, end),
            state,
            "DOP853",
            rtol=1e-13,
            atol=1e-15,
            max_step=0.004,
            dense_output=True,
            events=touches,
        )
        inside = np.linspace(time, flown.t[-1], 101)[1:-1]
        times.append(inside)
        places.append(flown.sol(inside)[:3])
        time, state = flown.t[-1], flown.y[:, -1].copy()
        if flown.status == 1:
            impacts.append(time)
            state[3:] -= (1.0 + simulation.restitution) * (plane.normal @ state[3:]) * plane.normal
    return impacts, np.concatenate(times), np.concatenate(places, axis=1)


@pytest.mark.parametrize("sideways", [0.003, 0.05, 0.5])
@pytest.mark.parametrize("floor", [None, TILTED], ids=["level", "tilted"])
def test_with_sideways_motion_drag_acts_on_the_whole_velocity(sideways: float, floor: dict[str, object]) -> None:
    setup = perfect_setup(
        rest_s=0.0, drag_per_m=0.2, drag_slow_m_s=0.5, restitution=0.7, floor=floor, lateral_speed_m_s=sideways
    )
    impacts, times, places = _integrated(setup, 5)
    scene = Scene(setup)
    np.testing.assert_allclose(scene.impacts_s(0.0, 100.0)[:5], impacts, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(scene.position_m(times), places, rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("kind", ["drop", "bed"])
@pytest.mark.parametrize("floor", [None, TILTED], ids=["level", "tilted"])
@pytest.mark.parametrize("sideways", [0.0, 0.1])
def test_drag_that_vanishes_leaves_the_fall_without_air(kind: str, floor: dict[str, object], sideways: float) -> None:
    base = {"scene": kind, "floor": floor, "lateral_speed_m_s": sideways, "restitution": 0.7}
    vacuum, air = Scene(perfect_setup(**base)), Scene(perfect_setup(**base, drag_per_m=1e-10))
    assert air.duration_s == pytest.approx(vacuum.duration_s, abs=1e-8)
    time = np.linspace(0.0, vacuum.duration_s or 0.0, 20001)
    np.testing.assert_allclose(air.position_m(time), vacuum.position_m(time), rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(air.impacts_s(0.0, 100.0), vacuum.impacts_s(0.0, 100.0), rtol=0.0, atol=1e-9)


def test_an_impact_in_air_turns_the_speed_along_the_normal_e_times_and_keeps_the_rest() -> None:
    setup = perfect_setup(rest_s=0.0, drag_per_m=0.1, restitution=0.6, floor=TILTED, lateral_speed_m_s=0.2)
    scene, normal = Scene(setup), contact_plane(setup).normal
    for time in scene.impacts_s(0.0, 100.0)[:4]:
        before, after = _velocity(scene, float(time), -1), _velocity(scene, float(time), +1)
        np.testing.assert_allclose(after, before - 1.6 * (before @ normal) * normal, atol=1e-8)
        assert normal @ scene.position_m(np.array([time]))[:, 0] == pytest.approx(contact_plane(setup).distance_m)


def test_the_bed_stops_a_sphere_from_the_air_evenly_over_its_depth() -> None:
    scene = Scene(perfect_setup(scene="bed", rest_s=0.0, bed_depth_m=0.01, drag_per_m=0.2))
    touch = np.arccosh(np.exp(0.2 * HEIGHT_M)) / np.sqrt(0.2 * G)
    speed = np.sqrt(G / 0.2 * -np.expm1(-0.4 * HEIGHT_M))
    assert scene.impacts_s(0.0, 100.0).size == 0
    assert scene.trajectory.duration_s == pytest.approx(touch + 0.02 / speed, abs=1e-9)
    assert scene.position_m(np.array([9.0]))[2, 0] == pytest.approx(-0.15, abs=1e-12)


@given(
    height=st.floats(0.001, 1.0),
    e=st.floats(0.0, 0.9),
    k=st.floats(1e-6, 0.2),
    speed=st.floats(0.0, 1.0),
    slope=st.floats(0.0, 0.3),
    repeat=st.booleans(),
    kind=st.sampled_from(["drop", "bed"]),
)
@settings(max_examples=25, deadline=None)
def test_any_fall_through_air_begins_at_the_release_and_never_passes_the_floor_nor_gains_height(
    height: float, e: float, k: float, speed: float, slope: float, repeat: bool, kind: str
) -> None:
    setup = perfect_setup(
        scene=kind,
        release=(0.0, 0.0, 0.0),
        floor={"normal": [slope, 0.0, 1.0]},
        drop_height_m=height,
        restitution=e,
        lateral_speed_m_s=speed,
        drag_per_m=k,
        rest_s=0.1,
    )
    scene, normal = Scene(setup, repeat=repeat), np.array(setup.floor.normal)
    position = scene.position_m(np.linspace(0.0, 20.0, 20001))
    assert np.isfinite(position).all()
    assert not position[:, :100].any()
    sunk = 0.01 if kind == "bed" else 0.0
    assert (normal @ position).min() >= -height * normal[2] - sunk - 1e-9
    assert (normal @ position).max() <= 1e-9


def test_a_recording_in_air_tells_the_true_motion_and_other_scenes_know_no_air() -> None:
    setup = perfect_setup(drag_per_m=0.05, restitution=0.8)
    recording, truth = simulate_recording(setup)
    np.testing.assert_allclose(truth.impact_time_s[:3], 0.6 + np.array(_vertical_impacts_s(0.05, 0.8, 3)), atol=1e-9)
    assert recording.n_samples == truth.position_m.shape[1]
    for kind in ("circle", "pendulum", "rest"):
        time = np.linspace(0.0, 3.0, 100)
        np.testing.assert_array_equal(
            Scene(perfect_setup(scene=kind, drag_per_m=0.2)).position_m(time),
            Scene(perfect_setup(scene=kind)).position_m(time),
        )
