"""Where a plate ends: what reaches the sphere over a rectangle, over what an endless plane would send (method 1).

Each side of the rectangle is a half-plane: the wave over it is a Fresnel integral of sqrt(2 K D / pi), D by which the
shortest way over the edge is longer than that by the reflection (Born & Wolf, section 11.5), its tail as strong as
Kirchhoff's integral has it (section 8.3: stationary phase along the edge). Both integrals along a side add, those of
the two sides multiply; corners are left out. Time factor exp(-i w t), as everywhere.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import fresnel

from radargui.model.arrays import ComplexArray, FloatArray
from radargui.model.assumed import u_of_edges
from radargui.model.setup import Setup

SIDES, AZIMUTH, MIDDLE = slice(0, 2), 2, slice(3, 5)
"""Where the unknowns of a plate's edges stand: half of each side (m), azimuth of the first (rad), x and y of its middle
(m)."""
N_EDGES = 5
HEIGHT, ANTENNA, ACROSS, ASIDE = 0, 1, slice(2, 4), slice(4, 6)
"""Where the slopes by each length of `OverPlate` stand."""
_EXACT = 1e-5  # m, rad
_NEAREST_M = 1e-4  # of a sphere's centre to the surface: nearer it would stand in it
_LEAST = 1e-9  # of the integral along a side, over which its slopes count
_GRAZING = 1e-9  # m: a way over an edge that is no longer goes there


@dataclass(frozen=True, slots=True)
class StatedEdges:
    """The unknowns of a plate's edges as the setup states them, and their standard uncertainties, shape (5,) both."""

    values: FloatArray
    u: FloatArray

    @staticmethod
    def of(setup: Setup) -> StatedEdges | None:
        """Return what a setup says; None where the floor has no edges that it knows of."""
        floor, release_m = setup.floor, setup.tracer.release_position_m
        if floor.size_m is None:
            return None
        u_size_m, u_azimuth_deg, u_middle_m = u_of_edges(floor)
        middle = release_m[:2] if floor.middle_m is None else floor.middle_m
        half = 0.5 * np.array(floor.size_m)
        u = np.array([0.5 * u_size_m, 0.5 * u_size_m, np.radians(u_azimuth_deg), u_middle_m, u_middle_m])
        # what is called exact moves by no more than this, but its pull is told
        return StatedEdges(np.array([*half, np.radians(floor.azimuth_deg), *middle]), np.maximum(u, _EXACT))


def sides_of(normal: FloatArray, azimuth_rad: float) -> FloatArray:
    """Return the unit vectors along the sides of a plate with this normal, shape (2, 3)."""
    along = np.array([np.cos(azimuth_rad), np.sin(azimuth_rad), 0.0])
    along -= normal * (normal @ along)
    along /= np.linalg.norm(along)
    return np.array([along, np.cross(normal, along)])


@dataclass(frozen=True, slots=True)
class Rectangle:
    """A plate as it lies.

    Attributes
    ----------
    sides
        Unit vectors along both, shape (2, 3).
    middle_m
        Of the plate, on its surface, shape (3,).
    half_m
        Half of each side, shape (2,).
    """

    sides: FloatArray
    middle_m: FloatArray
    half_m: FloatArray

    @staticmethod
    def of(values: FloatArray, normal: FloatArray, foot_m: FloatArray) -> Rectangle:
        """Return the plate of these unknowns (5,) in the plane with this normal and a point on it, shape (3,) both."""
        middle_m = np.array([*values[MIDDLE], 0.0])
        middle_m[2] = normal @ (foot_m - middle_m) / normal[2]
        return Rectangle(sides_of(normal, float(values[AZIMUTH])), middle_m, values[SIDES])

    def over(
        self,
        place_m: FloatArray,
        height_m: FloatArray,
        ends_m: FloatArray,
        antenna_m: FloatArray,
        fields: FloatArray | None,
        wavenumber: float,
    ) -> OverPlate:
        """Return the ways from antennas over the plate to places of the sphere.

        Parameters
        ----------
        place_m, height_m
            Of the sphere, shape (..., 3, n), and its height over the plane, (..., n).
        ends_m, antenna_m
            Places of some antennas, shape (..., n_ends, 3), and their heights, (..., n_ends, 1).
        fields
            Directions of their fields, (..., n_ends, 3); None where nobody knows them.
        wavenumber
            In 1/m.
        """
        across = (self.sides @ place_m)[..., None, :, :] - (ends_m @ self.sides.T)[..., None]
        aside = np.broadcast_to((self.sides @ (place_m - self.middle_m[:, None]))[..., None, :, :], across.shape)
        height = np.broadcast_to(height_m[..., None, :], (*across.shape[:-2], across.shape[-1]))
        return OverPlate(height, antenna_m, across, aside, self.half_m, self._power(fields, ends_m.shape), wavenumber)

    def _power(self, fields: FloatArray | None, shape: tuple[int, ...]) -> FloatArray:
        """Return the shares of the power of fields (..., 3) along the sides, or half and half: (..., 3), (..., 2)."""
        if fields is None:
            return np.full((*shape[:-1], 2), 0.5)
        parts = (fields @ self.sides.T) ** 2
        return np.asarray(parts / parts.sum(axis=-1, keepdims=True))


