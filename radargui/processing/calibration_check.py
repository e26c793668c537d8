"""What one drop says about the calibration before a series: whether g comes out and the sphere falls straight."""

import math
from dataclasses import dataclass

import numpy as np

from radargui.model.calibrated_setup import day_of
from radargui.model.gravity import g_and_u_of_site
from radargui.model.result import Bounces, RunResult
from radargui.model.rounding import COVERAGE, concise
from radargui.processing.uncertainty_budget import changes_of_track
from radargui.restitution.bounces import FlownTrack
from radargui.restitution.site_gravity import site_check

COVERAGE_2D = 2.45
"""So many u hold 95 % of the lengths of a vector of two components (Rayleigh's distribution)."""
LEAST_SAMPLES = 50
"""Valid ones of the fall; a parabola has three unknowns. Chosen by hand: of fewer too little of the fall is seen."""


@dataclass(frozen=True, slots=True)
class CalibrationCheck:
    """Whether the calibration holds, and the line that says so."""

    holds: bool
    words: str


def check_calibration(result: RunResult) -> CalibrationCheck | None:
    """Return what a drop says about the calibration of its setup, or the setup that has none; None: it cannot tell.

    The drift is the way that sideways acceleration makes over the fall, a T^2 / 2: a sphere let go with some sideways
    speed falls on a parabola all the same. Its u: that of the position (generous, for the fit averages), and with each
    uncertain input what it bends the fall by.

    Parameters
    ----------
    result
        Of a drop.
    """
    fall, budget, track, paths = result.bounces.free_fall, result.uncertainty_budget, result.track, result.paths
    u_g = None if budget is None else budget.g_m_s2.combined
    if fall is None or track is None or paths is None or result.segment is None or not u_g:
        return None
    during = (track.time_s >= fall.first_time_s) & (track.time_s <= fall.last_time_s)
    during &= track.valid & np.isfinite(track.position_m).all(axis=0)
    if during.sum() < LEAST_SAMPLES:
        return None
    span = fall.last_time_s - fall.first_time_s
    share = (track.time_s[during] - fall.first_time_s) / span
    # over shares of the span T: the coefficient of their square is a T^2 / 2 itself
    drift = np.polyfit(share, track.position_m[:2, during].T, 2)[0]
    variance = float(np.mean(track.u_position_m[:2, during] ** 2))
    for one in changes_of_track(paths, FlownTrack(Bounces()), result.setup, result.segment):
        inside = (one.time_s >= fall.first_time_s) & (one.time_s <= fall.last_time_s)
        if inside.sum() > 3:
            bends = np.polyfit((one.time_s[inside] - fall.first_time_s) / span, one.moved_m[:2, inside].T, 2)[0]
            variance += float(np.mean(bends**2))
    size, u_drift = float(np.hypot(*drift)), math.sqrt(variance)
    site = site_check(result)
    expected, u_expected = (site.expected_m_s2, site.u_expected_m_s2) if site else g_and_u_of_site(result.setup.site)
    # independent: the site's g knows nothing of the antennas
    g_holds = abs(fall.g_m_s2 - expected) <= COVERAGE * math.hypot(u_g, u_expected)
    holds = g_holds and size <= COVERAGE_2D * u_drift
    figures = f"g {concise(fall.g_m_s2, u_g, 'm/s²')}, drift {concise(size, u_drift, 'mm', 1e3)}"
    content = result.setup.calibration.content
    said = "the setup" if content is None else f"the calibration of {day_of(content)}"
    if holds:
        return CalibrationCheck(holds, f"{said} still holds: {figures}")
    return CalibrationCheck(holds, f"{said} does not hold: {figures}, g expected {expected:.4f}; calibrate again")
