"""Evaluate the joint solution at every sample: places, path lengths, uncertainties, corrected IQ."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from radargui.estimation.forward.motion_spline import SplineSeries
from radargui.estimation.forward.signal_model import FrontEndState
from radargui.estimation.motion_estimate import few_fringes_factor
from radargui.estimation.select.chosen_model import Alternative
from radargui.estimation.signals import ScaledSignals
from radargui.estimation.solve.changed_problem import positions_at_bins
from radargui.estimation.solve.minimise import Solution, local_chi_square
from radargui.model.arrays import ComplexArray, FloatArray, pieces
from radargui.model.front_end import point_of
from radargui.physics.path_length import Antennas, path_gradient, path_lengths, position_uncertainty


@dataclass(frozen=True, slots=True)
class SampleSettings:
    """What the uncertainty at the samples contains besides the posterior. Chosen by hand where nothing else is said.

    Attributes
    ----------
    smallest_u_m
        Least uncertainty of a position: what the equations of the scattering leave out.
    slow_start_s, creep_s
        At rest and until `slow_start_s` after the onset the tracer may have crept unseen by the noise of a mean over
        `creep_s`.
    """

    smallest_u_m: float = 1e-7
    slow_start_s: float = 0.03
    creep_s: float = 0.005


SAMPLES = SampleSettings()


@dataclass(frozen=True, slots=True)
class AtSamples:
    """Positions (3, n), changes (n_receivers, n) with standard uncertainties, unit-circle I and Q (n_receivers, n)."""

    position_m: FloatArray
    u_position_m: FloatArray
    change_m: FloatArray
    u_change_m: FloatArray
    i: FloatArray
    q: FloatArray
    misfit: FloatArray


def at_samples(solution: Solution, signals: ScaledSignals, alternatives: tuple[Alternative, ...] = ()) -> AtSamples:
    """Evaluate the solution at the samples' times.

    Uncertainties come from the inverse normal matrix at the bins, times the square root of the local misfit beyond the
    fitted noise scale; alternatives are mixed in; receivers of few fringes widen it.
    """
    problem, time = solution.problem, signals.time_s
    inputs, bins = problem.inputs, problem.bins
    release = inputs.release_m
    position = (solution.at.spline.offset(time, solution.state.coefficients) + release).T
    at_rest = path_lengths(release[:, None], inputs.antennas)
    change = path_lengths(position, inputs.antennas) - at_rest
    misfit = local_chi_square(solution.problem, solution.at)
    # where residuals are large the motion is doubtful there, not everywhere
    excess = np.sqrt(np.maximum(misfit / problem.noise_scale[:, None] ** 2, 1.0))
    wide = few_fringes_factor(change * inputs.wavenumber)
    u_position, u_change = with_alternatives(solution, alternatives, excess)
    # a place needs all receivers: the one that saw least decides
    u_position, u_change = wide.max() * u_position, wide[:, None] * u_change
    if not problem.in_flight.any():
        place = positions_at_bins(solution)
        hidden = hidden_m(solution, place)
        u_position = np.hypot(u_position, position_uncertainty(place, hidden, inputs.antennas))
        u_change = np.hypot(u_change, hidden)

    def spread(values: FloatArray) -> FloatArray:
        return np.array([np.interp(time, bins.time_s, row) for row in values])

    # a slow release moves less than the noise of a bin for tens of milliseconds
    slow = time < solution.at.spline.edge_s[0] + SAMPLES.slow_start_s
    unseen = np.where(slow, _unseen_m(solution, signals), SAMPLES.smallest_u_m)
    u_position, u_change = (np.hypot(spread(u), unseen) for u in (u_position, u_change))
    i, q = _corrected(solution, signals, change, at_rest)
    return AtSamples(np.ascontiguousarray(position), u_position, change, u_change, i, q, spread(misfit))


def hidden_m(solution: Solution, place: FloatArray) -> FloatArray:
    """Return the error of each path, (n_receivers, n), that reflectors outside the model may cause at places (3, n).

    A second wave of relative amplitude r multiplies the direct one by 1 + r, nearly exp(r). Its real part changes ln A,
    which the maps show. Its imaginary part changes the phase, which the motion takes up where no flight holds it. That
    part is a map of the same deviation s and length l, zero at rest: u^2 = 2 s^2 (1 - exp(-d^2 / 2 l^2)) / k^2, d the
    distance from there.
    """
    problem, theta = solution.problem, solution.state.theta
    away = np.linalg.norm(place - problem.inputs.release_m[:, None], axis=0) / problem.amplitude_basis.length_m
    maps = np.array([problem.inputs.amplitude_map @ theta[own.amplitude_map] for own in problem.layout.receivers])
    # near the rest 1 - exp(-x) is x, and would be rounding
    share = np.sqrt(-2.0 * np.expm1(-0.5 * away**2))
    least = SAMPLES.smallest_u_m
    return np.asarray(maps.std(axis=1)[:, None] / problem.inputs.wavenumber * share + least)


def _unseen_m(solution: Solution, signals: ScaledSignals) -> float:
    """Return how far the tracer may have crept before its motion was seen: the noise of a 5 ms mean."""
    amplitude = np.median([np.median(np.abs(signal.direct)) for signal in solution.at.signals])
    noise = float(np.median(signals.sigma)) / np.sqrt(max(1.0, SAMPLES.creep_s * signals.rate_hz))
    return float(noise / amplitude / solution.problem.inputs.wavenumber) + SAMPLES.smallest_u_m


def with_alternatives(
    solution: Solution, alternatives: tuple[Alternative, ...], excess: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return standard uncertainties of positions (3, n_bins) and path lengths (n_receivers, n_bins).

    A mixture of solutions with weights w around the best: u^2 = sum w (u_k^2 + d_k^2) / sum w, d_k the distance of
    solution k from the best; its own u is widened by the misfit.
    """
    problem = solution.problem
    here = positions_at_bins(solution)
    path = path_lengths(here, problem.inputs.antennas)
    total = 1.0
    own = uncertainties(solution)
    square, square_path = (own[0] * excess.max(axis=0)) ** 2, (own[1] * excess) ** 2
    # the best stays the answer: a mean of two motions obeys no equation of motion
    for alternative in alternatives:
        other, weight = alternative.solution, alternative.weight
        there = positions_at_bins(other)
        # what unseen mirrors move has the curvature of the best
        u_position, u_change = own if other.normal is solution.normal else uncertainties(other)
        square += weight * (u_position**2 + (there - here) ** 2)
        square_path += weight * (u_change**2 + (path_lengths(there, problem.inputs.antennas) - path) ** 2)
        total += weight
    return np.sqrt(square / total), np.sqrt(square_path / total)


