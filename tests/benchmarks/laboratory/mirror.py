"""A plane that reflects: an imperfect conductor, or a dielectric after Fresnel."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True)
class Mirror:
    """The plane normal . x = offset that reflects on the side to which its normal points.

    Attributes
    ----------
    normal, offset_m
        Unit vector (3,) and its distance from the origin along it.
    """

    normal: Array
    offset_m: float

    def height_m(self, point: Array) -> float:
        """Return how far in front of the plane a point lies."""
        return float(self.normal @ point - self.offset_m)

    def image(self, point: Array) -> Array:
        """Return the image of a point (3,)."""
        return point - 2.0 * self.height_m(point) * self.normal

    def mirrored(self, vector: Array) -> Array:
        """Return directions or fields (3, ...) mirrored."""
        return vector - 2.0 * np.multiply.outer(self.normal, np.tensordot(self.normal, vector, axes=1))

    def reflected(self, direction: Array, incident: Complex, antenna: int) -> Complex:
        """Return the field (3, n) behind the reflection of `incident` (3, n) that came along `direction` (3, n)."""
        raise NotImplementedError


@dataclass(frozen=True)
class Conductor(Mirror):
    """The boundary condition of a conductor, E tangential = 0, times what the surface leaves of the wave.

    `reflection` has one complex number an antenna (0 the transmitter): each looks at another spot of the surface.
    """

    reflection: Complex = field(default_factory=lambda: np.ones(5, complex))

    def reflected(self, direction: Array, incident: Complex, antenna: int) -> Complex:
        """Return minus the mirrored field, times the antenna's reflection."""
        del direction
        return -self.reflection[antenna] * self.mirrored(incident)


@dataclass(frozen=True)
class Dielectric(Mirror):
    """A half-space of relative permittivity `permittivity` (complex: with loss, imaginary part positive)."""

    permittivity: complex = 2.5

    def reflected(self, direction: Array, incident: Complex, antenna: int) -> Complex:
        """Return Fresnel's field: r_s along s = k x n and r_p from p = s x k to p' = s x k'.

        r_s = (c - q) / (c + q), r_p = (eps c - q) / (eps c + q), q = sqrt(eps - sin^2), c the cosine of incidence
        (Born & Wolf, section 1.5.2; a conductor has r_s = -1, r_p = 1).
        """
        del antenna
        across = np.cross(direction, self.normal, axisb=0, axisa=0, axisc=0)
        size = np.linalg.norm(across, axis=0)
        # straight down s is any direction along the plane: r_p = -r_s there, one field whatever is chosen
        spare = np.cross(self.normal, np.eye(3)[np.abs(self.normal).argmin()])[:, None]
        across = np.where(size > 1e-9, across, spare)
        across = across / np.linalg.norm(across, axis=0)
        cosine = np.abs(self.normal @ direction)
        root = np.sqrt(self.permittivity - 1.0 + cosine**2 + 0j)
        r_s = (cosine - root) / (cosine + root)
        r_p = (self.permittivity * cosine - root) / (self.permittivity * cosine + root)
        before = np.cross(across, direction, axis=0)
        after = np.cross(across, self.mirrored(direction), axis=0)
        s_part, p_part = (np.einsum("in,in->n", one, incident) for one in (across, before))
        return r_s * s_part * across + r_p * p_part * after


def permittivity_of(reflection: float) -> float:
    """Return the permittivity that reflects a wave straight down by this share: n = (1 + r) / (1 - r)."""
    return ((1.0 + reflection) / (1.0 - reflection)) ** 2
