"""What moves beside the sphere and has nothing to do with it: hand, person, fan, a thread left hanging."""

from __future__ import annotations

import numpy as np
from benchmarks.world.disturbance import Array, Disturbance
from benchmarks.world.disturbed.reflector import Reflector, direction, minimum_jerk, shares_of
from benchmarks.world.disturbed.strength import Case

GRAVITY_M_S2 = 9.81
_TREMBLING_M = 1e-4
_HAND_M = 0.04


def hand(case: Case, variant: str) -> tuple[Disturbance, ...]:
    """Return the hand that let go: it `retreats` after the release, or `comes` near until the release and stays.

    Three points of it move together, and tremble by 0.1 mm at 6 to 12 Hz.
    """
    rng, drop = case.rng, case.scene.drop
    outward = direction(rng, -10.0, 60.0)
    near = case.release_m + rng.uniform(0.1, 0.4) * outward
    away = outward + 0.5 * rng.standard_normal(3)
    step = rng.uniform(0.05, 0.2) * away / np.linalg.norm(away)
    lasts_s, wait_s = rng.uniform(0.3, 0.6), rng.uniform(0.0, 0.05)
    trembling_hz, phase = rng.uniform(6.0, 12.0, 3), rng.uniform(0.0, 2.0 * np.pi, 3)
    parts = []
    for _ in range(3):
        spot = near + rng.uniform(-_HAND_M, _HAND_M, 3)

        def place(time_s: Array, spot: Array = spot) -> Array:
            if variant == "comes":
                share = 1.0 - minimum_jerk((time_s - (drop.start_s - wait_s - lasts_s)) / lasts_s)
            else:
                share = minimum_jerk((time_s - drop.start_s - wait_s) / lasts_s)
            trembling = _TREMBLING_M * np.sin(2.0 * np.pi * np.outer(trembling_hz, time_s) + phase[:, None])
            return np.asarray(spot[:, None] + np.outer(step, share) + trembling)

        parts.append(Reflector(case.scene.room, place, shares_of(case, case.between(0.03, 0.3)) / np.sqrt(3.0), spot))
    return tuple(parts)


def person(case: Case, variant: str) -> tuple[Disturbance, ...]:
    """Return somebody who walks by at 1 to 3 m all the time: a body that sways, and two limbs that swing."""
    del variant
    rng, drop = case.rng, case.scene.drop
    foot, speed = direction(rng, 0.0, 0.0), rng.uniform(0.5, 1.5)
    along = np.array([-foot[1], foot[0], 0.0]) * rng.choice([-1.0, 1.0])
    nearest = rng.uniform(1.0, 3.0) * foot + np.array([0.0, 0.0, rng.uniform(-0.3, 0.5)])
    passes_s, steps_hz, phase = rng.uniform(0.0, drop.duration_s), 0.6 + 0.9 * speed, rng.uniform(0.0, 2.0 * np.pi)
    share = case.between(0.01, 0.3)

    def part(swing_m: float, begin: float, of_it: float, lower_m: float) -> Reflector:
        at = nearest - np.array([0.0, 0.0, lower_m])
        bob_m, sway_m = rng.uniform(0.01, 0.03), rng.uniform(0.01, 0.04)

        def place(time_s: Array) -> Array:
            step = 2.0 * np.pi * 0.5 * steps_hz * time_s + phase
            way = speed * (time_s - passes_s) + swing_m * np.sin(step + begin)
            up = np.outer([0.0, 0.0, bob_m], np.sin(2.0 * step))
            return np.asarray(at[:, None] + np.outer(along, way) + np.outer(foot, sway_m * np.sin(step)) + up)

        return Reflector(case.scene.room, place, shares_of(case, of_it * share), at)

    swing_m = rng.uniform(0.1, 0.3)
    return part(0.0, 0.0, 0.85, 0.0), part(swing_m, 0.0, 0.3, 0.2), part(swing_m, np.pi, 0.3, 0.2)


