"""A sphere among surfaces: flights, impacts, rolling, riding on a plate; from meeting to meeting."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from benchmarks.world.contact import Surface, rebound
from benchmarks.world.drop import ROLLING, SLOWEST_REBOUND_M_S, Body, Impact
from benchmarks.world.profile import Array
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

Solution = Callable[[Array], Array]

_STEPS_A_TURN = 40
_LONGEST_STEP_S = 0.02
_LOOK_S = 5e-4  # how often a rolling or riding sphere is looked at


@dataclass(frozen=True)
class Journey:
    """Where it goes, and what it met.

    Attributes
    ----------
    position
        Positions (3, n) at times (n,); before the start where it began, after the end as the last piece goes on.
    impacts, sides
        On floors and on what is none, in time order.
    lies_s
        Since when it no longer bounces; None: it did to the end.
    breaks_s
        Where the velocity may jump.
    """

    position: Solution
    impacts: tuple[Impact, ...]
    sides: tuple[Impact, ...]
    lies_s: float | None
    breaks_s: tuple[float, ...] = ()


def journey(
    rng: np.random.Generator,
    body: Body,
    surfaces: Sequence[Surface],
    place: Array,
    velocity: Array,
    *,
    start_s: float,
    end_s: float,
    resistance: float = 0.0,
    lies_on: Surface | None = None,
) -> Journey:
    """Follow the sphere from the start on.

    Parameters
    ----------
    resistance
        To rolling, over the weight: what stops it on a level floor.
    lies_on
        The surface it lies on at the start; None: it flies.
    """
    went = _Way(rng, body, tuple(surfaces), resistance, place, velocity, start_s, end_s)
    while went.time_s < end_s:
        if lies_on is None:
            lies_on = went.fly()
        else:
            lies_on = went.ride(lies_on) if lies_on.vibration.amplitude_m else went.roll(lies_on)
    breaks_s = tuple(begin for begin, _ in went.pieces)
    return Journey(pieced(place, went.pieces), tuple(went.impacts), tuple(went.sides), went.lies_s, breaks_s)


class _Way:
    """What has been gone so far: time, place, velocity and spin now; pieces and impacts."""

    def __init__(
        self, rng: np.random.Generator, body: Body, surfaces: tuple[Surface, ...], resistance: float, place: Array,
        velocity: Array, start_s: float, end_s: float,
    ) -> None:  # fmt: skip
        self.rng, self.body, self.surfaces, self.resistance = rng, body, surfaces, resistance
        self.time_s, self.end_s = start_s, end_s
        self.place, self.velocity, self.spin = place, velocity, np.zeros(3)
        self.pieces: list[tuple[float, Solution]] = []
        self.impacts: list[Impact] = []
        self.sides: list[Impact] = []
        self.lies_s: float | None = None

    def fly(self) -> Surface | None:
        """Fly to the next surface and meet it; return it where the sphere stays on it."""
        length, dense, surface = self._flight()
        self._go_on(length, lambda t: dense(t)[:3])
        self.place, self.velocity = np.split(dense(length), 2)
        if surface is None:
            return None
        if not surface.holds(self.place):
            # it falls past the end, and comes back to that plane no more
            self.surfaces = tuple(one for one in self.surfaces if one is not surface)
            return None
        impact = self._meet(surface)
        if impact.after_m_s >= SLOWEST_REBOUND_M_S or not surface.is_floor:
            (self.impacts if surface.is_floor else self.sides).append(impact)
            return None
        self.impacts.append(Impact(impact.time_s, impact.before_m_s, 0.0))
        self.velocity = surface.level(self.velocity)
        self.lies_s = self.time_s
        return surface

    def ride(self, plate: Surface) -> Surface | None:
        """Go with a vibrating plate, until it falls away faster than the sphere can follow."""
        times = np.arange(self.time_s, self.end_s + _LOOK_S, _LOOK_S)
        held = plate.vibration.moved(times, 2) + self.body.acceleration_m_s2
        free = np.flatnonzero(held < 0.0)
        leaves_s = self.end_s + 1.0
        if free.size:
            leaves_s = float(times[free[0]])
        if free.size and free[0]:
            leaves_s = brentq(
                lambda t: float(plate.vibration.moved(t, 2)) + self.body.acceleration_m_s2,
                leaves_s - _LOOK_S, leaves_s, xtol=1e-12,
            )  # fmt: skip
        length = leaves_s - self.time_s
        start, place, along = self.time_s, self.place, self.velocity
        height = float(plate.vibration.moved(start))

        def riding(t: Array) -> Array:
            return (
                place[:, None]
                + np.outer(along, t)
                + np.outer(plate.normal, plate.vibration.moved(start + np.asarray(t)) - height)
            )

        self._go_on(length, riding)
        self.place = riding(np.array([length]))[:, 0]
        self.velocity = along + plate.normal * float(plate.vibration.moved(self.time_s, 1))
        return None

    def roll(self, floor: Surface) -> Surface | None:
        """Roll until it meets something that is no floor; a level floor's resistance stops it.

        It rolls over no end: a motion that comes to it ends before.
        """
        pull = ROLLING * floor.level(np.array([0.0, 0.0, -self.body.acceleration_m_s2]))
        place, velocity, speed = self.place, self.velocity, float(np.linalg.norm(self.velocity))
        slowing = self.resistance * self.body.acceleration_m_s2 if not pull.any() else 0.0
        stop_s = speed / slowing if slowing and speed else np.inf

        def rolling(t: Array) -> Array:
            u = np.minimum(t, stop_s)
            braked = 1.0 - slowing * u / (2.0 * speed) if speed else 1.0
            return place[:, None] + np.outer(velocity, u * braked) + np.outer(pull, u**2 / 2.0)

        def rolls(t: float) -> Array:
            braked = max(0.0, 1.0 - slowing * t / speed) if speed else 1.0
            return velocity * braked + pull * t

        times = np.arange(0.0, self.end_s - self.time_s + 2.0 * _LOOK_S, _LOOK_S)
        first_s, met = np.inf, None
        for one in self.surfaces:
            gaps = one.normal @ (rolling(times) - one.touch_m[:, None])
            inside = 1 + np.flatnonzero((gaps[1:] < 0.0) & (np.diff(gaps) < 0.0))
            if one.is_floor or not inside.size or times[inside[0] - 1] >= first_s:
                continue
            low, high = times[inside[0] - 1 : inside[0] + 1].tolist()
            first_s, met = low, one
            if gaps[inside[0] - 1] > 0.0:
                first_s = brentq(lambda t, one=one: one.gap_m(0.0, rolling(np.array([t]))[:, 0]), low, high, xtol=1e-12)
        if met is None or self.time_s + first_s > self.end_s:
            self._go_on(self.end_s + 1.0 - self.time_s, rolling)
            return None
        self._go_on(first_s, rolling)
        self.place, self.velocity = rolling(np.array([first_s]))[:, 0], rolls(first_s)
        if met.approach_m_s(0.0, self.velocity) < SLOWEST_REBOUND_M_S:
            # it lies against the wall from now on
            lain = self.place
            self._go_on(self.end_s + 1.0 - self.time_s, lambda t: np.repeat(lain[:, None], t.size, axis=1))
            return None
        self.sides.append(self._meet(met))
        self.velocity = floor.level(self.velocity)
        return floor

    def _meet(self, surface: Surface) -> Impact:
        impact, self.velocity, self.spin = rebound(
            self.rng, surface, self.body.radius_m, self.time_s, self.velocity, self.spin
        )
        return impact

    def _go_on(self, length_s: float, solution: Solution) -> None:
        self.pieces.append((self.time_s, solution))
        self.time_s += length_s

    def _flight(self) -> tuple[float, Solution, Surface | None]:
        """Return how long it flies, place and velocity (6, n), and what it meets: nothing before the end is None."""
        body, start = self.body, self.time_s

        def slope(_time: float, state: Array) -> Array:
            speed = state[3:]
            braked = -body.braking_1_s(float(np.linalg.norm(speed))) * speed
            return np.concatenate([speed, braked - [0.0, 0.0, body.acceleration_m_s2]])

        def touching(surface: Surface) -> Callable[[float, Array], float]:
            def gap(time_s: float, state: Array) -> float:
                approached = surface.approach_m_s(start + time_s, state[3:]) > 0.0
                return surface.gap_m(start + time_s, state[:3]) if approached else 1.0

            gap.terminal = True  # type: ignore[attr-defined]
            return gap

        fastest = max((s.vibration.frequency_hz for s in self.surfaces if s.vibration.amplitude_m), default=0.0)
        found = solve_ivp(
            slope, (0.0, self.end_s + 0.01 - start), np.concatenate([self.place, self.velocity]), "DOP853",
            dense_output=True, rtol=1e-12, atol=1e-14, events=[touching(one) for one in self.surfaces],
            max_step=min(_LONGEST_STEP_S, 1.0 / (_STEPS_A_TURN * fastest)) if fastest else _LONGEST_STEP_S,
        )  # fmt: skip
        met = [one for one, times in zip(self.surfaces, found.t_events, strict=True) if times.size]
        return float(found.t[-1]), found.sol, met[0] if met else None


def pieced(begin_m: Array, pieces: Sequence[tuple[float, Solution]]) -> Solution:
    """Return positions (3, n) of solutions one after another, each from its own start; before the first `begin_m`."""
    starts = np.array([start for start, _ in pieces])

    def position(time_s: Array) -> Array:
        out = np.repeat(begin_m[:, None], time_s.size, axis=1)
        piece = np.searchsorted(starts, time_s, side="right") - 1
        for number in np.unique(piece[piece >= 0]):
            inside = piece == number
            start, solution = pieces[number]
            out[:, inside] = solution(time_s[inside] - start)[:3]
        return out

    return position
