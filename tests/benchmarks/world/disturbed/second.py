"""What moves because of the drop: a second sphere, the clamp that fell too, the block that was hit."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from benchmarks.world.disturbance import Array, Complex, Disturbance
from benchmarks.world.disturbed.reflector import Reflector, direction, minimum_jerk, shares_of
from benchmarks.world.disturbed.strength import Case
from benchmarks.world.drop import Drop, Floor, fall
from benchmarks.world.room import Room
from benchmarks.world.sphere import Sphere

UP = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True)
class SecondSphere(Disturbance):
    """Another sphere in the same room; waves between the two are not counted.

    `units` is the first one's echo at the centre in each receiver, complex with the local oscillator's phase.
    """

    room: Room
    drop: Drop
    units: Complex

    def echo(self, receiver: int, time_s: Array, place_m: Array, echo: Complex) -> Complex:
        """Add its own, by all ways that the first one's takes."""
        del place_m
        return echo + self.room.received(receiver, self.drop.position(time_s)) / self.units[receiver]


def second(case: Case, variant: str) -> tuple[Disturbance, ...]:
    """Return a second `sphere` that falls, a `clamp` that falls, or the `block` on which the sphere falls."""
    return {"sphere": _sphere, "clamp": _clamp, "block": _block}[variant](case)


def _floor(case: Case, higher_m: float, restitution: float) -> Floor:
    """Return the sphere's floor for a body whose centre is higher above it when it touches."""
    scene = case.scene
    normals = [one.normal for one in scene.room.mirrors[:1] if one.normal @ UP > 0.9]
    normal = normals[0] if normals else UP
    touch = scene.drop.position(np.array([scene.drop.impacts[0].time_s]))[:, 0]
    return Floor(normal, touch + higher_m * normal, restitution, 0.02, 0.02)


def _falls(case: Case, floor: Floor, beside_m: Array) -> Drop:
    drop = case.scene.drop
    late_s = case.rng.uniform(-0.05, 0.1)
    begin = case.release_m + beside_m
    return fall(
        case.rng, case.scene.body, floor, begin, start_s=drop.start_s + late_s, duration_s=drop.duration_s
    )  # fmt: skip


def _sphere(case: Case) -> tuple[Disturbance, ...]:
    scene, rng = case.scene, case.rng
    radius_m = case.between(0.4, 1.0) * scene.room.sphere.radius_m
    beside = rng.uniform(0.02, 0.08) * direction(rng, -10.0, 10.0)
    floor = _floor(case, radius_m - scene.room.sphere.radius_m, rng.uniform(0.4, 0.9))
    room = replace(scene.room, sphere=Sphere(radius_m, scene.room.sphere.wavenumber_rad_m))
    sizes = [abs(scene.room.direct(number, np.zeros((3, 1)))[0]) for number in range(case.n_receivers)]
    units = np.array(sizes) * np.exp(-1j * np.array(scene.phases_rad))
    return (SecondSphere(room, _falls(case, floor, beside), units),)


def _clamp(case: Case) -> tuple[Disturbance, ...]:
    rng = case.rng
    above = rng.uniform(0.02, 0.06) * direction(rng, 0.0, 60.0)
    drop = _falls(case, _floor(case, 0.0, rng.uniform(0.2, 0.5)), above)
    place = drop.position(np.zeros(1))[:, 0]
    return (Reflector(case.scene.room, drop.position, shares_of(case, case.between(0.03, 0.3)), place),)


def _block(case: Case) -> tuple[Disturbance, ...]:
    """Its echo is as large as the sphere's or half of it; it slides along the floor by 0.1 to 2 mm at the first
    impact and by less at the others, so that the floor that the sphere meets stays where it is."""
    scene, rng = case.scene, case.rng
    impacts, lasts_s = scene.drop.impacts, rng.uniform(0.002, 0.01)
    touch = scene.drop.position(np.array([impacts[0].time_s]))[:, 0] - scene.room.sphere.radius_m * UP
    spot = touch + rng.uniform(-0.02, 0.02, 3) * [1.0, 1.0, 0.0]
    first_m, ways = case.between(1e-4, 2e-3), [direction(rng, 0.0, 0.0) for _ in impacts]
    steps_m = [
        first_m * (one.before_m_s / impacts[0].before_m_s) ** 2 * way for one, way in zip(impacts, ways, strict=True)
    ]
    shares = shares_of(case, rng.uniform(0.5, 1.0))

    def place(time_s: Array) -> Array:
        out = np.repeat(spot[:, None], time_s.size, axis=1)
        for one, step in zip(impacts, steps_m, strict=True):
            out += np.outer(step, minimum_jerk((time_s - one.time_s) / lasts_s))
        return out

    return (Reflector(scene.room, place, shares, spot),)
