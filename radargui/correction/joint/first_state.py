"""The first state of the joint problem: what the adaptive rounds found."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import splu

from radargui.correction.adaptive.rounds import Ground, Round
from radargui.correction.joint.drift import Drift
from radargui.correction.joint.layout import FOUND_BREAK_SD_S, Prior, Sizes, make_layout, make_prior
from radargui.correction.joint.minimise import Solution
from radargui.correction.joint.mirrors import MirrorPlane
from radargui.correction.joint.motion_spline import MotionSpline, make_spline
from radargui.correction.joint.problem import JointProblem, State, diagonal
from radargui.correction.joint.signal_model import Stage
from radargui.correction.position_map import make_basis
from radargui.model.arrays import BoolArray, FloatArray

FIRST_JERK = 100.0
_U_PLACE_M = 1e-4
_RELEASE_S = 0.010
LEVEL_LENGTH_M = 0.10


def first_spline(
    ground: Ground, place: FloatArray, start_s: float, break_s: FloatArray
) -> tuple[MotionSpline, FloatArray]:
    """Fit the motion's spline to the places of the adaptive rounds; returns it with its coefficients (n, 3)."""
    spline = make_spline(start_s, float(ground.bins.last_s[-1]) + 1e-6, break_s)
    moving = ~ground.rest
    design = spline.design(ground.bins.time_s[moving])
    jerk, _, _ = spline.jerk()
    weight = ground.bins.count[moving] / ground.bins.count[moving].mean() / _U_PLACE_M**2
    normal = design.T @ diagonal(weight) @ design + jerk.T @ jerk / (3.0 * FIRST_JERK) ** 2
    offset = (place[:, moving] - ground.release_m[:, None]).T
    return spline, np.asarray(splu(csc_matrix(normal)).solve(design.T @ (weight[:, None] * offset)))


@dataclass(frozen=True)
class Posed:
    """A joint problem and where to start."""

    problem: JointProblem
    state: State


def pose(
    ground: Ground,
    motion: tuple[MotionSpline, FloatArray],
    constants: FloatArray,
    planes: tuple[MirrorPlane, ...],
    bias_length_m: float,
    drift: Drift,
    front_end: FloatArray | None = None,
) -> Posed:
    """Pose the joint problem with maps, mirrors and drift at zero.

    Parameters
    ----------
    ground
        Data and geometry.
    motion
        Spline and coefficients to start from.
    constants
        Phase, log amplitude, offsets, ln g, eps of each receiver, shape (n_receivers, 6).
    planes
        Mirrors to include.
    bias_length_m
        Correlation length of the bias maps.
    drift
        Slow noise.
    front_end
        Prior of ln g and eps, shape (n_receivers, 4), see `front_end_prior`.
    """
    bins, (spline, coefficients) = ground.bins, motion
    place = (spline.design(bins.time_s) @ coefficients + ground.release_m).T
    visited = place[:, ~ground.rest]
    bases = make_basis(visited, bias_length_m), make_basis(visited, LEVEL_LENGTH_M)
    n_receivers = ground.antennas.n_receivers
    sizes = Sizes(spline.break_s.size, len(planes), n_receivers, bases[0].size, bases[1].size, drift.count)
    layout = make_layout(sizes)
    theta = np.zeros(layout.size)
    theta[layout.breaks] = spline.break_s
    for own, values in zip(layout.receivers, constants, strict=True):
        theta[own.phase : own.skew + 1] = values
    empty = np.zeros((bins.n_bins, 0))
    stage = Stage(
        ground.antennas,
        ground.release_m,
        2.0 * np.pi / ground.wavelength_m,
        planes,
        empty,
        empty,
        np.zeros((n_receivers, 0)),
        drift.functions(bins.time_s),
    )
    prior = make_prior(layout, planes, spline.break_s, constants[:, 1:4], drift.sd)
    for own, known in zip(layout.receivers, front_end if front_end is not None else (), strict=False):
        prior.mean[own.log_gain], prior.sd[own.log_gain] = known[:2]
        prior.mean[own.skew], prior.sd[own.skew] = known[2:]
    problem = JointProblem(
        bins,
        ground.delay_s,
        spline,
        layout,
        stage,
        prior,
        np.full(sum(spline.spans), FIRST_JERK),
        np.ones(n_receivers),
        usable_bins(ground, spline.break_s),
        bases,
        ground.onset_s + _RELEASE_S,
    )
    return Posed(problem.at_places(place), State(coefficients, theta))


def pose_again(ground: Ground, solution: Solution, motion: tuple[MotionSpline, FloatArray]) -> Posed:
    """Pose a solution's problem with other breaks or knots, everything else as the solution has it."""
    problem, (spline, coefficients) = solution.problem, motion
    old = problem.layout
    layout = make_layout(replace(old.sizes, breaks=spline.break_s.size))
    rest = slice(old.breaks.stop, None)
    _, before, _ = solution.at.spline.jerk()
    _, now, _ = spline.jerk()
    jerk_sd = np.exp(np.interp(now, before, np.log(problem.jerk_sd)))
    shift = layout.breaks.stop - old.breaks.stop
    prior = Prior(
        np.concatenate([spline.break_s, problem.prior.mean[rest]]),
        np.concatenate([np.full(spline.break_s.size, FOUND_BREAK_SD_S), problem.prior.sd[rest]]),
        [(index + shift, lowest, highest) for index, lowest, highest in problem.prior.groups],
    )
    posed = replace(
        problem,
        spline=spline,
        layout=layout,
        prior=prior,
        jerk_sd=np.clip(jerk_sd, 3.0, 3.0 * FIRST_JERK),
        use=usable_bins(ground, spline.break_s),
    )
    return Posed(posed, State(coefficients, np.concatenate([spline.break_s, solution.state.theta[rest]])))


def usable_bins(ground: Ground, break_s: FloatArray) -> BoolArray:
    """Return which bins hold no break."""
    before = np.searchsorted(break_s, ground.bins.first_s)
    after = np.searchsorted(break_s, ground.bins.last_s)
    return np.asarray(before == after)


def circle_constants(found: Round) -> FloatArray:
    """Return phase, log amplitude, offsets, ln g, eps of each receiver; the mean of the bias counts as offset."""
    out = []
    for receiver, fit in enumerate(found.fits):
        ellipse, bias = fit.ellipse, np.zeros(2)
        if found.bias is not None:
            n = found.bias.size
            mean = found.bias(found.place).mean(axis=0)
            bias = np.array([mean @ fit.theta[5 : 5 + n], mean @ fit.theta[5 + n : 5 + 2 * n]])
        out.append(
            [
                found.turn_rad[receiver],
                np.log(found.amplitude[receiver, 0]),
                ellipse.offset_i + bias[0],
                ellipse.offset_q + bias[1],
                ellipse.log_gain,
                ellipse.skew_rad,
            ]
        )
    return np.array(out)
