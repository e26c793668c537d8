"""A drop as it happens: fall in air, bounces that scatter and kick, and how it ends; truth at any time."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

Array = NDArray[np.float64]

AIR_KG_M3 = 1.2
AIR_M2_S = 1.51e-5
"""Its kinematic viscosity at 20 degrees C."""


def drag_coefficient_times_speed(speed_m_s: float, diameter_m: float) -> float:
    """Return C_d v of a sphere in air: the standard drag curve after Clift & Gauvin (Proc. Chemeca 1, 14, 1970).

    C_d = 24 / Re (1 + 0.15 Re^0.687) + 0.42 / (1 + 42500 Re^-1.16), within 6 % of what was measured.
    """
    slow = AIR_M2_S / diameter_m
    reynolds = speed_m_s / slow
    rough = 0.42 / (1.0 + 42500.0 * reynolds**-1.16) if reynolds > 0.0 else 0.0
    return 24.0 * slow * (1.0 + 0.15 * reynolds**0.687) + rough * speed_m_s


SLOWEST_REBOUND_M_S = 0.02
ROLLING = 5.0 / 7.0  # of the speed along the floor that friction leaves, and of the slope's pull: a solid sphere
_FOREVER_S = 60.0


@dataclass(frozen=True)
class Body:
    """The sphere in air: what pulls it and what brakes it.

    Attributes
    ----------
    radius_m, density_kg_m3
        Of the sphere.
    gravity_m_s2
        Of the place.
    """

    radius_m: float
    density_kg_m3: float
    gravity_m_s2: float

    @property
    def acceleration_m_s2(self) -> float:
        """Acceleration at the start of a fall: buoyancy, and half of the air displaced moves along (added mass)."""
        share = AIR_KG_M3 / self.density_kg_m3
        return self.gravity_m_s2 * (1.0 - share) / (1.0 + 0.5 * share)

    def braking_1_s(self, speed_m_s: float) -> float:
        """Deceleration by drag over speed: (3/8) C_d v (air / sphere) / radius, the air moved along counted."""
        share = AIR_KG_M3 / self.density_kg_m3
        braking = drag_coefficient_times_speed(speed_m_s, 2.0 * self.radius_m)
        return 0.375 * braking * share / self.radius_m / (1.0 + 0.5 * share)


@dataclass(frozen=True)
class Impact:
    """One impact: instant, speeds along the floor's normal, both positive; velocities (x, y, z) where they are kept."""

    time_s: float
    before_m_s: float
    after_m_s: float
    arriving_m_s: tuple[float, ...] = ()
    leaving_m_s: tuple[float, ...] = ()

    @property
    def e(self) -> float:
        """Coefficient of restitution."""
        return self.after_m_s / self.before_m_s


@dataclass(frozen=True)
class Floor:
    """What the sphere falls on; heights are of the sphere's centre when it touches.

    Attributes
    ----------
    normal, touch_m
        Unit vector (3,) and a place (3,) of the centre that touches.
    restitution, scatter
        Mean coefficient, and its relative standard deviation from impact to impact.
    kick_m_s
        Standard deviation of the speed along x and along y that an impact adds.
    contact_s
        How long an impact lasts: rubber, foam; 0 of a hard floor.
    friction
        Coulomb's: the change of speed along the floor is no more than this share of that along the normal. None: it
        always suffices to roll.
    """

    normal: Array
    touch_m: Array
    restitution: float
    scatter: float = 0.01
    kick_m_s: float = 0.0
    contact_s: float = 0.0
    friction: float | None = None


@dataclass(frozen=True)
class Drop:
    """Motion from rest to the end of the record.

    Attributes
    ----------
    position
        Positions (3, n) at times (n,) in s.
    start_s, duration_s
        When the sphere is let go; length of the record.
    impacts
        In time order.
    breaks_s
        Where the velocity may jump, in time order; empty: not known.
    normal
        Unit vector of the floor.
    """

    position: Callable[[Array], Array]
    start_s: float
    duration_s: float
    impacts: tuple[Impact, ...]
    breaks_s: tuple[float, ...] = ()
    normal: tuple[float, ...] = (0.0, 0.0, 1.0)


def flight(body: Body, floor: Floor, place: Array, velocity: Array) -> tuple[float, Callable[[Array], Array]]:
    """Return the time until the floor is touched and the dense solution: place and velocity, shape (6, n)."""

    down_m_s2 = body.acceleration_m_s2

    def slope(_time: float, state: Array) -> Array:
        x, y, z = state[3:].tolist()
        braked = -body.braking_1_s(math.sqrt(x * x + y * y + z * z))
        return np.array([x, y, z, braked * x, braked * y, braked * z - down_m_s2])

    def touching(_time: float, state: Array) -> float:
        above = float(floor.normal @ (state[:3] - floor.touch_m))
        return above if floor.normal @ state[3:] < 0.0 else 1.0

    touching.terminal = True
    begin = np.concatenate([place, velocity])
    found = solve_ivp(
        slope, (0.0, _FOREVER_S), begin, "DOP853", dense_output=True, rtol=1e-12, atol=1e-14, events=touching,
        max_step=0.02,
    )  # fmt: skip
    return float(found.t[-1]), found.sol


