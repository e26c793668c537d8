"""Compute e of the first bounce from the live track while the flight after it still lasts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from radargui.experiment.event import LIVE
from radargui.live.track import LiveTrack
from radargui.model.gravity import expected_gravity_m_s2
from radargui.model.result import Bounce, PathLengths, Segment, Track
from radargui.model.setup import Setup
from radargui.physics.path_length import MIN_RECEIVERS
from radargui.processing.impacts_of_track import impacts_of_track
from radargui.restitution.track_flights import TrackFlights, find_track_flights

FLOWN_S = 0.1
"""Of the flight after the first impact, unless the next impact ends it. It leaves four fifths of half a second to find
e and to show it; of 22 drops of laboratories e was as near to the truth after 0.1 s as after 0.3."""
LONGEST_S = 3.0
"""Of a motion without a bounce it is looked for no longer: the longest fall that fits into the field of view takes a
third of a second, and a hand that lets go late some more."""
MOVED_M = 1e-3
"""So far from where it hung a tracer has begun to move: it is shown exactly there until its motion is seen."""
U_M = 1e-4
"""Of the live places, as far as it is not their noise: from the first fringe on the live track is within this of the
truth where no floor reflects strongly (`bench live`)."""
EVEN = 1.5
"""Spacings of live estimates that differ by more than this factor have a gap between them."""


def first_bounce(live: LiveTrack, first_index: int, setup: Setup) -> Bounce | None:
    """Return the first bounce of a run as soon as e is known, with its combined uncertainty; None until then.

    The places of the live track are taken like those of a corrected recording: two parabolas that meet at the impact,
    with what antennas, floor, drag and a fall that misses gravity leave open in the uncertainty.

    Parameters
    ----------
    live
        Of the acquisition.
    first_index
        Absolute index of the run's first sample.
    setup
        Under which it runs.
    """
    # where it began anew the places count from a rest that nobody knows
    if setup.n_receivers < MIN_RECEIVERS or live.began_anew:
        return None
    span = live.since(first_index)
    if span.index.size == 0:
        return None
    known = np.asarray(np.isfinite(span.position_m).all(axis=0))
    release_m = np.array(setup.tracer.release_position_m)
    away_m = np.linalg.norm(span.position_m - release_m[:, None], axis=0)
    moved = known & (away_m > MOVED_M)
    begin, spacing = int(np.argmax(moved)), np.diff(span.index)
    # the rest belongs to it: without one the places have no zero
    if not moved.any() or begin < 2 or not known[begin - 1] or span.time_s[-1] - span.time_s[begin] > LONGEST_S:
        return None
    # no coefficient is computed across a gap
    if spacing.max() > EVEN * spacing.min():
        return None
    rad_per_m, u_path = 2.0 * np.pi / setup.radar.wavelength_m, np.full(span.change_m.shape, U_M)
    valid = np.isfinite(span.change_m)
    paths = PathLengths(span.time_s, rad_per_m * span.change_m, span.change_m, u_path, valid)
    track = Track(span.time_s, span.position_m, np.full(span.position_m.shape, U_M), known, "exact")
    segment = Segment(begin - 1, span.index.size, 0, begin - 1)
    rate_hz = 1.0 / float(span.time_s[1] - span.time_s[0])
    # of the whole a look takes a tenth of a second of the processor, of the places of impacts a hundredth
    flights = find_track_flights(track, segment, rate_hz, expected_gravity_m_s2(setup.site))
    if not isinstance(flights, TrackFlights):
        return None
    if flights.impact_s.size == 1 and span.time_s[-1] - flights.impact_s[0] <= FLOWN_S:
        return None
    impacts = impacts_of_track(track, paths, segment, setup, rate_hz).bounces.impacts
    return replace(impacts[0], method=LIVE) if impacts and impacts[0].valid else None
