"""A bed of loose grains: how it stops a sphere that falls into it, and what its optical thickness does to a wave."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from benchmarks.world.drop import Body
from benchmarks.world.mirror import Mirror
from benchmarks.world.profile import Array
from scipy.integrate import solve_ivp

_SLOWEST_M_S = 1e-5
_FOREVER_S = 5.0


@dataclass(frozen=True)
class Grains:
    """A half-space of transparent grains below a level surface.

    Attributes
    ----------
    surface_z_m
        Height of the surface, on the clock of whatever holds it: of a course from where the sphere rests.
    index
        Refractive index over that of air.
    film
        Share of the field that something thin on the surface sends back; 0: only what the index does.
    """

    surface_z_m: float
    index: float
    film: float = 0.0


@dataclass(frozen=True)
class Bed:
    """Grains in a room.

    Attributes
    ----------
    grains
        With the surface's z in the room.
    surface
        The mirror that the surface is; it mirrors for a sphere above it alone.
    """

    grains: Grains
    surface: Mirror

    def longer_m(self, image_m: Array, position_m: Array, radius_m: float, bottom_z_m: float | None) -> Array:
        """Return by how much the way from an antenna or its image to the sphere is optically longer, shape (n,).

        The way is straight: what Fermat's bent way saves is of second order in index - 1. A wave from above meets the
        sphere at its top; one that comes over a mirror in the bed goes through it twice, and to the sphere's centre.
        """
        z = position_m[2]
        away = position_m - image_m[:, None]
        rise = np.maximum(np.abs(away[2]), 1e-9)
        surface = self.grains.surface_z_m
        if bottom_z_m is None or bottom_z_m >= surface or image_m[2] > bottom_z_m:
            inside = np.maximum(surface - radius_m - z, 0.0)
        else:
            inside = np.minimum(z, surface) - (2.0 * bottom_z_m - surface)
        return (self.grains.index - 1.0) * inside * np.linalg.norm(away, axis=0) / rise

    def above(self, position_m: Array, radius_m: float) -> Array:
        """Return 1 for a sphere above the surface, 0 for one below and the share of it that is above between."""
        return np.clip((position_m[2] - self.grains.surface_z_m + radius_m) / (2.0 * radius_m), 0.0, 1.0)


def friction_per_m(body: Body, speed_m_s: float, depth_m: float, drag_m: float) -> float:
    """Return k / m, in 1/s^2, of the bed that stops the sphere at this depth.

    With drag_m = d1 and a = 2 / d1 the speed of m z'' = m g - m z'^2 / d1 - k z is, from the equation's energy,
    v^2 = v0^2 E + (2 g / a) (1 - E) - 2 (k / m) (z / a - (1 - E) / a^2), E = exp(-a z).
    """
    a = 2.0 / drag_m
    left = np.exp(-a * depth_m)
    driven = speed_m_s**2 * left + 2.0 * body.acceleration_m_s2 / a * (1.0 - left)
    return float(driven / (2.0 * (depth_m / a - (1.0 - left) / a**2)))


def sinking(
    body: Body, speed_m_s: Array, friction: float, drag_m: float, settle_m: float, settle_s: float
) -> tuple[Callable[[Array], Array], float]:
    """Return displacements (3, n) at times (n,) since the surface was touched, and when it stops.

    Katsuragi & Durian (Nature Physics 3, 420, 2007): m z'' = m g - m z'^2 / d1 - k |z|, here with drag and friction
    against the speed, whatever its direction. Then it settles by `settle_m`, as 1 - exp(-t / settle_s).

    Parameters
    ----------
    speed_m_s
        As it touches, shape (3,).
    friction, drag_m
        k / m in 1/s^2, and d1.
    """

    def slope(_time: float, state: Array) -> Array:
        speed = state[3:]
        size = float(np.linalg.norm(speed))
        braked = -(size / drag_m + friction * max(-state[2], 0.0) / max(size, _SLOWEST_M_S)) * speed
        return np.concatenate([speed, braked - [0.0, 0.0, body.acceleration_m_s2]])

    def stopping(_time: float, state: Array) -> float:
        return float(-state[5] - _SLOWEST_M_S)

    stopping.terminal = True  # type: ignore[attr-defined]
    found = solve_ivp(
        slope, (0.0, _FOREVER_S), np.concatenate([np.zeros(3), speed_m_s]), "DOP853", dense_output=True, rtol=1e-10,
        atol=1e-13, events=stopping, max_step=1e-3,
    )  # fmt: skip
    stop_s = float(found.t[-1])

    def position(time_s: Array) -> Array:
        out = found.sol(np.clip(time_s, 0.0, stop_s))[:3]
        since = np.maximum(time_s - stop_s, 0.0)
        out[2] -= settle_m * -np.expm1(-since / settle_s)
        return np.asarray(out)

    return position, stop_s
