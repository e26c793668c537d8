"""The floor's normal as a distribution: what is believed of its tilt, what reflects, what impacts add (method 5)."""

from dataclasses import dataclass

import numpy as np

from radargui.model.arrays import FloatArray

UP = (0.0, 0.0, 1.0)  # the vertical, z of the setup


@dataclass(frozen=True, slots=True)
class NormalSettings:
    """What is believed of a floor before the impacts are seen.

    Attributes
    ----------
    tilt_sd_deg, tilts
        Range and number of standard deviations of the floor's slope, log uniform: from a plate laid with a spirit level
        to one that nobody looked at. A level floor weighed 9 : 1 left e outside 2u in 63 % of draws at 0.6 degrees with
        kicks of 0.03 m/s; so 95 to 98 % are inside, level floors too.
    min_tilt_sd
        Of a slope that the setup calls exact.
    kick_m_s, kicks
        Range and number of kicks' standard deviations, log uniform: the last is a rough floor's. With a first of 3e-4
        two kicks that happen to agree look like a tilt that is known: 88 % of e inside 2u after two impacts, 92 to
        100 % with this one.
    same, faces_deg
        Probability before the impacts that the surface which reflects is the one that the sphere falls on, and how far
        from parallel its faces may be (a plate of 30 cm whose thickness varies by a quarter of a millimetre). Even
        odds: of 300 laboratory drops that lean and kick 99 % of e were inside 2u where it was, and 90 to 94 % where it
        was another surface, off by 0.3 to 3 degrees; with 9 : 1 these were 69 to 88 %.
    friction
        Shares of the speed along the floor that an impact may take, all alike probable: (2/7)(1 + e_x) of a solid
        sphere that grips (Cross 2002), e_x the tangential coefficient of restitution, from -1 (no friction) to 1. A
        sphere that rolls, e_x = 0, is the middle. As the end it would have half of its own share in the mean, and every
        tilt would be found too small (of 300 laboratory drops that lean and kick 91 instead of 95 % of e inside 2u).
    """

    tilt_sd_deg: tuple[float, float] = (0.05, 5.0)
    tilts: int = 16
    min_tilt_sd: float = 1e-6
    kick_m_s: tuple[float, float] = (1e-2, 0.5)
    kicks: int = 32
    same: float = 0.5
    faces_deg: float = 0.05
    friction: tuple[float, ...] = tuple(4.0 / 7.0 * step / 8.0 for step in range(9))


NORMALS = NormalSettings()
_TILTS_SD = np.tan(np.radians(np.geomspace(*NORMALS.tilt_sd_deg, NORMALS.tilts)))
_KICKS_M_S = np.geomspace(*NORMALS.kick_m_s, NORMALS.kicks)


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

    def e_variance(self, before_m_s: FloatArray, after_m_s: FloatArray) -> FloatArray:
        """Return what the normal adds to the variance of e = -(after . n) / (before . n), of velocities (..., 3)."""
        b, a = (velocity @ self.normal[:, None] for velocity in (before_m_s, after_m_s))
        by_slope = (-after_m_s[..., :2] / b + a * before_m_s[..., :2] / b**2) * self.normal[2]
        return np.asarray(self.slope_variance * (by_slope**2).sum(axis=-1))


