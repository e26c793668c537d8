"""What a plate reflects, at every angle and in both polarisations: Fresnel's coefficients and Airy's sum (method 1).

Both coefficients count as of a perfect conductor's image, which is 1: R_TE = -r_s, R_TM = r_p (Born & Wolf, section
1.5.2, and 1.6.4 for the plate), time factor exp(-i w t).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from radargui.model.arrays import ComplexArray, FloatArray
from radargui.model.assumed import u_reflection
from radargui.model.radar import METAL, PLATES, Floor
from radargui.model.setup import Setup

_LEAST = 0.05  # |R| that ratios are taken to: some plates reflect nothing straight down
_ACROSS = 1e-12  # of sin^2: straight down both polarisations are one


@dataclass(frozen=True, slots=True)
class Plate:
    """A plane plate and what is below it; steel is `Plate(None)`.

    Attributes
    ----------
    index
        Refractive index against the air's, its imaginary part the loss; None of metal.
    thickness_m
        Of the plate.
    backing
        Refractive index of what is below it; None of metal.
    """

    index: complex | None
    thickness_m: float = 0.0
    backing: complex | None = 1.0

    @staticmethod
    def of(floor: Floor) -> Plate | None:
        """Return the plate of a setup's floor; None where it does not say of what it is."""
        if floor.material == "steel":
            return Plate(None)
        index = PLATES[floor.material] if floor.material is not None else floor.refractive_index
        if index is None or floor.thickness_m is None:
            return None
        below = floor.backing
        # air, where nothing is said
        backing = None if below == METAL else complex(below) if isinstance(below, float) else 1.0 + 0j
        return Plate(complex(index), floor.thickness_m, backing)

    def coefficients(self, cosine: FloatArray | ComplexArray, wavenumber: float) -> tuple[ComplexArray, ComplexArray]:
        """Return R_TE and R_TM at cosines of the angle of incidence, both of its shape; K in 1/m.

        Complex cosines, of evanescent waves, have no negative part.
        """
        square = 1.0 - cosine**2
        if self.index is None:
            one = np.ones(cosine.shape, complex)
            return one, one
        inside = np.asarray(np.sqrt(self.index**2 - square + 0j))
        s_top, p_top = _fresnel(1.0, np.asarray(cosine + 0j), self.index, inside)
        if self.backing is None:
            s_low, p_low = -np.ones(cosine.shape, complex), np.ones(cosine.shape, complex)
        else:
            below = np.asarray(np.sqrt(self.backing**2 - square + 0j))
            s_low, p_low = _fresnel(self.index, inside, self.backing, below)
        turn = np.exp(2j * wavenumber * self.thickness_m * inside)
        r_s, r_p = ((top + low * turn) / (1.0 + top * low * turn) for top, low in ((s_top, s_low), (p_top, p_low)))
        return -r_s, r_p

    def straight_down(self, wavenumber: float) -> complex:
        """Return R straight down, 0.05 at least: what is counted against it has to be there."""
        found = complex(self.coefficients(np.ones(1), wavenumber)[0][0])
        return found * max(1.0, _LEAST / max(abs(found), 1e-9))

    def parts(
        self, direction: FloatArray, normal: FloatArray, field: FloatArray, wavenumber: float
    ) -> tuple[ComplexArray, ComplexArray]:
        """Return what fields are reflected as, over R straight down: a share of the image's field, and of the normal.

        The image of a perfect conductor has the mirrored field e, across the way k. What a plate leaves of it is R_TE e
        + (R_TM - R_TE) p (p.e), p along n - k (k.n), and what is along k radiates nothing: R_TE e + v n.

        Parameters
        ----------
        direction
            Unit vectors k of the ways beyond the plate, shape (..., 3, n).
        normal
            Of the plate, shape (3,).
        field
            e, shape (..., n_fields, 3).
        wavenumber
            1/m.

        Returns
        -------
        tuple
            R_TE, shape (..., n), and v, shape (..., n_fields, n).
        """
        along = np.einsum("i,...in->...n", normal, direction)
        r_te, r_tm = self.coefficients(np.abs(along), wavenumber)
        across = (field @ normal)[..., None] - along[..., None, :] * (field @ direction)
        share = (r_tm - r_te) / np.maximum(1.0 - along**2, _ACROSS)
        straight = self.straight_down(wavenumber)
        return np.asarray(r_te / straight), np.asarray(share[..., None, :] * across / straight)


@dataclass(frozen=True, slots=True)
class StatedSurface:
    """What the setup says that a floor reflects.

    Attributes
    ----------
    reflection, u_reflection
        |R| straight down.
    plate
        Of what it is: R at every angle, and its phase at the surface; None where only |R| is known.
    touch_m
        How high over its surface the centre of the sphere is that touches it.
    """

    reflection: float
    u_reflection: float
    plate: Plate | None = None
    touch_m: float = 0.0

    @staticmethod
    def of(setup: Setup) -> StatedSurface | None:
        """Return what a setup says; None where it leaves it open."""
        floor = setup.floor
        if floor.reflection is not None:
            return StatedSurface(floor.reflection, u_reflection(floor))
        plate = Plate.of(floor)
        if plate is None:
            return None
        straight = plate.straight_down(2.0 * np.pi / setup.radar.wavelength_m)
        return StatedSurface(abs(straight), u_reflection(floor), plate, 0.5 * setup.tracer.diameter_m)


def _fresnel(n_1: complex, q_1: ComplexArray, n_2: complex, q_2: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
    """Return r_s and r_p of a surface between two media, each its index n and q, that times the cosine in it."""
    r_s = (q_1 - q_2) / (q_1 + q_2)
    r_p = (n_2**2 * q_1 - n_1**2 * q_2) / (n_2**2 * q_1 + n_1**2 * q_2)
    return np.asarray(r_s), np.asarray(r_p)
