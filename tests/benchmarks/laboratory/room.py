"""The radar in its room: what each receiver gets when the sphere is at a place, by all ways over the mirrors."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from benchmarks.laboratory.antenna import Antenna
from benchmarks.laboratory.bed import Bed
from benchmarks.laboratory.mirror import Mirror
from benchmarks.laboratory.sphere import Sphere
from numpy.typing import NDArray

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True)
class Room:
    """Antennas (0 the transmitter), the sphere and the mirrors.

    `corners` holds pairs of mirrors: the wave that meets both, the first one first, goes that way too. `coupled` holds
    mirrors that send back to the sphere, once, what it scatters straight at them: far from the sphere only, as the
    returning wave counts as plane. Waves in the `bed` go slower, and its surface mirrors for a sphere above it.
    """

    antennas: tuple[Antenna, ...]
    sphere: Sphere
    mirrors: tuple[Mirror, ...] = ()
    corners: tuple[tuple[Mirror, Mirror], ...] = ()
    coupled: tuple[Mirror, ...] = ()
    bed: Bed | None = None

    def path_m(self, position_m: Array) -> Array:
        """Return the path lengths transmitter - sphere - receiver, shape (n_receivers, n)."""
        ranges = [np.linalg.norm(position_m - one.position_m[:, None], axis=0) for one in self.antennas]
        return np.array([ranges[0] + one for one in ranges[1:]])

    def received(self, receiver: int, position_m: Array) -> Complex:
        """Return the complex signal of a receiver (from 0), shape (n,), for places of the sphere (3, n).

        Each way of the wave from the transmitter joins each way to the receiver; every pair has its own angle and
        polarisations at the sphere. The phase grows with the path: exp(+i K L).
        """
        out = np.zeros(position_m.shape[1], complex)
        back = list(self._ways(receiver + 1, position_m))
        there = list(self._ways(0, position_m))
        for incoming, field in there + [self._returned(mirror, there, position_m) for mirror in self.coupled]:
            for way, receiving in back:
                out += self.sphere.scattered(incoming, field, -way, receiving)
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
        field = antenna.field(direction)
        for mirror in over:
            field = mirror.reflected(direction, field, number)
            direction = mirror.mirrored(direction)
        longer_m: Array | float = 0.0
        if self.bed is not None:
            bottom = next((one.offset_m for one in over if one.normal[2] > 0.5), None)
            longer_m = self.bed.longer_m(image, position_m, self.sphere.radius_m, bottom)
        return direction, field * np.exp(1j * self.sphere.wavenumber_rad_m * (range_m + longer_m)) / range_m
