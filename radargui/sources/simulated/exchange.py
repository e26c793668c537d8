"""Simulate what a sphere and the floor under it send to and fro: exactly anywhere, and looked up along a motion."""

from __future__ import annotations

from math import factorial

import numpy as np
from scipy.interpolate import BSpline, make_interp_spline

from radargui.model.arrays import ComplexArray, FloatArray
from radargui.model.scattering import MieSphere, unit_vectors
from radargui.physics.edges import sides_of
from radargui.physics.plate import Plate, exchanged_signals, n_orders
from radargui.sources.simulated.scene import Plane


class Exchange:
    """What sphere and floor exchange, for every way in and out, directly and by way of the floor.

    Parameters
    ----------
    sphere
        The tracer.
    floor
        Its surface.
    reflection
        R straight down, 1 of a perfect conductor.
    plate
        Of what the floor is; None: R is the same at every angle.
    ends_m
        Places of the transmitter and its image in the floor, then of each receiver and its own, shape
        (1 + n_receivers, 2, 3).
    fields
        Directions of the fields that they send or answer to, shape (1 + n_receivers, 2, n_fields, 3).
    """

    def __init__(
        self,
        sphere: MieSphere,
        floor: Plane,
        reflection: complex,
        plate: Plate | None,
        ends_m: FloatArray,
        fields: FloatArray,
    ) -> None:
        self.sphere, self.floor, self.ends_m = sphere, floor, ends_m
        self._reflection, self._plate, self._fields = reflection, plate, fields

    def height_m(self, position_m: FloatArray) -> FloatArray:
        """Return the heights (n,) of places (3, n) over the floor; one that cuts the sphere counts as touched."""
        return np.maximum(self.floor.height_m(position_m), self.sphere.radius_m)

    def received(self, receiver: int, position_m: FloatArray) -> ComplexArray:
        """Return what is exchanged at places (3, n) as one receiver gets it, in units of the scattered field.

        Shape (2 ways in, 2 ways out, n_fields, n_fields, n).
        """
        return self.of_receivers(position_m, slice(receiver, receiver + 1))[0]

    def of_receivers(self, position_m: FloatArray, receivers: slice = slice(None)) -> ComplexArray:
        """Return what `received` does of several receivers, their number first."""
        leaving_m, got = self.ends_m[1:][receivers], self._fields[1:][receivers]
        incident = unit_vectors(position_m - self.ends_m[0][..., None])
        leaving = unit_vectors(leaving_m.reshape(-1, 3, 1) - position_m)
        found = exchanged_signals(
            self.sphere,
            self.height_m(position_m),
            self._reflection,
            self.floor.normal,
            incident,
            self._fields[0],
            leaving,
            got.reshape(-1, *got.shape[2:]),
            self._plate,
        ).signal
        return np.asarray(np.moveaxis(found.reshape(2, *leaving_m.shape[:2], *found.shape[2:]), 1, 0))


_NEAR_M, _GROWTH, _FAR_M = 2e-4, 0.1, 2e-3
"""Steps of the table at the floor, by how much of the height they grow, and at most."""
_DEGREE = 5
_ASIDE = 1e-4
"""Of the exchange, by which polynomials along the floor may be off."""


class ExchangeTable(Exchange):
    """`Exchange` looked up: a sample of its own costs half a millisecond.

    A spline over the height, in which what turns as the way to the image and back is taken off, and polynomials along
    the floor, where only directions change.

    Parameters
    ----------
    exchange
        What is looked up.
    place_m
        Where the sphere comes, shape (3, n): the table goes round all of it.
    """

    def __init__(self, exchange: Exchange, place_m: FloatArray) -> None:
        self.__dict__.update(exchange.__dict__)
        self._sides = sides_of(self.floor.normal, 0.0)
        aside = self._sides @ place_m
        nearest_m = float(np.linalg.norm(self.ends_m[:, 0, :, None] - place_m, axis=1).min())
        orders = n_orders(self.sphere.size)
        self._nodes = [_nodes(float(one.min()), float(one.max()), orders / nearest_m) for one in aside]
        height = self.height_m(place_m)
        heights = _heights(float(height.min()), float(height.max()), self.sphere.radius_m)
        u, v, over = (one.ravel() for one in np.meshgrid(*self._nodes, heights, indexing="ij"))
        foot_m = self.floor.distance_m * self.floor.normal
        grid = foot_m[:, None] + self._sides.T @ np.array([u, v]) + self.floor.normal[:, None] * over
        values = self.of_receivers(grid) * np.exp(-2j * self._wavenumber * over)
        # of each receiver, over the height: nodes along the floor, ways and fields
        self._shape = values.shape[1:-1]
        by_height = np.moveaxis(values.reshape(len(values), -1, u.size // heights.size, heights.size), 3, 1)
        by_height = np.ascontiguousarray(by_height.swapaxes(2, 3))
        self._splines: list[BSpline] = [make_interp_spline(heights, one.view(float), k=_DEGREE) for one in by_height]

    @property
    def _wavenumber(self) -> float:
        return 2.0 * np.pi / self.sphere.wavelength_m

    def received(self, receiver: int, position_m: FloatArray) -> ComplexArray:
        """Return what is exchanged at places (3, n) as one receiver gets it, looked up."""
        height, (u, v) = self.height_m(position_m), self._sides @ position_m
        shares = _shares(self._nodes[0], u)[:, :, None] * _shares(self._nodes[1], v)[:, None]
        values = self._splines[receiver](height)
        found = np.einsum("nk,nkc->nc", shares.reshape(height.size, -1), values).view(complex).T
        found = found * np.exp(2j * self._wavenumber * height)
        return np.asarray(found.reshape(*self._shape, height.size))


def _heights(lowest_m: float, highest_m: float, radius_m: float) -> FloatArray:
    """Return nodes over the height, dense near the floor, where many orders go to and fro."""
    out = [lowest_m]
    while out[-1] < highest_m or len(out) <= _DEGREE:
        out.append(out[-1] + min(_NEAR_M + _GROWTH * (out[-1] - radius_m), _FAR_M))
    return np.array(out)


def _nodes(lowest_m: float, highest_m: float, turns_rad_m: float) -> FloatArray:
    """Return the fewest Chebyshev nodes with which what turns so fast along the floor is right."""
    half, count = 0.5 * (highest_m - lowest_m), 1
    # remainder of interpolation at these nodes
    while (turns_rad_m * half) ** count / (2.0 ** (count - 1) * factorial(count)) > _ASIDE:
        count += 1
    return np.asarray(lowest_m + half * (1.0 - np.cos(np.pi * (np.arange(count) + 0.5) / count)))


def _shares(nodes: FloatArray, at: FloatArray) -> FloatArray:
    """Return Lagrange's polynomials of nodes (k,) at places (n,), shape (n, k)."""
    out = np.ones((at.size, nodes.size))
    for number, node in enumerate(nodes):
        others = np.delete(nodes, number)
        out[:, number] = ((at[:, None] - others) / (node - others)).prod(axis=1)
    return out
