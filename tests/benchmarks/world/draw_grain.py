"""Draws the experiments of granular physics: beds, shaken plates, boxes, second drops, bad releases, edges."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, Protocol

import numpy as np
from benchmarks.world.bed import Grains, friction_per_m, sinking
from benchmarks.world.contact import Surface, Vibration
from benchmarks.world.course import UP, Course
from benchmarks.world.drop import Body, Floor, flight
from benchmarks.world.hand import MINIMUM_JERK_PEAK, Move, carried
from benchmarks.world.journey import Journey, journey, pieced
from benchmarks.world.profile import Array, Profile, Span

EXPERIMENTS = ("bed", "shaken", "box", "twice", "loose", "edge")
SPREAD_M = 0.02
"""As drops they begin no farther from the axis."""
HIGHEST_M = 0.26

Generator = np.random.Generator


class Draws(Protocol):
    """Values by name, each from a generator of its own."""

    def rng(self, name: str) -> Generator:
        """Return the generator of a name."""

    def __call__(self, name: str, draw: Callable[[Generator], Any]) -> Any:
        """Return what is held, else what is drawn."""


def experiment_of(value: Draws, motion: str, body: Body, floor: Floor) -> Course:
    """Return the course of an experiment; `floor` says how the floor is, where the course falls on one."""
    draws = {"bed": _bed, "shaken": _shaken, "box": _box, "twice": _twice, "loose": _loose, "edge": _edge}
    return draws[motion](value, body, floor)


def _height_m(value: Draws) -> float:
    return float(value("height_m", lambda r: r.uniform(0.06, HIGHEST_M)))


def _direction(rng: Generator) -> Array:
    azimuth = rng.uniform(0.0, 2.0 * np.pi)
    return np.array([np.cos(azimuth), np.sin(azimuth), 0.0])


def _course(went: Journey, lasts_s: float, facts: dict[str, object], **values: Any) -> Course:
    """The course that a journey is; impacts on what is no floor are told beside, in s since it left."""
    if went.sides:
        facts = {**facts, "side_impacts": [round(one.time_s, 4) for one in went.sides]}
    told = {"spread_m": SPREAD_M, "breaks_s": went.breaks_s, **values}
    return Course(went.position, lasts_s, went.impacts, falls=True, facts=facts, **told)


def _surface(floor: Floor, touch_m: Array, **values: Any) -> Surface:
    """The floor there; other `values` are held."""
    return Surface(**{
        "normal": floor.normal, "touch_m": touch_m, "restitution": floor.restitution, "scatter": floor.scatter,
        "kick_m_s": floor.kick_m_s, **values,
    })  # fmt: skip


def _bed(value: Draws, body: Body, floor: Floor) -> Course:
    """Into foam beads, which stop it 1 to 6 cm deep; it may settle by a fraction of a millimetre in the next second."""
    del floor
    rng = value.rng("bed")
    height_m = _height_m(value)
    depth_m = value("depth_m", lambda r: r.uniform(0.01, 0.06))
    drag_m = depth_m * np.exp(rng.uniform(np.log(0.4), np.log(3.0)))
    sideways = rng.uniform(0.0, 0.05) * _direction(rng)
    settle_m, settle_s = (rng.uniform(0.05e-3, 0.5e-3) if rng.random() < 0.5 else 0.0), rng.uniform(0.1, 0.5)
    falls_s, dense = flight(body, Floor(UP, -height_m * UP, 0.0), np.zeros(3), np.zeros(3))
    met, arriving = np.split(dense(falls_s), 2)
    friction = friction_per_m(body, float(-arriving[2]), depth_m, drag_m)
    sunk, stop_s = sinking(body, arriving + sideways, friction, drag_m, settle_m, settle_s)
    index = value("index", lambda r: 1.0 + r.uniform(0.0, 0.02))
    film = value("film", lambda r: r.uniform(0.01, 0.05) if r.random() < 0.3 else 0.0)
    return Course(
        pieced(np.zeros(3), [(0.0, dense), (falls_s, lambda t: met[:, None] + sunk(t))]),
        falls_s + stop_s + rng.uniform(0.5, 1.2),
        falls=True,
        normal=UP,
        facts=_facts(tilt=0.0, depth=1e3 * depth_m, stop_ms=1e3 * stop_s, n=index, film=film, settle_mm=1e3 * settle_m),
        spread_m=SPREAD_M,
        grains=Grains(-height_m - body.radius_m, index, film),
        breaks_s=(float(falls_s), float(falls_s + stop_s)),
    )


def _shaken(value: Draws, body: Body, floor: Floor) -> Course:
    """On a plate of foam that vibrates upright: dropped on it, or thrown up by it as it starts."""
    rng = value.rng("shaken")
    mode = value("mode", lambda r: r.choice(["dropped", "jumping"]))
    # a plate that starts faster throws it less than half a millimetre high
    fastest = 60.0 if mode == "dropped" else 20.0
    frequency = value("shake_hz", lambda r: np.exp(r.uniform(np.log(5.0), np.log(fastest))))
    # no faster than 0.5 m/s: from a faster plate it jumps out of the field of view
    most = min(4.0, np.pi * frequency / body.gravity_m_s2)
    peak = value("shake_g", lambda r: r.uniform(0.3 if mode == "dropped" else 1.2, most))
    amplitude_m = peak * body.gravity_m_s2 / (2.0 * np.pi * frequency) ** 2
    lasts_s = rng.uniform(1.5, 3.0)
    grows_s = rng.uniform(2.0, 6.0) / frequency if mode == "jumping" else 0.0
    phase = rng.uniform(0.0, 2.0 * np.pi) if mode == "dropped" else 0.0
    shake = Vibration(amplitude_m, frequency, phase, grows_s)
    fallen_m = _height_m(value) / 2.0 + amplitude_m if mode == "dropped" else 0.0
    # few kicks: a sphere on a level plate without a dish would leave it
    plate = _surface(floor, -fallen_m * UP, normal=UP, kick_m_s=0.1 * floor.kick_m_s, vibration=shake)
    went = journey(
        value.rng("impacts"), body, [plate], np.zeros(3), np.zeros(3), start_s=0.0, end_s=lasts_s,
        lies_on=plate if mode == "jumping" else None,
    )  # fmt: skip
    return _course(
        went, lasts_s, normal=UP, facts=_facts(mode=mode, tilt=0.0, f=frequency, peak_g=peak, A_mm=1e3 * amplitude_m)
    )


def _box(value: Draws, body: Body, floor: Floor) -> Course:
    """Pushed over the edge of a shelf, or down onto a leaning floor, between one or two upright walls."""
    rng = value.rng("box")
    mode = value("mode", lambda r: r.choice(["pushed", "leaning"]))
    height_m, out = _height_m(value), _direction(rng)
    glass = value("side", lambda r: r.uniform(0.01, 0.04) if r.random() < 0.5 else 0.0)
    count, room_m = int(rng.integers(1, 3)), rng.uniform(0.005, 0.03)
    lean = np.radians(rng.uniform(3.0, 8.0)) if mode == "leaning" else 0.0
    normal = np.sin(lean) * out + np.cos(lean) * UP
    drawn = rng.uniform(0.08, 0.3) if mode == "pushed" else 0.0
    pushed, push_s = _pushed(out, value("speed_m_s", lambda _: drawn), rng.uniform(0.03, 0.08))
    ground = _surface(floor, -height_m * UP, normal=normal, kick_m_s=0.3 * floor.kick_m_s)
    away = pushed(np.array([push_s]))[:, 0]
    bounce = rng.uniform(0.5, 0.9), rng.uniform(0.1, 0.5)
    # walls: across the way it drifts, somewhat aslant
    aslant = rng.uniform(-0.6, 0.6)
    across = np.cos(aslant) * out + np.sin(aslant) * np.cross(UP, out)
    walls = [
        Surface(-sign * across, (across @ away + sign * room_m * far) * across, bounce[0], friction=bounce[1],
                is_floor=False)
        for sign, far in ((1.0, 1.0), (-1.0, rng.uniform(0.3, 2.0)))[:count]
    ]  # fmt: skip
    lasts_s = push_s + np.sqrt(2.0 * height_m / body.gravity_m_s2) + rng.uniform(0.6, 1.0)
    went = journey(
        value.rng("impacts"), body, [ground, *walls], away, (out * (2.0 / push_s)) * np.linalg.norm(away),
        start_s=push_s if away.any() else 0.0, end_s=lasts_s, resistance=rng.uniform(0.002, 0.01),
    )  # fmt: skip
    flown = went.position

    def offset_m(time_s: Array) -> Array:
        return np.where(time_s < push_s, pushed(time_s), flown(time_s)) if away.any() else flown(time_s)

    moved = replace(went, position=offset_m)
    sides = tuple((one.normal, one.touch_m - body.radius_m * one.normal, float(glass)) for one in walls)
    return _course(
        moved, lasts_s, touch_m=ground.touch_m, normal=normal, sides=sides,
        facts=_facts(mode=mode, tilt=np.degrees(lean), walls_beside=count, glass=glass, e_wall=bounce[0]),
    )  # fmt: skip


def _pushed(direction: Array, speed: float, push_s: float) -> tuple[Callable[[Array], Array], float]:
    """Return the way of a gentle push from rest to a speed, and how long it takes."""
    push = Profile((Span(push_s, speed, gentle=True),))
    return lambda t: np.outer(direction, push.way(np.minimum(t, push_s))), push_s


def _twice(value: Draws, body: Body, floor: Floor) -> Course:
    """Dropped, it bounces out and lies; a hand takes it up again to about where it was and lets it fall once more."""
    rng = value.rng("twice")
    height_m = _height_m(value)
    ground = _surface(floor, -height_m * UP, normal=UP, kick_m_s=0.3 * floor.kick_m_s)
    resistance = rng.uniform(0.005, 0.02)
    impacts_rng = value.rng("impacts")
    first = journey(
        impacts_rng, body, [ground], np.zeros(3), np.zeros(3), start_s=0.0, end_s=30.0, resistance=resistance
    )
    lies_s = (first.lies_s or 5.0) + rng.uniform(1.0, 3.0)
    lies_m = first.position(np.array([lies_s]))[:, 0]
    to = np.append(rng.normal(0.0, 0.002, 2), rng.normal(0.0, 0.002))
    aside = rng.uniform(0.01, 0.04) * _direction(rng)
    lift_s = max(rng.uniform(0.8, 2.0), MINIMUM_JERK_PEAK * height_m / 0.5)
    moves = [Move(0.0, lift_s, to + aside - lies_m), Move(0.8 * lift_s, rng.uniform(0.5, 1.0), -aside)]
    holds_s = moves[-1].end_s + rng.uniform(0.8, 2.0)
    trembling_m = value("tremor_m", lambda r: np.exp(r.uniform(np.log(3e-5), np.log(2e-4))))
    hand = carried(moves, trembling_m, value.rng("tremor"), put_down_s=holds_s)
    again_s = lies_s + holds_s + rng.uniform(0.0, 0.3)
    second = journey(
        impacts_rng, body, [ground], to, np.zeros(3), start_s=again_s, end_s=again_s + 30.0, resistance=resistance
    )
    lasts_s = (second.lies_s or again_s + 3.0) + rng.uniform(0.5, 2.0)
    position = pieced(
        np.zeros(3),
        [
            (0.0, first.position),
            (lies_s, lambda t: lies_m[:, None] + hand(t)),
            (again_s, lambda t: second.position(t + again_s)),
        ],
    )
    breaks_s = (*(one for one in first.breaks_s if one < lies_s), lies_s, *second.breaks_s)
    went = Journey(position, first.impacts + second.impacts, (), second.lies_s, breaks_s)
    facts = _facts(tilt=0.0, height=height_m, again_s=again_s, tremor_mm=1e3 * trembling_m)
    return _course(went, lasts_s, touch_m=ground.touch_m, normal=UP, facts=facts)


def _loose(value: Draws, body: Body, floor: Floor) -> Course:
    """Let go badly: it swings, slides or slips 1 to 3 mm before, or a magnet lets it go by and by."""
    rng = value.rng("loose")
    mode = value("mode", lambda r: r.choice(["swings", "slides", "slips", "magnet"]))
    height_m, lasts_s, way_m = _height_m(value), rng.uniform(0.1, 0.3), rng.uniform(0.001, 0.003)
    aside = _direction(rng)
    if mode == "magnet":
        lasts_s = rng.uniform(0.005, 0.03)
        begun, speed = _let_go(body, lasts_s, rng.uniform(0.0, 0.2) * aside)
    elif mode == "swings":
        begun, speed = _swung(way_m * aside, rng.uniform(0.08, 0.5), lasts_s, body)
    else:
        # gentle: the mean of s^2 (3 - 2 s) is a half
        along = -UP if mode == "slips" else aside
        begun, speed = _pushed(along, 2.0 * way_m / lasts_s, lasts_s)[0], 2.0 * way_m / lasts_s * along
    released = begun(np.array([lasts_s]))[:, 0]
    ground = _surface(floor, -height_m * UP)
    went = journey(
        value.rng("impacts"), body, [ground], released, speed, start_s=lasts_s, end_s=lasts_s + 0.9, resistance=0.005
    )
    position = pieced(np.zeros(3), [(0.0, begun), (lasts_s, lambda t: went.position(t + lasts_s))])
    moved = Journey(position, went.impacts, (), went.lies_s, (lasts_s, *went.breaks_s))
    return _course(
        moved, lasts_s + 0.9, touch_m=ground.touch_m, normal=floor.normal,
        facts=_facts(mode=mode, ms=1e3 * lasts_s, way_mm=1e3 * float(np.linalg.norm(released))),
    )  # fmt: skip


def _let_go(body: Body, lasts_s: float, drawn_g: Array) -> tuple[Callable[[Array], Array], Array]:
    """A magnet whose field dies: the acceleration grows to g as s^2 (3 - 2 s), and draws aside by what it has left."""

    def begun(time_s: Array) -> Array:
        s = np.clip(time_s / lasts_s, 0.0, 1.0)
        # twice the integral of s^2 (3 - 2 s), and of s (1 - s)
        fallen, drawn = s**4 / 4.0 - s**5 / 10.0, s**3 / 6.0 - s**4 / 12.0
        return body.acceleration_m_s2 * lasts_s**2 * (np.outer(drawn_g, drawn) - np.outer(UP, fallen))

    return begun, body.acceleration_m_s2 * lasts_s * (drawn_g / 6.0 - UP / 2.0)


def _swung(by_m: Array, length_m: float, lasts_s: float, body: Body) -> tuple[Callable[[Array], Array], Array]:
    """A thread whose upper end is moved by a hand, and cut: s^3 of half a swing's sine, lifted as the thread turns."""
    rate = np.sqrt(body.gravity_m_s2 / length_m)

    def angle(time_s: Array) -> Array:
        # it starts from rest, with no acceleration either: t - sin(w t) / w
        turned = rate * np.clip(time_s, 0.0, lasts_s)
        return turned - np.sin(turned)

    most = float(angle(np.array([lasts_s]))[0])
    size = float(np.linalg.norm(by_m))

    def begun(time_s: Array) -> Array:
        aside = size * angle(time_s) / most
        lifted = length_m - np.sqrt(length_m**2 - aside**2)
        return np.outer(by_m / size, aside) + np.outer(UP, lifted)

    speed = size * rate * (1.0 - np.cos(rate * lasts_s)) / most
    rise = speed * size / np.sqrt(length_m**2 - size**2)
    return begun, speed * by_m / size + rise * UP


