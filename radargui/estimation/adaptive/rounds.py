"""Rounds of circle fits: places from phases, maps on places, better phases (method 2, adaptive)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from radargui.estimation.adaptive.circle_data import at_one_time, circle_data, map_places
from radargui.estimation.adaptive.circle_fit import CircleData, CircleFit, CircleLayout, fit_circle
from radargui.estimation.adaptive.still_ellipse import StillEllipse
from radargui.estimation.forward.bins import BinnedData
from radargui.estimation.forward.parameters import ReceiverConstants
from radargui.estimation.forward.position_map import PositionBasis, make_basis
from radargui.model.arrays import BoolArray, FloatArray


@dataclass(frozen=True, slots=True)
class MapRoundSettings:
    """Which maps are tried. Chosen by hand; the accuracy benchmark is their test.

    Attributes
    ----------
    lengths_m
        Correlation lengths of the bias maps among which the evidence chooses.
    shortest_extents_a_fringe
        No length is shorter than so many extents of the motion a fringe: else a map can follow the wave itself.
    amplitude_longer
        The map of log amplitude is smoother than that of the bias by this factor: lobes are wide.
    time_functions
        Bumps of the amplitude over time, where it is a function of time.
    least_normal
        Added to the normal matrix where an earlier map is projected on new functions, which may hardly differ.
    """

    lengths_m: tuple[float, ...] = (0.06, 0.09, 0.13, 0.20)
    shortest_extents_a_fringe: float = 1.5
    amplitude_longer: float = 1.5
    time_functions: int = 16
    least_normal: float = 1e-3


MAP_ROUNDS = MapRoundSettings()


@dataclass(frozen=True, slots=True)
class Round:
    """One round's outcome.

    Attributes
    ----------
    phase_rad
        Unwrapped, zero at rest, shape (n_receivers, n_bins).
    rest_phase_rad
        Phase at rest, shape (n_receivers,).
    value
        Means brought to the time of channel 0, shape (n_channels, n_bins).
    amplitude
        Shape (n_receivers, n_bins).
    place
        Coordinate of the maps, shape (3 or n_receivers, n_bins).
    fits
        One a receiver.
    bias, amplitude_map
        The bases the fits used; None without maps.
    log_evidence
        Sum over the receivers.
    prior_mean
        Constants of the first round, prior means of the further ones, shape (n_receivers, 5) as in `CircleLayout`.
    holds_count
        Whether further rounds keep this one's count of the fringes, however near the signal comes to the centre.
    """

    phase_rad: FloatArray
    rest_phase_rad: FloatArray
    value: FloatArray
    amplitude: FloatArray
    place: FloatArray
    fits: tuple[CircleFit, ...]
    bias: PositionBasis | None
    amplitude_map: PositionBasis | None
    log_evidence: float
    prior_mean: FloatArray
    holds_count: bool = False

    def mean_centre(self, receiver: int) -> FloatArray:
        """Return the offsets of I and Q with the mean of the bias over the bins, shape (2,)."""
        functions = np.zeros((1, 0)) if self.bias is None else self.bias(self.place).mean(axis=0)[None]
        return self.fits[receiver].centre(functions)[:, 0]

    def receiver_constants(self) -> tuple[ReceiverConstants, ...]:
        """Return the constants of each receiver where the joint estimate starts."""
        out = []
        for receiver, fit in enumerate(self.fits):
            centre_i, centre_q = self.mean_centre(receiver)
            out.append(
                ReceiverConstants(
                    phase_rad=float(self.rest_phase_rad[receiver]),
                    log_amplitude=float(np.log(self.amplitude[receiver, 0])),
                    offset_i=float(centre_i),
                    offset_q=float(centre_q),
                    log_gain=fit.ellipse.log_gain,
                    quadrature_error_rad=fit.ellipse.quadrature_error_rad,
                )
            )
        return tuple(out)


def still_round(binned: BinnedData, ellipses: tuple[StillEllipse, ...], counted_rad: FloatArray) -> Round:
    """Take still ellipses as they are, with the fringes counted before.

    Parameters
    ----------
    binned
        Data.
    ellipses
        One a receiver.
    counted_rad
        Their unwrapped phases at the bins, from samples closer in time than the bins, shape (n_receivers, n_bins).
    """
    amplitude = np.array([np.full(binned.bins.n_bins, ellipse.amplitude) for ellipse in ellipses])
    value = binned.bins.value
    for _ in range(2 if binned.delay_s.any() else 1):
        points = [ellipse.point(i, q) for i, q, ellipse in zip(value[0::2], value[1::2], ellipses, strict=True)]
        phase, at_rest = _phases(points, binned.rest, counted_rad)
        value = at_one_time(binned, phase + at_rest[:, None], amplitude, ellipses)
    fits = tuple(CircleFit.still(ellipse) for ellipse in ellipses)
    # still ellipses tell offsets and amplitude; gain ratio and quadrature error of a short arc they do not
    prior_mean = np.array([fit.theta for fit in fits])
    prior_mean[:, CircleLayout.front_end] = 0.0
    return Round(
        phase_rad=phase,
        rest_phase_rad=at_rest,
        value=value,
        amplitude=amplitude,
        place=_places(binned, phase),
        fits=fits,
        bias=None,
        amplitude_map=None,
        log_evidence=-np.inf,
        prior_mean=prior_mean,
        holds_count=True,
    )


def first_round(binned: BinnedData, still: Round) -> Round:
    """Fit circles whose amplitude follows the range factor alone, starting from still ellipses."""
    data = circle_data(binned, still.value, still.phase_rad, still.place, None, None)
    return _fit(binned, data, still, None, None, [fit.theta for fit in still.fits])


def timed_round(binned: BinnedData, still: Round, settings: MapRoundSettings = MAP_ROUNDS) -> Round:
    """Fit circles whose amplitude is a smooth function of time: where it varies much, this is what finds the centre."""
    functions = _time_functions(binned, settings.time_functions)
    data = circle_data(binned, still.value, still.phase_rad, still.place, None, None)
    start = [np.concatenate([fit.theta, np.zeros(functions.shape[1])]) for fit in still.fits]
    return _fit(binned, [replace(own, amplitude_map=functions) for own in data], still, None, None, start)


def _time_functions(binned: BinnedData, count: int) -> FloatArray:
    """Return bumps over the time of the motion, constant at rest, shape (n_bins, count)."""
    time = binned.bins.time_s
    moving = time[~binned.rest]
    centre, width = np.linspace(moving[0], moving[-1], count, retstep=True)
    return np.asarray(np.exp(-0.5 * ((np.maximum(time, moving[0])[:, None] - centre) / width) ** 2))


def next_round(binned: BinnedData, before: Round, length_m: float, settings: MapRoundSettings = MAP_ROUNDS) -> Round:
    """Fit circles with maps of correlation length l over the places of the round before."""
    # the rest would put all functions where the sphere hangs
    visited = before.place[:, ~binned.rest]
    bias, amplitude_map = make_basis(visited, length_m), make_basis(visited, settings.amplitude_longer * length_m)
    start = [_carried(before, fit, bias, amplitude_map, settings.least_normal) for fit in before.fits]
    ellipses = [fit.ellipse for fit in before.fits]
    phase = before.phase_rad + before.rest_phase_rad[:, None]
    value = at_one_time(binned, phase, before.amplitude, ellipses)
    data = circle_data(binned, value, before.phase_rad, before.place, bias, amplitude_map)
    return _fit(binned, data, replace(before, value=value), bias, amplitude_map, start)


def best_round(binned: BinnedData, before: Round, settings: MapRoundSettings = MAP_ROUNDS) -> Round:
    """Fit with several lengths and keep the one with the largest evidence, common to the receivers."""
    extent = float(np.linalg.norm(np.ptp(before.place, axis=1)))
    fringes = float(np.ptp(before.phase_rad, axis=1).max()) / (2.0 * np.pi)
    shortest = settings.shortest_extents_a_fringe * extent / max(fringes, 1.0)
    # shorter ones could follow the wave itself, and leave nothing to the motion
    lengths = [length for length in settings.lengths_m if length >= shortest]
    tried = lengths or [max(settings.lengths_m[-1], shortest)]
    return max((next_round(binned, before, length) for length in tried), key=lambda one: one.log_evidence)


def _carried(
    before: Round, fit: CircleFit, bias: PositionBasis, amplitude_map: PositionBasis, least_normal: float
) -> FloatArray:
    """Return where an earlier round's fit starts with new functions: its maps projected on them."""
    layout = CircleLayout(bias.size, amplitude_map.size)
    out = np.zeros(layout.size)
    out[layout.constants] = fit.theta[layout.constants]
    if before.bias is None or before.amplitude_map is None:
        return out
    place, old = before.place, fit.layout
    new_bias, old_bias = bias(place), before.bias(place)
    old_amplitude = before.amplitude_map(place) @ fit.theta[old.amplitude_map]
    out[layout.bias_i] = _projected(new_bias, old_bias @ fit.theta[old.bias_i], least_normal)
    out[layout.bias_q] = _projected(new_bias, old_bias @ fit.theta[old.bias_q], least_normal)
    out[layout.amplitude_map] = _projected(amplitude_map(place), old_amplitude, least_normal)
    return out


