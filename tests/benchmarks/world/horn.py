"""A horn near by: the wave of an aperture with a curved front, whose centre of phase is no single point."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import RectBivariateSpline

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

_RANGES_M, _ANGLES_RAD = np.linspace(0.12, 2.2, 80), np.radians(np.linspace(0.0, 36.0, 37))
_RINGS, _SPOKES = 20, 48
_VIEW_RAD = np.radians(20.0)
_BEHIND_M = np.linspace(0.0, 0.3, 301)


@dataclass(frozen=True)
class Horn:
    """A conical horn.

    Attributes
    ----------
    radius_m, flare_m
        Of the aperture, and its distance from the apex: the front is a sphere about that.
    wavenumber_rad_m
        K.
    distance_m
        From the best centre of phase to the middle of the field of view, where the factor is 1.
    """

    radius_m: float
    flare_m: float
    wavenumber_rad_m: float
    distance_m: float

    def __post_init__(self) -> None:
        """Tabulate the wave about the aperture, and find the point from which it seems to come."""
        size, late = self._wave()
        view = _ANGLES_RAD <= _VIEW_RAD
        angle, range_m = _ANGLES_RAD[None, view], _RANGES_M[:, None]
        residuals = []
        for behind in _BEHIND_M:
            centred = np.sqrt(range_m**2 + behind**2 + 2.0 * range_m * behind * np.cos(angle))
            near = np.abs(centred - self.distance_m) < 0.25
            residuals.append(float(np.std((late[:, view] - self.wavenumber_rad_m * (centred - range_m))[near])))
        object.__setattr__(self, "behind_m", float(_BEHIND_M[int(np.argmin(residuals))]))
        object.__setattr__(self, "_size", RectBivariateSpline(_RANGES_M, _ANGLES_RAD, np.log(size)))
        object.__setattr__(self, "_late", RectBivariateSpline(_RANGES_M, _ANGLES_RAD, late))
        object.__setattr__(self, "_middle", self._seen(np.array([self.distance_m]), np.zeros(1))[0])

    behind_m: float = 0.0
    """How far behind the aperture the best centre of phase lies, for the field of view."""

    def factor(self, cosine: Array, range_m: Array) -> Complex:
        """Return the wave over the spherical one from the best centre of phase, shape (n,).

        Parameters
        ----------
        cosine, range_m
            Of the angle from the axis and of the distance, both about that centre.
        """
        return self._seen(range_m, np.arccos(np.clip(cosine, -1.0, 1.0))) / self._middle  # type: ignore[attr-defined]

    def _seen(self, range_m: Array, angle: Array) -> Complex:
        forward = range_m * np.cos(angle) - self.behind_m
        about = np.hypot(forward, range_m * np.sin(angle))
        bent = np.arctan2(range_m * np.sin(angle), forward)
        # beyond the table side lobes take over, which the antenna adds
        bent = np.clip(bent, 0.0, _ANGLES_RAD[-1])
        size, late = (table.ev(about, bent) for table in (self._size, self._late))  # type: ignore[attr-defined]
        return np.exp(size + 1j * (late + self.wavenumber_rad_m * (about - range_m))) * range_m / about

    def _wave(self) -> tuple[Array, Array]:
        """Return |wave| times range, and its phase beyond K range, at the table's ranges and angles, shape (80, 37).

        Huygens' sum over the aperture, whose field goes as cos(pi rho / 2 a).
        """
        node, weight = np.polynomial.legendre.leggauss(_RINGS)
        ring = self.radius_m * 0.5 * (node + 1.0)
        spoke = 2.0 * np.pi * np.arange(_SPOKES) / _SPOKES
        source = np.cos(0.5 * np.pi * ring / self.radius_m) * ring * weight
        source = source * np.exp(1j * self.wavenumber_rad_m * (np.hypot(self.flare_m, ring) - self.flare_m))
        x = _RANGES_M[:, None] * np.sin(_ANGLES_RAD)
        away = np.sqrt(
            _RANGES_M[:, None, None, None] ** 2
            + ring[:, None] ** 2
            - 2.0 * x[..., None, None] * ring[:, None] * np.cos(spoke)
        )  # fmt: skip
        turn = np.exp(1j * self.wavenumber_rad_m * (away - _RANGES_M[:, None, None, None])) / away
        wave = np.einsum("r,abrs->ab", source, turn) * _RANGES_M[:, None]
        return np.abs(wave), np.unwrap(np.angle(wave), axis=1)
