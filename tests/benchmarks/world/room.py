"""The radar in its room: what each receiver gets when the sphere is at a place, by all ways over the mirrors."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from benchmarks.world.antenna import Antenna
from benchmarks.world.bed import Bed
from benchmarks.world.container import Container
from benchmarks.world.exchange import Exchange, incident, radiated, sum_of
from benchmarks.world.mirror import Mirror
from benchmarks.world.sphere import Sphere
from numpy.typing import NDArray

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True)
class Holder:
    """What holds the sphere at rest and stays there: counted as a small sphere."""

    position_m: Array
    sphere: Sphere


@dataclass(frozen=True)
class Room:
    """Antennas (0 the transmitter), the sphere and the mirrors.

    `corners` holds pairs of mirrors: the wave that meets both, the first one first, goes that way too. `coupled` holds
    mirrors that send back to the sphere, once, what it scatters straight at them: far from the sphere only, as the
    returning wave counts as plane. Waves in the `bed` go slower, and its surface mirrors for a sphere above it.
    `exchange` is all that the sphere and the first mirror send to and fro, the `holder` a small sphere that sends each
    antenna's wave on once, the `container` stands in the straight rays and in those over the first mirror.
    """

    antennas: tuple[Antenna, ...]
    sphere: Sphere
    mirrors: tuple[Mirror, ...] = ()
    corners: tuple[tuple[Mirror, Mirror], ...] = ()
    coupled: tuple[Mirror, ...] = ()
    bed: Bed | None = None
    exchange: Exchange | None = None
    holder: Holder | None = None
    container: Container | None = None

    def path_m(self, position_m: Array) -> Array:
        """Return the path lengths transmitter - sphere - receiver, shape (n_receivers, n)."""
        ranges = [np.linalg.norm(position_m - one.position_m[:, None], axis=0) for one in self.antennas]
        return np.array([ranges[0] + one for one in ranges[1:]])

    def received(self, receiver: int, position_m: Array) -> Complex:
        """Return the complex signal of a receiver (from 0), shape (n,), for places of the sphere (3, n)."""
        return self._signals((receiver,), position_m)[0]

    def all_received(self, position_m: Array) -> Complex:
        """Return the complex signals of all receivers, shape (n_receivers, n)."""
        return self._signals(tuple(range(len(self.antennas) - 1)), position_m)

    def _signals(self, receivers: tuple[int, ...], position_m: Array) -> Complex:
        """Return signals (len(receivers), n).

        Each way of the wave from the transmitter joins each way to the receiver; every pair has its own angle and
        polarisations at the sphere. The phase grows with the path: exp(+i K L).
        """
        there = list(self._ways(0, position_m))
        back = [list(self._ways(receiver + 1, position_m)) for receiver in receivers]
        arriving = there + [self._returned(mirror, there, position_m) for mirror in self.coupled]
        out = np.zeros((len(receivers), position_m.shape[1]), complex)
        for number, ways in enumerate(back):
            for incoming, field in arriving:
                for way, receiving in ways:
                    out[number] += self.sphere.scattered(incoming, field, -way, receiving)
        if self.exchange is not None:
            gap_m = self.mirrors[0].normal @ position_m - self.mirrors[0].offset_m - self.sphere.radius_m
            turn = _upright(self.mirrors[0].normal)
            meets = sum_of(incident(turn @ way, turn @ field) for way, field in there)
            leaves = [sum_of(radiated(-turn @ way, turn @ field) for way, field in ways) for ways in back]
            out += self.exchange.received(gap_m, meets, leaves)
        return out

    def direct(self, receiver: int, position_m: Array) -> Complex:
        """Return the same for the room without mirrors."""
        return Room(self.antennas, self.sphere).received(receiver, position_m)

    def _ways(self, number: int, position_m: Array) -> Iterator[tuple[Array, Complex]]:
        """Give direction and field at the sphere of each way from an antenna: straight, by a mirror, by a corner."""
        antenna = self.antennas[number]
        yield self._way(number, (), position_m)
        if self.bed is not None:
            direction, field = self._way(number, (self.bed.surface,), position_m)
            yield direction, field * self.bed.above(position_m, self.sphere.radius_m)
        for over in (*((mirror,) for mirror in self.mirrors), *self.corners):
            # an antenna behind a mirror, or whose image in the first lies behind the second, does not light it
            place, seen = antenna.position_m, True
            for mirror in over:
                seen = seen and mirror.height_m(place) > 0.0
                place = mirror.image(place)
            if seen:
                yield self._way(number, over, position_m)
        if self.holder is not None:
            yield self._over_holder(number, position_m)

    def _over_holder(self, number: int, position_m: Array) -> tuple[Array, Complex]:
        """Return the wave that the holder sends on to the sphere: i exp(i K r) / (K r) times what it scatters."""
        holder = self.holder
        assert holder is not None
        there, field = self._way(number, (), holder.position_m[:, None])
        way = position_m - holder.position_m[:, None]
        range_m = np.linalg.norm(way, axis=0)
        turns = self.sphere.wavenumber_rad_m * range_m
        count = position_m.shape[1]
        sent = holder.sphere.field(np.repeat(there, count, axis=1), np.repeat(field, count, axis=1), way / range_m)
        return way / range_m, sent * 1j * np.exp(1j * turns) / turns

    def _returned(self, mirror: Mirror, ways: list[tuple[Array, Complex]], position_m: Array) -> tuple[Array, Complex]:
        """Return the wave that the sphere scatters straight at a mirror, back at the sphere.

        The scattered field is i exp(i K r) / (K r) times the amplitude (Bohren & Huffman, eq. 3.12), r = 2 heights.
        """
        count = position_m.shape[1]
        down = np.repeat(-mirror.normal[:, None], count, axis=1)
        field = np.zeros((3, count), complex)
        for axis in np.linalg.svd(mirror.normal[None])[2][1:]:
            basis = np.repeat(axis[:, None], count, axis=1)
            for incoming, one in ways:
                field += basis * self.sphere.scattered(incoming, one, down, basis)
        turns = 2.0 * self.sphere.wavenumber_rad_m * (mirror.normal @ position_m - mirror.offset_m)
        return -down, mirror.reflected(down, field, 0) * 1j * np.exp(1j * turns) / turns

    def _way(self, number: int, over: tuple[Mirror, ...], position_m: Array) -> tuple[Array, Complex]:
        antenna = self.antennas[number]
        image = antenna.position_m
        for mirror in over:
            image = mirror.image(image)
        away = position_m - image[:, None]
        range_m = np.linalg.norm(away, axis=0)
        # the direction at the antenna: that at the sphere, followed back over the mirrors
        direction = away / range_m
        for mirror in reversed(over):
            direction = mirror.mirrored(direction)
        field = antenna.field(direction, range_m)
        for mirror in over:
            field = mirror.reflected(direction, field, number)
            direction = mirror.mirrored(direction)
        if len(over) == 1 and over[0].plate is not None:
            plate, turns = over[0].plate, self.sphere.wavenumber_rad_m
            field = field * plate.seen(antenna.position_m, position_m, over[0].normal, field, turns)
        if self.container is not None and (not over or (len(over) == 1 and over[0] is self.mirrors[0])):
            seen_m = position_m
            if over:
                seen_m = over[0].mirrored(position_m) + 2.0 * over[0].offset_m * over[0].normal[:, None]
            field = field * self.container.delay(antenna.position_m, seen_m, self.sphere.wavenumber_rad_m)
        longer_m: Array | float = 0.0
        if self.bed is not None:
            bottom = next((one.offset_m for one in over if one.normal[2] > 0.5), None)
            longer_m = self.bed.longer_m(image, position_m, self.sphere.radius_m, bottom)
        return direction, field * np.exp(1j * self.sphere.wavenumber_rad_m * (range_m + longer_m)) / range_m


def _upright(normal: Array) -> Array:
    """Return the rotation (3, 3) that turns a normal into the z axis."""
    across = np.cross(np.eye(3)[np.abs(normal).argmin()], normal)
    across /= np.linalg.norm(across)
    return np.array([across, np.cross(normal, across), normal])
