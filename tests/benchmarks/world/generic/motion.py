"""Motions of the tracer with exact truth: drop with bounces, circle, pendulum, granular bed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from benchmarks.world.drop import drag_coefficient_times_speed
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

GRAVITY_M_S2 = 9.81
DIAMETER_M, FAST_M_S = 0.010, 2.0
"""Of the sphere, and the speed at which its drag is that told."""
Array = NDArray[np.float64]


@dataclass(frozen=True)
class Impact:
    """One impact of the truth: time and velocities (3,) before and after."""

    time_s: float
    before_m_s: Array
    after_m_s: Array


@dataclass(frozen=True)
class Motion:
    """A motion: position as a function of time, impacts, and the length of the record."""

    position: Callable[[Array], Array]
    duration_s: float
    motion_start_s: float
    impacts: tuple[Impact, ...] = field(default=())


def _flight(start: Array, velocity: Array, drag_1_m: float, floor_m: float, limit_s: float):
    """Integrate a fall with a sphere's drag, k v^2 at 2 m/s, until the floor or the limit; (duration, dense output)."""
    scale = drag_1_m * FAST_M_S / drag_coefficient_times_speed(FAST_M_S, DIAMETER_M)

    def rate(_t, state):
        v = state[3:]
        braked = scale * drag_coefficient_times_speed(float(np.linalg.norm(v)), DIAMETER_M) * v
        return np.concatenate([v, np.array([0.0, 0.0, -GRAVITY_M_S2]) - braked])

    def height(_t, state):
        return state[2] - floor_m if state[5] < 0 else 1.0

    height.terminal = True
    solution = solve_ivp(
        rate,
        (0.0, limit_s),
        np.concatenate([start, velocity]),
        method="DOP853",
        dense_output=True,
        rtol=1e-11,
        atol=1e-13,
        events=height,
        max_step=0.02,
    )
    return solution.t[-1], solution.sol


def drop(
    rng: np.random.Generator,
    *,
    release_m: Array,
    height_m: float,
    restitution: float,
    drag_1_m: float = 0.0,
    drift_m_s: float = 0.0,
    rest_s: float = 0.3,
    duration_s: float = 1.2,
) -> Motion:
    """Rest, fall, bounces; every bounce turns some speed sideways (`drift_m_s`)."""
    floor = release_m[2] - height_m
    pieces: list[tuple[float, float, object]] = []
    impacts: list[Impact] = []
    time, place, velocity = rest_s, release_m.copy(), np.zeros(3)
    while time < duration_s:
        length, dense = _flight(place, velocity, drag_1_m, floor, duration_s - time + 0.05)
        pieces.append((time, time + length, dense))
        time += length
        if time >= duration_s:
            break
        end = dense(length)
        before = end[3:]
        e = restitution * (1.0 + 0.01 * rng.standard_normal())
        kick = drift_m_s * rng.uniform(-1.0, 1.0, 2)
        after = np.array([before[0] * 0.8 + kick[0], before[1] * 0.8 + kick[1], -e * before[2]])
        place = np.array([end[0], end[1], floor])
        impacts.append(Impact(time, before, after))
        velocity = after
        if after[2] < 0.02:
            break
    rest_place = place.copy()

    def position(t: Array) -> Array:
        out = np.repeat(release_m[:, None], t.size, axis=1)
        for first, last, dense in pieces:
            inside = (t >= first) & (t < last)
            if inside.any():
                out[:, inside] = dense(t[inside] - first)[:3]
        if pieces[-1][1] < duration_s:
            out[:, t >= pieces[-1][1]] = rest_place[:, None]
        return out

    return Motion(position, duration_s, rest_s, tuple(impacts))


def bed(*, release_m: Array, height_m: float, depth_m: float, rest_s: float = 0.3, duration_s: float = 0.9) -> Motion:
    """Fall into grains: a constant force stops the sphere within `depth_m`; no rebound."""
    fall = np.sqrt(2.0 * height_m / GRAVITY_M_S2)
    speed = GRAVITY_M_S2 * fall
    stop = 2.0 * depth_m / speed

    def position(t: Array) -> Array:
        out = np.repeat(release_m[:, None], t.size, axis=1)
        u = np.clip(t - rest_s, 0.0, fall)
        w = np.clip(t - rest_s - fall, 0.0, stop)
        out[2] -= GRAVITY_M_S2 * u**2 / 2.0 + speed * (w - w**2 / (2.0 * stop))
        return out

    return Motion(position, duration_s, rest_s)


def _smooth_start(t: Array, start_s: float, ramp_s: float) -> Array:
    """Return elapsed time that starts with speed zero and reaches speed one after the ramp."""
    u = np.clip((t - start_s) / ramp_s, 0.0, 1.0)
    return ramp_s * (u**3 - u**4 / 2.0) + np.clip(t - start_s - ramp_s, 0.0, None)


def circle(
    *, release_m: Array, radius_m: float, period_s: float, slope: float, rest_s: float, duration_s: float
) -> Motion:
    """A circle in a sloped plane through the release position, started and never stopped."""

    def position(t: Array) -> Array:
        angle = 2.0 * np.pi * _smooth_start(t, rest_s, 0.25) / period_s
        x, y = radius_m * (np.cos(angle) - 1.0), radius_m * np.sin(angle)
        return release_m[:, None] + np.stack([x, y, slope * (x + 0.5 * y)])

    return Motion(position, duration_s, rest_s)


def pendulum(
    *,
    release_m: Array,
    length_m: float,
    amplitude_rad: float,
    azimuth_rad: float,
    rest_s: float,
    duration_s: float,
) -> Motion:
    """A plane pendulum let go at its amplitude, integrated exactly."""
    solution = solve_ivp(
        lambda _t, s: [s[1], -GRAVITY_M_S2 / length_m * np.sin(s[0])],
        (0.0, duration_s),
        [amplitude_rad, 0.0],
        method="DOP853",
        dense_output=True,
        rtol=1e-11,
        atol=1e-13,
        max_step=0.05,
    )
    away = np.array([np.cos(azimuth_rad), np.sin(azimuth_rad)])

    def place(angle: Array) -> Array:
        side = length_m * np.sin(angle)
        return np.stack([away[0] * side, away[1] * side, -length_m * np.cos(angle)])

    origin = release_m[:, None] - place(np.array([amplitude_rad]))

    def position(t: Array) -> Array:
        return origin + place(solution.sol(np.clip(t - rest_s, 0.0, None))[0])

    return Motion(position, duration_s, rest_s)