def _projected(functions: FloatArray, values: FloatArray, least_normal: float) -> FloatArray:
    normal = functions.T @ functions + least_normal * np.eye(functions.shape[1])
    return np.asarray(np.linalg.solve(normal, functions.T @ values))


def _fit(
    binned: BinnedData,
    data: list[CircleData],
    before: Round,
    bias: PositionBasis | None,
    amplitude_map: PositionBasis | None,
    start: list[FloatArray],
) -> Round:
    prior_mean = before.prior_mean
    fits = tuple(fit_circle(own, theta, mean) for own, theta, mean in zip(data, start, prior_mean, strict=True))
    phase, at_rest = _phases(
        [fit.point(own.i, own.q, own.bias) for fit, own in zip(fits, data, strict=True)],
        binned.rest,
        before.phase_rad if before.holds_count else None,
    )
    if bias is None:
        prior_mean = np.array([fit.theta[CircleLayout.constants] for fit in fits])
    return Round(
        phase_rad=phase,
        rest_phase_rad=at_rest,
        value=before.value,
        amplitude=np.array([fit.amplitude(own) for fit, own in zip(fits, data, strict=True)]),
        place=_places(binned, phase),
        fits=fits,
        bias=bias,
        amplitude_map=amplitude_map,
        log_evidence=sum(fit.log_evidence for fit in fits),
        prior_mean=prior_mean,
        holds_count=before.holds_count,
    )


