"""Where and how a sphere hit the floor: speeds, angle, what the floor did along itself (method 5, Oblique impacts)."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.model.assumed import TILT, uncertain_inputs
from radargui.model.result import Bounces, Track
from radargui.model.setup import Setup
from radargui.model.uncertainty_budget import InputChange
from radargui.restitution.track_flights import impact_sides

_SIGNIFICANT = 3.0
"""A velocity along the floor of fewer standard uncertainties has no direction: nothing is divided by it."""


def with_oblique(bounces: Bounces, changes: Iterable[InputChange], track: Track, setup: Setup) -> Bounces:
    """Return bounces with where the sphere hit, its speeds and angle, e_t and mu, and what each is known to.

    Velocities are as uncertain as they are with the setup held, and by what each uncertain input changes them by; the
    floor's normal is as the impacts left it, or as the setup states it.

    Parameters
    ----------
    bounces
        With the velocities that they were worked out from; without, only where the sphere hit is known.
    changes
        What the motion changes by with each uncertain input of the setup, independent of each other.
    track
        Where the sphere was.
    setup
        What it states of the floor.
    """
    bounces, known = _placed(bounces, track), bounces.velocities
    if known is None or bounces.normal is None:
        return bounces
    normal, variance = np.asarray(bounces.normal), known.slope_variance
    if "normal" in setup.floor.model_fields_set:
        u_deg = next(one.u for one in uncertain_inputs(setup) if one.key == TILT)
        variance = float(np.tan(np.radians(u_deg)) ** 2)
    covariance = known.covariance + _by_setup(changes, known.time_s)
    impacts = []
    for one in bounces.impacts:
        number = int(np.argmin(np.abs(known.time_s - one.time_s)))
        sides = known.before_m_s[number], known.after_m_s[number]
        impacts.append(replace(one, **_read(*sides, covariance[number], normal, variance)))
    return replace(bounces, impacts=tuple(impacts), velocities=None)


def _read(
    before_m_s: FloatArray, after_m_s: FloatArray, covariance: FloatArray, normal: FloatArray, slope_variance: float
) -> dict[str, Any]:
    """Return what the velocities (3,) at an impact say, with standard uncertainties, by the names of `Bounce`."""
    tangents = np.linalg.svd(normal[None])[2][1:]
    into, out = -float(before_m_s @ normal), float(after_m_s @ normal)
    arrives, leaves = tangents @ before_m_s, tangents @ after_m_s
    # by the velocities, and by a normal that leans over: what is along it then is partly along the floor
    slopes = np.zeros((6, 8))
    slopes[0, :3], slopes[1, 3:6], slopes[2:4, :3], slopes[4:, 3:6] = -normal, normal, tangents, tangents
    slopes[0, 6:], slopes[1, 6:], slopes[2:4, 6:], slopes[4:, 6:] = -arrives, leaves, into * np.eye(2), -out * np.eye(2)
    whole = np.zeros((8, 8))
    whole[:6, :6], whole[6:, 6:] = covariance, slope_variance * np.eye(2)
    of_parts = slopes @ whole @ slopes.T

    def u(*by: float) -> float:
        return float(np.sqrt(max(np.array(by) @ of_parts @ np.array(by), 0.0)))

    change, difference = leaves - arrives, np.concatenate([-np.eye(2), np.eye(2)], axis=1)
    vt_before, vt_after = _length(arrives, of_parts[2:4, 2:4]), _length(leaves, of_parts[4:, 4:])
    square, turned = into**2 + vt_before**2, into + out
    mu = _length(change, difference @ of_parts[2:, 2:] @ difference.T) / turned
    x, y = _direction(arrives)
    dx, dy = _direction(change) / turned
    e_t = u_e_t = float("nan")
    if vt_before > _SIGNIFICANT * u(0.0, 0.0, x, y, 0.0, 0.0):
        e_t = float(arrives @ leaves) / vt_before**2
        by_before, by_after = (leaves - 2.0 * e_t * arrives) / vt_before**2, arrives / vt_before**2
        u_e_t = u(0.0, 0.0, *by_before, *by_after)
    return {
        "u_speed_before_m_s": u(1.0, 0.0, 0.0, 0.0, 0.0, 0.0),
        "u_speed_after_m_s": u(0.0, 1.0, 0.0, 0.0, 0.0, 0.0),
        "angle_deg": float(np.degrees(np.arctan2(vt_before, into))),
        "u_angle_deg": float(np.degrees(u(-vt_before, 0.0, into * x, into * y, 0.0, 0.0) / square)),
        "vt_before_m_s": vt_before,
        "vt_after_m_s": vt_after,
        "e_t": e_t,
        "u_e_t": u_e_t,
        "mu": mu,
        "u_mu": u(-mu / turned, -mu / turned, -dx, -dy, dx, dy),
    }


def _direction(vector: FloatArray) -> FloatArray:
    return np.asarray(vector / max(float(np.linalg.norm(vector)), 1e-300))


def _length(vector: FloatArray, covariance: FloatArray) -> float:
    """Return a length (Rice): what the variances of its components add to its square is taken off."""
    return float(np.sqrt(max(float(vector @ vector) - float(np.trace(covariance)), 0.0)))


def _by_setup(changes: Iterable[InputChange], impact_s: FloatArray) -> FloatArray:
    """Return the covariance that the setup leaves to the velocities at impacts (n_impacts,), (n_impacts, 6, 6)."""
    out = np.zeros((impact_s.size, 6, 6))
    for one in changes:
        side, impact, samples = impact_sides(one.time_s, impact_s)
        moved = np.zeros((2, impact_s.size, 3))
        moved[side, impact] = samples.lines(samples.of(one.moved_m))[1].T
        both = np.concatenate([moved[0], moved[1]], axis=1)
        out += both[:, :, None] * both[:, None]
    return out


def _placed(bounces: Bounces, track: Track) -> Bounces:
    """Return bounces with where the sphere hit; u is the root mean square of the coordinates' uncertainties."""
    u_m = track.u_position_m if track.u_combined_m is None else track.u_combined_m
    known = track.valid & np.isfinite(track.position_m).all(axis=0)
    if not known.any():
        return bounces
    impacts = []
    for one in bounces.impacts:
        at, u_at = (
            [float(np.interp(one.time_s, track.time_s[known], row[known])) for row in rows]
            for rows in (track.position_m, u_m)
        )
        impacts.append(replace(one, x_m=at[0], y_m=at[1], z_m=at[2], u_position_m=float(np.linalg.norm(u_at) / 3**0.5)))
    return replace(bounces, impacts=tuple(impacts))
