"""The impacts of a track with their combined uncertainties: of a run that is recorded, and of one that still falls."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

from radargui.model.result import Bounces, PathLengths, Segment, Track
from radargui.model.setup import Setup
from radargui.model.setup_posterior import SetupValue
from radargui.model.uncertainty_budget import InputChange, UncertaintyBudget
from radargui.processing.uncertainty_budget import (
    TrackShifts,
    changes_of_drops,
    changes_of_places,
    moved_track,
    with_budget,
)
from radargui.restitution.bounces import bounces_of_drops, joined
from radargui.restitution.track_fit import fit_drops


class TrackImpacts(NamedTuple):
    """A track and its bounces with their combined uncertainties, their budget, and what flights say of the setup."""

    track: Track
    bounces: Bounces
    budget: UncertaintyBudget | None = None
    posterior: tuple[SetupValue, ...] = ()


def impacts_of_track(
    track: Track,
    paths: PathLengths,
    segment: Segment,
    setup: Setup,
    sample_rate_hz: float,
    bounces: Bounces | None = None,
    changes: tuple[InputChange, ...] | None = None,
) -> TrackImpacts:
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
        those of the flights that are fitted to the paths, which also say where the antennas are.
    """
    fits = fit_drops(paths, track, segment, setup, sample_rate_hz) if bounces is None else ()
    # without a rest the zero of L is assumed: no uncertainty of a calibration means anything then
    if not segment.has_rest:
        found = bounces or joined(bounces_of_drops(fits, track, segment, setup))
        # where the sphere was at the start is assumed, not known: no e, and no g
        return TrackImpacts(track, Bounces(tuple(replace(impact, valid=False) for impact in found.impacts)))
    if bounces is not None and changes is not None:
        return TrackImpacts(*with_budget(track, bounces, changes, segment, setup))
    shifts = TrackShifts.of(track, segment, setup, fits[0] if fits else None)
    if not fits:
        found = bounces or Bounces()
        return TrackImpacts(*with_budget(track, found, changes_of_places(shifts, found), segment, setup))
    track, posterior = moved_track(track, shifts, fits[0]), fits[0].posterior.values(setup)
    each = bounces_of_drops(fits, track, segment, setup)
    own = changes_of_drops(shifts, each, setup, fits)
    return TrackImpacts(*with_budget(track, joined(each), own, segment, setup), posterior)
