"""A plane that reflects: an imperfect conductor, or a dielectric after Fresnel, a plate with edges."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.special import fresnel

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True)
class Mirror:
    """The plane normal . x = offset that reflects on the side to which its normal points.

    Attributes
    ----------
    normal, offset_m
        Unit vector (3,) and its distance from the origin along it.
    plate
        How far the surface goes; None: without end.
    """

    normal: Array
    offset_m: float
    plate: Plate | None = field(default=None, kw_only=True)

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

    def straight_down(self) -> complex:
        """Return R at normal incidence: 1 of a conductor, that is minus the tangential field's reflection."""
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

    def straight_down(self) -> complex:
        """Return the mean of what the antennas see."""
        return complex(self.reflection.mean())


@dataclass(frozen=True)
class Dielectric(Mirror):
    """A half-space of relative permittivity `permittivity` (complex: with loss, imaginary part positive)."""

    permittivity: complex = 2.5

    def reflected(self, direction: Array, incident: Complex, antenna: int) -> Complex:
        """Return Fresnel's field: r_s along s = k x n and r_p from p = s x k to p' = s x k'."""
        del antenna
        across = np.cross(direction, self.normal, axisb=0, axisa=0, axisc=0)
        size = np.linalg.norm(across, axis=0)
        # straight down s is any direction along the plane: r_p = -r_s there, one field whatever is chosen
        spare = np.cross(self.normal, np.eye(3)[np.abs(self.normal).argmin()])[:, None]
        across = np.where(size > 1e-9, across, spare)
        across = across / np.linalg.norm(across, axis=0)
        r_s, r_p = self.ratios(np.abs(self.normal @ direction))
        before = np.cross(across, direction, axis=0)
        after = np.cross(across, self.mirrored(direction), axis=0)
        s_part, p_part = (np.einsum("in,in->n", one, incident) for one in (across, before))
        return r_s * s_part * across + r_p * p_part * after

    def over_conductor(self, cosine: Complex) -> tuple[Complex, Complex]:
        """Return -r_s and r_p at cosines, complex ones too: what the field is over that of a conductor."""
        r_s, r_p = self.ratios(cosine)
        return -r_s, r_p

    def ratios(self, cosine: Array | Complex) -> tuple[Complex, Complex]:
        """Return r_s and r_p at the cosines c of the angle of incidence.

        r_s = (c - q) / (c + q), r_p = (eps c - q) / (eps c + q), q = sqrt(eps - sin^2) (Born & Wolf, section 1.5.2; a
        conductor has r_s = -1, r_p = 1).
        """
        root = np.sqrt(self.permittivity - 1.0 + cosine**2 + 0j)
        r_p = (self.permittivity * cosine - root) / (self.permittivity * cosine + root)
        return (cosine - root) / (cosine + root), r_p

    def straight_down(self) -> complex:
        """Return minus r_s at normal incidence."""
        return complex(-self.ratios(np.ones(1))[0][0])


@dataclass(frozen=True)
class Slab(Dielectric):
    """A plate of dielectric in free air: `thickness_m` thick, K the wavenumber in air."""

    thickness_m: float = 0.01
    wavenumber_rad_m: float = 2.0 * np.pi / 0.03

    def ratios(self, cosine: Array | Complex) -> tuple[Complex, Complex]:
        """Return r (1 - e) / (1 - r^2 e) of both polarisations, e = exp(2 i K d q) (Born & Wolf, section 1.6.4)."""
        turn = np.exp(
            2j * self.wavenumber_rad_m * self.thickness_m * np.sqrt(self.permittivity - 1.0 + cosine**2 + 0j)
        )  # fmt: skip
        r_s, r_p = (r * (1.0 - turn) / (1.0 - r**2 * turn) for r in super().ratios(cosine))
        return r_s, r_p


@dataclass(frozen=True)
class Plate:
    """Where a reflecting surface ends: a rectangle.

    Attributes
    ----------
    centre_m
        On the surface, shape (3,).
    axes
        Unit vectors along the sides, shape (2, 3).
    half_m
        Half of each side.
    """

    centre_m: Array
    axes: Array
    half_m: tuple[float, float]

    def seen(self, image_m: Array, position_m: Array, normal: Array, wavenumber_rad_m: float) -> Complex:
        """Return the wave over the plate to positions (3, n), over that of an endless surface, shape (n,).

        Kirchhoff's integral about the point of reflection, to second order in the way: along each side a Fresnel
        integral between its edges (Born & Wolf, section 8.7.3), with the curvature (1 / r + 1 / r') (1 - u^2), u the
        part of the direction along the side. The mixed term u u' of ways aslant to both sides is left out.
        """
        way = position_m - image_m[:, None]
        length = np.linalg.norm(way, axis=0)
        behind = normal @ (self.centre_m[:, None] - image_m[:, None]) / (normal @ way)
        behind = np.clip(behind, 1e-6, 1.0 - 1e-6)
        touched = image_m[:, None] + behind * way - self.centre_m[:, None]
        curved = 1.0 / (behind * length) + 1.0 / ((1.0 - behind) * length)
        out = np.ones(length.size, complex)
        for axis, half in zip(self.axes, self.half_m, strict=True):
            scale = np.sqrt(wavenumber_rad_m / np.pi * curved * (1.0 - (axis @ way / length) ** 2))
            place = axis @ touched
            out *= _fresnel(scale * (half - place)) - _fresnel(scale * (-half - place))
        return out


def _fresnel(upper: Array) -> Complex:
    """Return (1 - i) / 2 times the integral of exp(i pi t^2 / 2) from 0: plus and minus a half at both infinities."""
    sine, cosine = fresnel(upper)
    return 0.5 * (1.0 - 1j) * (cosine + 1j * sine)


def permittivity_of(reflection: float) -> float:
    """Return the permittivity that reflects a wave straight down by this share: n = (1 + r) / (1 - r)."""
    return ((1.0 + reflection) / (1.0 - reflection)) ** 2
