"""Flights of a track: where they lie, and their fit to the path lengths with the setup within its u (method 5)."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from radargui.estimation.flights.of_paths import PathData, PathFlights, PathModel, PathSetup, fit_paths
from radargui.model.arrays import BoolArray, FloatArray, IntArray, median
from radargui.model.gravity import NOMINAL_GRAVITY_M_S2
from radargui.model.result import PathLengths, Segment, Track
from radargui.model.setup import Setup
from radargui.motion.flights import Flights
from radargui.motion.impacts import find_track_impacts
from radargui.restitution.settings import TRACKS
from radargui.restitution.sphere_parts import sphere_parts_m
from radargui.restitution.walls_of_track import Aside


def fit_drops(
    paths: PathLengths, track: Track, segment: Segment, setup: Setup, sample_rate_hz: float
) -> tuple[PathFlights, ...]:
    """Return the flights of each drop of a record: what lies there may be taken up and dropped again.

    Parameters as for `fit_track`.
    """
    found: list[PathFlights] = []
    while (fit := fit_track(paths, track, segment, setup, sample_rate_hz)) is not None:
        found.append(fit)
        if not fit.goes_on:
            break
        after = int(np.searchsorted(track.time_s, fit.end_s + TRACKS.clearance_s))
        segment = replace(segment, first=after)
    return tuple(found)


def fit_track(
    paths: PathLengths, track: Track, segment: Segment, setup: Setup, sample_rate_hz: float
) -> PathFlights | None:
    """Return the flights between the impacts of a track; None without impacts, or where nothing falls.

    Parameters
    ----------
    paths
        Changes of path of three or more receivers.
    track
        Where they were located with the setup as it is stated.
    segment
        The motion within the track.
    setup
        What it states, with its u.
    sample_rate_hz
        Rate of the samples.
    """
    part = slice(segment.first, segment.last)
    time_s, height_m = track.time_s[part], track.position_m[2, part]
    known = track.valid[part] & np.isfinite(height_m)
    impact_s = find_track_impacts(time_s, height_m, known, sample_rate_hz)
    if not impact_s.size:
        return None
    # no release is a clean cut
    begin_s = min(float(time_s[0]) + TRACKS.start_clearance_s, float(impact_s[0]) - TRACKS.clearance_s)
    # no fall lasts longer: before it a hand held the body
    begin_s = max(begin_s, float(impact_s[0]) - TRACKS.longest_fall_s)
    end_s = min(float(time_s[-1]), _landing_s(time_s[known], height_m[known], float(impact_s[-1])))
    found, stated = None, PathSetup.of(setup)
    # a wall beside the fall bends it aside
    met_wall = Aside.of(track, np.append(begin_s, impact_s), np.append(impact_s, end_s)).turned
    goes_on = False
    # impacts are seen to a millisecond only: with samples of the wrong flight a second time
    for _ in range(2):
        means = _means(paths, track, begin_s, impact_s, end_s)
        means = means.chosen(~means.not_falling_yet())
        fall = _Falls.of(means, impact_s.size + 1)
        are_flights = fall.are_flights & ~met_wall
        if abs(fall.g_m_s2 / NOMINAL_GRAVITY_M_S2 - 1.0) >= TRACKS.largest_g_error:
            return None
        lasts_s = np.diff(np.concatenate([[begin_s], impact_s, [end_s]]))
        if stops := np.flatnonzero(~are_flights & (lasts_s > TRACKS.longest_flight_s)).tolist():
            # it lay there until somebody dropped it again: what follows is another drop
            goes_on = True
            impact_s, end_s = impact_s[: stops[0]], float(impact_s[stops[0] - 1]) if stops[0] else begin_s
            are_flights, met_wall = are_flights[: stops[0] + 1], met_wall[: stops[0] + 1]
        means = means.chosen(means.flight < are_flights.size)
        means = means.chosen(are_flights[means.flight])
        if not means.time_s.size or not impact_s.size:
            return None
        start = _start(means, np.append(begin_s, impact_s)) if found is None else found.flights
        data = PathData(*means, sphere_parts_m(means.position_m, setup))
        noise = None if found is None else found.noise
        found = fit_paths(PathModel.of(stated, setup.tracer, start, data), are_flights, end_s, noise)
        if found is None:
            return None
        found = replace(found, goes_on=goes_on)
        before_s, impact_s = impact_s, found.flights.impact_s
        if np.abs(impact_s - before_s).max() < TRACKS.settled_s:
            break
    return found


def _landing_s(time_s: FloatArray, height_m: FloatArray, impact_s: float) -> float:
    """Return when the body is back on the floor after its last impact, by the milliseconds that follow this."""
    # the corner itself is rounded by the low-pass of the correction
    begin_s = impact_s + 0.001
    inside = slice(*np.searchsorted(time_s, [begin_s, begin_s + TRACKS.rising_s]))
    d, height = time_s[inside] - impact_s, height_m[inside]
    if d.size < 2 or d[-1] - d[0] < TRACKS.least_rising_s:
        return impact_s
    # gravity taken off, a line has one unknown less: so few samples bear no parabola
    straight, away = height + 0.5 * NOMINAL_GRAVITY_M_S2 * d * d, d - d.mean()
    rising_m_s = float(away @ straight / (away @ away))
    return impact_s + 2.0 * max(0.0, rising_m_s) / NOMINAL_GRAVITY_M_S2


class _Means(NamedTuple):
    """Means over parts of flights: times (n,), changes of path (n_receivers, n), flights (n,), places (3, n)."""

    time_s: FloatArray
    change_m: FloatArray
    flight: IntArray
    position_m: FloatArray

    def chosen(self, which: BoolArray) -> _Means:
        """Return some of them."""
        return _Means(self.time_s[which], self.change_m[:, which], self.flight[which], self.position_m[:, which])

    def not_falling_yet(self) -> BoolArray:
        """Return which of the first flight's means come before it is a parabola, shape (n,).

        A hand that throws, a thread that slips, a magnet: the last part of the flight says how well one can be.
        """
        first = np.flatnonzero(self.flight == 0)
        out = np.zeros(self.time_s.size, dtype=np.bool_)
        shares = [round(share * first.size) for share in TRACKS.begins]
        if first.size - shares[-1] < 2 * TRACKS.least_means:
            return out
        missed = [parabola_of(self.time_s[first[n:]], self.position_m[2, first[n:]]).missed_m for n in shares]
        bound_m = max(TRACKS.bends_at_first * missed[-1], TRACKS.least_bend_m)
        begin = next(n for n, own in zip(shares, missed, strict=True) if own <= bound_m)
        out[first[:begin]] = True
        return out


class Parabola(NamedTuple):
    """Height against a parabola of its own: its g, what that weighs, and the root mean square missed."""

    g_m_s2: float
    weight: float
    missed_m: float


def parabola_of(time_s: FloatArray, height_m: FloatArray) -> Parabola:
    """Return the least-squares parabola of a height, shapes (n,)."""
    d = time_s - time_s.mean()
    bend = d * d - np.polyval(np.polyfit(d, d * d, 1), d)
    weight = float(bend @ bend)
    half_g = -float(bend @ height_m) / weight
    straight = height_m + half_g * d * d
    left = straight - np.polyval(np.polyfit(d, straight, 1), d)
    return Parabola(2.0 * half_g, weight, float(np.sqrt(np.mean(left**2))))


def _means(paths: PathLengths, track: Track, begin_s: float, impact_s: FloatArray, end_s: float) -> _Means:
    """Return means over 2 ms or more, the ends of flights left out, of all that is known there."""
    begins = np.append(begin_s, impact_s + TRACKS.clearance_s)
    ends = np.append(impact_s, end_s) - TRACKS.clearance_s
    step_s = max(TRACKS.mean_s, float(np.maximum(ends - begins, 0.0).sum()) / TRACKS.most_means)
    spacing_s = float(track.time_s[1] - track.time_s[0])
    out = [_Means(np.zeros(0), np.zeros((len(paths.change_m), 0)), np.zeros(0, np.intp), np.zeros((3, 0)))]
    for number, (first_s, last_s) in enumerate(zip(begins, ends, strict=True)):
        if last_s - first_s < TRACKS.least_flight_s:
            continue
        count = max(TRACKS.least_means, round((last_s - first_s) / step_s))
        edges = np.unique(np.searchsorted(track.time_s, np.linspace(first_s, last_s, count + 1)))
        if edges.size <= TRACKS.least_means:
            continue
        inner, at, size = slice(edges[0], edges[-1]), edges[:-1] - edges[0], np.diff(edges)
        # over a gap nobody knows the mean
        known = paths.valid[:, inner].all(axis=0) & track.valid[inner]
        seen = np.logical_and.reduceat(known, at)
        if seen.sum() < TRACKS.least_means:
            continue
        time_s, change_m, place_m = (
            np.add.reduceat(rows[..., inner], at, axis=-1) / size
            for rows in (track.time_s, paths.change_m, track.position_m)
        )
        # a mean of what bends is not what it is in the middle: by half the bend times the variance of the times
        step = np.diff(time_s)
        bend = np.diff(np.diff(change_m) / step) / (0.5 * (step[1:] + step[:-1]))
        change_m = change_m - np.pad(bend, ((0, 0), (1, 1)), mode="edge") * (size**2 - 1.0) / 24.0 * spacing_s**2
        seen &= np.isfinite(change_m).all(axis=0)
        out.append(_Means(time_s, change_m, np.full(size.size, number), place_m).chosen(seen))
    return _Means(
        np.concatenate([one.time_s for one in out]),
        np.concatenate([one.change_m for one in out], axis=1),
        np.concatenate([one.flight for one in out]),
        np.concatenate([one.position_m for one in out], axis=1),
    )


class _Falls(NamedTuple):
    """Which flights bend as free ones do, (n_flights,), and the g that they share."""

    are_flights: BoolArray
    g_m_s2: float

    @staticmethod
    def of(means: _Means, n_flights: int) -> _Falls:
        """Hold each flight's heights against a parabola of its own.

        A hand, a string or a lost fringe makes kinks as well, and may lie between flights: what misses its parabola by
        far, or lasts and does not fall, is no flight.
        """
        own = [np.flatnonzero(means.flight == number) for number in range(n_flights)]
        missed, g, weight = np.full((3, n_flights), np.nan)
        for number, which in enumerate(own):
            if which.size:
                own_fit = parabola_of(means.time_s[which], means.position_m[2, which])
                g[number], weight[number], missed[number] = own_fit
        known = np.isfinite(missed)
        if known.sum() > 2:
            # two flights have no median that tells which of them is wrong
            bound_m = max(TRACKS.largest_residual * float(median(missed[known])), TRACKS.least_residual_m)
            known &= ~(missed > bound_m)
        lasts_s = np.array([means.time_s[which[-1]] - means.time_s[which[0]] if which.size else 0.0 for which in own])
        falls = np.abs(g / NOMINAL_GRAVITY_M_S2 - 1.0) < TRACKS.largest_g_error
        known &= falls | (lasts_s < TRACKS.least_falling_s)
        return _Falls(known, float(np.average(g[known], weights=weight[known])) if known.any() else np.nan)


def _start(means: _Means, begin_s: FloatArray) -> Flights:
    """Begin with lines through the places of each flight, gravity taken off."""
    place, velocity = np.full((begin_s.size, 3), np.nan), np.zeros((begin_s.size, 3))
    for number in np.unique(means.flight):
        own = means.flight == number
        d = means.time_s[own] - begin_s[number]
        straight = means.position_m[:, own].copy()
        straight[2] += 0.5 * NOMINAL_GRAVITY_M_S2 * d * d
        velocity[number], place[number] = np.polyfit(d, straight.T, 1)
    known = np.isfinite(place[:, 0])
    place = np.stack([np.interp(begin_s, begin_s[known], place[known, axis]) for axis in range(3)], axis=1)
    lasts_s = np.diff(begin_s)[:, None]
    # each flight begins where the one before ends
    velocity[:-1] = np.diff(place, axis=0) / lasts_s + 0.5 * NOMINAL_GRAVITY_M_S2 * lasts_s * np.array([0.0, 0.0, 1.0])
    return Flights(float(begin_s[0]), place[0], NOMINAL_GRAVITY_M_S2, 0.0, velocity, begin_s[1:].copy())