def uncertainties(solution: Solution) -> tuple[FloatArray, FloatArray]:
    """Return standard uncertainties at the bins: positions (3, n_bins), changes of path (n_receivers, n_bins)."""
    problem = solution.problem
    gradient = path_gradient(positions_at_bins(solution), problem.inputs.antennas)
    covariance = covariance_of_motion(solution, problem.bins.time_s, solution.at.series)
    # paths from the same covariance: errors of x, y and z of one motion are correlated
    of_paths = np.einsum("ran,nab,rbn->rn", gradient, covariance, gradient)
    return np.sqrt(np.diagonal(covariance, axis1=1, axis2=2)).T, np.sqrt(of_paths)


def covariance_of_motion(solution: Solution, time_s: FloatArray, series: SplineSeries, order: int = 0) -> FloatArray:
    """Return the covariance of a derivative of the motion at times (n,), where these series are, (n, 3, 3)."""
    spline, motion = solution.at.spline, series.motion(solution.state.coefficients)
    # a break that moves carries the knots of both flights along: the derivative of share times velocity
    share, breaks = spline.break_shares(time_s)
    by_breaks = motion[order + 1].T[:, :, None] * share[:, None]
    if order:
        by_breaks += order * motion[order].T[:, :, None] * spline.break_share_rates(time_s)[:, None]
    return solution.normal.covariance().of_rows(series.rows(order), by_global=by_breaks, places=breaks)


