"""Draws the motions other than drops, and where in the field of view they begin."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

import numpy as np
from benchmarks.world.course import UP, Course, along, circle, downhill
from benchmarks.world.drop import ROLLING, Body, Drop, Floor
from benchmarks.world.hand import MINIMUM_JERK_PEAK, Move, carried
from benchmarks.world.pendulum import swing
from benchmarks.world.profile import Array, Span, held, joined, trapezoid
from benchmarks.world.throw import thrown

COURSES = ("circle", "pendulum", "hand", "throw", "incline", "stage", "rail")
FIELD_M = 0.15
"""The field of view reaches so far from the centre along each axis."""
SIZES_M = (0.05, 0.28)
"""Diameter of a circle, width of a swing, height of a throw, way of stage and board, edge of a hand's box."""
FASTEST_M_S = 1.5
"""Of what a motor or a hand moves; what is thrown 28 cm high goes with 2.3 m/s, as a drop does."""
LONGEST_S = 5.0

Generator = np.random.Generator


class Draws(Protocol):
    """Values by name, each from a generator of its own."""

    def rng(self, name: str) -> Generator:
        """Return the generator of a name."""

    def __call__(self, name: str, draw: Callable[[Generator], Any]) -> Any:
        """Return what is held, else what is drawn."""


def course_of(value: Draws, motion: str, body: Body, floor: Floor) -> Course:
    """Return the course of a motion; `floor` says how the floor is, where the course falls on one."""
    size_m = value("size_m", lambda r: r.uniform(*SIZES_M))
    if motion == "pendulum":
        return _pendulum(value, body, size_m)
    if motion == "throw":
        return _throw(value, body, floor, size_m)
    if motion == "incline":
        return _incline(value, body, size_m)
    return {"circle": _circle, "hand": _hand, "stage": _stage, "rail": _rail}[motion](value, size_m)


def placed(value: Draws, course: Course, rest_s: float) -> tuple[Drop, Array]:
    """Return the motion on the record's clock and its start place: drawn such that it stays in the field of view."""
    places = course.places_m()
    low, high = -FIELD_M - places.min(axis=1), FIELD_M - places.max(axis=1)
    low, high = np.minimum(low, (low + high) / 2.0), np.maximum(high, (low + high) / 2.0)
    if course.spread_m is not None:
        low[:2], high[:2] = -course.spread_m, course.spread_m
    start = np.array(value("start_m", lambda r: r.uniform(low, high)), dtype=np.float64)
    impacts = tuple(type(one)(one.time_s + rest_s, one.before_m_s, one.after_m_s) for one in course.impacts)

    def position(time_s: Array) -> Array:
        return start[:, None] + course.offset_m(time_s - rest_s) * (time_s > rest_s)

    breaks_s = (rest_s, *(rest_s + one for one in course.breaks_s))
    return Drop(position, rest_s, rest_s + course.lasts_s, impacts, breaks_s), start


def _circle(value: Draws, size_m: float) -> Course:
    """A rotating arm: level or not, soon at an even rate or faster all the time, stopped at the end or not."""
    rng = value.rng("circle")
    mode = value("mode", lambda r: r.choice(["steady", "accelerating"]))
    lean = np.radians(value("lean_deg", lambda r: r.uniform(0.0, 80.0) if r.random() < 0.5 else 0.0))
    azimuth = rng.uniform(0.0, 2.0 * np.pi)
    normal = np.array([np.sin(lean) * np.cos(azimuth), np.sin(lean) * np.sin(azimuth), np.cos(lean)])
    period_s = np.exp(rng.uniform(np.log(0.6), np.log(4.0)))
    drawn = min(np.pi * size_m / period_s, FASTEST_M_S)
    rate = 2.0 * value("speed_m_s", lambda _: drawn) / size_m
    ramp_s = rng.uniform(0.2, 0.8)
    even_s = min(rng.uniform(1.0, 3.0) * 2.0 * np.pi / rate, LONGEST_S - 2.0 * ramp_s)
    speeding = (Span(ramp_s, rate, gentle=True), held(even_s, rate)) if mode == "steady" else (Span(even_s, rate),)
    stops = value("stops", lambda r: bool(r.random() < 0.5))
    profile = joined(speeding, (Span(ramp_s, 0.0, gentle=mode == "steady"),) if stops else ())
    offset_m = circle(profile, size_m / 2.0, normal * rng.choice([-1.0, 1.0]), rng.uniform(0.0, 2.0 * np.pi))
    lasts_s = profile.lasts_s + (rng.uniform(0.2, 0.5) if stops else 0.0)
    turns = profile.way(np.array([lasts_s]))[0] / (2.0 * np.pi)
    return _told(offset_m, lasts_s, mode=mode, size=size_m, v=rate * size_m / 2.0, lean=np.degrees(lean), turns=turns)


