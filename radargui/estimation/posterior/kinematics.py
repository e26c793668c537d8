"""Compute velocity and acceleration of a joint solution, with their uncertainties."""

from __future__ import annotations

import numpy as np

from radargui.estimation.motion_estimate import few_fringes_factor
from radargui.estimation.posterior.samples import SAMPLES, covariance_of_motion, hidden_m
from radargui.estimation.select.chosen_model import Alternative
from radargui.estimation.solve.minimise import Solution, local_chi_square
from radargui.model.arrays import FloatArray, IntArray
from radargui.model.result import Kinematics
from radargui.physics.path_length import path_lengths, position_uncertainty


def kinematics(solution: Solution, alternatives: tuple[Alternative, ...], time_s: FloatArray) -> Kinematics:
    """Return place, velocity and acceleration at times (n,) of the motion.

    Uncertainties are made as those of places at the samples: the posterior, with alternatives mixed in, widened by the
    local misfit beyond the noise and by receivers of few fringes. Where nothing flies, maps may stand for motion; the
    slope of a map of deviation s and length l deviates by s / l.
    """
    problem = solution.problem
    inputs, bins = problem.inputs, problem.bins
    values, square = _of(solution, time_s)
    total = 1.0
    for alternative in alternatives:
        other, weight = alternative.solution, alternative.weight
        there, own = _of(other, time_s)
        square = square + weight * (own + (there - values) ** 2)
        total += weight
    misfit = local_chi_square(problem, solution.at) / problem.noise_scale[:, None] ** 2
    excess = np.interp(time_s, bins.time_s, np.sqrt(np.maximum(misfit, 1.0)).max(axis=0))
    place = values[0] + inputs.release_m[:, None]
    change = path_lengths(place, inputs.antennas) - path_lengths(inputs.release_m[:, None], inputs.antennas)
    wide = few_fringes_factor(change * inputs.wavenumber).max()
    u = wide * excess * np.sqrt(np.maximum(square / total, 0.0))
    if not problem.in_flight.any():
        hidden = position_uncertainty(place, hidden_m(solution, place), inputs.antennas)
        turns_hz = np.linalg.norm(values[1], axis=0) / problem.amplitude_basis.length_m
        u = np.hypot(u, hidden * turns_hz ** np.arange(3)[:, None, None])
    u[0] = np.hypot(u[0], SAMPLES.smallest_u_m)
    return Kinematics(time_s, place, values[1], values[2], u[0], u[1], u[2], _flight(solution, time_s))


def _of(solution: Solution, time_s: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the offset from the release and its first two derivatives, and their variances, both (3, 3, n)."""
    series = solution.at.spline.series(time_s)
    covariance = [covariance_of_motion(solution, time_s, series, order) for order in range(3)]
    variance = np.diagonal(np.array(covariance), axis1=2, axis2=3).transpose(0, 2, 1)
    return series.motion(solution.state.coefficients)[:3], np.asarray(variance)


def _flight(solution: Solution, time_s: FloatArray) -> IntArray:
    """Return the number of the flight at times (n,), -1 where the motion is none."""
    spline = solution.at.spline
    flies = np.logical_or.reduceat(solution.problem.in_flight, np.cumsum([0, *spline.spans[:-1]]))
    number = np.cumsum(flies) - 1
    segment = np.clip(np.searchsorted(spline.edge_s, time_s, side="right") - 1, 0, flies.size - 1)
    return np.where(flies[segment], number[segment], -1)
