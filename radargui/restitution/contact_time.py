"""How long impacts last: on rubber or foam the flights before and after meet below the floor, the deeper the faster.

Method 5, One plane.
"""

from __future__ import annotations

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.model.gravity import NOMINAL_GRAVITY_M_S2
from radargui.model.result import Bounce, Bounces, Track
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
    if misfit > CONTACTS.most_left * before:
        return None
    least = max(CONTACTS.least_s, CONTACTS.coverage * u_s)
    return float(contact_s) if least < contact_s < CONTACTS.longest_s else None


def contact_of_track_s(bounces: Bounces, track: Track, *, by_conic: bool = False) -> float | None:
    """Return the time that impacts last by how the track rounds the corner between flights; None where that is short.

    For tracks that follow the signal at every moment; a motion with breaks has no round corners. `by_conic`: of one
    circle for the whole motion, whose waves are as long as the sphere is fast, and round corners alike.
    """
    found = [_rounded_s(one, bounces, track) for one in bounces.impacts if one.valid]
    known = np.array([one for one in found if one is not None]).reshape(-1, 2)
    if not len(known):
        return None
    weight = known[:, 1] ** -2.0
    # errors of a track are those of the place: more impacts do not make them smaller
    rounded_s, u_s = float(known[:, 0] @ weight / weight.sum()), float(known[:, 1].min())
    coverage = CONTACTS.coverage_of_conic if by_conic else CONTACTS.coverage_of_track
    if rounded_s < max(CONTACTS.least_rounded_s, coverage * u_s):
        return None
    return CONTACTS.hidden_s + rounded_s


def _rounded_s(one: Bounce, bounces: Bounces, track: Track) -> tuple[float, float] | None:
    """Return (time, u) that a corner's roundness stands for: of a half swing D = (1/2 - 1/pi) T (v + v') / 2."""
    normal = np.asarray(bounces.normal)
    near_s, (late_s, early_s) = CONTACTS.near_s, CONTACTS.beside_s
    part = slice(*np.searchsorted(track.time_s, [one.time_s - early_s, one.time_s + early_s]))
    since_s, known = track.time_s[part] - one.time_s, track.valid[part]
    height, u_m = normal @ track.position_m[:, part], np.sqrt(normal**2 @ track.u_position_m[:, part] ** 2)
    known = known & np.isfinite(height) & np.isfinite(u_m)
    speed = np.where(since_s < 0.0, -one.speed_before_m_s, one.speed_after_m_s)
    off = height - speed * since_s + 0.5 * NOMINAL_GRAVITY_M_S2 * float(normal[2]) * since_s**2
    away = np.abs(since_s) > late_s
    sides = [off[known & away & (since_s < 0.0)], off[known & away & (since_s > 0.0)]]
    here = known & (np.abs(since_s) < near_s)
    if min(side.size for side in sides) < CONTACTS.least_samples or not here.any():
        return None
    before, after = (float(side.mean()) for side in sides)
    u = float(u_m[here].mean())
    # these flights do not meet here
    if abs(after - before) > CONTACTS.coverage * np.hypot(u, CONTACTS.apart_m):
        return None
    per_m = 4.0 / ((1.0 - 2.0 / np.pi) * (one.speed_before_m_s + one.speed_after_m_s))
    return per_m * (float(off[here].mean()) - 0.5 * (before + after)), per_m * u
