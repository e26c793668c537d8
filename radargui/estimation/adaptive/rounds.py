"""Repeat rounds of circle fits: places from phases, maps at these places, better phases."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from radargui.correction.phase import unwrapped
from radargui.estimation.adaptive.circle_data import at_one_time, circle_data, map_places
from radargui.estimation.adaptive.circle_fit import CircleData, CircleFit, fit_circle
from radargui.estimation.adaptive.circle_layout import CircleLayout
from radargui.estimation.forward.bins import BinnedData, Bins
from radargui.estimation.forward.parameters import ReceiverConstants
from radargui.estimation.forward.position_map import PositionBasis, make_basis
from radargui.model.arrays import BoolArray, FloatArray
from radargui.signals.ellipse import Ellipse
from radargui.signals.rows import pairs_of


@dataclass(frozen=True, slots=True)
class MapRoundSettings:
    """Which maps are tried. Chosen by hand; the accuracy benchmark is their test.

    Attributes
    ----------
    lengths_m
        Correlation lengths of the bias maps among which the evidence chooses.
    shortest_extents_a_fringe
        Least length, in extents of the motion for each fringe: with a shorter one a map could follow the wave itself.
    amplitude_longer
        The map of log amplitude has a correlation length longer by this factor than the bias maps, because lobes are
        wide.
    time_functions
        Number of functions of time for the amplitude, where it is a function of time.
    min_normal
        Added to the normal matrix where an earlier map is projected on new functions, which may hardly differ.
    quick_length_m
        The only length of a round that merely finds the impacts.
    """

    lengths_m: tuple[float, ...] = (0.06, 0.09, 0.13, 0.20)
    shortest_extents_a_fringe: float = 1.5
    amplitude_longer: float = 1.5
    time_functions: int = 16
    min_normal: float = 1e-3
    quick_length_m: float = 0.13


MAP_ROUNDS = MapRoundSettings()


@dataclass(frozen=True, slots=True)
class Round:
    """The result of one round.

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
        The bases of the maps; None without maps.
    log_evidence
        Sum over the receivers.
    prior_mean
        Constants of the first round, which are prior means in further ones, shape (n_receivers, 5) as in
        `CircleLayout`.
    holds_count
        Whether further rounds keep this count of the fringes, however near the signal comes to the centre.
    made_from
        The preceding round, of one with maps.
    fitted_m
        Places at which the maps hold, shape as `place`, if another count of the fringes has moved the places; else
        None.
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
    made_from: Round | None = None
    fitted_m: FloatArray | None = None

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
                    log_gain=float(fit.theta[CircleLayout.log_gain]),
                    quadrature_error_rad=fit.ellipse.quadrature_error_rad,
                )
            )
        return tuple(out)


def still_round(binned: BinnedData, ellipses: tuple[Ellipse, ...], counted_rad: FloatArray) -> Round:
    """Return constant ellipses as a round, with the fringes as counted before.

    Parameters
    ----------
    binned
        Data.
    ellipses
        One a receiver.
    counted_rad
        Their unwrapped phases at the bins, from samples closer in time than the bins, shape (n_receivers, n_bins).
    """
    amplitude = np.array([np.full(binned.bins.n_bins, ellipse.amplitude_v) for ellipse in ellipses])
    value = binned.bins.value
    # phases tell what a channel would have shown at the time of channel 0, and that tells better phases
    for _ in range(2 if binned.delay_s.any() else 1):
        points = [own.apply(value[pair]) for pair, own in zip(pairs_of(value), ellipses, strict=True)]
        phase, at_rest = _phases(points, binned.bins, binned.rest, counted_rad)
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
    return _fit(binned, data, still, [fit.theta for fit in still.fits])


def timed_round(binned: BinnedData, still: Round) -> Round:
    """Fit circles whose amplitude is a smooth function of time, for amplitudes that vary much."""
    functions = _time_functions(binned)
    data = circle_data(binned, still.value, still.phase_rad, still.place, None, None)
    start = [np.concatenate([fit.theta, np.zeros(functions.shape[1])]) for fit in still.fits]
    # bumps over time in the place of a map: places are not known yet
    return _fit(binned, [replace(own, amplitude_map=functions) for own in data], still, start)


def _time_functions(binned: BinnedData) -> FloatArray:
    """Return bumps over the time of the motion, constant at rest, shape (n_bins, count)."""
    time = binned.bins.time_s
    moving = time[~binned.rest]
    centre, width = np.linspace(moving[0], moving[-1], MAP_ROUNDS.time_functions, retstep=True)
    return np.asarray(np.exp(-0.5 * ((np.maximum(time, moving[0])[:, None] - centre) / width) ** 2))