@dataclass(frozen=True, slots=True)
class OverPlate:
    """Ways from antennas over a plate to places of the sphere.

    Attributes
    ----------
    height_m, antenna_m
        Of the sphere and of the antenna over the plate's plane, shapes (..., n) and (..., 1).
    across_m
        From the antenna to the sphere along each side, shape (..., 2, n).
    aside_m
        From the plate's middle to the sphere along each side, shape (..., 2, n).
    half_m
        Half of each side, shape (2,).
    power
        Of the field along each side, as a share, shape (..., 2); half and half where no polarisation is known.
    wavenumber
        In 1/m.
    """

    height_m: FloatArray
    antenna_m: FloatArray
    across_m: FloatArray
    aside_m: FloatArray
    half_m: FloatArray
    power: FloatArray
    wavenumber: float

    def value(self) -> ComplexArray:
        """Return the wave over the plate, over that of an endless one, shape (..., n)."""
        return np.asarray(self._over_edges().integral(self.power).sum(axis=-2).prod(axis=-2))

    def slopes(self) -> tuple[ComplexArray, ComplexArray]:
        """Return the slopes of the logarithm of `value`: by half of each side, (..., 2, n), and by the lengths.

        By height of sphere and antenna, the two across and the two aside, shape (..., 6, n). How strong the tails are
        changes slowly and counts as constant.
        """
        ways = self._over_edges()
        each = ways.integral(self.power).sum(axis=-2)
        each = np.where(np.abs(each) > _LEAST, each, _LEAST)
        # by the way over an edge less the direct one, in 1/m
        kernel = ways.strength(self.power) * _kernel(ways.end) * (self.wavenumber / np.pi) / ways.end
        kernel = kernel / each[..., None, :]
        near, far = self._near[..., None, None, :], self.antenna_m[..., None, None, :]
        turn = ways.both_m / ways.length_m
        by_sphere = turn * ways.sphere_m / ways.from_sphere_m
        by_antenna = turn * ways.antenna_m / ways.from_antenna_m
        direct = ways.direct_m[..., None, None, :]
        rises = (near + far) / direct
        out = np.empty((*self.height_m.shape[:-1], 6, self.height_m.shape[-1]), complex)
        out[..., HEIGHT, :] = (kernel * (turn * near / ways.from_sphere_m - rises)).sum(axis=(-3, -2))
        out[..., ANTENNA, :] = (kernel * (turn * far / ways.from_antenna_m - rises)).sum(axis=(-3, -2))
        by_both = kernel * (by_sphere + by_antenna)
        out[..., ASIDE, :] = -by_both.sum(axis=-2)
        straight = self.across_m / ways.direct_m[..., None, :]
        # the ways over the edges of one side are longer with what they go along them, the other side
        over_other = (kernel * ways.along_m / ways.length_m).sum(axis=-2)[..., ::-1, :]
        all_of_them = kernel.sum(axis=(-3, -2))[..., None, :]
        out[..., ACROSS, :] = (kernel * by_antenna).sum(axis=-2) + over_other - straight * all_of_them
        return np.asarray((_SIGN * by_both).sum(axis=-2)), out

    @property
    def _near(self) -> FloatArray:
        return np.maximum(self.height_m, _NEAREST_M)

    def _over_edges(self) -> _OverEdges:
        near, far = self._near, np.broadcast_to(self.antenna_m, self.height_m.shape)
        edge = _SIGN * self.half_m[:, None, None]
        sphere = edge - self.aside_m[..., None, :]
        antenna = sphere + self.across_m[..., None, :]
        direct = np.sqrt((self.across_m**2).sum(axis=-2) + (near + far) ** 2)
        from_sphere = np.sqrt(sphere**2 + near[..., None, None, :] ** 2)
        from_antenna = np.sqrt(antenna**2 + far[..., None, None, :] ** 2)
        both = from_sphere + from_antenna
        along = self.across_m[..., ::-1, None, :]
        length = np.sqrt(both**2 + along**2)
        longer = np.maximum(length - direct[..., None, None, :], _GRAZING)
        # the reflection lies before the edge, or beyond it
        share = (near / (near + far))[..., None, None, :]
        inside = np.sign(_SIGN * (sphere + self.across_m[..., None, :] * share))
        end = np.where(inside < 0.0, -1.0, 1.0) * np.sqrt(2.0 * self.wavenumber / np.pi * longer)
        return _OverEdges(near, far, direct, sphere, antenna, from_sphere, from_antenna, both, along, length, end)