def _places(binned: BinnedData, phase_rad: FloatArray) -> FloatArray:
    change = phase_rad * binned.wavelength_m / (2.0 * np.pi)
    return map_places(change, binned.antennas, binned.release_m, binned.rest)


def _phases(
    points: list[FloatArray], rest: BoolArray, counted_rad: FloatArray | None = None
) -> tuple[FloatArray, FloatArray]:
    """Return the unwrapped phases against their mean direction at rest, and that direction.

    Unwrapped in time, or to within half a turn of phases that count the fringes already.
    """
    phases, at_rest = [], []
    for number, point in enumerate(points):
        z = point[0] + 1j * point[1]
        # the mean direction at rest is zero of L: one sample would carry its noise into all
        reference = z[rest].mean() if rest.any() else z[0]
        angle = np.angle(z * reference.conj())
        if counted_rad is None:
            phase = np.unwrap(angle)
        else:
            near = counted_rad[number] - (counted_rad[number, rest].mean() if rest.any() else counted_rad[number, 0])
            phase = near + np.angle(np.exp(1j * (angle - near)))
        phases.append(phase - 2.0 * np.pi * np.round((phase[rest].mean() if rest.any() else phase[0]) / (2.0 * np.pi)))
        at_rest.append(float(np.angle(reference)))
    return np.array(phases), np.array(at_rest)
