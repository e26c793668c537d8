"""What one drop says about the calibration before a series: whether g comes out and what it pulls the antennas by."""

import math
from dataclasses import dataclass

from radargui.model.calibrated_setup import day_of
from radargui.model.gravity import g_and_u_of_site
from radargui.model.result import RunResult
from radargui.model.rounding import COVERAGE, concise
from radargui.restitution.site_gravity import site_check

MAX_PULL = 4.0
"""Beyond it what is stated and what the drop says differ by more than chance: one of ten values once in 1,600 drops."""


@dataclass(frozen=True, slots=True)
class CalibrationCheck:
    """Whether the calibration holds, and the line that says so."""

    holds: bool
    words: str


def check_calibration(result: RunResult) -> CalibrationCheck | None:
    """Return what a drop says about the calibration of its setup, or the setup that has none; None: it cannot tell.

    Flights tell of antennas and release what `RunResult.setup_posterior` has; one that is far from what is stated in
    the uncertainty of both is wrong, or bends as another one that is.

    Parameters
    ----------
    result
        Of a drop.
    """
    fall, budget = result.bounces.free_fall, result.uncertainty_budget
    pulls = [abs(one.pull) for one in result.setup_posterior if one.pull is not None]
    u_g = None if budget is None else budget.g_m_s2.combined
    if fall is None or not u_g or not pulls:
        return None
    site = site_check(result)
    expected, u_expected = (site.expected_m_s2, site.u_expected_m_s2) if site else g_and_u_of_site(result.setup.site)
    # independent: the site's g knows nothing of the antennas
    g_holds = abs(fall.g_m_s2 - expected) <= COVERAGE * math.hypot(u_g, u_expected)
    holds = g_holds and max(pulls) <= MAX_PULL
    figures = f"g {concise(fall.g_m_s2, u_g, 'm/s²')}, largest pull {max(pulls):.1f}"
    content = result.setup.calibration.content
    said = "the setup" if content is None else f"the calibration of {day_of(content)}"
    if holds:
        return CalibrationCheck(holds, f"{said} still holds: {figures}")
    return CalibrationCheck(holds, f"{said} does not hold: {figures}, g expected {expected:.4f}; calibrate again")
