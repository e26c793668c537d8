"""What is said of the motion, its flights and its impacts: how it was found, that they bend, that they disagree."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from radargui.model.finding import Finding, warn
from radargui.model.gravity import EARTH_GRAVITY_M_S2, expected_gravity_m_s2, gravity_of_site, share_in_air
from radargui.model.setup import Setup
from radargui.processing.checks.evidence import Evidence
from radargui.processing.checks.setup import SIGMAS, floor_elsewhere, is_misplaced
from radargui.restitution.cross_check import disagreements, floor_and_wall
from radargui.restitution.stopped_fall import braked_without_impact


def on_the_way(evidence: Evidence) -> Iterator[Finding]:
    """Yield what was found while it was measured: echoes lost, a correction that does not stand, a rest that drifts."""
    return (_of_all(one, evidence.part.receivers) for one in evidence.motion.findings)


def _of_all(finding: Finding, receivers: Sequence[int]) -> Finding:
    """Return what is found of one of some receivers with its number among all."""
    facts = {name: _of_all(one, receivers) if isinstance(one, Finding) else one for name, one in finding.facts.items()}
    receiver = None if finding.receiver is None else receivers[finding.receiver - 1] + 1
    return replace(finding, receiver=receiver, facts=facts)


def further_motions(evidence: Evidence) -> Iterator[Finding]:
    """Yield each other motion of a record of which one drop is measured, from its rest."""
    for begin_s, end_s in evidence.part.whole.further:
        yield warn("further_motion", begin_s=begin_s, end_s=end_s)


def plane_geometry(evidence: Evidence) -> Finding | None:
    """The antennas were taken as infinitely far away."""
    track = evidence.measured
    return warn("plane_geometry") if track is not None and track.geometry == "plane" else None


def no_position(evidence: Evidence) -> Finding | None:
    """Path lengths are known, and tell no position."""
    known, track = evidence.motion.paths.valid.all(axis=0), evidence.motion.track
    if evidence.is_refused or track is None or not known.any():
        return None
    return None if (known & np.isfinite(track.u_position_m)).any() else warn("no_position")


def no_rest(evidence: Evidence) -> Finding | None:
    """It begins without a rest."""
    if evidence.track is None or evidence.segment.has_rest:
        return None
    # with a gap before it even the release is no assumption that one could make
    return warn("no_rest_after_gap" if evidence.part.begins_after_gap else "no_rest")


_LIGHTEST_KG_M3 = 1000.0
"""Of a sphere of which no density is given: air may take 0.18 % off its acceleration, or nothing."""


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
    if not max(least - fall.g_m_s2, fall.g_m_s2 - most) > SIGMAS * u:
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
    if found is None or evidence.part.whole.clock is not None:
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
    least, most = EARTH_GRAVITY_M_S2 if site is None else (site[0] - SIGMAS * site[1], site[0] + SIGMAS * site[1])
    lightest = share_in_air(_LIGHTEST_KG_M3 if density is None else density, setup.air.gas)
    return lightest * least, most if density is None else lightest * most


def braked(evidence: Evidence) -> Finding | None:
    """Flights are braked more than a metal sphere is."""
    drag_1_m = evidence.bounces.braked_1_m
    return None if drag_1_m is None else warn("flights_braked", drag_1_m=drag_1_m)


def coefficients_disagree(evidence: Evidence) -> Sequence[Finding]:
    """Speeds, duration and height of a flight give different coefficients."""
    return disagreements(evidence.bounces)


def wall_at_impact(evidence: Evidence) -> Sequence[Finding]:
    """A wall was met together with the floor."""
    return floor_and_wall(evidence.bounces)


def floor(evidence: Evidence) -> Sequence[Finding]:
    """The impacts do not lie in one plane, or take their time: found while they were judged by it."""
    return evidence.floor


def no_impact(evidence: Evidence) -> Finding | None:
    """The fall ends on some way, not by an impact."""
    return None if evidence.measured is None else braked_without_impact(evidence.bounces, evidence.measured)