def fan(case: Case, variant: str) -> tuple[Disturbance, ...]:
    """Return the `blades` of a fan, each of its own size and seen while it is broadside, or a `panel` that they shake.

    The panel moves by 0.05 to 0.5 mm, and swells; 10 to 60 turns a second.
    """
    rng = case.rng
    hub = rng.uniform(0.4, 1.5) * direction(rng, -20.0, 40.0)
    turns_hz, count = rng.uniform(10.0, 60.0), int(rng.integers(3, 8))
    share = case.between(0.01, 0.1)
    if variant == "panel":
        return (_panel(case, hub, turns_hz, share),)
    radius_m, normal = rng.uniform(0.03, 0.15), direction(rng, -90.0, 90.0)
    across = np.cross(normal, np.eye(3)[np.abs(normal).argmin()])
    across /= np.linalg.norm(across)
    beside, broadside = np.cross(normal, across), rng.uniform(0.0, 2.0 * np.pi)
    weights = rng.uniform(0.6, 1.0, count)
    shares = shares_of(case, share)

    def blade(weight: float, begin: float) -> Reflector:
        def angle(time_s: Array) -> Array:
            return np.asarray(2.0 * np.pi * turns_hz * time_s + begin)

        def place(time_s: Array) -> Array:
            around = np.outer(across, np.cos(angle(time_s))) + np.outer(beside, np.sin(angle(time_s)))
            return np.asarray(hub[:, None] + radius_m * around)

        def swell(time_s: Array) -> Array:
            return np.asarray(weight * np.cos(0.5 * (angle(time_s) - broadside)) ** 8)

        return Reflector(case.scene.room, place, shares, hub, swell)

    begins = 2.0 * np.pi * (np.arange(count) + rng.normal(0.0, 0.01, count)) / count
    return tuple(blade(*one) for one in zip(weights, begins, strict=True))


def _panel(case: Case, hub: Array, turns_hz: float, share: float) -> Reflector:
    rng = case.rng
    toward = -hub / np.linalg.norm(hub)
    sizes_m = rng.uniform(5e-5, 5e-4) / np.arange(1, 5)
    phase, beat_hz = rng.uniform(0.0, 2.0 * np.pi, 4), rng.uniform(0.5, 3.0)

    def place(time_s: Array) -> Array:
        tones = np.sin(2.0 * np.pi * turns_hz * np.outer(np.arange(1, 5), time_s) + phase[:, None])
        loud = 1.0 + 0.3 * np.sin(2.0 * np.pi * beat_hz * time_s)
        return np.asarray(hub[:, None] + np.outer(toward, loud * (sizes_m @ tones)))

    def swell(time_s: Array) -> Array:
        return 1.0 + 0.2 * np.sin(2.0 * np.pi * turns_hz * time_s)

    return Reflector(case.scene.room, place, shares_of(case, share), hub, swell)


def swing(case: Case, variant: str) -> tuple[Disturbance, ...]:
    """Return a thread or cable that held the sphere: it swings and dies out after the release.

    Its lower end reflects, and the middle half as much.
    """
    del variant
    rng, drop = case.rng, case.scene.drop
    length_m = rng.uniform(0.05, 0.4)
    end = case.release_m + np.array([0.0, 0.0, rng.uniform(0.005, 0.03)])
    reach_m, side = min(rng.uniform(0.01, 0.1), 0.4 * length_m), direction(rng, 0.0, 0.0)
    rate = np.sqrt(GRAVITY_M_S2 / length_m)
    decay_s, share = rng.uniform(0.5, 3.0), case.between(0.01, 0.1)

    def part(of_length: float, of_it: float) -> Reflector:
        at = end + np.array([0.0, 0.0, (1.0 - of_length) * length_m])

        def place(time_s: Array) -> Array:
            since = np.maximum(time_s - drop.start_s, 0.0)
            # from rest at the place where it held the sphere about a line beside: 1 - cos, braked
            lean = reach_m / length_m * (1.0 - np.cos(rate * since) * np.exp(-since / decay_s))
            moved = np.outer(side, np.sin(lean)) + np.outer([0.0, 0.0, 1.0], 1.0 - np.cos(lean))
            return np.asarray(at[:, None] + of_length * length_m * moved)

        return Reflector(case.scene.room, place, shares_of(case, of_it * share), at)

    return part(1.0, 1.0), part(0.5, 0.5)
