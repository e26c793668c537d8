"""Plane reflectors as physics: what mirrors add to the field at a receiver (image theory; method 1 and 4, Mirrors)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from radargui.geometry.reflectors import mirror
from radargui.model.arrays import ComplexArray, FloatArray

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
    """

    foot_m: FloatArray
    normal: FloatArray
    name: str
    u_turn_rad: float = 0.03
    u_tilt_rad: float = 0.03
    u_shift_m: float = 0.03

    @property
    def deviations(self) -> tuple[float, float, float]:
        """Prior standard deviations of the unknowns: two tilts (rad), shift (m)."""
        return self.u_turn_rad, self.u_tilt_rad, self.u_shift_m

    def image(self, point_m: FloatArray, unknown: FloatArray) -> FloatArray:
        """Return the mirror image of a point for two tilts (rad) and a shift along the normal (m)."""
        normal = self._tilted(unknown)
        return mirror(point_m, normal, float(normal @ (self.foot_m + unknown[2] * self.normal)))

    def turned(self, direction: FloatArray, unknown: FloatArray) -> FloatArray:
        """Return the mirror image of directions, shape (..., 3)."""
        # a direction has no place: mirrored in the parallel plane through the origin
        return mirror(direction, self._tilted(unknown), 0.0)

    def _tilted(self, unknown: FloatArray) -> FloatArray:
        first, second = _tangents(tuple(self.normal.tolist()))
        # small turns as sums; normalised, so that the image keeps its distance
        normal = self.normal + unknown[0] * first + unknown[1] * second
        return np.asarray(normal / np.linalg.norm(normal))

    def image_slope(self, point_m: FloatArray, unknown: FloatArray) -> FloatArray:
        """Return d image / d unknown, shape (3 unknowns, 3).

        a' = a - 2 (n.w) n, w = a - foot - shift n0, n = (n0 + tilts) / length, dn / d tilt = (t - n (n.t)) / length.
        """
        first, second = _tangents(tuple(self.normal.tolist()))
        normal = self.normal + unknown[0] * first + unknown[1] * second
        length = np.linalg.norm(normal)
        normal = normal / length
        away = point_m - self.foot_m - unknown[2] * self.normal
        turned = [(tangent - normal * (normal @ tangent)) / length for tangent in (first, second)]
        by_tilts = [-2.0 * ((turn @ away) * normal + (normal @ away) * turn) for turn in turned]
        return np.array([*by_tilts, 2.0 * (normal @ self.normal) * normal])


@dataclass(frozen=True, slots=True)
class Detour:
    """The path over one mirror relative to the direct path, phase referenced to the release position.

    rho(p) = (r / r') exp(jK [(r' - r) - (r' - r at release)]), r = |p - a|, r' = |p - a'|.

    Attributes
    ----------
    ratio
        rho, shape (...).
    slope
        d ln rho / dp, shape (3, ...).
    plane
        d ln rho / d(tilt, tilt, shift), shape (3, ...).
    """

    ratio: ComplexArray
    slope: ComplexArray
    plane: ComplexArray


def detour(
    place: FloatArray, antenna_m: FloatArray, plane: MirrorPlane, unknown: FloatArray, release_m: FloatArray, k: float
) -> Detour:
    """Return the detour over a mirror for places (3, ...), k the wavenumber."""
    tail = (1,) * (place.ndim - 1)
    image = plane.image(antenna_m, unknown)
    direct, mirrored = place - antenna_m.reshape(3, *tail), place - image.reshape(3, *tail)
    r, r_image = _length(direct), _length(mirrored)
    # zero at the release: else every shift of the plane would turn T and R by radians, and nothing would converge
    at_rest = release_m - image
    rest_m = np.linalg.norm(at_rest)
    phase = k * (r_image - r - (rest_m - np.linalg.norm(release_m - antenna_m)))
    # spreading: the longer way arrives weaker
    ratio = r / r_image * turned(phase)
    direct, mirrored = direct / r, mirrored / r_image
    moved = plane.image_slope(antenna_m, unknown)
    lengthened = -(moved @ mirrored.reshape(3, -1)).reshape(place.shape)
    at_release = -(moved @ at_rest / rest_m).reshape(3, *tail)
    slope, by_plane = np.empty(place.shape, complex), np.empty(place.shape, complex)
    # amplitude in the real part, phase in the imaginary one: d ln rho needs no division by rho
    slope.real, slope.imag = direct / r - mirrored / r_image, k * (mirrored - direct)
    by_plane.real, by_plane.imag = -lengthened / r_image, k * (lengthened - at_release)
    return Detour(ratio, slope, by_plane)


def detour_ratio(
    place: FloatArray, antenna_m: FloatArray, plane: MirrorPlane, unknown: FloatArray, release_m: FloatArray, k: float
) -> ComplexArray:
    """Return only rho of the detour over a mirror, without derivatives."""
    image = plane.image(antenna_m, unknown)

    tail = (1,) * (place.ndim - 1)
    r, r_image = (_length(place - point.reshape(3, *tail)) for point in (antenna_m, image))
    at_rest = np.linalg.norm(release_m - image) - np.linalg.norm(release_m - antenna_m)
    return np.asarray(r / r_image * turned(k * (r_image - r - at_rest)))


def _length(vectors: FloatArray) -> FloatArray:
    x, y, z = vectors
    return np.asarray(np.sqrt(x * x + y * y + z * z))


def turned(phase: FloatArray) -> ComplexArray:
    """Return exp(j phase) = (1 - t^2 + 2 j t) / (1 + t^2), t the tangent of half the phase.

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
def _tangents(direction: tuple[float, ...]) -> tuple[FloatArray, FloatArray]:
    normal = np.array(direction)
    # the axis farthest from the normal, so that the cross product is never small
    least = np.eye(3)[int(np.argmin(np.abs(normal)))]
    first = np.cross(normal, least)
    first /= np.linalg.norm(first)
    return first, np.cross(normal, first)