def next_round(binned: BinnedData, before: Round, length_m: float) -> Round:
    """Fit circles with maps of correlation length l over the places of the round before."""
    before = _at_one_time(binned, before)
    return _round_of_maps(binned, before, _maps(binned, before, length_m))


def moved_round(binned: BinnedData, one: Round, was_s: FloatArray) -> Round:
    """Return a round of bins at other times, interpolated to these bins, for another round to start from.

    Parameters
    ----------
    binned
        The bins wanted.
    one, was_s
        The round, and the times of its bins, shape (n_bins,).
    """
    phase, amplitude, place = (
        np.array([np.interp(binned.bins.time_s, was_s, row) for row in rows])
        for rows in (one.phase_rad, one.amplitude, one.place)
    )
    return replace(one, phase_rad=phase, amplitude=amplitude, place=place, value=binned.bins.value, made_from=None)


def quick_round(binned: BinnedData, before: Round) -> Round:
    """Fit with one length, good enough to see where the impacts are."""
    return next_round(binned, before, max(MAP_ROUNDS.quick_length_m, _shortest_m(before)))


def best_round(binned: BinnedData, before: Round) -> Round:
    """Fit with several lengths and keep the one with the largest evidence, common to the receivers."""
    # shorter ones could follow the wave itself, and leave nothing to the motion
    shortest = _shortest_m(before)
    lengths = MAP_ROUNDS.lengths_m
    tried = [length for length in lengths if length >= shortest] or [max(lengths[-1], shortest)]
    before = _at_one_time(binned, before)
    best = _maps(binned, before, tried[-1])
    # the longest have the fewest functions: where the evidence has begun to fall the others cannot be asked for less
    for length in reversed(tried[:-1]):
        maps = _maps(binned, before, length)
        if maps.log_evidence < best.log_evidence:
            break
        best = maps
    return _round_of_maps(binned, before, best)


def recounted_round(binned: BinnedData, one: Round) -> Round:
    """Return a round whose fringes are counted anew in time by its own circles."""
    phase = unwrapped(one.phase_rad, binned.bins.time_s)
    fitted = one if one.made_from is None else one.made_from
    return replace(one, phase_rad=phase, place=_places(binned, phase), fitted_m=fitted.place)


def located(binned: BinnedData, one: Round) -> Round:
    """Return a round at the places that its phases tell."""
    return replace(one, place=_places(binned, one.phase_rad))


def _shortest_m(before: Round) -> float:
    extent = float(np.linalg.norm(np.ptp(before.place, axis=1)))
    # an extent over its fringes is how far the tracer goes in one
    fringes = float(np.ptp(before.phase_rad, axis=1).max()) / (2.0 * np.pi)
    return MAP_ROUNDS.shortest_extents_a_fringe * extent / max(fringes, 1.0)


@dataclass(frozen=True, slots=True)
class _Maps:
    """Circles with maps, before phases are taken from them."""

    bias: PositionBasis | None
    amplitude_map: PositionBasis | None
    fits: tuple[CircleFit, ...]

    @property
    def log_evidence(self) -> float:
        return sum(fit.log_evidence for fit in self.fits)


def _at_one_time(binned: BinnedData, before: Round) -> Round:
    phase = before.phase_rad + before.rest_phase_rad[:, None]
    return replace(before, value=at_one_time(binned, phase, before.amplitude, [fit.ellipse for fit in before.fits]))


def _maps(binned: BinnedData, before: Round, length_m: float) -> _Maps:
    # the rest would put all functions where the sphere hangs
    visited = before.place[:, ~binned.rest]
    bias, amplitude_map = make_basis(visited, length_m), make_basis(visited, MAP_ROUNDS.amplitude_longer * length_m)
    data = circle_data(binned, before.value, before.phase_rad, before.place, bias, amplitude_map)
    fitted_m = before.place if before.fitted_m is None else before.fitted_m
    starts = _carried(before, data, fitted_m)
    if before.bias is None:
        fits = tuple(fit_circle(*own) for own in zip(data, starts, before.prior_mean, strict=True))
    else:
        # the deviations hardly depend on the length
        deviations = [fit.deviation_of(data[0].layout) for fit in before.fits]
        every = zip(data, starts, before.prior_mean, deviations, strict=True)
        fits = tuple(fit_circle(*own, updates=1) for own in every)
    return _Maps(bias, amplitude_map, fits)


