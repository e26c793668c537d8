"""The impacts of a track with their combined uncertainties: of a run that is recorded, and of one that still falls."""

from __future__ import annotations

from dataclasses import dataclass, replace

from radargui.model.finding import Finding
from radargui.model.result import Bounces, PathLengths, Segment, Track
from radargui.model.setup import Setup
from radargui.model.setup_posterior import SetupValue
from radargui.model.uncertainty_budget import InputChange, UncertaintyBudget
from radargui.processing.measured_motion import locate
from radargui.processing.uncertainty_budget import changes_of_track, with_budget
from radargui.restitution.bounces import FlownTrack, find_bounces
from radargui.restitution.oblique import with_oblique


@dataclass(frozen=True, slots=True)
class ImpactsOfTrack:
    """A track and its bounces with their combined uncertainties.

    Attributes
    ----------
    track, bounces
        The track located with the setup as its flights found it.
    budget
        Of the uncertainties; None without a rest.
    setup_posterior
        What the flights of a located track say of the setup.
    cause
        What of it is likely wrong.
    """

    track: Track
    bounces: Bounces
    budget: UncertaintyBudget | None = None
    setup_posterior: tuple[SetupValue, ...] = ()
    cause: Finding | None = None


def impacts_of_track(
    track: Track,
    paths: PathLengths,
    segment: Segment,
    setup: Setup,
    sample_rate_hz: float,
    bounces: Bounces | None = None,
    changes: tuple[InputChange, ...] | None = None,
) -> ImpactsOfTrack:
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
    flown = find_bounces(track, paths, segment, setup, sample_rate_hz) if bounces is None else FlownTrack(bounces)
    # without a rest the zero of L is assumed: no uncertainty of a calibration means anything then
    if not segment.has_rest:
        # where the sphere was at the start is assumed, not known: no e, and no g
        return ImpactsOfTrack(track, Bounces(tuple(replace(one, valid=False) for one in flown.bounces.impacts)))
    values: tuple[SetupValue, ...] = ()
    if changes is None:
        posterior = flown.posterior
        found = setup if posterior is None else posterior.applied(setup)
        values = () if posterior is None else posterior.values(setup)
        again = None if posterior is None or track.geometry != "exact" else locate(paths, found)
        if again is not None:
            track = replace(track, position_m=again.position_m, valid=track.valid & again.valid)
        changes = changes_of_track(paths, flown, found, segment)
    track, bounces, budget = with_budget(track, flown.bounces, changes, segment, setup)
    return ImpactsOfTrack(track, with_oblique(bounces, changes, track, setup), budget, values, flown.cause)
