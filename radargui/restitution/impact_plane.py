"""Whether the impacts lie in one plane, as those on a rigid floor do: one that moves takes part in every speed.

Method 5, One plane.
"""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from radargui.model.arrays import BoolArray, FloatArray, median
from radargui.model.finding import Finding, warn
from radargui.model.result import Bounce, Bounces, Track
from radargui.restitution.contact_time import contact_of_places_s, contact_of_track_s, depth_per_s
from radargui.restitution.settings import CHECKS

_SAMPLES = 8  # of each flight before an impact: more say the same


def judged_by_floor(
    bounces: Bounces, track: Track, gravity_m_s2: float, alike_m: float | None = None, *, by_conic: bool = False
) -> tuple[Bounces, list[Finding]]:
    """Return the bounces, and a finding where the impacts do not lie in one plane, or take their time.

    Where impacts last there is no instant that has the speeds, and no e is valid. Where a rebound is faster than its
    arrival, too, the floor moves, and no e of the run is one of a floor at rest: none is valid. Off the plane alone may
    be a step, or grains on the floor.

    Parameters
    ----------
    bounces
        Impacts in order, and the normal found or given.
    track
        Position of the sphere's centre.
    gravity_m_s2
        g of the place.
    alike_m
        Places so close to each other have the same error: that of a joint estimate belongs to the place, and what
        mirrors do turns by one radian within wavelength / 4 pi. None: the errors are each their own.
    by_conic
        Whether one circle a receiver, or none, has made the track.
    """
    faster = [
        number
        for number, impact in enumerate(bounces.impacts, 1)
        if _gain(impact) - CHECKS.coverage * impact.u_stated > 1.0 and impact.speed_before_m_s > CHECKS.min_speed_m_s
    ]
    off = _off_one_plane(bounces, track, gravity_m_s2, alike_m, faster)
    contact_s = None if off is None or faster else off[2]
    if contact_s is None and not faster and alike_m is None and bounces.normal is not None:
        contact_s = contact_of_track_s(bounces, track, gravity_m_s2, by_conic=by_conic)
    if contact_s is not None:
        return _without_e(bounces), [warn("floor_gives_way", contact_s=contact_s)]
    if off is None:
        return bounces, []
    lie = {"off_m": off[0], "u_m": off[1]}
    if not faster:
        return bounces, [warn("impacts_off_plane", **lie)]
    return _without_e(bounces), [warn("floor_moves", impact=faster[0], **lie)]


def _gain(impact: Bounce) -> float:
    """Return the whole speed after an impact over that before; e where what is along the floor is not known.

    A passive floor gives no energy, but at grazing incidence it turns speed along it into speed away from it (Louge &
    Adams, Phys. Rev. E 65, 021303, 2002): e above 1 alone is no floor that moves.
    """
    if math.isnan(impact.vt_before_m_s) or math.isnan(impact.vt_after_m_s):
        return impact.e
    before = math.hypot(impact.speed_before_m_s, impact.vt_before_m_s)
    return math.hypot(impact.speed_after_m_s, impact.vt_after_m_s) / before


def _without_e(bounces: Bounces) -> Bounces:
    return replace(bounces, impacts=tuple(replace(one, valid=False) for one in bounces.impacts))


def _off_one_plane(
    bounces: Bounces, track: Track, gravity_m_s2: float, alike_m: float | None, faster: Sequence[int]
) -> tuple[float, float, float | None] | None:
    """Return how far impacts are off one plane, and how far they might be, in m; None where that is no farther.

    And how long they last, in s, where that is why.

    h_k = c + s x_k + r_k, heights along the floor's normal; the slope s is within what is known of the normal, and r_k
    of the variance u_k^2 + (a floor's own unevenness)^2. Chi-square of r says whether that is all.
    """
    if bounces.normal is None:
        return None
    normal = np.asarray(bounces.normal)
    position, variance, per_s = _places(bounces, track, normal, gravity_m_s2, faster)
    if len(position) < CHECKS.min_in_plane:
        return None
    if alike_m is not None:
        apart = np.linalg.norm(position - median(position, axis=0), axis=1)
        variance = variance * np.minimum(1.0, apart / alike_m) ** 2
    variance = variance + CHECKS.uneven_m**2
    away = position - np.average(position, axis=0, weights=1.0 / variance)
    height = away @ normal
    aside = away - np.outer(height, normal)
    u_tilt = math.radians(CHECKS.given_tilt_deg if bounces.u_tilt_deg is None else bounces.u_tilt_deg)
    covariance = np.diag(variance) + u_tilt**2 * aside @ aside.T
    n = len(position) - 1
    misfit, spread = float(height @ np.linalg.solve(covariance, height)), 2.0 / (9.0 * n)
    # Wilson & Hilferty 1931: the cube root of chi-square / n is nearly normal, about 1 - 2 / 9n
    # NaN compares false: places that are not known at all lie in any plane
    if not math.cbrt(misfit / n) >= 1.0 - spread + CHECKS.plane_sigmas * math.sqrt(spread):
        return None
    by_contact_s = contact_of_places_s(height, covariance, per_s)
    return float(np.abs(height).max()), float(np.sqrt(np.diag(covariance)).max()), by_contact_s


