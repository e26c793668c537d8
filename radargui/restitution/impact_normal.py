"""The floor's normal from the velocities at the impacts, weighed against a level floor."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.restitution.floor_normal import UP

_TILT_SD = np.tan(np.radians([1.0, 2.0, 4.0, 8.0, 16.0]))
_KICK_SD_M_S = np.geomspace(3e-4, 0.5, 32)
_FRICTION = np.linspace(0.0, 2.0 / 7.0, 7)
_TILTED, _CLEARLY = 0.1, 0.9


@dataclass(frozen=True, slots=True)
class FloorNormal:
    """Direction away from the floor.

    Attributes
    ----------
    normal
        Unit vector, shape (3,).
    slope_variance
        Variance of normal_x / normal_z and of normal_y / normal_z; zero where the setup gives the normal.
    tilted
        Whether the impacts say that the floor is not level.
    """

    normal: FloatArray
    slope_variance: float = 0.0
    tilted: bool = False

    @property
    def tilt_deg(self) -> float:
        """Angle from the vertical."""
        return float(np.degrees(np.arctan2(np.hypot(*self.normal[:2]), self.normal[2])))

    @property
    def u_tilt_deg(self) -> float:
        """Standard uncertainty of the angle."""
        return float(np.degrees(np.sqrt(self.slope_variance)))

    @property
    def azimuth_deg(self) -> float:
        """Direction in which the floor falls, from the x axis."""
        return float(np.degrees(np.arctan2(self.normal[1], self.normal[0])) % 360.0)

    def e_variance(self, before_m_s: FloatArray, after_m_s: FloatArray) -> float:
        """Return what the normal adds to the variance of e = -(after . n) / (before . n), velocities of shape (3,)."""
        b, a = float(before_m_s @ self.normal), float(after_m_s @ self.normal)
        by_slope = (-after_m_s[:2] / b + a * before_m_s[:2] / b**2) * self.normal[2]
        return float(self.slope_variance * (by_slope**2).sum())


def normal_of_impacts(before_m_s: FloatArray, after_m_s: FloatArray, u_m_s: FloatArray) -> FloorNormal:
    """Return the normal that the velocities' changes at the impacts support; level unless they say otherwise.

    A sphere is pushed along the normal n ~ (t_x, t_y, 1), loses a share r of its speed along the floor by friction
    (0 without; 2/7 where a solid sphere grips and rolls, Cross 2002) and is kicked aside by what the floor's surface
    is like:

        dv_xy = t dv_z - r (v_xy - t v_z) + k,   k ~ N(0, s^2 + u^2) an axis

    with v before the impact. A level floor (t = 0) and a tilted one, t ~ N(0, tan^2 of 1 to 16 degrees), prior odds
    9 to 1 (floors in a laboratory are level unless the setup says otherwise), are weighed by their evidence; r and s
    (log uniform, 0.3 mm/s to 0.5 m/s) are summed over. One impact cannot tell a tilt from a kick: then the floor counts
    as level and the uncertainty is that of both. The tilt is taken where its probability exceeds 90 %.

    Parameters
    ----------
    before_m_s, after_m_s
        Velocities at the impacts, shape (n_impacts, 3).
    u_m_s
        Standard uncertainty of a horizontal component of their difference, shape (n_impacts,).
    """
    change = after_m_s - before_m_s
    friction, kick = _FRICTION[:, None, None], _KICK_SD_M_S[None, :, None]
    weight = 1.0 / (kick**2 + u_m_s**2)
    push = change[:, 2] + friction * before_m_s[:, 2]
    side = [change[:, axis] + friction * before_m_s[:, axis] for axis in (0, 1)]
    a = (weight * push**2).sum(axis=2)
    b = [(weight * push * own).sum(axis=2) for own in side]
    level = np.log(weight).sum(axis=2) - 0.5 * sum((weight * own**2).sum(axis=2) for own in side)
    stiffness = a[..., None] + _TILT_SD**-2.0
    gain = sum(0.5 * own[..., None] ** 2 / stiffness for own in b) - np.log(stiffness * _TILT_SD**2)
    peak = max(float(level.max()), float((level[..., None] + gain).max()))
    of_level = np.exp(level - peak) * (1.0 - _TILTED)
    of_tilt = np.exp(level[..., None] + gain - peak) * _TILTED / _TILT_SD.size
    tilt = np.array([(of_tilt * own[..., None] / stiffness).sum() for own in b]) / of_tilt.sum()
    second = [(of_tilt * (1.0 / stiffness + (own[..., None] / stiffness) ** 2)).sum() / of_tilt.sum() for own in b]
    own_variance = float(np.mean(second) - np.mean(tilt**2))
    probability = float(of_tilt.sum() / (of_tilt.sum() + of_level.sum()))
    if probability > _CLEARLY:
        normal = np.array([*tilt, 1.0])
        spread = own_variance + (1.0 - probability) * float(np.mean(tilt**2))
        return FloorNormal(normal / np.linalg.norm(normal), spread, tilted=True)
    return FloorNormal(np.array(UP), probability * (own_variance + float(np.mean(tilt**2))))