def _pendulum(value: Draws, body: Body, size_m: float) -> Course:
    rng = value.rng("pendulum")
    mode = value("mode", lambda r: r.choice(["plane", "plane", "conical", "pushed"]))
    half_m = size_m / 2.0
    length_m = np.exp(rng.uniform(np.log(max(0.12, half_m / 0.77)), np.log(1.0)))
    side = half_m if mode != "pushed" else 0.0
    azimuth = rng.uniform(0.0, 2.0 * np.pi)
    out, around = (np.array([np.cos(a), np.sin(a), 0.0]) for a in (azimuth, azimuth + np.pi / 2.0))
    hang_m = side * out - np.sqrt(length_m**2 - side**2) * UP
    depth_m = length_m - np.sqrt(length_m**2 - half_m**2)
    pushes = {
        "plane": 0.0,
        "pushed": np.sqrt(2.0 * body.acceleration_m_s2 * depth_m),
        # what it needs for a level circle, times a share: an ellipse
        "conical": half_m * np.sqrt(body.acceleration_m_s2 / np.sqrt(length_m**2 - half_m**2)) * rng.uniform(0.3, 1.0),
    }
    lasts_s = rng.uniform(1.5, 4.0)
    offset_m = swing(
        body, hang_m, push_m_s=pushes[mode] * around, push_s=rng.uniform(0.05, 0.12), decay_s=rng.uniform(3.0, 30.0),
        lasts_s=lasts_s,
    )  # fmt: skip
    return _told(offset_m, lasts_s, mode=mode, size=size_m, thread=length_m)


def _hand(value: Draws, size_m: float) -> Course:
    rng = value.rng("hand")
    flat = rng.uniform(0.3, 1.0)
    fastest = value("speed_m_s", lambda r: r.uniform(0.3, 1.2))
    place, moves, next_s = np.zeros(3), [], 0.0
    corner = -rng.uniform(0.0, 1.0, 3)  # where in the box it begins
    while len(moves) < 3 or (next_s < LONGEST_S - 1.5 and len(moves) < 8):
        to = size_m * (corner + rng.uniform(0.0, 1.0, 3)) * [1.0, 1.0, flat]
        lasts_s = max(rng.uniform(0.35, 0.9), MINIMUM_JERK_PEAK * float(np.linalg.norm(to - place)) / fastest)
        moves.append(Move(next_s, lasts_s, to - place))
        holds, pause, blend = rng.random() < 0.35, rng.uniform(0.1, 0.4), rng.uniform(0.0, 0.4)
        next_s = moves[-1].end_s + (pause if holds else -blend * lasts_s)
        place = to
    put_down = rng.random() < 0.5
    end_s = moves[-1].end_s
    trembling_m = value("tremor_m", lambda r: np.exp(r.uniform(np.log(3e-5), np.log(3e-4))))
    offset_m = carried(moves, trembling_m, value.rng("tremor"), put_down_s=end_s if put_down else np.inf)
    lasts_s = end_s + (rng.uniform(0.2, 0.5) if put_down else 0.1)
    return _told(offset_m, lasts_s, size=size_m, v=fastest, tremor_mm=1e3 * trembling_m)


def _throw(value: Draws, body: Body, floor: Floor, size_m: float) -> Course:
    rng = value.rng("throw")
    mode = value("mode", lambda r: r.choice(["caught", "bouncing"]))
    lean, azimuth = np.radians(rng.uniform(0.0, 8.0)), rng.uniform(0.0, 2.0 * np.pi)
    direction = np.array([np.sin(lean) * np.cos(azimuth), np.sin(lean) * np.sin(azimuth), np.cos(lean)])
    pushed_m = rng.uniform(0.15, 0.4) * size_m
    speed = np.sqrt(2.0 * body.acceleration_m_s2 * (size_m - pushed_m))
    below_m = rng.uniform(0.005, 0.06)
    ground = Floor(floor.normal, -below_m * UP, floor.restitution, floor.scatter, floor.kick_m_s)
    flies_s = 2.0 * speed / body.acceleration_m_s2
    push_s = 2.0 * pushed_m / speed
    course = thrown(
        value.rng("impacts"), body, speed_m_s=speed * direction, push_s=push_s,
        floor=ground if mode == "bouncing" else None, caught_within_m=rng.uniform(0.3, 0.9) * pushed_m,
        lasts_s=push_s + flies_s + rng.uniform(0.4, 0.8),
    )  # fmt: skip
    return Course(
        course.offset_m, course.lasts_s, course.impacts, falls=True, touch_m=course.touch_m, normal=course.normal,
        facts=_facts(mode=mode, size=size_m, v=speed), breaks_s=course.breaks_s,
    )  # fmt: skip


