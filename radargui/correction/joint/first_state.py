"""The first state of the joint problem: what the adaptive rounds found."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import splu

from radargui.correction.adaptive.place import range_law
from radargui.correction.adaptive.rounds import Ground, Round
from radargui.correction.joint.layout import Layout, make_layout, make_prior
from radargui.correction.joint.mirrors import MirrorPlane
from radargui.correction.joint.motion_spline import MotionSpline, make_spline
from radargui.correction.joint.problem import JointProblem, State, diagonal
from radargui.correction.joint.signal_model import Stage
from radargui.correction.position_map import PositionBasis, make_basis
from radargui.model.arrays import FloatArray

_FIRST_JERK = 100.0
_U_PLACE_M = 1e-4
LEVEL_LENGTH_M = 0.15


def first_spline(ground: Ground, place: FloatArray, start_s: float, break_s: FloatArray) -> tuple[MotionSpline, FloatArray]:
    """Fit the motion's spline to the places of the adaptive rounds; returns it with its coefficients (n, 3)."""
    spline = make_spline(start_s, float(ground.bins.last_s[-1]) + 1e-6, break_s)
    moving = ~ground.rest
    design = spline.design(ground.bins.time_s[moving])
    jerk, _, _ = spline.jerk()
    weight = ground.bins.count[moving] / ground.bins.count[moving].mean() / _U_PLACE_M**2
    normal = design.T @ diagonal(weight) @ design + jerk.T @ jerk / (3.0 * _FIRST_JERK) ** 2
    offset = (place[:, moving] - ground.release_m[:, None]).T
    return spline, np.asarray(splu(csc_matrix(normal)).solve(design.T @ (weight[:, None] * offset)))


def pose(
    ground: Ground,
    spline: MotionSpline,
    coefficients: FloatArray,
    found: Round,
    planes: tuple[MirrorPlane, ...],
    bias_length_m: float,
) -> tuple[JointProblem, State, tuple[PositionBasis, PositionBasis]]:
    """Pose the joint problem with maps at zero and start it from the constants of the adaptive rounds."""
    bins = ground.bins
    place = (spline.design(bins.time_s) @ coefficients + ground.release_m).T
    visited = place[:, ~ground.rest]
    bases = make_basis(visited, bias_length_m), make_basis(visited, LEVEL_LENGTH_M)
    n_receivers = ground.antennas.n_receivers
    layout = make_layout(spline.break_s.size, len(planes), n_receivers, bases[0].size, bases[1].size)
    theta = np.zeros(layout.size)
    theta[layout.breaks] = spline.break_s
    _start_constants(theta, layout, found)
    log_amplitude = np.array([theta[own.log_amplitude] for own in layout.receivers])
    stage = Stage(
        ground.antennas, ground.release_m, 2.0 * np.pi / ground.wavelength_m, planes,
        bases[0](place), bases[1](place), range_law(place, ground.antennas, ground.release_m),
    )
    _, middle, _ = spline.jerk()
    problem = JointProblem(
        bins, ground.delay_s, spline, layout, stage, make_prior(layout, spline.break_s, log_amplitude),
        np.full(middle.size, _FIRST_JERK), np.ones(n_receivers), usable_bins(ground, spline.break_s),
    )
    return problem, State(coefficients, theta), bases


def usable_bins(ground: Ground, break_s: FloatArray) -> FloatArray:
    """Return which bins hold no break."""
    before = np.searchsorted(break_s, ground.bins.first_s)
    after = np.searchsorted(break_s, ground.bins.last_s)
    return np.asarray(before == after)


def _start_constants(theta: FloatArray, layout: Layout, found: Round) -> None:
    """Constants of the circles, the mean of their bias maps counted as offset."""
    for receiver, (own, fit) in enumerate(zip(layout.receivers, found.fits, strict=True)):
        ellipse = fit.ellipse
        bias = np.zeros(2)
        if found.bias is not None:
            n = found.bias.size
            at = found.bias(found.place).mean(axis=0)
            bias = np.array([at @ fit.theta[5 : 5 + n], at @ fit.theta[5 + n : 5 + 2 * n]])
        theta[own.phase] = found.turn_rad[receiver]
        theta[own.log_amplitude] = np.log(found.amplitude[receiver, 0])
        theta[own.offset] = np.array([ellipse.offset_i, ellipse.offset_q]) + bias
        theta[own.log_gain], theta[own.skew] = ellipse.log_gain, ellipse.skew_rad