def _corrected(
    solution: Solution, signals: ScaledSignals, change_m: FloatArray, at_rest_m: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return I and Q on the unit circle at the time of channel 0: the model's circle plus what the samples add.

    The difference between sample and model is taken at the channel's own time, brought back through gain ratio and
    quadrature error and divided by the amplitude: mirrors, bias and drift are gone, noise stays.
    """
    out_i, out_q = np.empty((2, signals.n_receivers, signals.time_s.size))
    for receiver in range(signals.n_receivers):
        circle = _Circle(solution, signals, receiver, change_m[receiver], float(at_rest_m[receiver, 0]))
        for part in pieces(signals.time_s.size):
            z = circle.at(part)
            out_i[receiver, part], out_q[receiver, part] = z.real, z.imag
    return out_i, out_q


class _Circle:
    """One receiver's circle between the bins."""

    def __init__(
        self, solution: Solution, signals: ScaledSignals, receiver: int, change_m: FloatArray, at_rest_m: float
    ) -> None:
        self.solution, self.signals, self.receiver = solution, signals, receiver
        self.change_m, self.at_rest_m = change_m, at_rest_m
        self.own, signal = solution.problem.layout.receivers[receiver], solution.at.signals[receiver]
        inputs, layout = solution.problem.inputs, solution.problem.layout
        scattered = inputs.sphere_factors(solution.state.theta, layout, receiver, inputs.sphere).direct
        # mirrors turn phase and amplitude: divided out, the sample lies on the circle of the direct path
        ratio = signal.field / signal.direct * scattered / np.abs(scattered)
        self.curves = np.stack([np.abs(signal.direct), ratio.real, ratio.imag, *signal.besides])
        antennas = inputs.antennas
        self.antennas = Antennas(antennas.transmitter_m, antennas.receivers_m[receiver : receiver + 1])

    def at(self, part: slice) -> ComplexArray:
        """Return points near the unit circle at some samples."""
        theta, own, time = self.solution.state.theta, self.own, self.signals.time_s[part]
        pair = slice(2 * self.receiver, 2 * self.receiver + 2)
        bin_s = self.solution.problem.bins.time_s
        size, real, imaginary, besides_i, besides_q = (np.interp(time, bin_s, row) for row in self.curves)
        amplitude = size * np.exp(1j * theta[own.phase]) * (real + 1j * imaginary)
        here = self._unit(self.change_m[part])
        # Q is sampled later than I: at 2 m/s and 15 us two degrees
        delays = self.solution.problem.delay_s[pair]
        later = [self._unit(self._change(time + delay)) if delay else here for delay in delays]
        front_end = FrontEndState.of(theta, own)
        model = front_end.channels(np.stack(later) * amplitude)
        # model and sample at the channel's own time; only their difference is moved to that of I
        left_i, left_q = self.signals.value[pair, part] - model - np.stack([besides_i, besides_q])
        x, y = point_of(left_i, left_q, front_end.gain_ratio, front_end.quadrature_error_rad)
        return np.asarray(here + (x + 1j * y) / amplitude)

    def _change(self, time_s: FloatArray) -> FloatArray:
        place = self.solution.at.spline.offset(time_s, self.solution.state.coefficients)
        place += self.solution.problem.inputs.release_m
        return np.asarray(path_lengths(place.T, self.antennas)[0] - self.at_rest_m)

    def _unit(self, change_m: FloatArray) -> ComplexArray:
        angle = self.solution.problem.inputs.wavenumber * change_m
        return np.asarray(np.cos(angle) + 1j * np.sin(angle))
