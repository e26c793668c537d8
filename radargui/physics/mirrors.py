"""Plane reflectors as physics: what mirrors add to the field at a receiver (image theory; method 1 and 4, Mirrors)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from radargui.model.arrays import ComplexArray, FloatArray
from radargui.physics.edges import StatedEdges
from radargui.physics.path_length import mirror
from radargui.physics.plate import StatedSurface

FLOOR, WALL = "floor", "wall"


@dataclass(frozen=True, slots=True)
class MirrorPlane:
    """A plane near which a reflector is sought; its unknowns are two tilts and a shift.

    Attributes
    ----------
    foot_m
        A point on it, shape (3,).
    normal
        Unit vector to the tracer's side, shape (3,).
    name
        FLOOR or WALL.
    u_turn_rad
        Prior standard deviation of the first tilt: of a wall its azimuth, which a search knows only to some degrees.
    u_tilt_rad
        Of the second tilt: 2 degrees, chosen by hand; tables and walls of a laboratory stand straighter.
    u_shift_m
        Of the shift: one wavelength at 10 GHz, chosen by hand; a floor is sought just below the lowest place.
    surface
        What the setup says that it reflects; None: nothing.
    edges
        Where it ends; None: nowhere that counts.
    """

    foot_m: FloatArray
    normal: FloatArray
    name: str
    u_turn_rad: float = 0.03
    u_tilt_rad: float = 0.03
    u_shift_m: float = 0.03
    surface: StatedSurface | None = None
    edges: StatedEdges | None = None

    @property
    def deviations(self) -> tuple[float, float, float]:
        """Prior standard deviations of the unknowns: two tilts (rad), shift (m)."""
        return self.u_turn_rad, self.u_tilt_rad, self.u_shift_m

    def image(self, point_m: FloatArray, unknown: FloatArray) -> FloatArray:
        """Return the mirror image of points (..., 3) for two tilts (rad) and a shift along the normal (m)."""
        normal = self.turned_normal(unknown)
        return mirror(point_m, normal, float(normal @ (self.foot_m + unknown[2] * self.normal)))

    def shifted_foot(self, unknown: FloatArray) -> FloatArray:
        """Return a point on the plane with its shift, shape (3,)."""
        return np.asarray(self.foot_m + unknown[2] * self.normal)

    def height(self, place_m: FloatArray, unknown: FloatArray) -> FloatArray:
        """Return the distances (..., n) of places (..., 3, n) from the plane, positive on the tracer's side."""
        return np.asarray(self.turned_normal(unknown) @ (place_m - self.shifted_foot(unknown)[:, None]))

    def height_slope(self, place_m: FloatArray, unknown: FloatArray) -> FloatArray:
        """Return the slopes of the distances of places (..., 3, n) by the unknowns, shape (..., 3, n)."""
        turn, away = self.normal_slope(unknown), place_m - self.shifted_foot(unknown)[:, None]
        out = np.empty(place_m.shape)
        out[..., :2, :], out[..., 2, :] = turn @ away, -float(self.turned_normal(unknown) @ self.normal)
        return out

    def turned(self, direction: FloatArray, unknown: FloatArray) -> FloatArray:
        """Return the mirror image of directions, shape (..., 3)."""
        # a direction has no place: mirrored in the parallel plane through the origin
        return mirror(direction, self.turned_normal(unknown), 0.0)

    def turned_slope(self, direction: FloatArray, unknown: FloatArray) -> FloatArray:
        """Return d turned / d unknown of directions (..., 3), shape (..., 3 unknowns, 3): a shift turns nothing."""
        out = np.zeros((*direction.shape[:-1], 3, 3))
        out[..., :2, :] = self._mirrored_slope(direction, unknown)
        return out

    def lean(self, unknown: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return (n_x, n_y) / n_z, shape (2,), and its derivatives by the two tilts, shape (2, 2)."""
        tangents = _tangents(tuple(self.normal.tolist()))
        normal = self.normal + unknown[:2] @ tangents
        slope = normal[:2] / normal[2]
        return slope, np.asarray((tangents[:, :2] - np.outer(tangents[:, 2], slope)).T / normal[2])

    def turned_normal(self, unknown: FloatArray) -> FloatArray:
        """Return the unit normal, (3,), of the plane with its tilts."""
        # small turns as sums; normalised, so that the image keeps its distance
        normal = self.normal + unknown[:2] @ _tangents(tuple(self.normal.tolist()))
        return np.asarray(normal / np.sqrt(normal @ normal))

    def image_slope(self, point_m: FloatArray, unknown: FloatArray) -> FloatArray:
        """Return d image / d unknown of points (..., 3), shape (..., 3 unknowns, 3).

        a' = a - 2 (n.w) n, w = a - foot - shift n0, n = (n0 + tilts) / length, dn / d tilt = (t - n (n.t)) / length.
        """
        normal = self.turned_normal(unknown)
        away = point_m - self.foot_m - unknown[2] * self.normal
        out = np.empty((*point_m.shape[:-1], 3, 3))
        out[..., :2, :], out[..., 2, :] = self._mirrored_slope(away, unknown), 2.0 * (normal @ self.normal) * normal
        return out

    def _mirrored_slope(self, away: FloatArray, unknown: FloatArray) -> FloatArray:
        """Return d (w - 2 (n.w) n) / d tilts of w (..., 3), shape (..., 2, 3)."""
        turn, normal = self.normal_slope(unknown), self.turned_normal(unknown)
        return np.asarray(-2.0 * ((away @ turn.T)[..., None] * normal + (away @ normal)[..., None, None] * turn))

    def normal_slope(self, unknown: FloatArray) -> FloatArray:
        """Return d n / d tilts, n as `turned_normal` returns it, shape (2, 3)."""
        tangents, normal = _tangents(tuple(self.normal.tolist())), self.turned_normal(unknown)
        along = tangents @ normal
        # n (n0 + tilts) is the length of what was normalised
        return np.asarray((tangents - along[:, None] * normal) / (normal @ self.normal + along @ unknown[:2]))


def has_floor(planes: Sequence[MirrorPlane]) -> bool:
    """Return whether the first mirror is a floor; no other is."""
    return bool(planes) and planes[0].name == FLOOR


def edges_of(planes: Sequence[MirrorPlane]) -> StatedEdges | None:
    """Return where the floor among mirrors ends; None where there is none, or none whose edges count."""
    return planes[0].edges if has_floor(planes) else None


def walls_of(planes: tuple[MirrorPlane, ...]) -> tuple[MirrorPlane, ...]:
    """Return the mirrors that are no floor."""
    return planes[has_floor(planes) :]


def distances(place_m: FloatArray, points_m: FloatArray) -> FloatArray:
    """Return |p - a| for places (..., 3, n) and some antennas or images a, (..., n_points, 3), (..., n_points, n).

    |p|^2 + |a|^2 - 2 p.a is a product of matrices; a tracer keeps centimetres away from them.
    """
    square = (points_m**2).sum(axis=-1)[..., None] + (place_m * place_m).sum(axis=-2)[..., None, :]
    square -= 2.0 * (points_m @ place_m)
    return np.asarray(np.sqrt(square, out=square))


def turned(phase: FloatArray) -> ComplexArray:
    """Return exp(j phase) = (1 - t^2 + 2 j t) / (1 + t^2), shape as the phase, t the tangent of its half.

    numpy computes a tangent many elements at a time where it takes cosines and sines one by one.
    """
    # its poles do no harm: there the share is zero and both parts keep their limits
    tangent = np.tan(0.5 * phase)
    square = tangent * tangent
    share = 1.0 / (1.0 + square)
    out = np.empty(phase.shape, complex)
    out.real, out.imag = (1.0 - square) * share, 2.0 * tangent * share
    return out


@lru_cache(maxsize=512)
def _tangents(direction: tuple[float, ...]) -> FloatArray:
    """Return two directions across a unit vector, shape (2, 3)."""
    normal = np.array(direction)
    # the axis farthest from the normal, so that the cross product is never small
    least = np.eye(3)[int(np.argmin(np.abs(normal)))]
    first = np.cross(normal, least)
    first /= np.linalg.norm(first)
    return np.array([first, np.cross(normal, first)])
