"""Simulate what a sphere and the floor under it send to and fro: exactly anywhere, and looked up along a motion."""

from __future__ import annotations

from math import factorial

import numpy as np
from scipy.interpolate import BSpline, make_interp_spline
from scipy.sparse import csr_array

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
        return np.asarray(np.maximum(self.floor.height_m(position_m), self.sphere.radius_m))

    def received(self, receiver: int, position_m: FloatArray) -> ComplexArray:
        """Return what is exchanged at places (3, n) as one receiver gets it, in units of the scattered field.

        Shape (2 ways in, 2 ways out, n_fields, n_fields, n).
        """
        return np.asarray(self.of_receivers(position_m, slice(receiver, receiver + 1))[0])

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
_ASIDE, _MOST_ASIDE = 1e-4, 9
"""Of the exchange, by which polynomials along the floor may be off, and their nodes at most."""


class ExchangeTable:
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
        floor, sphere = exchange.floor, exchange.sphere
        self._exchange, self._sides = exchange, sides_of(floor.normal, 0.0)
        nearest_m = float(np.linalg.norm(exchange.ends_m[:, 0, :, None] - place_m, axis=1).min())
        turns_rad_m = n_orders(sphere.size) / nearest_m
        self._nodes = [_nodes(float(one.min()), float(one.max()), turns_rad_m) for one in self._sides @ place_m]
        height_m = exchange.height_m(place_m)
        heights = _heights(float(height_m.min()), float(height_m.max()), sphere.radius_m)
        u, v, over = (one.ravel() for one in np.meshgrid(*self._nodes, heights, indexing="ij"))
        grid_m = self._sides.T @ np.array([u, v]) + floor.normal[:, None] * (floor.distance_m + over)
        values = exchange.of_receivers(grid_m) / self._turned(over)
        self._shape = values.shape[1:-1]
        # of each receiver, over the height: nodes along the floor, ways and fields
        over_height = values.reshape(len(values), -1, u.size // heights.size, heights.size).transpose(3, 0, 2, 1)
        spline: BSpline = make_interp_spline(heights, over_height, k=_DEGREE)
        self._knots = spline.t
        # nodes along the floor first, those of the spline within
        by_node = spline.c.transpose(1, 2, 0, 3)
        self._coefficients = by_node.reshape(len(values), -1, by_node.shape[-1]).copy().view(float)

    def received(self, receiver: int, position_m: FloatArray) -> ComplexArray:
        """Return what `Exchange.received` does."""
        height_m, (u, v) = self._exchange.height_m(position_m), self._sides @ position_m
        aside = (_shares(self._nodes[0], u)[:, :, None] * _shares(self._nodes[1], v)[:, None]).reshape(u.size, -1)
        within = np.clip(height_m, self._knots[0], self._knots[-1])
        over_height = BSpline.design_matrix(within, self._knots, _DEGREE)
        # one row of a sparse matrix for each place: a spline of hundreds of columns takes several times as long
        n_heights, n_aside = over_height.shape[1], aside.shape[1]
        columns = over_height.indices.reshape(u.size, 1, -1) + n_heights * np.arange(n_aside)[:, None]
        shares = aside[:, :, None] * over_height.data.reshape(u.size, 1, -1)
        begins = columns[0].size * np.arange(u.size + 1)
        rows = csr_array((shares.ravel(), columns.ravel(), begins), (u.size, n_aside * n_heights))
        found = (rows @ self._coefficients[receiver]).view(complex).T
        turned = np.multiply(found, self._turned(height_m), order="C")
        return np.asarray(turned.reshape(*self._shape, u.size))

    def _turned(self, height_m: FloatArray) -> ComplexArray:
        return np.asarray(np.exp(4j * np.pi / self._exchange.sphere.wavelength_m * height_m))


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
    while (turns_rad_m * half) ** count / (2.0 ** (count - 1) * factorial(count)) > _ASIDE and count < _MOST_ASIDE:
        count += 1
    return np.asarray(lowest_m + half * (1.0 - np.cos(np.pi * (np.arange(count) + 0.5) / count)))


def _shares(nodes: FloatArray, at: FloatArray) -> FloatArray:
    """Return Lagrange's polynomials of nodes (k,) at places (n,), shape (n, k)."""
    out = np.ones((at.size, nodes.size))
    for number, node in enumerate(nodes):
        others = np.delete(nodes, number)
        out[:, number] = ((at[:, None] - others) / (node - others)).prod(axis=1)
    return out