def _edge(value: Draws, body: Body, floor: Floor) -> Course:
    """It bounces along a block of foam, over its end, and on the table 2 to 10 cm below."""
    rng = value.rng("edge")
    height_m = min(_height_m(value), 0.2)
    step_m = value("step_m", lambda r: r.uniform(0.02, 0.1))
    out = _direction(rng)
    pushed, push_s = _pushed(out, rng.uniform(0.05, 0.14), rng.uniform(0.03, 0.08))
    away = pushed(np.array([push_s]))[:, 0]
    velocity = out * 2.0 / push_s * np.linalg.norm(away)
    lasts_s = push_s + np.sqrt(2.0 * (height_m + step_m) / body.gravity_m_s2) + rng.uniform(0.8, 1.2)
    block, table = (
        _surface(floor, -down * UP, normal=UP, kick_m_s=0.3 * floor.kick_m_s, restitution=max(floor.restitution, 0.6))
        for down in (height_m, height_m + step_m)
    )

    def gone(*surfaces: Surface) -> Journey:
        return journey(
            value.rng("impacts"), body, surfaces, away, velocity, start_s=push_s, end_s=lasts_s, resistance=0.005
        )

    endless = gone(block).impacts
    count = min(value("bounces", lambda r: int(r.integers(1, 4))), len(endless) - 1)
    # it goes over the end in the flight after so many bounces, where it clears the corner if it can
    times = [one.time_s for one in endless[count - 1 : count + 1]]
    last, following = out @ gone(block).position(np.array(times))
    for share in (0.5, 0.4, 0.3, 0.2, 0.1, 0.05):
        end = (out, float(last + share * (following - last)))
        went = gone(Surface(**{**vars(block), "end": end}), table)
        if _clears(went, body, times[0], end, block.touch_m[2]):
            break
    flown = went.position

    def offset_m(time_s: Array) -> Array:
        return np.where(time_s < push_s, pushed(time_s), flown(time_s))

    on_block = sum(one.time_s < times[1] and offset_m(np.array([one.time_s]))[2, 0] > -height_m - 0.01
                   for one in went.impacts)  # fmt: skip
    return _course(
        replace(went, position=offset_m), lasts_s, touch_m=table.touch_m, normal=UP,
        facts=_facts(tilt=0.0, height=height_m, step=step_m, on_block=int(on_block)),
    )  # fmt: skip


def _clears(went: Journey, body: Body, since_s: float, end: tuple[Array, float], top_m: float) -> bool:
    """Return whether the sphere never touches the block's corner or its side; heights are of the touching centre."""
    places = went.position(np.linspace(since_s, since_s + 0.5, 2000))
    beyond, above = end[0] @ places - end[1], places[2] - (top_m - body.radius_m)
    near = np.hypot(beyond, np.maximum(above, 0.0))
    return bool((near[(beyond > 0.0)] > body.radius_m - 1e-6).all())


def _facts(**facts: object) -> dict[str, object]:
    return {key: round(float(one), 4) if isinstance(one, float) else str(one) for key, one in facts.items()}
