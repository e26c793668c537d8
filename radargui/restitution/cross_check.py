"""Two other ways to e, from the flight after the impact: its duration and its height."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.model.bounce import Bounce, Bounces

LEAST_SAMPLES = 16
COVERAGE = 3.0
MODEL_SHARE = 0.01
"""Air drag and a floor that gives way make the three differ by up to about a percent, none of them being wrong."""


def cross_check(bounces: Bounces, time_s: FloatArray, height_m: FloatArray, g_m_s2: float) -> Bounces:
    """Return the bounces with e from the flight time and from the height of the flight that follows each.

    A flight of duration T over a level floor begins with g T / 2, one of height h with sqrt(2 g h); over the speed
    before the impact each is e.

    Parameters
    ----------
    bounces
        Impacts in order.
    time_s, height_m
        Height along the floor's normal on the known samples of the motion, shape (n_samples,).
    g_m_s2
        Gravity along the normal.
    """
    impacts = list(bounces.impacts)
    for number, (impact, following) in enumerate(itertools.pairwise(impacts)):
        if not impact.speed_before_m_s > 0.0:
            continue
        duration = following.time_s - impact.time_s
        rise = _apex(impact, following, time_s, height_m)
        impacts[number] = replace(
            impact,
            e_flight_time=g_m_s2 * duration / (2.0 * impact.speed_before_m_s),
            e_height=float(np.sqrt(2.0 * g_m_s2 * rise)) / impact.speed_before_m_s if rise > 0.0 else float("nan"),
        )
    return replace(bounces, impacts=tuple(impacts))


def _apex(impact: Bounce, following: Bounce, time_s: FloatArray, height_m: FloatArray) -> float:
    """Return the height of the flight above the impact before it, from a parabola of its own; NaN where unknown."""
    span = following.time_s - impact.time_s
    inside = slice(*np.searchsorted(time_s, [impact.time_s + 0.05 * span, following.time_s - 0.05 * span]))
    time, height = time_s[inside] - impact.time_s, height_m[inside]
    if time.size < LEAST_SAMPLES:
        return float("nan")
    _, slope, bend = (float(c) for c in np.polynomial.Polynomial.fit(time, height, 2).convert().coef)
    return -slope * slope / (4.0 * bend) if bend < 0.0 else float("nan")


def disagreements(bounces: Bounces) -> list[str]:
    """Return a sentence for each impact whose three coefficients do not agree within three standard uncertainties."""
    sentences = []
    for number, impact in enumerate(bounces.impacts, 1):
        if not impact.valid:
            continue
        within = COVERAGE * float(np.hypot(impact.u_e, MODEL_SHARE * impact.e))
        for name, other in (("flight time", impact.e_flight_time), ("height", impact.e_height)):
            if np.isfinite(other) and abs(other - impact.e) > within:
                sentences.append(
                    f"impact {number}: e = {impact.e:.4f} from the speeds, {other:.4f} from the {name} after it: "
                    "an impact may be missing, the floor not level, or air drag strong"
                )
    return sentences
