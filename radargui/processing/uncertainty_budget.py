"""The uncertainty budget of a result, and the combined uncertainties of its track and its impacts (method 6)."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from radargui.conditioning.averager import block_means
from radargui.estimation.flights.of_paths import PathFlights, PathSetup
from radargui.geometry.bistatic import solve_gradient
from radargui.model.arrays import FloatArray
from radargui.model.assumed import assumed_uncertainties
from radargui.model.result import Bounces, Segment, Track
from radargui.model.setup import Setup
from radargui.model.uncertainty_budget import BudgetLine, InputChange, Share, UncertaintyBudget
from radargui.restitution.drop_bounces import e_slopes
from radargui.restitution.floor_and_clock import tilt_and_clock
from radargui.restitution.sphere_parts import sphere_parts_m

NO_BOUNCES = Bounces()
POINTS, LONGEST_S = 500, 0.002
"""Means of a motion at which its shifts are given, at the least, and how long one may be."""


def with_budget(
    track: Track, bounces: Bounces, changes: Iterable[InputChange], segment: Segment, setup: Setup
) -> tuple[Track, Bounces, UncertaintyBudget]:
    """Return track and bounces with their combined uncertainties, and the budget.

    Parameters
    ----------
    track, bounces
        With their statistical uncertainties.
    changes
        What they change by with each uncertain input.
    segment
        The motion, over which the position's uncertainty is averaged.
    setup
        Says which uncertainties were assumed.
    """
    by_share: dict[str, list[InputChange]] = {}
    for one in changes:
        by_share.setdefault(one.share, []).append(one)
    # inputs are uncertain independently: squares of what they change add (JCGM 100, 5.1.2)
    moved = {share: np.sum([one.moved_m**2 for one in of], axis=0) for share, of in by_share.items()}
    # on straight lines between the instants of the changes, held before and after
    squares = {share: _between(by_share[share][0].time_s, square, track.time_s) for share, square in moved.items()}
    e_squares = {share: np.sum([one.e**2 for one in of], axis=0) for share, of in by_share.items()}
    g_squares = {share: sum(one.g_m_s2**2 for one in of) for share, of in by_share.items()}
    combined = np.sqrt(track.u_position_m**2 + sum(squares.values()))
    u_e = np.array([one.u_e for one in bounces.impacts])
    u_e = np.sqrt(u_e**2 + sum(e_squares.values()))
    impacts = tuple(replace(own, u_e_combined=u) for own, u in zip(bounces.impacts, u_e.tolist(), strict=True))
    part = slice(segment.first, segment.last)

    valid = track.valid[part]

    def motion(square: FloatArray) -> float:
        known = square[:, part] if valid.all() else square[:, part][:, valid]
        if not (finite := np.isfinite(known)).all():
            known = known[finite]
        return float(np.sqrt(known.mean())) if known.size else float("nan")

    fall = bounces.free_fall
    u_first, u_g = bounces.impacts[0].u_e if bounces.impacts else np.nan, np.nan if fall is None else fall.u_g_m_s2
    position = _line(motion(track.u_position_m**2), {share: motion(value) for share, value in squares.items()})
    if position.statistical is not None:
        # what all places share changes no speed and no height
        bent = [one.moved_m - one.moved_m.mean(axis=1, keepdims=True) for of in by_share.values() for one in of]
        square = sum(float(np.mean(one**2)) for one in bent if one.size)
        position = replace(position, shape=float(np.sqrt(position.statistical**2 + square)))
    e = _line(u_first, {share: float(np.sqrt(value[0])) for share, value in e_squares.items() if value.size})
    g = _line(u_g, {share: float(np.sqrt(value)) for share, value in g_squares.items()})
    budget = UncertaintyBudget(position, e, g, assumed_uncertainties(setup))
    return replace(track, u_combined_m=combined), replace(bounces, impacts=impacts), budget


def _between(known_s: FloatArray, known: FloatArray, time_s: FloatArray) -> FloatArray:
    """Return curves (k, n_known) on straight lines between their instants, held before and after, shape (k, n)."""
    if known_s.size == 0:
        return np.zeros((known.shape[0], time_s.size))
    begin, end = np.searchsorted(time_s, known_s[[0, -1]])
    out = np.empty((known.shape[0], time_s.size))
    out[:, :begin], out[:, end:] = known[:, :1], known[:, -1:]
    for row, own in zip(out, known, strict=True):
        row[begin:end] = np.interp(time_s[begin:end], known_s, own)
    return out


def _line(statistical: float, shares: dict[str, float]) -> BudgetLine:
    if not np.isfinite(statistical):
        return BudgetLine()
    calibration, sphere = shares.get("calibration", 0.0), shares.get("sphere", 0.0)
    combined = float(np.sqrt(statistical**2 + calibration**2 + sphere**2))
    known = [value if np.isfinite(value) else None for value in (statistical, calibration, sphere, combined)]
    return BudgetLine(*known)


class TrackShifts(NamedTuple):
    """What places change by with each unknown of setup and sphere.

    Attributes
    ----------
    time_s
        Instants, shape (n,): shifts are smooth, few tell them.
    moved_m
        With each, one standard uncertainty of its prior unit, shape (n_unknowns, 3, n); 0 where the place is unknown.
    setup
        The first of them are its.
    """

    time_s: FloatArray
    moved_m: FloatArray
    setup: PathSetup

    @staticmethod
    def of(track: Track, segment: Segment, setup: Setup, fit: PathFlights | None) -> TrackShifts:
        """Return those of a track, at the instants that its flights were fitted at where any were.

        The same path lengths are located with the unknown moved (GUM, 5.1.3), to first order.
        """
        if fit is not None:
            data = fit.model.data
            return TrackShifts._at(data.time_s, data.position_m, data.added_m, fit.model.setup)
        spacing_s = float(track.time_s[1] - track.time_s[0])
        size = max(1, min((segment.last - segment.first) // POINTS, round(LONGEST_S / spacing_s)))
        part = slice(segment.first, segment.last)
        # with a sample that is not known the mean is not
        place = block_means(np.where(track.valid, track.position_m, np.nan)[:, part], size)
        time_s = block_means(track.time_s[part], size)
        return TrackShifts._at(time_s, place, sphere_parts_m(place, setup), PathSetup.of(setup))

    @staticmethod
    def _at(time_s: FloatArray, place_m: FloatArray, added_m: FloatArray, setup: PathSetup) -> TrackShifts:
        at = np.zeros(setup.unknowns.size)
        longer = np.concatenate([np.moveaxis(setup.by_unknowns(at, place_m), -1, 0), added_m])
        gradient = setup.gradient(at, place_m)
        moved = [-solve_gradient(gradient, one) for one in longer]
        return TrackShifts(time_s, np.nan_to_num(np.array(moved).reshape(-1, *place_m.shape)), setup)

    def along(self, direction: FloatArray) -> FloatArray:
        """Return the shift, (3, n), along a direction whose first values are those of setup and sphere."""
        return np.asarray(np.tensordot(direction[: len(self.moved_m)], self.moved_m, 1))


def moved_track(track: Track, shifts: TrackShifts, fit: PathFlights) -> Track:
    """Return a track located anew with the setup and the sphere that its flights found, to first order."""
    shift = _between(shifts.time_s, shifts.along(fit.at), track.time_s)
    return replace(track, position_m=track.position_m + shift)


def changes_of_places(shifts: TrackShifts, bounces: Bounces = NO_BOUNCES) -> tuple[InputChange, ...]:
    """Return what places change by with each input by its own u, where nothing flies; e and g are not known."""
    inputs, n = shifts.setup.unknowns, len(shifts.moved_m)
    own = np.concatenate([np.where(inputs.deviation < 1.0, 0.0, 1.0), np.ones(n - inputs.size)])
    keys = [*(one.key for one in inputs.inputs), *("sphere",) * (n - inputs.size)]
    calibration: Share = "calibration"
    sphere: Share = "sphere"
    of_share = [*[calibration] * inputs.size, *[sphere] * (n - inputs.size)]
    unknown = np.full(len(bounces.impacts), np.nan)
    return tuple(
        InputChange(key, share, shifts.time_s, by * moved, unknown, np.nan)
        for key, share, by, moved in zip(keys, of_share, own.tolist(), shifts.moved_m, strict=True)
    )


def changes_of_drops(
    shifts: TrackShifts, each: Sequence[Bounces], setup: Setup, fits: Sequence[PathFlights]
) -> tuple[InputChange, ...]:
    """Return what the track, all e and g change by along independent directions that setup and sphere are left open in.

    Those of the posterior of each drop's flights; track and g are of the first.

    Parameters
    ----------
    shifts
        Of the track's places, at the instants of the first drop's flights.
    each, fits
        Of the drops.
    setup
        Says how well floor and clock are known, which move no place.
    """
    changes, sizes = [], [len(one.impacts) for one in each]
    for number, (bounces, fit) in enumerate(zip(each, fits, strict=True)):
        around = sum(sizes[:number]), sum(sizes[number + 1 :])
        for one in _changes_of_drop(shifts, bounces, setup, fit):
            e = np.pad(one.e, around)
            changes.append(
                replace(one, e=e) if number == 0 else replace(one, e=e, moved_m=np.zeros_like(one.moved_m), g_m_s2=0.0)
            )
    return tuple(changes)


def _changes_of_drop(shifts: TrackShifts, bounces: Bounces, setup: Setup, fit: PathFlights) -> list[InputChange]:
    time_s = shifts.time_s
    velocity, by_unknowns = fit.impact_velocities()
    by_e, place, unit = e_slopes(bounces, by_unknowns), fit.model.gravity, float(fit.model.deviation[4])
    shares: tuple[Share, Share] = ("calibration", "sphere")
    directions, of_paths = fit.directions(), fit.directions(prior_of_g=False)
    changes = [
        InputChange(f"{share}[{number}]", share, time_s, shifts.along(one), by_e @ one, unit * float(of_g[place]))
        for share, own, apart in zip(shares, directions, of_paths, strict=True)
        for number, (one, of_g) in enumerate(zip(own, apart, strict=True), 1)
    ]
    changes += tilt_and_clock(time_s, lambda: (velocity[:, :3], velocity[:, 3:]), bounces, setup)
    return changes
