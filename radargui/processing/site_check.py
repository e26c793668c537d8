"""The check of a result's g against the gravity of the place, with all that is known of its uncertainty."""

from __future__ import annotations

from radargui.model.result import RunResult
from radargui.restitution.site_gravity import SiteCheck, check_against_site


def site_check(result: RunResult) -> SiteCheck | None:
    """Return the check; None without a fall, or where the setup does not say where it stands."""
    fall = result.bounces.free_fall
    if fall is None:
        return None
    budget = result.uncertainty_budget
    u = None if budget is None else budget.g_m_s2.combined
    return check_against_site(fall, result.setup, u)
