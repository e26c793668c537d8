"""What the flights say: that they bend, by what likely, that they are braked, that g is none of this Earth."""

import math

from radargui.model.finding import Finding, warn
from radargui.model.gravity import EARTH_GRAVITY_M_S2, expected_gravity_m_s2, gravity_of_site, share_in_air
from radargui.model.setup import Setup
from radargui.processing.checks.evidence import Evidence
from radargui.processing.checks.setup import floor_elsewhere, is_misplaced

_LIGHTEST_KG_M3 = 1000.0
"""Of a sphere of which no density is given: air may take 0.18 % off its acceleration, or nothing."""
_SIGMAS = 3.0
"""How far beyond what is possible a measured value has to be, in its own u."""


def setup_contradicted(evidence: Evidence) -> Finding | None:
    """Flights name a place of the setup that is likely wrong."""
    # where antennas stand as none does flights would name any place
    if evidence.measured is not None and is_misplaced(evidence.setup):
        return None
    cause = evidence.motion.flights.cause
    # what bends the rest of it stands there already
    return None if cause is not None and evidence.part.left_out and not cause.facts["explains"] else cause


def flights_bend(evidence: Evidence) -> Finding | None:
    """Flights bend as neither noise nor the setup makes them; with a guess at the cause where nothing names one."""
    flights = evidence.motion.flights
    if flights.bent is None or "guess" not in flights.bent.facts:
        return flights.bent
    is_named = (
        flights.is_explained or evidence.part.left_out or (evidence.measured is not None and _is_setup_wrong(evidence))
    )
    return flights.bent.with_facts(guess="", remedy="") if is_named else flights.bent


def _is_setup_wrong(evidence: Evidence) -> bool:
    if is_misplaced(evidence.setup) or not evidence.part.has_room:
        return True
    return g_impossible(evidence) is not None or floor_elsewhere(evidence) is not None


def g_impossible(evidence: Evidence) -> Finding | None:
    """The fall contradicts the setup: g is that of no place on Earth, or not the site's."""
    setup, budget, fall = evidence.setup, evidence.budget, evidence.bounces.free_fall
    if evidence.exact_track is None or budget is None:
        return None
    combined, rate_hz = budget.g_m_s2.combined, evidence.part.conditioned.sample_rate_hz
    # what is thrown upwards does not fall (NaN neither)
    if fall is None or not fall.g_m_s2 > 0.0:
        return None
    u = fall.u_g_m_s2 if combined is None else combined
    least, most = possible_g_m_s2(setup)
    # NaN compares false: what is not known contradicts nothing
    if not max(least - fall.g_m_s2, fall.g_m_s2 - most) > _SIGMAS * u:
        return None
    site, there = gravity_of_site(setup.site), expected_gravity_m_s2(setup.site)
    # lengths go with 1 / frequency, times with 1 / rate
    ratio = fall.g_m_s2 / there
    return warn(
        "g_impossible",
        g_m_s2=fall.g_m_s2,
        u_g_m_s2=u,
        known="earth" if site is None else "site",
        site_m_s2=there,
        rate_hz=rate_hz / math.sqrt(ratio),
        frequency_hz=ratio * setup.radar.frequency_hz,
    )


def falls_otherwise(evidence: Evidence) -> Finding | None:
    """Something falls and bounces, but not with the g of the place."""
    found, there = evidence.bounces.falls_with_m_s2, expected_gravity_m_s2(evidence.setup.site)
    # phases that all turn too fast or too slowly say it already
    if found is None or evidence.part.clock is not None:
        return None
    ratio = found / there
    return warn(
        "falls_otherwise",
        g_m_s2=found,
        site_m_s2=there,
        rate_hz=evidence.part.conditioned.sample_rate_hz / math.sqrt(ratio),
        frequency_hz=ratio * evidence.setup.radar.frequency_hz,
    )


def possible_g_m_s2(setup: Setup) -> tuple[float, float]:
    """Return the least and the most that the sphere may fall with at the setup's site, or anywhere on Earth, m/s^2."""
    density, site = setup.tracer.density_kg_m3, gravity_of_site(setup.site)
    least, most = EARTH_GRAVITY_M_S2 if site is None else (site[0] - _SIGMAS * site[1], site[0] + _SIGMAS * site[1])
    lightest = share_in_air(_LIGHTEST_KG_M3 if density is None else density, setup.air.gas)
    return lightest * least, most if density is None else lightest * most


def braked(evidence: Evidence) -> Finding | None:
    """Flights are braked more than a metal sphere is."""
    drag_1_m = evidence.bounces.braked_1_m
    return None if drag_1_m is None else warn("flights_braked", drag_1_m=drag_1_m)
