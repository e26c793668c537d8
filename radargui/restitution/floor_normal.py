"""The floor's normal as a distribution: what is believed of its tilt and what the impacts add (method 5)."""

from dataclasses import dataclass

import numpy as np

from radargui.model.arrays import FloatArray

UP = (0.0, 0.0, 1.0)


@dataclass(frozen=True, slots=True)
class NormalSettings:
    """What is believed of a floor before the impacts are seen.

    Attributes
    ----------
    tilt_sd_deg, tilts
        Range and number of standard deviations of the floor's slope, log uniform: from a plate laid with a spirit level
        to one that nobody looked at. A level floor weighed 9 : 1 left e outside 2u in 63 % of draws at 0.6 degrees with
        kicks of 0.03 m/s; so 95 to 98 % are inside, level floors too.
    least_tilt_sd
        Of a slope that the setup calls exact.
    kick_m_s, kicks
        Range and number of kicks' standard deviations, log uniform: the last is a rough floor's. With a first of 3e-4
        two kicks that happen to agree look like a tilt that is known: 88 % of e inside 2u after two impacts, 92 to
        100 % with this one.
    friction
        Shares of the speed along the floor that an impact may take: none, to 2/7 where a solid sphere grips and rolls
        (Cross 2002), all alike probable.
    """

    tilt_sd_deg: tuple[float, float] = (0.05, 5.0)
    tilts: int = 16
    least_tilt_sd: float = 1e-6
    kick_m_s: tuple[float, float] = (1e-2, 0.5)
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
    """

    normal: FloatArray
    slope_variance: float = 0.0

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


def normal_of_impacts(
    before_m_s: FloatArray, after_m_s: FloatArray, u_m_s: FloatArray, u_tilt_deg: float | None = None
) -> FloorNormal:
    """Return the mean normal that the velocities' changes at the impacts leave, and its variance.

    A sphere is pushed along the normal n ~ (t_x, t_y, 1), loses a share r of its speed along the floor by friction
    (0 without; 2/7 where a solid sphere grips and rolls, Cross 2002) and is kicked aside by what the floor's surface
    is like:

        dv_xy = t dv_z - r (v_xy - t v_z) + k,   k ~ N(0, q^2 + u^2) an axis

    with v before the impact. t ~ N(0, s^2) an axis; r, q (log uniform, 1 cm/s to 0.5 m/s) and s (log uniform, 0.05 to
    5 degrees) are summed over. One impact cannot separate a tilt from a kick: the variance holds both.

    Parameters
    ----------
    before_m_s, after_m_s
        Velocities at the impacts, shape (n_impacts, 3).
    u_m_s
        Standard uncertainty of a horizontal component of their difference, shape (n_impacts,).
    u_tilt_deg
        s where the setup gives it.
    """
    # the floor acts on the change alone: the speed along it was there before
    change = after_m_s - before_m_s
    tilt_sd = np.tan(
        np.radians(np.geomspace(*NORMALS.tilt_sd_deg, NORMALS.tilts) if u_tilt_deg is None else u_tilt_deg)
    )
    # an exact normal is a narrow prior, not a division by zero
    tilt_sd = np.maximum(np.atleast_1d(tilt_sd), NORMALS.least_tilt_sd)
    friction = np.array(NORMALS.friction)[:, None, None]
    kick = np.geomspace(*NORMALS.kick_m_s, NORMALS.kicks)[None, :, None]
    # a kick cannot be told from noise sideways: their variances add
    weight = 1.0 / (kick**2 + u_m_s**2)
    # friction takes r (v - t v_z): what belongs to the tilt t is collected here
    push = change[:, 2] + friction * before_m_s[:, 2]
    side = [change[:, axis] + friction * before_m_s[:, axis] for axis in (0, 1)]
    a = (weight * push**2).sum(axis=2)
    b = [(weight * push * own).sum(axis=2) for own in side]
    level = np.log(weight).sum(axis=2) - 0.5 * sum((weight * own**2).sum(axis=2) for own in side)
    # t is Gaussian given r, q and s: its integral is closed, and r, q and s alone are summed on a grid
    stiffness = a[..., None] + tilt_sd**-2.0
    log_evidence = (
        level[..., None] + sum(0.5 * own[..., None] ** 2 / stiffness for own in b) - np.log(stiffness * tilt_sd**2)
    )
    # less the largest, whose exponential would overflow
    share = np.exp(log_evidence - log_evidence.max())
    share /= share.sum()
    tilt = np.array([(share * own[..., None] / stiffness).sum() for own in b])
    # law of total variance: within each of the grid's points and between them
    second = [(share * (1.0 / stiffness + (own[..., None] / stiffness) ** 2)).sum() for own in b]
    normal = np.array([*tilt, 1.0])
    return FloorNormal(normal / np.linalg.norm(normal), float(np.mean(second) - np.mean(tilt**2)))


def e_by_tilt(before_m_s: FloatArray, after_m_s: FloatArray, normal: FloatArray, u_deg: float) -> list[FloatArray]:
    """Return the changes of all e = -(after . n) / (before . n) where n leans by u_deg towards x, and towards y."""
    out, down, up = [], before_m_s @ normal, after_m_s @ normal
    for axis in np.eye(3)[:2]:
        side = np.tan(np.radians(u_deg)) * (axis - normal * (axis @ normal))
        out.append(np.asarray(-(after_m_s @ side) / down + up / down**2 * (before_m_s @ side)))
    return out
