"""What a sphere meets: planes that stand or vibrate, and what an impact makes of its speed and of its spin."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from benchmarks.world.drop import Impact
from benchmarks.world.profile import Array

SPIN_SHARE = 2.0 / 7.0
"""Of the slip, what an impact takes from the speed of a solid sphere that comes to roll; the rest goes to the spin."""


@dataclass(frozen=True)
class Vibration:
    """A plate's way along its normal: amplitude times sin(2 pi f t + phase), growing from none within `grows_s`."""

    amplitude_m: float
    frequency_hz: float
    phase_rad: float = 0.0
    grows_s: float = 0.0

    def moved(self, time_s: Array | float, derivative: int = 0) -> Array:
        """Return height, speed or acceleration (derivative 0 to 2) at times."""
        rate = 2.0 * np.pi * self.frequency_hz
        angle = rate * np.asarray(time_s) + self.phase_rad
        # 10 s^3 - 15 s^4 + 6 s^5: even the acceleration begins and ends without a jump
        s = np.clip(np.asarray(time_s) / self.grows_s, 0.0, 1.0) if self.grows_s else np.ones_like(angle)
        per_s = 1.0 / self.grows_s if self.grows_s else 0.0
        grown = s**3 * (10.0 - 15.0 * s + 6.0 * s**2)
        growth = 30.0 * s**2 * (1.0 - s) ** 2 * per_s
        bend = 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) * per_s**2
        turns = (
            grown * np.sin(angle),
            growth * np.sin(angle) + grown * rate * np.cos(angle),
            bend * np.sin(angle) + 2.0 * growth * rate * np.cos(angle) - grown * rate**2 * np.sin(angle),
        )
        return self.amplitude_m * turns[derivative]


STILL = Vibration(0.0, 1.0)


@dataclass(frozen=True)
class Surface:
    """A plane that turns the sphere back; places are of the sphere's centre when it touches.

    Attributes
    ----------
    normal, touch_m
        Unit vector (3,) towards the sphere and a place (3,) of the centre that touches, of a plate in the middle.
    restitution, scatter
        Of the speed along the normal relative to the plane, and its relative standard deviation from impact to impact.
    kick_m_s
        Standard deviation of the speed along x and along y that an impact adds.
    friction
        Coulomb's: the impulse along the plane is no more than this share of that along the normal.
    vibration
        Along the normal.
    is_floor
        Whether its impacts have the coefficient that is asked for; a wall's have not.
    end
        Unit vector (3,) along the plane and how far from the origin the plane ends in that direction; None: nowhere.
    """

    normal: Array
    touch_m: Array
    restitution: float
    scatter: float = 0.01
    kick_m_s: float = 0.0
    friction: float = 1.0
    vibration: Vibration = STILL
    is_floor: bool = True
    end: tuple[Array, float] | None = None

    def gap_m(self, time_s: float, place: Array) -> float:
        """Return how far the centre (3,) is from touching, as if the plane had no end."""
        return float(self.normal @ (place - self.touch_m) - self.vibration.moved(time_s))

    def holds(self, place: Array) -> bool:
        """Return whether the plane goes as far as a place (3,)."""
        return self.end is None or float(self.end[0] @ place) <= self.end[1]

    def approach_m_s(self, time_s: float, velocity: Array) -> float:
        """Return the speed towards the plane."""
        return float(self.vibration.moved(time_s, 1) - self.normal @ velocity)

    def level(self, vector: Array) -> Array:
        """Return the part of a vector (3,) along the plane."""
        return vector - self.normal * (self.normal @ vector)


def rebound(
    rng: np.random.Generator, surface: Surface, radius_m: float, time_s: float, velocity: Array, spin: Array
) -> tuple[Impact, Array, Array]:
    """Return the impact, and velocity and spin (rad/s) after it.

    Along the plane friction takes the slip of the touching point, or as much as it can: the impulse J over the mass
    changes the speed by J and the spin by -(5 / 2a) n x J, so that J = -2/7 slip lets it roll.
    """
    normal = surface.normal
    before = surface.approach_m_s(time_s, velocity)
    after = before * surface.restitution * (1.0 + surface.scatter * rng.standard_normal())
    along = surface.level(velocity)
    push = -SPIN_SHARE * (along - radius_m * np.cross(spin, normal))
    size, most = float(np.linalg.norm(push)), surface.friction * (before + after)
    push = push * min(1.0, most / size) if size > 0.0 else push
    kick = surface.level(surface.kick_m_s * np.append(rng.standard_normal(2), 0.0))
    leaving = after + float(surface.vibration.moved(time_s, 1))
    spinning = spin - 2.5 / radius_m * np.cross(normal, push)
    return Impact(time_s, before, after), along + push + kick + leaving * normal, spinning
