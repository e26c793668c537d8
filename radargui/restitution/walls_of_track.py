"""Walls that a track met beside its fall: where a flight turns aside, or an impact throws it back along the floor.

A wall rubs: flights that met one are no parabolas, and their ends tell no speed at the floor (method 5, Impacts).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from radargui.model.arrays import BoolArray, FloatArray, IntArray
from radargui.model.result import Track
from radargui.restitution.settings import WALLS
from radargui.restitution.track_flights import TrackFlights


def walls_of_flights(
    track: Track, flights: TrackFlights, normal: FloatArray, gravity_m_s2: float
) -> tuple[BoolArray, BoolArray, tuple[float, ...]]:
    """Return which flights met a wall, which impacts did, shapes (n_flights,) and (n_impacts,), and when.

    Parameters
    ----------
    track, flights
        Places, and what flies; shape (n_flights,).
    normal, gravity_m_s2
        Floor's normal, shape (3,), and g of the place.
    """
    first_s, last_s = flights.first_s, np.append(flights.impact_s, flights.end_s[-1])
    aside = Aside.of(track, first_s, np.where(np.isfinite(last_s), last_s, first_s))
    falls = flights.velocity_m_s[:, 2] - gravity_m_s2 * (last_s - first_s)
    thrown = aside.thrown_back(falls[:-1], flights.velocity_m_s[1:, 2], normal)
    thrown &= flights.are_known[:-1] & flights.are_known[1:]
    walls_s = np.sort(np.concatenate([aside.when_s[aside.turned], flights.impact_s[thrown]]))
    return aside.turned, thrown, tuple(walls_s.tolist())


@dataclass(frozen=True, slots=True)
class Aside:
    """How flights go aside, along x and y.

    Nothing pulls a body aside in the air: over a flight x and y are lines, to which a wall adds a hinge, max(0, t - w).
    Over means of equal parts each hinge has one shape, whatever the flight's length.

    Attributes
    ----------
    when_s
        Of the hinge that fits best, shape (n_flights,); NaN where a flight is too short to tell.
    before_m_s, after_m_s
        Speeds on both sides of it, those of a line where it is none, shape (n_flights, 2).
    turned
        Whether the flight turns there by more than waves and noise make, shape (n_flights,).
    u_m_s
        Of the speeds, of whole flights, shape (n_flights,).
    """

    when_s: FloatArray
    before_m_s: FloatArray
    after_m_s: FloatArray
    turned: BoolArray
    u_m_s: FloatArray

    @classmethod
    def of(cls, track: Track, begin_s: FloatArray, end_s: FloatArray) -> Aside:
        """Return that of flights (n_flights,)."""
        begin, length = begin_s + WALLS.clearance_s, end_s - begin_s - 2.0 * WALLS.clearance_s
        edges = begin[:, None] + length[:, None] * np.arange(WALLS.parts + 1) / WALLS.parts
        place = np.searchsorted(track.time_s, edges)
        when, before = np.full(begin.size, np.nan), np.full((begin.size, 2), np.nan)
        after, turned, u = before.copy(), np.zeros(begin.size, dtype=np.bool_), when.copy()
        long = np.flatnonzero((np.diff(place, axis=1) > 0).all(axis=1) & (length > WALLS.min_flight_s))
        if long.size:
            mean_m, u_m, known = _means(track, place[long])
            # over a gap nobody knows whether it turned
            seen, mean_m, u_m = long[known], mean_m[known], u_m[known]
            part_s = length[seen] / WALLS.parts
            best, before[seen], after[seen], turned[seen] = _hinges(mean_m, u_m, part_s)
            when[seen] = begin[seen] + part_s * (best + 0.5)
            # errors of a track are waves: as if one were as long as the flight
            u[seen] = np.sqrt(12.0) * u_m / length[seen]
        return cls(when, before, after, turned, u)

    def thrown_back(self, falls_m_s: FloatArray, rises_m_s: FloatArray, normal: FloatArray) -> BoolArray:
        """Return which impacts turned the motion along the floor back: friction stops it at most, shape (n_impacts,).

        Whole flights say how fast they go aside: what a wall within milliseconds of the floor does is the impact's.
        Speeds along z before and after, shape (n_impacts,).
        """
        before = np.column_stack([self.after_m_s[:-1], falls_m_s])
        after = np.column_stack([self.before_m_s[1:], rises_m_s])
        before, after = (one - np.outer(one @ normal, normal) for one in (before, after))
        slower = np.minimum(np.linalg.norm(before, axis=1), np.linalg.norm(after, axis=1))
        back = (before * after).sum(axis=1) < 0.0
        least = np.maximum(WALLS.min_back_m_s, WALLS.sigmas_back * np.hypot(self.u_m_s[:-1], self.u_m_s[1:]))
        return np.asarray(back & (slower > least))


def _means(track: Track, place: IntArray) -> tuple[FloatArray, FloatArray, BoolArray]:
    """Return x and y over the parts of flights that begin at places (n, parts + 1), (n, 2, parts), and their u, (n,).

    And whether all of a flight is known, (n,).
    """
    part, shape = slice(int(place[0, 0]), int(place[-1, -1])), (-1, *place.shape)
    # the runs between two flights are added, too, and left out: the last one is empty
    first = place.ravel()[:-1] - part.start
    sums = np.append(np.add.reduceat(track.position_m[:2, part], first, axis=1), np.zeros((2, 1)), axis=1)
    valid = np.append(np.logical_and.reduceat(track.valid[part], first), True)
    mean_m = sums.reshape(shape)[..., :-1] / np.diff(place)
    known = valid.reshape(place.shape)[:, :-1].all(axis=1) & np.isfinite(mean_m).all(axis=(0, 2))
    u_m = np.sqrt((track.u_position_m[:2][:, place[:, :-1]] ** 2).mean(axis=(0, 2)))
    return mean_m.swapaxes(0, 1), np.asarray(u_m), np.asarray(known)


def _hinges(
    mean_m: FloatArray, u_m: FloatArray, part_s: FloatArray
) -> tuple[IntArray, FloatArray, FloatArray, BoolArray]:
    """Return the parts in which flights turn, (n,), speeds before and after, (n, 2), and whether they do, (n,)."""
    bent, across, size = _shapes()
    # a line of slope 1 a part has this size along the second of the two vectors
    per_part, flight = across[1] @ np.arange(WALLS.parts), np.arange(len(mean_m))
    left = mean_m - (mean_m @ across.T) @ across
    along = left @ bent.T / size
    gained = (along**2).sum(axis=1)
    best = gained.argmax(axis=1)
    most = gained[flight, best]
    sigma_m = np.sqrt(np.maximum((left**2).sum(axis=(1, 2)) - most, 0.0) / (2 * (WALLS.parts - 3)))
    turn = along[flight, :, best] / size[best, None]
    hinge = np.maximum(0.0, np.arange(WALLS.parts) - (best[:, None] + 1.0))
    before = (mean_m @ across[1] - turn * (hinge @ across[1])[:, None]) / per_part
    shown_m = np.sqrt(most)
    is_hinge = (
        (np.linalg.norm(turn, axis=1) / part_s > WALLS.min_jump_m_s)
        & (shown_m > WALLS.sigmas * sigma_m)
        & (shown_m > WALLS.min_of_u * u_m * np.sqrt(WALLS.parts))
    )
    straight = (mean_m @ across[1]) / per_part
    before, after = (np.where(is_hinge[:, None], one, straight) for one in (before, before + turn))
    return best + 1, before / part_s[:, None], after / part_s[:, None], is_hinge


@cache
def _shapes() -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return hinges across straight lines, (n_hinges, parts), two unit vectors along these, (2, parts), and sizes."""
    part = np.arange(WALLS.parts, dtype=np.float64)
    across = np.linalg.qr(np.stack([np.ones(WALLS.parts), part], axis=1))[0].T
    bent = np.maximum(0.0, part - part[1:-1, None])
    bent = bent - bent @ across.T @ across
    return bent, across, np.linalg.norm(bent, axis=1)
