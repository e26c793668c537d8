"""Bounces of a track: coefficient of restitution of each, and the free fall before the first (method 5, Flights)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from radargui.estimation.flights.of_paths import PathFlights
from radargui.model.arrays import BoolArray, FloatArray
from radargui.model.gravity import drag_of_sphere_1_m
from radargui.model.result import Bounce, Bounces, FreeFall, Segment, Track
from radargui.model.setup import Setup
from radargui.restitution.cross_check import FITTED_PATHS, cross_check, without_checks_by_walls
from radargui.restitution.drop_bounces import normal_of_velocities, speeds_along
from radargui.restitution.floor_normal import FloorNormal
from radargui.restitution.settings import FLIGHTS, TRACKS
from radargui.restitution.walls_of_track import without_e_by_walls


def bounces_of_drops(fits: Sequence[PathFlights], track: Track, segment: Segment, setup: Setup) -> tuple[Bounces, ...]:
    """Return the bounces of each drop of a record, parameters as for `find_bounces`."""
    return tuple(find_bounces(one, track, segment, setup) for one in fits)


def joined(each: Sequence[Bounces]) -> Bounces:
    """Return the bounces of some drops, one after the other, as those of the first."""
    if not each:
        return Bounces()
    return replace(
        each[0],
        impacts=tuple(impact for one in each for impact in one.impacts),
        walls_s=tuple(moment for one in each for moment in one.walls_s),
        with_walls_s=tuple(moment for one in each for moment in one.with_walls_s),
    )


def find_bounces(fit: PathFlights, track: Track, segment: Segment, setup: Setup) -> Bounces:
    """Return impacts with e = speed after / speed before along the floor's normal, and the first fall.

    Parameters
    ----------
    fit
        Of the track's flights, whose speeds where they meet these are.
    track
        Where the body was, for walls, heights and what is drawn.
    segment
        The motion within the track.
    setup
        Its floor's normal is the direction of the speeds; where it gives none, the one that the impacts support, whose
        uncertainty is a part of u_e.
    """
    flights, (velocity, by_unknowns) = fit.flights, fit.impact_velocities()
    statistical = np.einsum("ean,nm,ebm->eab", by_unknowns, fit.held, by_unknowns)
    # an impact is known by the flights before and after it
    known = fit.fitted[:-1] & fit.fitted[1:] & (velocity[:, 2] < 0.0) & (velocity[:, 5] > 0.0)
    floor, given = FloorNormal(np.asarray(setup.floor.normal)), "normal" in setup.floor.model_fields_set
    if not given:
        # an impact that gives no e may be no impact: it has no say about the floor
        usable = known & np.array(
            [_bounce(0.0, one, own, floor, is_known=True).valid for one, own in zip(velocity, statistical, strict=True)]
        )
        floor = normal_of_velocities(velocity[usable], statistical[usable], setup.floor.u_tilt_deg)
    # a speed is that of a flight that was fitted
    velocity[~fit.fitted[:-1], :3] = velocity[~fit.fitted[1:], 3:] = np.nan
    rows = zip(flights.impact_s.tolist(), velocity, statistical, known.tolist(), strict=True)
    impacts = tuple(_bounce(time_s, one, own, floor, is_known=seen) for time_s, one, own, seen in rows)
    x, y, z = (float(part) for part in floor.normal)
    bounces = Bounces(
        impacts,
        _free_fall(fit, track, segment, floor.normal),
        (x, y, z),
        None if given else floor.u_tilt_deg,
        _braked_1_m(fit, setup),
    )
    span_s = float(track.time_s[segment.first]), fit.end_s
    bounces = without_e_by_walls(bounces, track, velocity, span_s)
    time_s = np.arange(flights.onset_s, fit.end_s, FLIGHTS.check_step_s)
    height_m = floor.normal @ flights.position_m(time_s)
    checked = cross_check(bounces, time_s, height_m, flights.g_m_s2 * z, flights.drag_1_m)
    return without_checks_by_walls(checked)


def _bounce(
    time_s: float, velocity: FloatArray, covariance: FloatArray, floor: FloorNormal, *, is_known: bool
) -> Bounce:
    before, after, e, u_e = speeds_along(velocity, covariance, floor)
    if not is_known:
        return Bounce(time_s, before, after, np.nan, np.nan, FITTED_PATHS, valid=False)
    # no passive impact gives more than it takes: e above 1 beyond its u is a wrong track
    valid = bool(u_e < TRACKS.largest_u_e and 0.0 < e < 1.0 + TRACKS.sigmas_above_1 * u_e)
    return Bounce(time_s, before, after, e, u_e, FITTED_PATHS, valid)


def _braked_1_m(fit: PathFlights, setup: Setup) -> float | None:
    """Return k where the flights of a sphere of unknown density are braked more than metal is; None else."""
    metal_1_m = drag_of_sphere_1_m(setup.tracer.diameter_m, None)
    drag_1_m, u_1_m = fit.drag
    is_braked = drag_1_m - TRACKS.sure_of_drag * u_1_m > TRACKS.much_drag * metal_1_m
    return drag_1_m if setup.tracer.density_kg_m3 is None and is_braked else None


def _free_fall(fit: PathFlights, track: Track, segment: Segment, normal: FloatArray) -> FreeFall | None:
    """Return the first fall with the g of all flights: a check of the whole chain against gravity."""
    flights = fit.flights
    first_s, last_s = flights.onset_s, float(flights.impact_s[0]) - TRACKS.clearance_s
    if not fit.fitted[0] or last_s - first_s < TRACKS.least_fall_s:
        return None
    g, u_g = fit.gravity
    height_m = normal @ track.position_m
    during = _known(track, height_m, slice(*np.searchsorted(track.time_s, [first_s, last_s])))
    # what is drawn is a parabola of this fall alone
    since_s = track.time_s[during] - first_s
    bend, slope, level = np.polyfit(since_s, height_m[during], 2).tolist()
    left = height_m[during] - np.polyval([bend, slope, level], since_s)
    at_rest = height_m[_known(track, height_m, slice(segment.rest_first, segment.rest_last))]
    # without a known rest the highest place stands for it: the fall began no lower
    release = float(at_rest.mean()) if at_rest.size else float(height_m[during].max())
    drop = release - float(normal @ flights.position_m(flights.impact_s[:1])[:, 0])
    rms = float(np.sqrt((left**2).mean()))
    return FreeFall(g, u_g, first_s, last_s, release, drop, (level, slope, bend), rms)


def _known(track: Track, height_m: FloatArray, part: slice) -> BoolArray:
    """Return which samples of a part of a track are known, shape (n_samples,)."""
    out = np.zeros(track.valid.size, dtype=np.bool_)
    out[part] = track.valid[part] & np.isfinite(height_m[part])
    return out
