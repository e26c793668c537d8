"""The floor's normal, found from the impacts: a smooth floor changes the velocity along its normal only."""

from __future__ import annotations

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.motion.flights import CLEARANCE_S

SIDE_S = 0.03
LEAST_SAMPLES = 12
LEAST_TILT_RAD = np.radians(0.5)
SIGMAS = 4.0
UP = (0.0, 0.0, 1.0)


def find_normal(
    time_s: FloatArray, position_m: FloatArray, impact_s: FloatArray, g_m_s2: float
) -> tuple[float, float, float]:
    """Return the mean direction of the velocity's changes at the impacts; straight up unless that is clearly wrong.

    Velocities are the ends of lines through the 30 ms before and after each impact, gravity taken off. A tilt below
    half a degree, or below four standard errors of the scatter between impacts, is not told from none.

    Parameters
    ----------
    time_s, position_m
        Known samples of the motion, shapes (n_samples,) and (3, n_samples).
    impact_s
        Instants of impact, shape (n_impacts,).
    g_m_s2
        Gravity, downwards.
    """
    changes = [
        change for instant in impact_s if (change := _change(time_s, position_m, float(instant), g_m_s2)) is not None
    ]
    if len(changes) < 2:
        return UP
    total = np.sum(changes, axis=0)
    slopes = np.array([change[:2] / change[2] for change in changes])
    weights = np.array([change[2] for change in changes])
    mean = total[:2] / total[2]
    scatter = np.sqrt((weights**2 @ ((slopes - mean) ** 2).sum(axis=1)) / weights.sum() ** 2)
    tilt = float(np.hypot(*mean))
    if tilt < max(LEAST_TILT_RAD, SIGMAS * float(scatter)):
        return UP
    normal = total / np.linalg.norm(total)
    return (float(normal[0]), float(normal[1]), float(normal[2]))


def _change(time_s: FloatArray, position_m: FloatArray, instant_s: float, g_m_s2: float) -> FloatArray | None:
    """Return the velocity after less the velocity before one impact; None where too little is known."""
    velocities = []
    for begin, end in ((instant_s - SIDE_S, instant_s - CLEARANCE_S), (instant_s + CLEARANCE_S, instant_s + SIDE_S)):
        inside = slice(*np.searchsorted(time_s, [begin, end]))
        d = time_s[inside] - instant_s
        if d.size < LEAST_SAMPLES:
            return None
        straight = position_m[:, inside].copy()
        straight[2] += 0.5 * g_m_s2 * d * d
        velocities.append(np.polynomial.polynomial.polyfit(d, straight.T, 1)[1])
    change = np.asarray(velocities[1] - velocities[0])
    return change if change[2] > 0.0 else None