def normal_of_impacts(
    before_m_s: FloatArray,
    after_m_s: FloatArray,
    u_m_s: FloatArray,
    u_tilt_deg: float | None = None,
    reflecting: FloorNormal | None = None,
) -> FloorNormal:
    """Return the mean normal that the velocities' changes at the impacts leave, and its variance.

    A sphere is pushed along the normal n ~ (t_x, t_y, 1), loses a share r of its speed along the floor by friction
    (2/7 where a solid sphere grips and rolls, Cross 2002) and is kicked aside by what the floor's surface is like:

        dv_xy = t dv_z - r (v_xy - t v_z) + k,   k ~ N(0, q^2 + u^2) an axis

    with v before the impact. t ~ N(0, s^2) an axis; r, q (log uniform, 1 cm/s to 0.5 m/s) and s (log uniform, 0.05 to
    5 degrees) are summed over. One impact cannot separate a tilt from a kick: the variance holds both.

    Where the estimate found a surface below that reflects, with slope m and variance v, the floor is that surface,
    t ~ N(m, v + d^2) with faces parallel within d, or, as probable before the impacts, another one as above: waves may
    go through what the sphere falls on.

    Parameters
    ----------
    before_m_s, after_m_s
        Velocities at the impacts, shape (n_impacts, 3).
    u_m_s
        Standard uncertainty of a horizontal component of their difference, shape (n_impacts,).
    u_tilt_deg
        s where the setup gives it: then against the horizontal alone.
    reflecting
        Normal of the surface that reflects, where one was found.
    """
    tilt_sd, (a, b, level) = _tilts_sd(u_tilt_deg), _sums_of_impacts(before_m_s, after_m_s, u_m_s)
    # t is Gaussian given r, q and s: its integral is closed, and r, q and s alone are summed on a grid
    mean, precision, belief = np.zeros((2, tilt_sd.size)), tilt_sd**-2.0, np.full(tilt_sd.size, 1.0 / tilt_sd.size)
    if reflecting is not None and u_tilt_deg is None:
        apart = np.radians(NORMALS.faces_deg) ** 2 + reflecting.slope_variance
        mean = np.concatenate([mean, (reflecting.normal[:2] / reflecting.normal[2])[:, None]], axis=1)
        precision = np.append(precision, 1.0 / apart)
        belief = np.append((1.0 - NORMALS.same) * belief, NORMALS.same)
    softness = 1.0 / (a[..., None] + precision)
    pull = b[..., None] + (precision * mean)[:, None, None, :]
    exponent = level[..., None] - 0.5 * (precision * mean**2).sum(axis=0) + 0.5 * (pull**2).sum(axis=0) * softness
    # less the largest, whose exponential would overflow
    share = np.exp(exponent - exponent.max()) * softness * (precision * belief)
    share /= share.sum()
    tilt = (pull * softness * share).sum(axis=(1, 2, 3))
    second = ((pull * softness) ** 2 * share).sum(axis=(1, 2, 3)) + (softness * share).sum()
    normal = np.array([*tilt, 1.0])
    # law of total variance: within each of the grid's points and between them
    return FloorNormal(normal / np.linalg.norm(normal), float(np.mean(second) - np.mean(tilt**2)))


def _tilts_sd(u_tilt_deg: float | None) -> FloatArray:
    """Return the standard deviations of the slope that are summed over, shape (n_tilts,)."""
    tilt_sd = _TILTS_SD if u_tilt_deg is None else np.tan(np.radians([u_tilt_deg]))
    # an exact normal is a narrow prior, not a division by zero
    return np.asarray(np.maximum(tilt_sd, NORMALS.min_tilt_sd))


def _sums_of_impacts(
    before_m_s: FloatArray, after_m_s: FloatArray, u_m_s: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return a, b (x and y: another axis before) and c of ln p = c + b . t - a |t|^2 / 2, of each r and q: (..., r, q).

    Velocities (..., n_impacts, 3), else as in `normal_of_impacts`.
    """
    # the floor acts on the change alone: the speed along it was there before
    change = after_m_s - before_m_s
    # a kick cannot be told from noise sideways: their variances add
    weight = 1.0 / (_KICKS_M_S**2 + u_m_s[:, None] ** 2)
    # friction takes r (v - t v_z): sums over the impacts of what belongs to the tilt t, second degree polynomials in r
    friction = np.array(NORMALS.friction)[:, None]

    def summed(one: int, other: int) -> FloatArray:
        degrees = (
            change[..., one] * change[..., other],
            change[..., one] * before_m_s[..., other] + before_m_s[..., one] * change[..., other],
            before_m_s[..., one] * before_m_s[..., other],
        )
        level, linear, square = ((degree @ weight)[..., None, :] for degree in degrees)
        return np.asarray(level + friction * (linear + friction * square))

    sideways = np.stack([summed(2, axis) for axis in (0, 1)], axis=-3)
    return summed(2, 2), sideways, np.log(weight).sum(axis=0) - 0.5 * (summed(0, 0) + summed(1, 1))


def e_by_tilt(before_m_s: FloatArray, after_m_s: FloatArray, normal: FloatArray, u_deg: float) -> list[FloatArray]:
    """Return the changes of all e = -(after . n) / (before . n) where n leans by u_deg towards x, and towards y.

    Velocities (n_impacts, 3), changes (n_impacts,).
    """
    out, down, up = [], before_m_s @ normal, after_m_s @ normal
    for axis in np.eye(3)[:2]:
        side = np.tan(np.radians(u_deg)) * (axis - normal * (axis @ normal))
        out.append(np.asarray(-(after_m_s @ side) / down + up / down**2 * (before_m_s @ side)))
    return out
