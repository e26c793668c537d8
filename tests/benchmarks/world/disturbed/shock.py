"""An impact shakes table and antennas: the path lengths ring, and the direct wave between the antennas with them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from benchmarks.world.disturbance import Array, Complex, Disturbance
from benchmarks.world.disturbed.reflector import direction
from benchmarks.world.disturbed.strength import Case
from benchmarks.world.room import Room

_OF_THE_RELEASE = 0.3
_ARRIVES_S = (0.0005, 0.003)


@dataclass(frozen=True)
class Ring:
    """An antenna on its stand: it swings along one direction after every blow and dies out.

    Attributes
    ----------
    along_m
        Direction times amplitude after a blow of size 1, shape (3,).
    rate_hz, decay_s, late_s
        Of the stand; `late_s` is the way of the shock to it.
    blows
        Times and sizes.
    """

    along_m: Array
    rate_hz: float
    decay_s: float
    late_s: float
    blows: tuple[tuple[float, float], ...]

    def moved_m(self, time_s: Array) -> Array:
        """Return displacements (3, n) at times (n,)."""
        out = np.zeros(time_s.size)
        for begin_s, size in self.blows:
            since = time_s - begin_s - self.late_s
            after = np.maximum(since, 0.0)
            out += size * np.exp(-after / self.decay_s) * np.sin(2.0 * np.pi * self.rate_hz * after)
        return np.outer(self.along_m, out)


@dataclass(frozen=True)
class Shock(Disturbance):
    """All antennas (0 the transmitter) ring; the wave over floor and walls counts as long as the straight one.

    `leaks` is the direct wave from the transmitter in each receiver, complex, in units of the echo: its mean is in
    the offsets already.
    """

    room: Room
    rings: tuple[Ring, ...]
    leaks: Complex

    def path_change_m(self, receiver: int, time_s: Array, place_m: Array) -> Array:
        """Return by how much the way over the sphere at places (3, n) is longer, shape (n,)."""
        out = np.zeros(time_s.size)
        for number in (0, receiver + 1):
            away = place_m - self.room.antennas[number].position_m[:, None]
            out -= np.einsum("in,in->n", away / np.linalg.norm(away, axis=0), self.rings[number].moved_m(time_s))
        return out

    def direct_change_m(self, receiver: int, time_s: Array) -> Array:
        """Return by how much the way between the antennas is longer, shape (n,)."""
        away = self.room.antennas[receiver + 1].position_m - self.room.antennas[0].position_m
        apart = self.rings[receiver + 1].moved_m(time_s) - self.rings[0].moved_m(time_s)
        return np.asarray(away / np.linalg.norm(away) @ apart)

    def echo(self, receiver: int, time_s: Array, place_m: Array, echo: Complex) -> Complex:
        """Turn echo and direct wave by what their ways are longer."""
        wavenumber = self.room.sphere.wavenumber_rad_m
        turned = echo * np.exp(1j * wavenumber * self.path_change_m(receiver, time_s, place_m))
        rings = np.exp(1j * wavenumber * self.direct_change_m(receiver, time_s)) - 1.0
        return turned + self.leaks[receiver] * rings


def shock(case: Case, variant: str) -> tuple[Disturbance, ...]:
    """Return blows by the release and every impact, as hard as the sphere is fast; a path rings by 10 to 200 um."""
    del variant
    rng, drop = case.rng, case.scene.drop
    fastest = max((one.before_m_s for one in drop.impacts), default=1.0)
    blows = [(drop.start_s, _OF_THE_RELEASE), *((one.time_s, one.before_m_s / fastest) for one in drop.impacts)]
    size_m = case.between(1e-5, 2e-4)
    rings = tuple(
        Ring(
            size_m * rng.uniform(0.5, 1.0) * direction(rng, -90.0, 90.0),
            float(np.exp(rng.uniform(np.log(20.0), np.log(200.0)))),
            rng.uniform(0.05, 0.3),
            rng.uniform(*_ARRIVES_S),
            tuple(blows),
        )
        for _ in case.scene.room.antennas
    )
    leaks = np.array([complex(*one.offset) for one in case.scene.mixers]) * np.exp(1j * rng.normal(0.0, 0.5))
    return (Shock(case.scene.room, rings, leaks),)
