"""A small thing that reflects beside the sphere, wherever it moves: hand, person, fan, thread, clamp, block."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from benchmarks.world.disturbance import Array, Complex, Disturbance
from benchmarks.world.disturbed.strength import Case
from benchmarks.world.room import Room


@dataclass(frozen=True)
class Reflector(Disturbance):
    """One point that scatters alike in all directions, in the antennas' lobes, over the straight ways alone.

    Attributes
    ----------
    room
        Whose antennas light it and get its echo.
    place
        Positions (3, n) at times (n,).
    shares
        Its echo at `at_m` in each receiver, complex, over the sphere's at the centre, shape (n_receivers,).
    at_m
        Shape (3,).
    swell
        What its size is multiplied by at times (n,).
    """

    room: Room
    place: Callable[[Array], Array]
    shares: Complex
    at_m: Array
    swell: Callable[[Array], Array] = np.ones_like

    def echo(self, receiver: int, time_s: Array, place_m: Array, echo: Complex) -> Complex:
        """Add its own: 1 / range and lobe to and fro, the phase by the path."""
        del place_m
        size, path_m = self._seen(receiver, self.place(time_s))
        size_then, path_then_m = self._seen(receiver, self.at_m[:, None])
        turn = self.room.sphere.wavenumber_rad_m * (path_m - path_then_m)
        return echo + self.shares[receiver] * self.swell(time_s) * size / size_then * np.exp(1j * turn)

    def _seen(self, receiver: int, place_m: Array) -> tuple[Array, Array]:
        size, path_m = np.ones(place_m.shape[1]), np.zeros(place_m.shape[1])
        for antenna in (self.room.antennas[0], self.room.antennas[receiver + 1]):
            away = place_m - antenna.position_m[:, None]
            range_m = np.linalg.norm(away, axis=0)
            size, path_m = size * antenna.strength(away / range_m) / range_m, path_m + range_m
        return size, path_m


def shares_of(case: Case, share: float) -> Complex:
    """Return a share for each receiver, 0.3 to 1 times the one given, at any phase."""
    rng, count = case.rng, case.n_receivers
    return share * rng.uniform(0.3, 1.0, count) * np.exp(2j * np.pi * rng.random(count))


def direction(rng: np.random.Generator, lowest_deg: float, highest_deg: float) -> Array:
    """Return a unit vector (3,) of any azimuth, between two elevations."""
    azimuth, elevation = rng.uniform(0.0, 2.0 * np.pi), np.radians(rng.uniform(lowest_deg, highest_deg))
    level = np.cos(elevation)
    return np.array([level * np.cos(azimuth), level * np.sin(azimuth), np.sin(elevation)])


def minimum_jerk(share: Array) -> Array:
    """Return the way of a hand from 0 to 1, 10 s^3 - 15 s^4 + 6 s^5 (Flash & Hogan 1985)."""
    s = np.clip(share, 0.0, 1.0)
    return np.asarray(s**3 * (10.0 - 15.0 * s + 6.0 * s**2))
