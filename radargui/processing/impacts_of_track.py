"""The impacts of a track with their combined uncertainties: of a run that is recorded, and of one that still falls."""

from __future__ import annotations

import math
from dataclasses import replace

from radargui.model.gravity import drag_of_sphere, expected_gravity_m_s2
from radargui.model.result import Bounces, PathLengths, Segment, Track
from radargui.model.setup import Setup
from radargui.model.uncertainty_budget import InputChange, UncertaintyBudget
from radargui.processing.uncertainty_budget import changes_of_track, with_budget
from radargui.restitution.bounces import find_bounces
from radargui.restitution.oblique import with_oblique
from radargui.restitution.site_gravity import with_missed_gravity


def impacts_of_track(
    track: Track,
    paths: PathLengths,
    segment: Segment,
    setup: Setup,
    sample_rate_hz: float,
    bounces: Bounces | None = None,
    changes: tuple[InputChange, ...] | None = None,
) -> tuple[Track, Bounces, UncertaintyBudget | None]:
    """Return a track and its bounces with their combined uncertainties, and the budget of these.

    Parameters
    ----------
    track, paths
        Places, and the path lengths that they were located from.
    segment
        The motion within both. Without a rest before it no e is valid, and there is no budget.
    setup
        Geometry, floor and sphere, with their uncertainties.
    sample_rate_hz
        Of track and paths.
    bounces, changes
        Of an estimate that knows the speeds at an impact from all samples, and what its uncertain inputs change; None:
        those of the track, from its flights.
    """
    of_track = bounces is None
    if bounces is None:
        bounces = _bounces_of(track, segment, setup, sample_rate_hz)
    # without a rest the zero of L is assumed: no uncertainty of a calibration means anything then
    if not segment.has_rest:
        # where the sphere was at the start is assumed, not known: no e, and no g
        return track, Bounces(tuple(replace(impact, valid=False) for impact in bounces.impacts)), None
    if changes is None:
        changes = changes_of_track(paths, bounces, setup, segment)
    if of_track:
        bounces = with_missed_gravity(bounces, setup, math.hypot(*(one.g_m_s2 for one in changes)))
    track, bounces, budget = with_budget(track, bounces, changes, segment, setup)
    return track, with_oblique(bounces, changes, track, setup), budget


def _bounces_of(track: Track, segment: Segment, setup: Setup, rate_hz: float) -> Bounces:
    # a normal that is a default is no statement about this floor
    given = "normal" in setup.floor.model_fields_set
    normal = setup.floor.normal if given else None
    drag = drag_of_sphere(setup.tracer.diameter_m, setup.tracer.density_kg_m3, setup.air.gas)
    is_known = setup.tracer.density_kg_m3 is not None
    g_m_s2 = expected_gravity_m_s2(setup.site)
    return find_bounces(track, segment, normal, rate_hz, g_m_s2, setup.floor.u_tilt_deg, drag, is_drag_known=is_known)
