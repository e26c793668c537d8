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

    def seen(
        self, antenna_m: Array, position_m: Array, normal: Array, field: Complex, wavenumber_rad_m: float
    ) -> Complex:
        """Return the wave over the plate to positions (3, n), over that of an endless surface, shape (n,).

        Physical optics: a reflection and four edges. An edge that the sphere sees from the side where the reflection
        lies takes the tail of a Fresnel integral off, of u = sqrt(2 K D / pi), D by which the way over the edge is
        longer (Born & Wolf, section 11.5); how strong it is follows from Kirchhoff's integral by stationary phase.
        `field` (3, n), behind the reflection: across an edge it radiates with the cosine of the way up to the sphere.
        Corners are left out; paraxial integrals, as near a shadow's edge, are wrong by half the wave where the sphere
        is nearer to the plate than to its edge.
        """
        up, above = normal @ (position_m - self.centre_m[:, None]), float(normal @ (antenna_m - self.centre_m))
        there, here = self.axes @ (antenna_m - self.centre_m), self.axes @ (position_m - self.centre_m[:, None])
        straight = np.sqrt(((here - there[:, None]) ** 2).sum(axis=0) + (up + above) ** 2)
        legs = above * straight / (up + above), up * straight / (up + above)
        spot = here + (there[:, None] - here) * up / (up + above)
        parts = np.abs(self.axes @ field) ** 2
        across = parts / np.maximum(parts.sum(axis=0), 1e-300)
        out = np.ones(up.size, complex)
        for side, half in enumerate(self.half_m):
            along = here[1 - side] - there[1 - side]
            total = np.zeros(up.size, complex)
            for sign in (1.0, -1.0):
                first, second = sign * half - there[side], sign * half - here[side]
                rise = np.hypot(first, above), np.hypot(second, up)
                way = np.hypot(rise[0] + rise[1], along)
                before, behind = (one * way / (rise[0] + rise[1]) for one in rise)
                longer = np.maximum(way - straight, 1e-9)
                # stationary phase: what arrives, over the slope of the phase and the root of its curvature
                slope = np.maximum(np.abs(first / before + second / behind), 1e-12)
                bends = (1.0 / before + 1.0 / behind) * (1.0 - (along / way) ** 2)
                reflects = (1.0 / legs[0] + 1.0 / legs[1]) * (up + above) / straight
                tail = legs[0] * legs[1] / (before * behind) * reflects / np.sqrt(bends) / slope
                tail = tail * np.sqrt(2.0 * longer)
                tail = tail * (across[side] * legs[1] / behind + (1.0 - across[side]) * legs[0] / before)
                tail = np.where(longer > 1e-8, tail, 1.0)
                lit = np.where(half - sign * spot[side] >= 0.0, 1.0, -1.0)
                end = lit * np.sqrt(2.0 * wavenumber_rad_m * longer / np.pi)
                total += 0.5 * lit + (_fresnel(end) - 0.5 * lit) * tail
            out *= total
        return out


def _fresnel(upper: Array) -> Complex:
    """Return (1 - i) / 2 times the integral of exp(i pi t^2 / 2) from 0: plus and minus a half at both infinities."""
    sine, cosine = fresnel(upper)
    return 0.5 * (1.0 - 1j) * (cosine + 1j * sine)


def permittivity_of(reflection: float) -> float:
    """Return the permittivity that reflects a wave straight down by this share: n = (1 + r) / (1 - r)."""
    return ((1.0 + reflection) / (1.0 - reflection)) ** 2
