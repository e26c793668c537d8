"""Whether the impacts lie in one plane, as those on a rigid floor do: one that moves takes part in every speed."""

import math
from dataclasses import replace

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.model.gravity import NOMINAL_GRAVITY_M_S2
from radargui.model.result import Bounces, Track
from radargui.restitution.settings import CHECKS


def judged_by_floor(bounces: Bounces, track: Track, alike_m: float | None = None) -> tuple[Bounces, list[str]]:
    """Return the bounces, and a sentence where the impacts do not lie in one plane.

    Where a rebound is faster than its arrival, too, the floor moves, and no e of the run is one of a floor at rest:
    none is valid. Off the plane alone may be a step, or grains on the floor.

    Parameters
    ----------
    bounces
        Impacts in order, and the normal found or given.
    track
        Position of the sphere's centre.
    alike_m
        Places so close to each other have the same error: that of a joint estimate belongs to the place, and what
        mirrors do turns by one radian within wavelength / 4 pi. None: the errors are each their own.
    """
    off = _off_one_plane(bounces, track, alike_m)
    if off is None:
        return bounces, []
    lie = (
        f"the impacts lie up to {1e3 * off[0]:.2g} mm off one plane, where track and floor leave {1e3 * off[1]:.2g} mm"
    )
    faster = [
        number
        for number, impact in enumerate(bounces.impacts, 1)
        if impact.e - CHECKS.coverage * impact.u_stated > 1.0 and impact.speed_before_m_s > CHECKS.least_speed_m_s
    ]
    if not faster:
        sentence = (
            f"{lie}: the floor moves, gives way or has steps, or a receiver lost a fringe. What moves has a share in "
            "every e: look at the heights of the impacts"
        )
        return bounces, [sentence]
    sentence = (
        f"{lie}, and after impact {faster[0]} the sphere is faster than before: the floor moves. A ratio of the "
        "sphere's speeds is then no coefficient of restitution, and none is given"
    )
    return replace(bounces, impacts=tuple(replace(one, valid=False) for one in bounces.impacts)), [sentence]


def _off_one_plane(bounces: Bounces, track: Track, alike_m: float | None) -> tuple[float, float] | None:
    """Return how far impacts are off one plane, and how far they might be, in m; None where that is no farther.

    h_k = c + s x_k + r_k, heights along the floor's normal; the slope s is within what is known of the normal, and r_k
    of the variance u_k^2 + (a floor's own unevenness)^2. Chi-square of r says whether that is all.
    """
    if bounces.normal is None:
        return None
    normal = np.asarray(bounces.normal)
    found = [_place(bounces, number, track) for number in range(len(bounces.impacts))]
    places = [place for place in found if place is not None]
    if len(places) < CHECKS.least_in_plane:
        return None
    position, variance = np.stack([one[0] for one in places]), np.array([one[1] for one in places])
    if alike_m is not None:
        apart = np.linalg.norm(position - np.median(position, axis=0), axis=1)
        variance = variance * np.minimum(1.0, apart / alike_m) ** 2
    variance = variance + CHECKS.uneven_m**2
    away = position - np.average(position, axis=0, weights=1.0 / variance)
    height = away @ normal
    aside = away - np.outer(height, normal)
    u_tilt = math.radians(CHECKS.given_tilt_deg if bounces.u_tilt_deg is None else bounces.u_tilt_deg)
    covariance = np.diag(variance) + u_tilt**2 * aside @ aside.T
    n = len(places) - 1
    misfit, spread = float(height @ np.linalg.solve(covariance, height)), 2.0 / (9.0 * n)
    # Wilson & Hilferty 1931: the cube root of chi-square / n is nearly normal, about 1 - 2 / 9n
    if math.cbrt(misfit / n) < 1.0 - spread + CHECKS.plane_sigmas * math.sqrt(spread):
        return None
    return float(np.abs(height).max()), float(np.sqrt(np.diag(covariance)).max())


def _place(bounces: Bounces, number: int, track: Track) -> tuple[FloatArray, float] | None:
    """Return where the centre is at an impact, shape (3,), and the variance of its height; None where nobody knows."""
    impact, normal = bounces.impacts[number], np.asarray(bounces.normal)
    # what hardly arrives or hardly leaves may lie, or hang in a hand
    if not min(impact.speed_before_m_s, impact.speed_after_m_s) > CHECKS.least_bounce_m_s:
        return None
    g_m_s2 = NOMINAL_GRAVITY_M_S2 * float(normal[2])
    first_s = impact.time_s - CHECKS.before_impact_s[0]
    if number:
        first_s = max(first_s, bounces.impacts[number - 1].time_s + CHECKS.before_impact_s[1])
    begin, end = np.searchsorted(track.time_s, [first_s, impact.time_s - CHECKS.before_impact_s[1]])
    known = begin + np.flatnonzero(track.valid[begin:end])
    if not known.size:
        return None
    left_s = impact.time_s - track.time_s[known]
    # v(t) = v_k - g (t_k - t) downwards
    fallen_m = impact.speed_before_m_s * left_s - g_m_s2 * left_s**2 / 2.0
    position = (track.position_m[:, known] - normal[:, None] * fallen_m).mean(axis=1)
    return position, float((normal**2 @ track.u_position_m[:, known] ** 2).mean())