def fall(
    rng: np.random.Generator,
    body: Body,
    floor: Floor,
    release_m: Array,
    *,
    start_s: float,
    duration_s: float,
    caught_within_m: float | None = None,
    velocity_m_s: Array | None = None,
) -> Drop:
    """Let the sphere go and follow it to the end of the record: it bounces and rolls, or is caught once.

    It goes from rest, or with the velocity (3,) given.
    """
    pieces: list[tuple[float, Callable[[Array], Array]]] = []
    impacts: list[Impact] = []
    time, place = start_s, release_m
    velocity = np.zeros(3) if velocity_m_s is None else velocity_m_s
    while time < duration_s:
        length, dense = flight(body, floor, place, velocity)
        pieces.append((time, dense))
        time += length
        place, arriving = np.split(dense(length), 2)
        if caught_within_m is not None:
            pieces.append((time, _caught(place, arriving, caught_within_m)))
            break
        if time >= duration_s:
            break
        impact, velocity = _bounce(rng, floor, time, arriving)
        if floor.contact_s and impact.after_m_s > 0.0:
            pieces.append((time, _pressed(floor, place, arriving, velocity)))
            place = pieces[-1][1](np.array([floor.contact_s]))[:, 0]
            # an instant stands for it: the middle
            impact = replace(impact, time_s=time + floor.contact_s / 2.0)
            time += floor.contact_s
        if impact.after_m_s < SLOWEST_REBOUND_M_S:
            velocity = velocity - floor.normal * (floor.normal @ velocity)
            impact = replace(impact, after_m_s=0.0)
            pieces.append((time, _rolling(body, floor, place, velocity)))
        impacts.append(impact)
        if impact.after_m_s == 0.0:
            break
    breaks_s = tuple(begin for begin, _ in pieces)
    return Drop(_joined(release_m, pieces), start_s, duration_s, tuple(impacts), breaks_s, tuple(floor.normal.tolist()))


def _bounce(rng: np.random.Generator, floor: Floor, time_s: float, arriving: Array) -> tuple[Impact, Array]:
    """Reverse the speed along the normal; friction takes what spin needs of the rest, roughness adds the kick."""
    before = -float(floor.normal @ arriving)
    along = arriving + before * floor.normal
    kick = floor.kick_m_s * np.append(rng.standard_normal(2), 0.0)
    after = before * floor.restitution * (1.0 + floor.scatter * rng.standard_normal())
    kept = ROLLING
    if floor.friction is not None:
        slip = float(np.linalg.norm(along))
        kept = max(ROLLING, 1.0 - floor.friction * (before + after) / slip) if slip > 0.0 else 1.0
    leaving = kept * along + kick - floor.normal * (floor.normal @ kick) + after * floor.normal
    return Impact(time_s, before, after, tuple(arriving.tolist()), tuple(leaving.tolist())), leaving


def _pressed(floor: Floor, place: Array, arriving: Array, leaving: Array) -> Callable[[Array], Array]:
    """Go through a contact: along the normal half a swing of a damped spring, along the floor evenly to what is left.

    -(v / w) exp(-c t) sin w t with w = pi / T is back after T with the speed v exp(-c T) = e v.
    """
    normal, lasts_s = floor.normal, floor.contact_s
    before, after = -float(normal @ arriving), float(normal @ leaving)
    along = [one - normal * (normal @ one) for one in (arriving, leaving)]
    damping, rate = np.log(before / after) / lasts_s, np.pi / lasts_s

    def position(t: Array) -> Array:
        depth = before / rate * np.exp(-damping * t) * np.sin(rate * t)
        level = np.outer(along[0], t) + np.outer(along[1] - along[0], t**2 / (2.0 * lasts_s))
        return place[:, None] + level - np.outer(normal, depth)

    return position


def _rolling(body: Body, floor: Floor, place: Array, velocity: Array) -> Callable[[Array], Array]:
    pull = np.array([0.0, 0.0, -body.acceleration_m_s2])
    pull = ROLLING * (pull - floor.normal * (floor.normal @ pull))
    return lambda t: place[:, None] + np.outer(velocity, t) + np.outer(pull, t**2 / 2.0)


def _caught(place: Array, velocity: Array, depth_m: float) -> Callable[[Array], Array]:
    """Stop within the depth by a constant force."""
    stop_s = 2.0 * depth_m / float(np.linalg.norm(velocity))

    def position(t: Array) -> Array:
        u = np.clip(t, 0.0, stop_s)
        return place[:, None] + np.outer(velocity, u - u**2 / (2.0 * stop_s))

    return position


def _joined(release_m: Array, pieces: list[tuple[float, Callable[[Array], Array]]]) -> Callable[[Array], Array]:
    starts = np.array([start for start, _ in pieces])

    def position(time_s: Array) -> Array:
        out = np.repeat(release_m[:, None], time_s.size, axis=1)
        piece = np.searchsorted(starts, time_s, side="right") - 1
        for number, (start, solution) in enumerate(pieces):
            inside = piece == number
            if inside.any():
                out[:, inside] = solution(time_s[inside] - start)[:3]
        return out

    return position
