"""How long impacts last: on rubber or foam the flights before and after meet below the floor, the deeper the faster.

Method 5, One plane.
"""

from __future__ import annotations

import numpy as np

from radargui.model.arrays import BoolArray, FloatArray
from radargui.model.result import Bounces, Track
from radargui.restitution.settings import CONTACTS


def depth_per_s(before_m_s: FloatArray, after_m_s: FloatArray) -> FloatArray:
    """Return how far below the floor flights meet, over the time between touching and leaving: v v' / (v + v')."""
    together = before_m_s + after_m_s
    return np.asarray(before_m_s * after_m_s / np.where(together > 0.0, together, 1.0))


def contact_of_places_s(height_m: FloatArray, covariance: FloatArray, per_s: FloatArray) -> float | None:
    """Return the time that impacts at heights (n,) last, where that is why they lie in no plane; else None.

    h_k = c - T w_k + r_k by generalised least squares, w_k of `depth_per_s`. A floor that has steps or moves is neither
    lower the faster the sphere comes, nor does what is left fit.

    Parameters
    ----------
    height_m, covariance
        Where flights meet, along the normal, and the covariance of r, shapes (n,) and (n, n).
    per_s
        w, shape (n,).
    """
    design = np.stack([np.ones(per_s.size), -per_s], axis=1)
    weighed = np.linalg.solve(covariance, np.column_stack([design, height_m]))
    normal, pull = design.T @ weighed[:, :2], design.T @ weighed[:, 2]
    # equal speeds tell nothing
    if np.linalg.cond(normal / np.sqrt(np.outer(np.diag(normal), np.diag(normal)))) > CONTACTS.worst_condition:
        return None
    _, contact_s = np.linalg.solve(normal, pull)
    u_s = float(np.sqrt(np.linalg.inv(normal)[1, 1]))
    flat = height_m - np.linalg.solve(normal[:1, :1], pull[:1])
    left = height_m - design @ np.linalg.solve(normal, pull)
    misfit, before = (float(off @ np.linalg.solve(covariance, off)) for off in (left, flat))
    if misfit > CONTACTS.max_left * before:
        return None
    least = max(CONTACTS.min_s, CONTACTS.coverage * u_s)
    return float(contact_s) if least < contact_s < CONTACTS.longest_s else None


def contact_of_track_s(bounces: Bounces, track: Track, gravity_m_s2: float, *, by_conic: bool = False) -> float | None:
    """Return the time that impacts last by how the track rounds the corner between flights; None where that is short.

    For tracks that follow the signal at every moment; a motion with breaks has no round corners. `by_conic`: of one
    circle for the whole motion, whose waves are as long as the sphere is fast, and round corners alike.
    """
    impacts = [one for one in bounces.impacts if one.valid]
    if not impacts:
        return None
    time_s, before, after = np.array([(one.time_s, one.speed_before_m_s, one.speed_after_m_s) for one in impacts]).T
    found, u_found_s = _rounded_s(time_s, before, after, np.asarray(bounces.normal), track, gravity_m_s2)
    if not found.size:
        return None
    weight = u_found_s**-2.0
    # errors of a track are those of the place: more impacts do not make them smaller
    rounded_s, u_s = float(found @ weight / weight.sum()), float(u_found_s.min())
    coverage = CONTACTS.coverage_of_conic if by_conic else CONTACTS.coverage_of_track
    if rounded_s < max(CONTACTS.min_rounded_s, coverage * u_s):
        return None
    return CONTACTS.hidden_s + rounded_s


def _rounded_s(
    time_s: FloatArray,
    before_m_s: FloatArray,
    after_m_s: FloatArray,
    normal: FloatArray,
    track: Track,
    gravity_m_s2: float,
) -> tuple[FloatArray, FloatArray]:
    """Return times, (n,), that the roundness of corners stands for, and u: of a half swing (1/2 - 1/pi) T (v + v') / 2.

    Of those impacts (n_impacts,) whose flights meet there.
    """
    near_s, (late_s, early_s) = CONTACTS.near_s, CONTACTS.beside_s
    first, last = np.searchsorted(track.time_s, [time_s - early_s, time_s + early_s])
    place = first[:, None] + np.arange(int((last - first).max()))
    inside, place = place < last[:, None], np.minimum(place, track.time_s.size - 1)
    since_s = track.time_s[place] - time_s[:, None]
    # one row an impact
    height = (normal @ track.position_m[:, place.ravel()]).reshape(place.shape)
    u_m = np.sqrt(normal**2 @ track.u_position_m[:, place.ravel()] ** 2).reshape(place.shape)
    known = inside & track.valid[place] & np.isfinite(height) & np.isfinite(u_m)
    speed = np.where(since_s < 0.0, -before_m_s[:, None], after_m_s[:, None])
    off = height - speed * since_s + 0.5 * gravity_m_s2 * float(normal[2]) * since_s**2
    away = known & (np.abs(since_s) > late_s)
    sides, here = (away & (since_s < 0.0), away & (since_s > 0.0)), known & (np.abs(since_s) < near_s)
    seen = here.any(axis=1)
    for side in sides:
        seen &= side.sum(axis=1) >= CONTACTS.min_samples

    def mean(values: FloatArray, where: BoolArray) -> FloatArray:
        return np.asarray(np.where(where, values, 0.0)[seen].sum(axis=1) / where[seen].sum(axis=1))

    before, after, corner, u = mean(off, sides[0]), mean(off, sides[1]), mean(off, here), mean(u_m, here)
    per_m = 4.0 / ((1.0 - 2.0 / np.pi) * (before_m_s + after_m_s)[seen])
    # where flights do not meet nothing is known
    meet = np.abs(after - before) <= CONTACTS.coverage * np.hypot(u, CONTACTS.apart_m)
    return (per_m * (corner - 0.5 * (before + after)))[meet], (per_m * u)[meet]
