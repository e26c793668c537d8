"""A solution on fewer and longer bins, on which models are compared at less cost, and back (method 4, Walls)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from radargui.estimation.forward.bins import BINS, Bins, weighted_means
from radargui.estimation.solve.minimise import Solution, solved_at
from radargui.estimation.solve.problem import JointProblem, Start, State

MOST_OFF = 0.2
"""What two nodes may be off from the mean of a wave, in deviations of the noise."""


def with_fewer_bins(start: Start, most: int) -> Start:
    """Return a start with up to so many neighbouring bins in one, none across a break."""
    problem, bins = start.problem, start.problem.bins
    break_s = start.state.theta[problem.layout.breaks]
    before, after = (np.searchsorted(break_s, edge_s) for edge_s in (bins.first_s, bins.last_s))
    # what does not count must not be in a mean, and a mean over an impact is a point on no circle
    joins = (problem.use[1:] == problem.use[:-1]) & (after[1:] == before[:-1])
    begin = bins.runs(np.append(False, joins), _allowed(bins, most))
    drift = weighted_means(problem.inputs.drift.swapaxes(1, 2), bins.count, begin).swapaxes(1, 2)
    fewer = replace(problem, bins=bins.together(begin), use=problem.use[begin])
    return _carried(start.state, replace(fewer, inputs=replace(problem.inputs, drift=drift)))


def with_bins_of(solution: Solution, whole: JointProblem) -> Solution:
    """Return a solution's state with the bins of another problem, no step taken."""
    problem = replace(solution.problem, bins=whole.bins, use=whole.use)
    inputs = replace(problem.inputs, drift=whole.inputs.drift)
    return solved_at(_carried(solution.state, replace(problem, inputs=inputs)))


def _allowed(bins: Bins, most: int) -> int:
    """Return how many bins two nodes may stand for: a wave of one is off by (pi / bins a fringe)^4 / 270."""
    sigma = float(np.median(bins.sigma)) / np.sqrt(most)
    return int(np.clip(BINS.per_fringe / np.pi * (270.0 * MOST_OFF * sigma) ** 0.25, 1.0, most))


def _carried(state: State, problem: JointProblem) -> Start:
    spline = problem.spline.with_breaks(state.theta[problem.layout.breaks])
    place = spline.offset(problem.bins.time_s, state.coefficients) + problem.inputs.release_m
    return Start(problem.at_places(place.T, state.theta), state)