def _round_of_maps(binned: BinnedData, before: Round, maps: _Maps) -> Round:
    data = circle_data(binned, before.value, before.phase_rad, before.place, maps.bias, maps.amplitude_map)
    return _round(binned, data, before, maps)


def _carried(before: Round, data: list[CircleData], place: FloatArray) -> list[FloatArray]:
    """Return where earlier fits start with new functions, those of data at places: their maps projected on them."""
    layout = data[0].layout
    starts = [np.zeros(layout.size) for _ in before.fits]
    for out, fit in zip(starts, before.fits, strict=True):
        out[layout.constants] = fit.theta[layout.constants]
    # the first maps begin at nothing: the circles before them had none
    if before.bias is None or before.amplitude_map is None:
        return starts
    old = before.fits[0].layout
    thetas = np.array([fit.theta for fit in before.fits])
    old_bias, old_amplitude = before.bias(place), before.amplitude_map(place)
    for new, was, functions, values in (
        (layout.bias_i, old.bias_i, data[0].bias, old_bias),
        (layout.bias_q, old.bias_q, data[0].bias, old_bias),
        (layout.amplitude_map, old.amplitude_map, data[0].amplitude_map, old_amplitude),
    ):
        # values go over, not coefficients: functions of another length are other functions
        normal = functions.T @ functions + MAP_ROUNDS.min_normal * np.eye(functions.shape[1])
        projected = np.linalg.solve(normal, functions.T @ (values @ thetas[:, was].T))
        for out, own in zip(starts, projected.T, strict=True):
            out[new] = own
    return starts


def _fit(binned: BinnedData, data: list[CircleData], before: Round, start: list[FloatArray]) -> Round:
    """Return the round of circles without maps."""
    fits = tuple(fit_circle(*own, updates=0) for own in zip(data, start, before.prior_mean, strict=True))
    return _round(binned, data, before, _Maps(None, None, fits))


def _round(binned: BinnedData, data: list[CircleData], before: Round, maps: _Maps) -> Round:
    """Return the round of circles, with the phases that all bins have then."""
    fits, prior_mean = maps.fits, before.prior_mean
    phase, at_rest = _phases(
        [fit.point(own.i, own.q, own.bias) for fit, own in zip(fits, data, strict=True)],
        binned.bins,
        binned.rest,
        before.phase_rad if before.holds_count else None,
    )
    # maps can bend a circle to anything: its constants keep near those of the range factor alone
    if maps.bias is None:
        prior_mean = np.array([fit.theta[CircleLayout.constants] for fit in fits])
    return Round(
        phase_rad=phase,
        rest_phase_rad=at_rest,
        value=before.value,
        amplitude=np.array([fit.amplitude(own) for fit, own in zip(fits, data, strict=True)]),
        place=_places(binned, phase),
        fits=fits,
        bias=maps.bias,
        amplitude_map=maps.amplitude_map,
        log_evidence=maps.log_evidence,
        prior_mean=prior_mean,
        holds_count=before.holds_count,
        # one step back: what comes before that is not needed again
        made_from=None if maps.bias is None else replace(before, made_from=None),
    )


def _places(binned: BinnedData, phase_rad: FloatArray) -> FloatArray:
    # phi = 2 pi L / lambda, L the whole path from the transmitter to a receiver
    change = phase_rad * binned.wavelength_m / (2.0 * np.pi)
    return map_places(change, binned.antennas, binned.release_m, binned.rest)


def _phases(
    points: list[FloatArray], bins: Bins, rest: BoolArray, counted_rad: FloatArray | None = None
) -> tuple[FloatArray, FloatArray]:
    """Return the unwrapped phases against their mean direction at rest, and that direction.

    The phases are unwrapped in time, or to within half a turn of phases that count the fringes already.
    """
    phases, at_rest = [], []
    for number, point in enumerate(points):
        z = point[0] + 1j * point[1]
        # the mean direction at rest is zero of L: one sample would carry its noise into all
        reference = z[rest].mean() if rest.any() else z[0]
        angle = np.angle(z * reference.conj())
        if counted_rad is None:
            phase = unwrapped(angle, bins.time_s)
        else:
            near = counted_rad[number] - (counted_rad[number, rest].mean() if rest.any() else counted_rad[number, 0])
            phase = angle - 2.0 * np.pi * np.rint((angle - near) / (2.0 * np.pi))
        phases.append(phase - 2.0 * np.pi * np.round((phase[rest].mean() if rest.any() else phase[0]) / (2.0 * np.pi)))
        at_rest.append(float(np.angle(reference)))
    return np.array(phases), np.array(at_rest)
