"""Rounds of circle fits: places from phases, maps on places, better phases."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from radargui.correction.adaptive.circle_fit import CircleData, CircleFit, fit_circle
from radargui.correction.adaptive.place import map_places, range_law
from radargui.correction.adaptive.unskew import unskew
from radargui.correction.bins import Bins
from radargui.correction.position_map import PositionBasis, make_basis
from radargui.correction.start import StillEllipse, circle_point
from radargui.geometry.antennas import Antennas
from radargui.model.arrays import BoolArray, FloatArray

LENGTHS_M = (0.06, 0.09, 0.13, 0.20)
_LEVEL_LONGER = 1.5
_TIME_FUNCTIONS = 16


@dataclass(frozen=True, slots=True)
class Ground:
    """What stays the same over the rounds: bins, geometry, the rest and where it is seen to end."""

    bins: Bins
    antennas: Antennas
    release_m: FloatArray
    wavelength_m: float
    rest: BoolArray
    delay_s: FloatArray
    onset_s: float


@dataclass(frozen=True, slots=True)
class Round:
    """One round's outcome.

    Attributes
    ----------
    phase_rad
        Unwrapped, zero at rest, shape (n_receivers, n_bins).
    turn_rad
        Phase at rest, shape (n_receivers,).
    value
        Means brought to the time of channel 0, shape (n_channels, n_bins).
    amplitude
        Shape (n_receivers, n_bins).
    place
        Coordinate of the maps, shape (3 or n_receivers, n_bins).
    fits
        One a receiver.
    bias, level
        The bases the fits used; None without maps.
    log_evidence
        Sum over the receivers.
    home
        Constants of the first round, prior means of the further ones, shape (n_receivers, 5).
    holds_count
        Whether further rounds keep this one's count of the fringes, however near the signal comes to the centre.
    """

    phase_rad: FloatArray
    turn_rad: FloatArray
    value: FloatArray
    amplitude: FloatArray
    place: FloatArray
    fits: tuple[CircleFit, ...]
    bias: PositionBasis | None
    level: PositionBasis | None
    log_evidence: float
    home: FloatArray
    holds_count: bool = False


def still_round(ground: Ground, ellipses: tuple[StillEllipse, ...], counted_rad: FloatArray) -> Round:
    """Take still ellipses as they are, with the fringes counted before.

    Parameters
    ----------
    ground
        Data.
    ellipses
        One a receiver.
    counted_rad
        Their unwrapped phases at the bins, from samples closer in time than the bins, shape (n_receivers, n_bins).
    """
    amplitude = np.array([np.full(ground.bins.n_bins, ellipse.amplitude) for ellipse in ellipses])
    value = ground.bins.value
    for _ in range(2 if ground.delay_s.any() else 1):
        points = [circle_point(i, q, e) for i, q, e in zip(value[0::2], value[1::2], ellipses, strict=True)]
        phase, turn = _phases(points, ground.rest, counted_rad)
        value = unskew(ground.bins, ground.delay_s, phase + turn[:, None], amplitude, ellipses)
    fits = tuple(CircleFit.still(ellipse) for ellipse in ellipses)
    home = _home([fit.theta for fit in fits])
    return Round(
        phase, turn, value, amplitude, _places(ground, phase), fits, None, None, -np.inf, home, holds_count=True
    )


def first_round(ground: Ground, still: Round) -> Round:
    """Fit circles whose amplitude follows the range law alone, starting from still ellipses."""
    data = circle_data(ground, still.value, still.phase_rad, still.place, None, None)
    return _fit(ground, data, still, None, None, [fit.theta for fit in still.fits])


def timed_round(ground: Ground, still: Round) -> Round:
    """Fit circles whose amplitude is a smooth function of time: where it varies much, this is what finds the centre."""
    functions = _time_functions(ground)
    data = circle_data(ground, still.value, still.phase_rad, still.place, None, None)
    start = [np.concatenate([fit.theta, np.zeros(functions.shape[1])]) for fit in still.fits]
    return _fit(ground, [replace(own, level=functions) for own in data], still, None, None, start)


def _time_functions(ground: Ground) -> FloatArray:
    """Return bumps over the time of the motion, constant at rest, shape (n_bins, n)."""
    time = ground.bins.time_s
    moving = time[~ground.rest]
    centre, width = np.linspace(moving[0], moving[-1], _TIME_FUNCTIONS, retstep=True)
    return np.asarray(np.exp(-0.5 * ((np.maximum(time, moving[0])[:, None] - centre) / width) ** 2))


def next_round(ground: Ground, before: Round, length_m: float) -> Round:
    """Fit circles with maps of correlation length l over the places of the round before."""
    visited = before.place[:, ~ground.rest]
    bias, level = make_basis(visited, length_m), make_basis(visited, _LEVEL_LONGER * length_m)
    start = [_carry(before, fit, bias, level) for fit in before.fits]
    ellipses = [fit.ellipse for fit in before.fits]
    turned = before.phase_rad + before.turn_rad[:, None]
    value = unskew(ground.bins, ground.delay_s, turned, before.amplitude, ellipses)
    data = circle_data(ground, value, before.phase_rad, before.place, bias, level)
    return _fit(ground, data, replace(before, value=value), bias, level, start)


def best_round(ground: Ground, before: Round) -> Round:
    """Fit with several lengths and keep the one with the largest evidence, common to the receivers."""
    extent = float(np.linalg.norm(np.ptp(before.place, axis=1)))
    fringes = float(np.ptp(before.phase_rad, axis=1).max()) / (2.0 * np.pi)
    shortest = 1.5 * extent / max(fringes, 1.0)
    lengths = [length for length in LENGTHS_M if length >= shortest] or [max(LENGTHS_M[-1], shortest)]
    return max((next_round(ground, before, length) for length in lengths), key=lambda r: r.log_evidence)


def _carry(before: Round, fit: CircleFit, bias: PositionBasis, level: PositionBasis) -> FloatArray:
    """Start from an earlier round's fit: its maps projected on the new functions."""
    place = before.place
    if before.bias is None or before.level is None:
        return np.concatenate([fit.theta[:5], np.zeros(2 * bias.size + level.size)])
    n = before.bias.size
    old_bias, old_level = before.bias(place), before.level(place)
    return np.concatenate(
        [
            fit.theta[:5],
            _project(bias(place), old_bias @ fit.theta[5 : 5 + n]),
            _project(bias(place), old_bias @ fit.theta[5 + n : 5 + 2 * n]),
            _project(level(place), old_level @ fit.theta[5 + 2 * n :]),
        ]
    )