_SIGN = np.array([[1.0], [-1.0]])  # the two edges of a side


@dataclass(frozen=True, slots=True)
class _OverEdges:
    """Ways over the two edges at the ends of each side, (..., 2 sides, 2 edges, n), and by the reflection, (..., n)."""

    near_m: FloatArray
    far_m: FloatArray
    direct_m: FloatArray
    sphere_m: FloatArray
    antenna_m: FloatArray
    from_sphere_m: FloatArray
    from_antenna_m: FloatArray
    both_m: FloatArray
    along_m: FloatArray
    length_m: FloatArray
    end: FloatArray

    def integral(self, power: FloatArray) -> ComplexArray:
        """Return the Fresnel integrals with tails as `strength` has them."""
        step = np.where(self.end < 0.0, -0.5, 0.5)
        return np.asarray(step + (_integral(self.end) - step) * self.strength(power))

    def strength(self, power: FloatArray) -> FloatArray:
        """Return how strong the tails are, over those of the Fresnel integrals.

        By stationary phase the wave over an edge is as strong as what reaches it, 1 / (r r'), over the slope of the
        phase and the root of its curvature along the edge. Across the edge a field is weakened by the cosine of the
        way behind it, along it by that of the way before it.
        """
        across = power[..., None, None]
        near, far = self.near_m[..., None, None, :], self.far_m[..., None, None, :]
        direct = self.direct_m[..., None, None, :]
        behind, before = direct * near / (near + far), direct * far / (near + far)
        over_behind, over_before = (
            self.length_m * one / self.both_m for one in (self.from_sphere_m, self.from_antenna_m)
        )
        slope = np.abs(self.antenna_m / over_before + self.sphere_m / over_behind)
        curved = (1.0 / behind + 1.0 / before) * (near + far) / direct
        aslant = (1.0 / over_behind + 1.0 / over_before) * (1.0 - (self.along_m / self.length_m) ** 2)
        longer = np.maximum(self.length_m - direct, _GRAZING)
        spread = behind * before / (over_behind * over_before) * curved / np.sqrt(aslant)
        leaves = across * behind / over_behind + (1.0 - across) * before / over_before
        # at the reflection itself both are one
        found = spread * leaves * np.sqrt(2.0 * longer) / np.maximum(slope, 1e-12)
        return np.asarray(np.where(longer > 10.0 * _GRAZING, found, 1.0))


def _integral(end: FloatArray) -> ComplexArray:
    """Return (1 - i) / 2 times the integral of exp(i pi t^2 / 2) from 0: plus and minus a half far away."""
    sine, cosine = fresnel(end)
    return np.asarray(0.5 * (1.0 - 1j) * (cosine + 1j * sine))


def _kernel(end: FloatArray) -> ComplexArray:
    """Return what `_integral` changes by with its end."""
    return np.asarray(0.5 * (1.0 - 1j) * np.exp(0.5j * np.pi * end**2))
