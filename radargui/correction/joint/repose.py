"""A solution's problem posed again: with other mirrors or other bias maps, its priors started anew."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from radargui.correction.joint.first_state import Posed
from radargui.correction.joint.layout import Layout, make_layout, make_prior
from radargui.correction.joint.minimise import Solution
from radargui.correction.joint.mirrors import MirrorPlane
from radargui.correction.joint.problem import JointProblem, State
from radargui.correction.position_map import PositionBasis
from radargui.model.arrays import FloatArray, IntArray


def repose(solution: Solution, planes: tuple[MirrorPlane, ...], bias: PositionBasis | None = None) -> Posed:
    """Pose a solution's problem with other mirrors or other functions for the bias.

    Everything else starts from the solution; new mirrors and new bias maps start at zero, and the deviations of all
    maps and mirrors are started again.

    Parameters
    ----------
    solution
        Converged.
    planes
        Its mirrors in its order, more or fewer.
    bias
        Functions of the bias maps; None keeps them.
    """
    before, theta = solution.problem, solution.state.theta
    old = before.layout
    n_bias = old.sizes.bias if bias is None else bias.size
    layout = make_layout(replace(old.sizes, mirrors=len(planes), bias=n_bias))
    source, target = carried_places(old, layout, bias=bias is None)
    new_theta = np.zeros(layout.size)
    new_theta[target] = theta[source]
    mean = before.prior.mean
    circles = np.array([[mean[own.log_amplitude], *mean[own.offset]] for own in old.receivers])
    prior = make_prior(layout, planes, mean[old.breaks], circles, _drift_sd(before))
    for was, now in zip(old.receivers, layout.receivers, strict=True):
        for a, b in ((was.log_gain, now.log_gain), (was.skew, now.skew)):
            prior.mean[b], prior.sd[b] = mean[a], before.prior.sd[a]
    stage = replace(before.stage, planes=planes)
    bases = before.bases if bias is None else (bias, before.bases[1])
    problem = replace(before, layout=layout, prior=prior, stage=stage, spline=solution.at.spline, bases=bases)
    if bias is not None:
        place = (solution.at.design @ solution.state.coefficients + stage.release_m).T
        problem = problem.at_places(place)
    return Posed(problem, State(solution.state.coefficients, new_theta))


def carried_places(old: Layout, new: Layout, *, bias: bool = True) -> tuple[IntArray, IntArray]:
    """Return places in the old layout and where they stand in a new one with more or fewer mirrors.

    Parameters
    ----------
    old, new
        Layouts.
    bias
        Whether the coefficients of the bias maps mean the same in both.
    """
    pairs: list[tuple[slice, slice]] = [(old.breaks, new.breaks), (old.planes, new.planes)]
    pairs += [(old.forward, new.forward), (old.forward_lobe, new.forward_lobe)]
    for was, now in zip(old.receivers, new.receivers, strict=True):
        pairs += [(slice(was.phase, was.skew + 1), slice(now.phase, now.skew + 1)), (was.level, now.level)]
        if bias:
            pairs += [(was.bias_i, now.bias_i), (was.bias_q, now.bias_q)]
        pairs += [(was.backward, now.backward), (was.backward_lobe, now.backward_lobe), (was.ghost, now.ghost)]
        pairs += [(was.drift_i, now.drift_i), (was.drift_q, now.drift_q)]
    shared = [(a.start, b.start, min(a.stop - a.start, b.stop - b.start)) for a, b in pairs]
    source = np.concatenate([np.arange(a, a + count) for a, _, count in shared])
    target = np.concatenate([np.arange(b, b + count) for _, b, count in shared])
    return source, target


def _drift_sd(problem: JointProblem) -> FloatArray:
    rows = []
    for own in problem.layout.receivers:
        rows += [problem.prior.sd[own.drift_i], problem.prior.sd[own.drift_q]]
    return np.array(rows)