def _project(functions: FloatArray, values: FloatArray) -> FloatArray:
    normal = functions.T @ functions + 1e-3 * np.eye(functions.shape[1])
    return np.asarray(np.linalg.solve(normal, functions.T @ values))


def circle_data(
    ground: Ground,
    value: FloatArray,
    phase: FloatArray,
    place: FloatArray,
    bias: PositionBasis | None,
    level: PositionBasis | None,
) -> list[CircleData]:
    """Return each receiver's bins with map functions and the known factor of the amplitude."""
    bins, none = ground.bins, np.zeros((ground.bins.n_bins, 0))
    rate = np.gradient(phase, bins.time_s, axis=1)
    shape = range_law(place, ground.antennas, ground.release_m) * np.cos(np.clip(rate * bins.node_s, -0.3, 0.3))
    at_bias = none if bias is None else bias(place)
    at_level = none if level is None else level(place)
    return [
        CircleData(
            value[2 * n], value[2 * n + 1], bins.sigma[2 * n], bins.sigma[2 * n + 1], shape[n], at_bias, at_level
        )
        for n in range(ground.antennas.n_receivers)
    ]


def _fit(
    ground: Ground,
    data: list[CircleData],
    before: Round,
    bias: PositionBasis | None,
    level: PositionBasis | None,
    start: list[FloatArray],
) -> Round:
    home, holds_count = before.home, before.holds_count
    fits = tuple(fit_circle(own, theta, one) for own, theta, one in zip(data, start, home, strict=True))
    better, turn = _phases(
        [fit.point(own.i, own.q, own.bias) for fit, own in zip(fits, data, strict=True)],
        ground.rest,
        before.phase_rad if holds_count else None,
    )
    amplitude = np.array([fit.amplitude(own.shape, own.level) for fit, own in zip(fits, data, strict=True)])
    evidence = sum(fit.log_evidence for fit in fits)
    if bias is None:
        home = np.array([fit.theta[:5] for fit in fits])
    place = _places(ground, better)
    return Round(better, turn, before.value, amplitude, place, fits, bias, level, evidence, home, holds_count)


def _home(start: list[FloatArray]) -> FloatArray:
    """Return prior means for the first round: the still ellipses' offsets and amplitude, no gain or skew."""
    home = np.array(start)
    home[:, 2:4] = 0.0
    return home


def _places(ground: Ground, phase: FloatArray) -> FloatArray:
    change = phase * ground.wavelength_m / (2.0 * np.pi)
    return map_places(change, ground.antennas, ground.release_m, ground.rest)


def _phases(
    points: list[FloatArray], rest: BoolArray, counted_rad: FloatArray | None = None
) -> tuple[FloatArray, FloatArray]:
    """Return the unwrapped phases against their mean direction at rest, and that direction.

    Unwrapped in time, or to within half a turn of phases that count the fringes already.
    """
    phases, turns = [], []
    for number, point in enumerate(points):
        z = point[0] + 1j * point[1]
        reference = z[rest].mean() if rest.any() else z[0]
        angle = np.angle(z * reference.conj())
        if counted_rad is None:
            phase = np.unwrap(angle)
        else:
            near = counted_rad[number] - (counted_rad[number, rest].mean() if rest.any() else counted_rad[number, 0])
            phase = near + np.angle(np.exp(1j * (angle - near)))
        phases.append(phase - 2.0 * np.pi * np.round((phase[rest].mean() if rest.any() else phase[0]) / (2.0 * np.pi)))
        turns.append(float(np.angle(reference)))
    return np.array(phases), np.array(turns)
