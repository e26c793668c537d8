"""The uncertainty budget of a result, and the combined uncertainties of its track and its impacts (method 6)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from itertools import combinations_with_replacement

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.model.assumed import (
    OF_SPHERE,
    SUPPOSED_POLARIZATIONS_DEG,
    SUPPOSED_TURNS_DEG,
    assumed_uncertainties,
    uncertain_inputs,
)
from radargui.model.gravity import expected_gravity_m_s2
from radargui.model.result import Bounces, PathLengths, Segment, Track
from radargui.model.setup import Setup
from radargui.model.setup_posterior import unknown_inputs
from radargui.model.uncertainty_budget import BudgetLine, InputChange, UncertaintyBudget
from radargui.physics.path_length import (
    MIN_RECEIVERS,
    distance,
    path_gradient,
    place_antennas,
    solve_gradient,
    t_matrix,
)
from radargui.physics.scattering import scattering_delay_m, supposed_delays_m
from radargui.processing.measured_motion import place_at
from radargui.restitution.bounces import FlownTrack
from radargui.restitution.track_response import tilt_and_clock
from radargui.signals.averager import block_means

POINTS, LONGEST_S = 500, 0.002
"""Means of the motion at which its shifts are given, at the least, and how long one may be: a flight of 12 ms, and the
30 ms beside an impact, must hold some."""
FIELD_POINTS, MIN_OF_FIELD = 200, 1e-6
"""Places at which a smooth field of place is computed; share of the strongest below which no direction is visited."""
MIN_M = 1e-12
"""In place of the reach of a coordinate that stays the same, so that nothing is divided by zero."""
SUPPOSED = len(SUPPOSED_POLARIZATIONS_DEG) * len(SUPPOSED_TURNS_DEG)


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
    changes = list(changes)
    for one in (*changes, *changes_by_horns(track, bounces, changes, setup)):
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
    e = _line(u_first, {share: float(np.sqrt(value[0])) for share, value in e_squares.items() if value.size})
    g = _line(u_g, {share: float(np.sqrt(value)) for share, value in g_squares.items()})
    budget = UncertaintyBudget(position, e, g, assumed_uncertainties(setup))
    return replace(track, u_combined_m=combined), replace(bounces, impacts=impacts), budget


U_HORN_M = 8e-5
"""Root mean square of path that no single phase centre can follow of a horn near by: 0.06 to 0.1 mm."""
BEND_OF_FALL = 1.92
"""Share of g by which a fall from rest seems faster, times what its heights are off over its height: where they are off
by the second Legendre polynomial of the height, which is what a shift and a scale leave, and 1 and t^2 are fitted."""


def changes_by_horns(
    track: Track, bounces: Bounces, changes: Sequence[InputChange], setup: Setup
) -> tuple[InputChange, ...]:
    """Return what the place changes by with what a single phase centre leaves of each horn.

    An antenna counts as one where the setup says that its phase centre lies elsewhere than the point that its distance
    is measured to. What is left depends on the place: both speeds at an impact change alike, and e does not. A fall
    bends by it (`BEND_OF_FALL`).

    Parameters
    ----------
    track, bounces
        Of the run.
    changes
        With the inputs: these stand at the same instants.
    """
    antennas = place_antennas(setup)
    horns = [bool(setup.transmitter.phase_centre_m), *(bool(one.phase_centre_m) for one in setup.receiver)]
    if not any(horns) or setup.n_receivers < MIN_RECEIVERS or not track.valid.any():
        return ()
    time_s = changes[0].time_s if changes else track.time_s[:: max(1, track.time_s.size // POINTS)]
    known = track.valid & np.isfinite(track.position_m).all(axis=0)
    place = np.array([np.interp(time_s, track.time_s[known], row[known]) for row in track.position_m])
    gradient, none = path_gradient(place, antennas), np.zeros(len(bounces.impacts))
    units = np.vstack([np.ones(antennas.n_receivers), np.eye(antennas.n_receivers)])
    g_m_s2, fallen_m = expected_gravity_m_s2(setup.site), max(float(np.ptp(place[2])), MIN_M)
    found = []
    for number in np.flatnonzero(horns):
        moved_m = U_HORN_M * solve_gradient(gradient, units[number][:, None])
        bent = BEND_OF_FALL * g_m_s2 * float(np.sqrt((moved_m[2] ** 2).mean())) / fallen_m
        found.append(InputChange(f"horn[{number}]", "calibration", time_s, moved_m, none, bent))
    return tuple(found)


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


def changes_of_track(paths: PathLengths, flown: FlownTrack, setup: Setup, segment: Segment) -> tuple[InputChange, ...]:
    """Return what a located track changes by along each direction in which the setup is left open, to first order.

    The same path lengths are located with the inputs moved (GUM, 5.1.3); directions are those of the posterior that the
    flights leave, or without flights the inputs themselves. That paths change with the geometry too, through maps of
    position, is of second order. A sphere that is no point adds the phase it scatters with: by its diameter and the
    polarisations where they are stated, else that of a few polarisations; what flights make of it the setup follows.

    Parameters
    ----------
    paths, flown, segment
        Of the run.
    setup
        With the values that the track was located with.
    """
    spacing_s = float(paths.time_s[1] - paths.time_s[0])
    size = max(1, min((segment.last - segment.first) // POINTS, round(LONGEST_S / spacing_s)))
    # before and after the motion all shifts stand
    part = slice(segment.first, segment.last)
    if setup.n_receivers < MIN_RECEIVERS:
        return ()
    # with a sample that is not known the mean is not
    change_m = block_means(np.where(paths.valid, paths.change_m, np.nan)[:, part], size)
    position, time_s = place_at(change_m, setup), block_means(paths.time_s[part], size)
    known = np.asarray(np.isfinite(position).all(axis=0))
    base = Track(time_s, position, np.full_like(position, np.nan), known, setup.processing.geometry)
    shifts = _Shifts(base.position_m, change_m, setup)
    posterior = flown.posterior
    # a setup that was moved may state its antennas by other keys
    inputs, deviation = unknown_inputs(setup) if posterior is None else (posterior.inputs, posterior.deviation)
    by_unit = np.zeros((0, *base.position_m.shape))
    if inputs:
        by_unit = np.stack([shifts.by_setup(one.moved(setup)) for one in inputs])
    found: list[InputChange] = []

    def of_paths(key: str, longer_m: FloatArray, share: float = 1.0) -> None:
        follows, e, g = flown.by_paths(base.time_s[known], longer_m[:, known])
        moved = shifts.by_paths(longer_m) + (np.tensordot(follows, by_unit, 1) if follows.size else 0.0)
        found.append(InputChange(key, "sphere", base.time_s, share * moved, share * e, share * g))

    is_polarised = setup.transmitter.polarization_deg is not None
    for one in uncertain_inputs(setup):
        if one.u and is_polarised and (one.key in OF_SPHERE or one.key.endswith("polarization_deg")):
            other = one.moved(setup)
            of_paths(one.key, scattering_delay_m(base.position_m, setup) - scattering_delay_m(base.position_m, other))
    if not is_polarised:
        delays_m = smooth_in_place(base.position_m, lambda place_m: supposed_delays_m(place_m, setup))
        # none of them is likelier: their mean square counts
        for delay_m in delays_m:
            of_paths("sphere", -delay_m, 1.0 / np.sqrt(SUPPOSED))
    along, e, g = flown.directions()
    if not len(along):
        # without flights nothing is known but what is stated; what is called exact moves nothing
        along = np.diag(np.where(deviation < 1.0, 0.0, 1.0))
        e, g = np.full((len(along), len(flown.bounces.impacts)), np.nan), np.full(len(along), np.nan)
    for number, (direction, of_e, of_g) in enumerate(zip(along, e, g.tolist(), strict=True), 1):
        if direction.any():
            moved = np.tensordot(direction, by_unit, 1)
            found.append(InputChange(f"setup[{number}]", "calibration", base.time_s, moved, of_e, of_g))
    if not known.all():
        found = [replace(one, moved_m=np.nan_to_num(one.moved_m)) for one in found]

    def sides() -> tuple[FloatArray, FloatArray]:
        at = flown.bounces.velocities
        unknown = np.full((len(flown.bounces.impacts), 3), np.nan)
        return (unknown, unknown) if at is None else (at.before_m_s, at.after_m_s)

    return (*found, *tilt_and_clock(base.time_s, sides, flown.bounces, setup))


class _Shifts:
    """How places move with paths and with the setup, to first order: one Newton step, of a shift far below them.

    Parameters
    ----------
    position_m, change_m
        Places and their changes of path, shapes (3, n) and (n_receivers, n).
    setup
        That the places were found with.
    """

    def __init__(self, position_m: FloatArray, change_m: FloatArray, setup: Setup) -> None:
        self._position_m, self._change_m, self._setup = position_m, change_m, setup
        antennas = place_antennas(setup)
        self._away_m: dict[tuple[float, ...], FloatArray] = {}
        self._since_release_m = self._ways(setup)
        # moves of a place by each path, shape (n_receivers, 3, n), shared by all inputs: each is a change of some paths
        if setup.processing.geometry == "plane":
            # p = p_release - T^-1 dL (Rech & Huang 2019, eq. 3)
            self._by_path = -np.linalg.pinv(t_matrix(antennas)).T[:, :, None]
        else:
            gradient, units = path_gradient(position_m, antennas), np.eye(antennas.n_receivers)
            self._by_path = np.stack([solve_gradient(gradient, unit[:, None]) for unit in units])

    def _ways(self, setup: Setup) -> FloatArray:
        """Return how much longer the paths of a setup are than at its release, shape (n_receivers, n)."""
        antennas, release = place_antennas(setup), np.array(setup.tracer.release_position_m)
        there, *back = (self._way(place_m, release) for place_m in (antennas.transmitter_m, *antennas.receivers_m))
        return np.stack([there + one for one in back])

    def _way(self, antenna_m: FloatArray, release_m: FloatArray) -> FloatArray:
        """Return how much farther the places are from an antenna than the release is, shape (n,)."""
        # most inputs move one antenna or none
        key = tuple(antenna_m.tolist())
        if key not in self._away_m:
            self._away_m[key] = distance(self._position_m - antenna_m[:, None])
        return self._away_m[key] - float(np.linalg.norm(release_m - antenna_m))

    def by_paths(self, longer_m: FloatArray) -> FloatArray:
        """Return the moves by paths that are longer, shape (n_receivers, n) or (n_receivers, 1)."""
        out = np.zeros(self._position_m.shape)
        for column, longer in zip(self._by_path, longer_m, strict=True):
            if longer.any():
                out += column * longer
        return out

    def by_setup(self, other: Setup) -> FloatArray:
        """Return the moves where the same phases are located with another setup."""
        ratio = other.radar.wavelength_m / self._setup.radar.wavelength_m
        if self._setup.processing.geometry == "plane":
            return place_at(ratio * self._change_m, other) - self._position_m
        # what was measured less what the other setup gives there
        longer = self._since_release_m - self._ways(other)
        if ratio != 1.0:
            # the phase was measured: its path counts in wavelengths
            longer = longer + (ratio - 1.0) * self._change_m
        return self.by_paths(longer)


def smooth_in_place(position_m: FloatArray, field: Callable[[FloatArray], FloatArray]) -> FloatArray:
    """Return a smooth field of place (..., n) at places (3, n), computed at few of them.

    Between these a polynomial of third degree: the phase of a sphere's echo changes by fractions of a millimetre over
    the whole motion. NaN where the place is.
    """
    known = np.flatnonzero(np.isfinite(position_m).all(axis=0))
    if known.size <= FIELD_POINTS:
        return field(position_m)
    few = position_m[:, known[:: known.size // FIELD_POINTS]]
    centre = few.mean(axis=1, keepdims=True)
    unit = np.maximum(np.ptp(few, axis=1, keepdims=True), MIN_M)
    there = field(few)
    columns, *_ = np.linalg.lstsq(
        _cubic((few - centre) / unit).T, there.reshape(-1, few.shape[1]).T, rcond=MIN_OF_FIELD
    )
    out = columns.T @ _cubic((position_m - centre) / unit)
    return np.asarray(out.reshape(*there.shape[:-1], -1))


def _cubic(place: FloatArray) -> FloatArray:
    """Return the twenty products of up to three coordinates of places (3, n), shape (20, n)."""
    x = np.concatenate([np.ones((1, place.shape[1])), place])
    return np.stack([x[a] * x[b] * x[c] for a, b, c in combinations_with_replacement(range(4), 3)])
