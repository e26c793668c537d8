"""The first state of the joint problem: what the adaptive rounds found."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import splu

from radargui.correction.adaptive.place import range_law
from radargui.correction.adaptive.rounds import Ground, Round
from radargui.correction.joint.layout import make_layout, make_prior
from radargui.correction.joint.mirrors import MirrorPlane
from radargui.correction.joint.motion_spline import MotionSpline, make_spline
from radargui.correction.joint.problem import JointProblem, State, diagonal
from radargui.correction.joint.signal_model import Stage
from radargui.correction.position_map import PositionBasis, make_basis
from radargui.model.arrays import FloatArray

FIRST_JERK = 100.0
_U_PLACE_M = 1e-4
LEVEL_LENGTH_M = 0.15


def first_spline(ground: Ground, place: FloatArray, start_s: float, break_s: FloatArray) -> tuple[MotionSpline, FloatArray]:
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
    """A joint problem, where to start, and its map functions (bias, log amplitude)."""

    problem: JointProblem
    state: State
    bases: tuple[PositionBasis, PositionBasis]


def pose(
    ground: Ground,
    motion: tuple[MotionSpline, FloatArray],
    constants: FloatArray,
    planes: tuple[MirrorPlane, ...],
    bias_length_m: float,
    jerk_sd: FloatArray | None = None,
) -> Posed:
    """Pose the joint problem with maps and mirrors at zero.

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
    jerk_sd
        Deviations of the jerk to start from.
    """
    bins, (spline, coefficients) = ground.bins, motion
    place = (spline.design(bins.time_s) @ coefficients + ground.release_m).T
    visited = place[:, ~ground.rest]
    bases = make_basis(visited, bias_length_m), make_basis(visited, LEVEL_LENGTH_M)
    n_receivers = ground.antennas.n_receivers
    layout = make_layout(spline.break_s.size, len(planes), n_receivers, bases[0].size, bases[1].size)
    theta = np.zeros(layout.size)
    theta[layout.breaks] = spline.break_s
    for own, values in zip(layout.receivers, constants, strict=True):
        theta[own.phase : own.skew + 1] = values
    stage = Stage(
        ground.antennas, ground.release_m, 2.0 * np.pi / ground.wavelength_m, planes,
        bases[0](place), bases[1](place), range_law(place, ground.antennas, ground.release_m),
    )
    if jerk_sd is None:
        jerk_sd = np.full(sum(spline.spans), FIRST_JERK)
    problem = JointProblem(
        bins, ground.delay_s, spline, layout, stage, make_prior(layout, spline.break_s, constants[:, 1]),
        jerk_sd, np.ones(n_receivers), usable_bins(ground, spline.break_s),
    )
    return Posed(problem, State(coefficients, theta), bases)


def usable_bins(ground: Ground, break_s: FloatArray) -> FloatArray:
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
        out.append([
            found.turn_rad[receiver], np.log(found.amplitude[receiver, 0]),
            ellipse.offset_i + bias[0], ellipse.offset_q + bias[1], ellipse.log_gain, ellipse.skew_rad,
        ])
    return np.array(out)


def joint_constants(problem: JointProblem, theta: FloatArray) -> FloatArray:
    """Return the same constants from a border vector; the mean of the bias counts as offset."""
    mean, out = problem.stage.bias.mean(axis=0), []
    for own in problem.layout.receivers:
        values = theta[own.phase : own.skew + 1].copy()
        beta = complex(mean @ theta[own.bias_i], mean @ theta[own.bias_q])
        values[2] += beta.real
        values[3] += np.exp(values[4]) * (np.sin(values[5]) * beta.real + np.cos(values[5]) * beta.imag)
        out.append(values)
    return np.array(out)