def _incline(value: Draws, body: Body, size_m: float) -> Course:
    """A board that leans: let go and rolling down, or pushed up and coming back; foam ends it or the record does.

    Held alone: rolling down against a `stopper` and back up, by turns.
    """
    rng = value.rng("incline")
    mode = value("mode", lambda r: r.choice(["down", "down", "up"]))
    slope = np.radians(value("lean_deg", lambda r: r.uniform(2.0, 15.0)))
    down, normal = downhill(slope, rng.uniform(0.0, 2.0 * np.pi))
    friction = rng.uniform(0.001, 0.005)
    falling, climbing = (
        ROLLING * body.acceleration_m_s2 * (np.sin(slope) + s * friction * np.cos(slope)) for s in (-1, 1)
    )
    push_s, foam_m = rng.uniform(0.1, 0.2), rng.uniform(0.005, 0.02)
    start: tuple[Span, ...] = ()
    if mode == "up":
        # the push goes on over push_s * v / 2, then v^2 / (2 a) more
        up = climbing * (np.sqrt((push_s / 2.0) ** 2 + 2.0 * size_m / climbing) - push_s / 2.0)
        start = (Span(push_s, -up, gentle=True), Span(up / climbing, 0.0))
    speed = np.sqrt(2.0 * falling * size_m)
    rolling = (Span(speed / falling, speed),)
    ends = value("stops", lambda r: bool(r.random() < 0.6))
    if mode == "stopper":
        shares = value("e", lambda r: r.uniform(0.3, 0.7)) ** np.arange(1, 4)
        # thrown back within no time, and up and down again under the same acceleration
        rolling += tuple(
            one for v in speed * shares for one in (Span(1e-9, -v), Span(2.0 * v / falling, v))
        )  # fmt: skip
    profile = joined(start, rolling, (Span(2.0 * foam_m / speed, 0.0),) if ends else ())
    lasts_s = profile.lasts_s + (rng.uniform(0.2, 0.5) if ends else 0.0)
    told = _told(along(down, profile), lasts_s, mode=mode, size=size_m, v=speed, slope=np.degrees(slope))
    breaks_s = tuple(np.cumsum([one.lasts_s for one in profile.spans]).tolist())
    return Course(told.offset_m, lasts_s, touch_m=np.zeros(3), normal=normal, facts=told.facts, breaks_s=breaks_s)


def _stage(value: Draws, size_m: float) -> Course:
    """A linear stage, there and back: level, upright or oblique."""
    rng = value.rng("stage")
    rise = np.radians(value("lean_deg", lambda r: [0.0, 90.0, r.uniform(0.0, 90.0)][r.integers(3)]))
    azimuth = rng.uniform(0.0, 2.0 * np.pi)
    direction = np.array([np.cos(rise) * np.cos(azimuth), np.cos(rise) * np.sin(azimuth), np.sin(rise)])
    length_m = size_m * rng.choice([-1.0, 1.0])
    times = int(rng.integers(1, 3))
    slowest = 2.5 * times * size_m / LONGEST_S
    speed = value("speed_m_s", lambda r: np.exp(r.uniform(np.log(slowest), np.log(1.0))))
    acceleration, waits_s = np.exp(rng.uniform(np.log(1.0), np.log(10.0))), rng.uniform(0.1, 0.4)
    there, back = (trapezoid(sign * length_m, speed, acceleration) for sign in (1, -1))
    wait = (held(waits_s, 0.0),)
    profile = joined(*((there, wait, back, wait) * times))
    return _told(along(direction, profile), profile.lasts_s + 0.1, size=size_m, v=speed, rise=np.degrees(rise))


def _rail(value: Draws, size_m: float) -> Course:
    """A carriage on a level rail: pushed, slowed by friction, turned back by rubber at the ends, until it stands."""
    rng = value.rng("rail")
    azimuth = rng.uniform(0.0, 2.0 * np.pi)
    direction = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
    speed = value("speed_m_s", lambda r: np.exp(r.uniform(np.log(0.2), np.log(1.0))))
    slowing, share = rng.uniform(0.02, 0.15), rng.uniform(0.4, 0.8)
    push_s, turn_s = min(rng.uniform(0.1, 0.3), size_m / speed), rng.uniform(0.01, 0.03)
    spans = [Span(push_s, speed, gentle=True)]
    left_m, sign, fast = size_m - 0.5 * speed * push_s, 1.0, speed
    while True:
        end = np.sqrt(max(fast**2 - 2.0 * slowing * left_m, 0.0))
        spans.append(Span((fast - end) / slowing, sign * end))
        if end < 0.05 or sum(one.lasts_s for one in spans) > LONGEST_S - 1.5:
            break
        # rubber takes the speed and gives a share of it back within its length
        sign, fast, left_m = -sign, share * end, size_m
        spans.append(Span(turn_s, sign * fast))
    # the last of the speed goes into the rubber
    spans.append(Span(turn_s, 0.0))
    profile = joined(spans)
    return _told(along(direction, profile), profile.lasts_s + rng.uniform(0.2, 0.4), size=size_m, v=speed)


def _told(offset_m: Callable[[Array], Array], lasts_s: float, **facts: object) -> Course:
    return Course(offset_m, lasts_s, facts=_facts(**facts))


def _facts(**facts: object) -> dict[str, object]:
    return {key: round(float(one), 3) if isinstance(one, float) else str(one) for key, one in facts.items()}