def _before_a_sure_one(sure: BoolArray, at_s: FloatArray, after_m_s: FloatArray, gravity_m_s2: float) -> BoolArray:
    """Return which impacts are sure, or have a sure one after them before the sphere lies still, shape (n,)."""
    # dropped again by a hand it lay for longer than any flight from there
    lay = np.append(np.diff(at_s), np.inf) * gravity_m_s2 / 2.0 > CHECKS.longest_flight * after_m_s
    fall = np.cumsum(np.append(0, lay[:-1]))
    last = np.full(int(fall[-1]) + 1, -1)
    last[fall[sure]] = np.flatnonzero(sure)
    return np.asarray(np.arange(sure.size) <= last[fall])


def _places(
    bounces: Bounces, track: Track, normal: FloatArray, gravity_m_s2: float, faster: Sequence[int]
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return where the centre is at the impacts that bounce and are seen, shape (n, 3), and the heights' variances.

    And how far below the floor flights meet there over the time that an impact lasts, shape (n,).
    """
    at_s, before_m_s, after_m_s = (
        np.array([(one.time_s, one.speed_before_m_s, one.speed_after_m_s) for one in bounces.impacts]).reshape(-1, 3).T
    )
    early_s, late_s = CHECKS.before_impact_s
    first_s = np.maximum(at_s - early_s, np.append(-np.inf, at_s[:-1]) + late_s)
    begin, end = np.searchsorted(track.time_s, [first_s, at_s - late_s])
    # some samples of each stretch tell it
    sample = begin[:, None] + np.arange(_SAMPLES) * np.maximum(end - begin - 1, 0)[:, None] // (_SAMPLES - 1)
    sample = np.minimum(sample, track.time_s.size - 1)
    # what hardly arrives or hardly leaves may lie, or hang in a hand
    bounce = (np.minimum(before_m_s, after_m_s) > CHECKS.min_bounce_m_s) & (end > begin)
    # the last one found may be several that are not told apart: it gives no e, and lies above the floor; those before
    # it that are faster than they came were thrown by one
    thrown = set(faster) - {at_s.size}
    sure = np.array([one.valid or number in thrown for number, one in enumerate(bounces.impacts, 1)], dtype=np.bool_)
    if sure.any():
        bounce &= _before_a_sure_one(sure, at_s, after_m_s, gravity_m_s2)
    known = track.valid[sample] & bounce[:, None]
    seen = known.any(axis=1)
    weight = known[seen] / known[seen].sum(axis=1, keepdims=True)
    sample, left_s = sample[seen], at_s[seen, None] - track.time_s[sample[seen]]
    # v(t) = v_k - g (t_k - t) downwards
    fallen_m = before_m_s[seen, None] * left_s - gravity_m_s2 * normal[2] * left_s**2 / 2.0
    # a sample that is not known may be NaN: its weight is none
    position = np.where(known[seen], track.position_m[:, sample] - normal[:, None, None] * fallen_m, 0.0)
    variance = np.where(known[seen], np.tensordot(normal**2, track.u_position_m[:, sample] ** 2, 1), 0.0)
    per_s = depth_per_s(before_m_s, after_m_s)[seen]
    return np.asarray((position * weight).sum(axis=2).T), np.asarray((variance * weight).sum(axis=1)), per_s
