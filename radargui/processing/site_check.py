"""The check of a result's g against the gravity of the place, with all that is known of its uncertainty."""

from __future__ import annotations

import math

from radargui.model.assumed import uncertain_inputs
from radargui.model.result import RunResult
from radargui.model.setup import Setup
from radargui.restitution.site_gravity import SiteCheck, check_against_site


def site_check(result: RunResult) -> SiteCheck | None:
    """Return the check; None without a fall, or where the setup does not say where it stands."""
    fall = result.bounces.free_fall
    if fall is None:
        return None
    by_antennas = (result.calibration_uncertainty or {}).get("u_g_m_s2")
    u = None if by_antennas is None else math.hypot(fall.u_g_m_s2, by_antennas, fall.g_m_s2 * u_scale(result.setup))
    return check_against_site(fall, result.setup, u)


def u_scale(setup: Setup) -> float:
    """Return the relative uncertainty of g by wavelength and clock: g goes with c / (n f) and the rate squared."""
    shares = {
        "radar.frequency_hz": 1.0 / setup.radar.frequency_hz,
        "radar.refractive_index": 1.0 / (setup.radar.refractive_index or 1.0),
        "daq.clock_ppm": 2e-6,
    }
    return math.hypot(*(shares[one.key] * one.u for one in uncertain_inputs(setup) if one.key in shares))
