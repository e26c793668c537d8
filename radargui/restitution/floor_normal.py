"""The floor's normal from the velocities at the impacts, weighed against a level floor (method 5)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from radargui.model.arrays import FloatArray

UP = (0.0, 0.0, 1.0)


@dataclass(frozen=True, slots=True)
class NormalSettings:
    """What is believed of a floor before the impacts are seen.

    Attributes
    ----------
    tilt_sd_deg
        Standard deviations of a tilted floor's slope, all alike probable: a plate that was not levelled to a wedge.
    tilted
        Probability of a tilt beforehand: floors in a laboratory are level unless the setup says otherwise.
    clearly
        Probability above which the tilt is taken; below it belongs to the uncertainty. Chosen by hand.
    kick_m_s, kicks
        Range and number of kicks' standard deviations, log uniform: below the first the fit of a track does not see
        them, the last is a rough floor's.
    friction
        Shares of the speed along the floor that an impact may take: none, to 2/7 where a solid sphere grips and rolls
        (Cross 2002), all alike probable.
    """

    tilt_sd_deg: tuple[float, ...] = (1.0, 2.0, 4.0, 8.0, 16.0)
    tilted: float = 0.1
    clearly: float = 0.9
    kick_m_s: tuple[float, float] = (3e-4, 0.5)
    kicks: int = 32
    friction: tuple[float, ...] = tuple(2.0 / 7.0 * step / 6.0 for step in range(7))


NORMALS = NormalSettings()


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
    tilt_sd = np.tan(np.radians(NORMALS.tilt_sd_deg))
    friction = np.array(NORMALS.friction)[:, None, None]
    kick = np.geomspace(*NORMALS.kick_m_s, NORMALS.kicks)[None, :, None]
    weight = 1.0 / (kick**2 + u_m_s**2)
    push = change[:, 2] + friction * before_m_s[:, 2]
    side = [change[:, axis] + friction * before_m_s[:, axis] for axis in (0, 1)]
    a = (weight * push**2).sum(axis=2)
    b = [(weight * push * own).sum(axis=2) for own in side]
    level = np.log(weight).sum(axis=2) - 0.5 * sum((weight * own**2).sum(axis=2) for own in side)
    stiffness = a[..., None] + tilt_sd**-2.0
    gain = sum(0.5 * own[..., None] ** 2 / stiffness for own in b) - np.log(stiffness * tilt_sd**2)
    peak = max(float(level.max()), float((level[..., None] + gain).max()))
    of_level = np.exp(level - peak) * (1.0 - NORMALS.tilted)
    of_tilt = np.exp(level[..., None] + gain - peak) * NORMALS.tilted / tilt_sd.size
    tilt = np.array([(of_tilt * own[..., None] / stiffness).sum() for own in b]) / of_tilt.sum()
    second = [(of_tilt * (1.0 / stiffness + (own[..., None] / stiffness) ** 2)).sum() / of_tilt.sum() for own in b]
    own_variance = float(np.mean(second) - np.mean(tilt**2))
    probability = float(of_tilt.sum() / (of_tilt.sum() + of_level.sum()))
    if probability > NORMALS.clearly:
        normal = np.array([*tilt, 1.0])
        spread = own_variance + (1.0 - probability) * float(np.mean(tilt**2))
        return FloorNormal(normal / np.linalg.norm(normal), spread, tilted=True)
    return FloorNormal(np.array(UP), probability * (own_variance + float(np.mean(tilt**2))))
