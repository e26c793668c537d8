"""Recognise bias maps that have grown until they stand for the signal itself."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from radargui.estimation.forward.signal_model import bias_of
from radargui.estimation.solve.minimise import Solution, chi_square
from radargui.model.arrays import FloatArray


@dataclass(frozen=True, slots=True)
class LostSettings:
    """When a level motion counts as lost. Chosen by hand.

    Attributes
    ----------
    bias, misfit
        A motion is lost if the bias maps of all receivers have a deviation above `bias`, and the misfit (chi-square)
        exceeds `misfit` or an offset exceeds the wave. Five that no wall put right had misfits of 5 to 60, or offsets
        of up to 200 waves (two hands, three level circles, one of these with two walls). Of those that a wall did put
        right one had such maps in all receivers, with a misfit of 1.9 and offsets of 0.4, the others a receiver with
        0.1.
    """

    bias: float = 0.2
    misfit: float = 3.0


LOST = LostSettings()


def bias_deviations(solution: Solution) -> FloatArray:
    """Return the deviation of each receiver's bias maps, in amplitudes, shape (n_receivers,)."""
    problem = solution.problem
    return np.array([problem.prior.sd[own.bias_i.start] for own in problem.layout.receivers])


def goes_beyond_wave(solution: Solution, onset_s: float) -> bool:
    """Return whether an offset is larger than its wave somewhere: the phasor may go round it on the other side."""
    problem = solution.problem
    moving, own_signals = problem.bins.time_s > onset_s, zip(problem.layout.receivers, solution.at.signals, strict=True)
    return any(
        (np.abs(bias_of(solution.state.theta, own, problem.inputs)) > np.abs(signal.field))[moving].any()
        for own, signal in own_signals
    )


def is_lost(solution: Solution, onset_s: float) -> bool:
    """Return whether a level motion is not determined any more, because its maps are as large as waves.

    Parameters
    ----------
    solution
        Converged solution with settled breaks. If the sphere counts as a point maps describe what it scatters, and the
        answer is no.
    onset_s
        End of the rest.
    """
    problem = solution.problem
    if problem.sphere is None or problem.in_flight.any() or bias_deviations(solution).min() < LOST.bias:
        return False
    return bool(chi_square(solution).max() > LOST.misfit) or goes_beyond_wave(solution, onset_s)
