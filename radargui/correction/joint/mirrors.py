"""Plane reflectors as physics: what mirrors add to the field at a receiver (image theory)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from radargui.geometry.reflectors import mirror
from radargui.model.arrays import FloatArray

ComplexArray: TypeAlias = NDArray[np.complex128]
_STEP = 1e-6
_U_TILT, _U_SHIFT_M = 0.03, 0.03


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
        For people.
    u_turn
        Prior standard deviation of the first tilt, rad: of a wall its azimuth, which a search knows only to some
        degrees.
    """

    foot_m: FloatArray
    normal: FloatArray
    name: str
    u_turn: float = 0.03

    @property
    def deviations(self) -> tuple[float, float, float]:
        """Prior standard deviations of the unknowns: two tilts (rad), shift (m)."""
        return self.u_turn, _U_TILT, _U_SHIFT_M

    def image(self, point_m: FloatArray, unknown: FloatArray) -> FloatArray:
        """Return the mirror image of a point for two tilts (rad) and a shift along the normal (m)."""
        first, second = _tangents(tuple(self.normal.tolist()))
        normal = self.normal + unknown[0] * first + unknown[1] * second
        normal = normal / np.linalg.norm(normal)
        return mirror(point_m, normal, float(normal @ (self.foot_m + unknown[2] * self.normal)))

    def image_slope(self, point_m: FloatArray, unknown: FloatArray) -> FloatArray:
        """Return d image / d unknown, shape (3 unknowns, 3)."""
        return np.array(
            [
                (self.image(point_m, unknown + step) - self.image(point_m, unknown - step)) / (2.0 * _STEP)
                for step in _STEP * np.eye(3)
            ]
        )


@dataclass(frozen=True, slots=True)
class Detour:
    """The path over one mirror relative to the direct path, phase referenced to the release position.

    rho(p) = (r / r') exp(jK [(r' - r) - (r' - r at release)]), r = |p - a|, r' = |p - a'|.

    Attributes
    ----------
    ratio
        rho, shape (...).
    slope
        d rho / dp, shape (3, ...).
    plane
        d rho / d(tilt, tilt, shift), shape (3, ...).
    """

    ratio: ComplexArray
    slope: ComplexArray
    plane: ComplexArray


def detour(
    place: FloatArray, antenna_m: FloatArray, plane: MirrorPlane, unknown: FloatArray, release_m: FloatArray, k: float
) -> Detour:
    """Return the detour over a mirror for places (3, ...), k the wavenumber."""
    tail = (1,) * (place.ndim - 1)

    def at(point: FloatArray) -> FloatArray:
        return point.reshape(3, *tail)

    image = plane.image(antenna_m, unknown)
    direct, mirrored = place - at(antenna_m), place - at(image)
    r, r_image = (np.sqrt((away * away).sum(axis=0)) for away in (direct, mirrored))
    at_rest = release_m - image
    difference = r_image - r - (np.linalg.norm(at_rest) - np.linalg.norm(release_m - antenna_m))
    ratio = r / r_image * np.exp(1j * k * difference)
    direct, mirrored = direct / r, mirrored / r_image
    moved = plane.image_slope(antenna_m, unknown)
    lengthened = -np.tensordot(moved, mirrored, axes=(1, 0))
    at_release = -(moved @ at_rest / np.linalg.norm(at_rest)).reshape(3, *tail)
    slope = 1j * k * (mirrored - direct) + direct / r - mirrored / r_image
    by_plane = 1j * k * (lengthened - at_release) - lengthened / r_image
    return Detour(ratio, ratio * slope, ratio * by_plane)


def detour_ratio(
    place: FloatArray, antenna_m: FloatArray, plane: MirrorPlane, unknown: FloatArray, release_m: FloatArray, k: float
) -> ComplexArray:
    """Return only rho of the detour over a mirror, without derivatives."""
    image = plane.image(antenna_m, unknown)

    def distance(point: FloatArray) -> FloatArray:
        x, y, z = place - point.reshape(3, *(1,) * (place.ndim - 1))
        return np.asarray(np.sqrt(x * x + y * y + z * z))

    r, r_image = distance(antenna_m), distance(image)
    at_rest = np.linalg.norm(release_m - image) - np.linalg.norm(release_m - antenna_m)
    phase = k * (r_image - r - at_rest)
    return np.asarray(r / r_image * (np.cos(phase) + 1j * np.sin(phase)))


@lru_cache(maxsize=512)
def _tangents(direction: tuple[float, ...]) -> tuple[FloatArray, FloatArray]:
    normal = np.array(direction)
    least = np.eye(3)[int(np.argmin(np.abs(normal)))]
    first = np.cross(normal, least)
    first /= np.linalg.norm(first)
    return first, np.cross(normal, first)
