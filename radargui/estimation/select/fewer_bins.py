"""Compare models on fewer and longer bins at less cost, and return to all bins."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from radargui.estimation.forward.bins import BINS, BinnedData, Bins
from radargui.estimation.solve.changed_problem import problem_with_fine_maps
from radargui.estimation.solve.initial_problem import usable_bins
from radargui.estimation.solve.minimise import Solution, local_chi_square
from radargui.estimation.solve.problem import Start, linearise
from radargui.model.arrays import FloatArray, IntArray

MAX_BINS = 3
"""Neighbours that count as one while models are compared: 1/8 fringe, which two nodes tell to 1e-4; half the time."""
MAX_OFF = 0.2
"""What two nodes may be off from the mean of a wave, in deviations of the noise."""
NEAR_BREAK_S = 0.008
"""So near a break bins stay as they are: it moves while it is settled, and a longer mean over it would hold it back."""


def fewer_bins(data: BinnedData, break_s: FloatArray, most: int = MAX_BINS) -> BinnedData:
    """Return the data with up to `most` neighbours a bin, none near breaks (n_breaks,) or over the end of the rest."""
    return data.together(_begins(data, break_s, most))


def _begins(data: BinnedData, break_s: FloatArray, most: int) -> IntArray:
    bins = data.bins
    reach = (bins.first_s - NEAR_BREAK_S, bins.last_s + NEAR_BREAK_S)
    near = np.diff(np.searchsorted(break_s, reach), axis=0)[0] > 0
    # a mean over an impact is a point on no circle
    joins = ~near[1:] & (data.rest[1:] == data.rest[:-1])
    return bins.runs(np.append(False, joins), _allowed(bins, most))


def with_bins_of(solution: Solution | Start, data: BinnedData) -> Start:
    """Return a solution's state with the bins of other data of the same samples."""
    state, problem = solution.state, solution.problem
    break_s = state.theta[problem.layout.breaks]
    inputs = replace(problem.inputs, drift=data.drift)
    problem = replace(problem, bins=data.bins, use=usable_bins(data.bins, break_s), inputs=inputs)
    spline = problem.spline.with_breaks(break_s)
    # maps, range factor and scattering are evaluated at bins: at the new ones anew
    place = spline.offset(data.bins.time_s, state.coefficients) + problem.inputs.release_m
    return Start(problem.at_places(place.T, state.theta), state)


def in_full(solution: Solution, data: BinnedData) -> Start:
    """Return a solution's state on all bins of the data, with all functions of its maps."""
    start = with_bins_of(solution, data)
    place = start.problem.spline.offset(data.bins.time_s, start.state.coefficients) + data.release_m
    return problem_with_fine_maps(start, place.T, ~data.rest)


def misfit_on(data: BinnedData, solution: Solution) -> FloatArray:
    """Return the median over all bins of each receiver's local chi-square, shape (n_receivers,)."""
    start = with_bins_of(solution, data)
    return np.asarray(np.median(local_chi_square(start.problem, linearise(start.problem, start.state)), axis=1))


def _allowed(bins: Bins, most: int) -> int:
    """Return how many bins two nodes may stand for: a wave of one is off by (pi / bins a fringe)^4 / 270."""
    # white noise of a longer bin is smaller, and shows sooner what two nodes are off by
    sigma = float(np.median(bins.sigma)) / np.sqrt(most)
    return int(np.clip(BINS.per_fringe / np.pi * (270.0 * MAX_OFF * sigma) ** 0.25, 1.0, most))
