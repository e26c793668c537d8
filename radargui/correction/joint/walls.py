"""Walls that reflect: searched over azimuth and distance where the misfit asks for them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy.sparse import eye_array, kron

from radargui.correction.adaptive.rounds import Ground
from radargui.correction.joint.first_state import Posed
from radargui.correction.joint.layout import Layout, make_layout, make_prior
from radargui.correction.joint.minimise import Solution, log_evidence
from radargui.correction.joint.mirrors import MirrorPlane
from radargui.correction.joint.problem import JointProblem, Linearised, State, linearise
from radargui.correction.joint.rounds import converge
from radargui.model.arrays import FloatArray

_AZIMUTHS, _DISTANCES_M = 40, (0.08, 0.11, 0.14, 0.17, 0.20)
_CARRIED = 3
_COEFFICIENT_SD = 0.03
_ROUNDS = 5


def search_wall(
    ground: Ground, solution: Solution, normal: FloatArray, tick: Callable[[], None]
) -> tuple[Solution, float]:
    """Return the best solution with one more wall and what it gains in log evidence.

    Every wall of a grid gets its linearised evidence with everything else marginalised; the best few are converged,
    because the linearised ranking is not reliable.
    """
    candidates = _grid(solution, normal)
    gains = []
    for number, plane in enumerate(candidates):
        if number % 20 == 0:
            tick()
        gains.append(_linearised_gain(solution, plane))
    best: tuple[Solution, float] = (solution, -np.inf)
    for number in _peaks(np.array(gains).reshape(_AZIMUTHS, -1)):
        trial = converge(ground, add_mirror(solution, candidates[number]), _ROUNDS, tick)
        gain = log_evidence(trial) - log_evidence(solution)
        if gain > best[1]:
            best = (trial, gain)
    return best


def add_mirror(solution: Solution, plane: MirrorPlane) -> Posed:
    """Pose the problem with one more mirror, its coefficients at zero, the maps' deviations started again."""
    old_problem, theta = solution.problem, solution.state.theta
    old = old_problem.layout
    layout = make_layout(replace(old.sizes, mirrors=old.sizes.mirrors + 1))
    place = _carried_places(old, layout)
    new_theta = np.zeros(layout.size)
    new_theta[place] = theta
    prior = make_prior(
        layout, old_problem.prior.mean[old.breaks],
        np.array([old_problem.prior.mean[own.log_amplitude] for own in old.receivers]), _drift_sd(old_problem),
    )
    stage = replace(old_problem.stage, planes=(*old_problem.stage.planes, plane))
    spline = solution.at.spline
    problem = replace(old_problem, layout=layout, prior=prior, stage=stage, spline=spline)
    return Posed(problem, State(solution.state.coefficients, new_theta))


def _drift_sd(problem: JointProblem) -> FloatArray:
    rows = []
    for own in problem.layout.receivers:
        rows += [problem.prior.sd[own.drift_i], problem.prior.sd[own.drift_q]]
    return np.array(rows)


def _carried_places(old: Layout, new: Layout) -> FloatArray:
    """Return where each old unknown stands in a layout with more mirrors."""
    out = np.arange(old.size)
    pairs: list[tuple[slice, slice]] = [(old.breaks, new.breaks), (old.planes, new.planes), (old.forward, new.forward)]
    for a, b in zip(old.receivers, new.receivers, strict=True):
        pairs += [(slice(a.phase, a.skew + 1), slice(b.phase, b.skew + 1))]
        pairs += [(a.bias_i, b.bias_i), (a.bias_q, b.bias_q), (a.level, b.level), (a.backward, b.backward)]
        pairs += [(a.ghost, b.ghost), (a.drift_i, b.drift_i), (a.drift_q, b.drift_q)]
    for a, b in pairs:
        out[a] = np.arange(b.start, b.start + a.stop - a.start)
    return out


def _grid(solution: Solution, normal: FloatArray) -> list[MirrorPlane]:
    """Return upright planes around the middle of the motion, azimuth by azimuth."""
    place = solution.at.design @ solution.state.coefficients + solution.problem.stage.release_m
    middle = place.mean(axis=0)
    first = np.cross(normal, np.array([0.0, 1.0, 0.0]))
    first /= np.linalg.norm(first)
    second = np.cross(normal, first)
    out = []
    for azimuth in np.linspace(0.0, 2.0 * np.pi, _AZIMUTHS, endpoint=False):
        outward = np.cos(azimuth) * first + np.sin(azimuth) * second
        for distance in _DISTANCES_M:
            out.append(MirrorPlane(middle + distance * outward, -outward, "wall"))
    return out


def _linearised_gain(solution: Solution, plane: MirrorPlane) -> float:
    """Return g^T A^-1 g / 2 - ln det(A sd^2) / 2, A the Schur complement of the new coefficients, g their slope."""
    posed = add_mirror(solution, plane)
    at = linearise(posed.problem, posed.state)
    columns, slope, curvature, to_motion, to_border = _wall_blocks(solution, posed.problem, at)
    half = solution.normal.motion.half_solve(to_motion)
    border = to_border - solution.normal.half.T @ half
    lower = np.linalg.solve(np.tril(solution.normal.border[0]), border)
    a = curvature - half.T @ half - lower.T @ lower + np.eye(columns) / _COEFFICIENT_SD**2
    sign, log_determinant = np.linalg.slogdet(a)
    if sign <= 0:
        return -np.inf
    return float(0.5 * slope @ np.linalg.solve(a, slope) - 0.5 * log_determinant - columns * np.log(_COEFFICIENT_SD))


def _wall_blocks(
    solution: Solution, problem: JointProblem, at: Linearised
) -> tuple[int, FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return number, slope and curvature of the new mirror's T and R, and their coupling to motion and border."""
    layout, old = problem.layout, solution.problem.layout
    n_receivers, n_bins = problem.n_receivers, problem.bins.n_bins
    n_new = 2 + 2 * n_receivers
    slope, curvature = np.zeros(n_new), np.zeros((n_new, n_new))
    to_border = np.zeros((old.size, n_new))
    pulled = np.zeros((n_bins, 3, n_new))
    first_forward = layout.forward.stop - layout.planes.start - 2
    mirrors = slice(old.planes.start, old.forward.stop)
    for receiver, (signal, before) in enumerate(zip(at.signals, solution.at.signals, strict=True)):
        own = layout.receivers[receiver]
        last = own.backward.stop - own.first
        j = np.zeros((2, n_bins, n_new))
        j[:, :, :2] = signal.by_mirrors[:, :, first_forward : first_forward + 2]
        j[:, :, 2 + 2 * receiver : 4 + 2 * receiver] = signal.by_own[:, :, last - 2 : last]
        pair = slice(2 * receiver, 2 * receiver + 2)
        weight = solution.at.weight[pair]
        weighed = weight[:, :, None] * j
        misfit = before.value - problem.bins.value[pair]
        slope += np.einsum("pnk,pn->k", weighed, misfit)
        curvature += np.einsum("pnk,pnl->kl", weighed, j)
        places = slice(old.receivers[receiver].first, old.receivers[receiver].last)
        flat = weighed.reshape(2 * n_bins, n_new)
        to_border[places] += before.by_own.reshape(2 * n_bins, -1).T @ flat
        to_border[mirrors] += before.by_mirrors.reshape(2 * n_bins, -1).T @ flat
        pulled += np.einsum("pan,pnk->nak", before.by_position, weighed)
    flat = pulled.reshape(3 * n_bins, n_new)
    breaks = solution.at.spline.break_slopes(problem.bins.time_s, solution.state.coefficients)
    if breaks.shape[0]:
        to_border[old.breaks] = breaks.reshape(-1, 3 * n_bins) @ flat
    motion = kron(solution.at.design, eye_array(3), format="csr")
    return n_new, slope, curvature, motion.T @ flat, to_border


def _peaks(gain: FloatArray) -> list[int]:
    """Return the flat indices of the highest few local maxima over azimuth (around) and distance."""
    around = np.maximum(np.roll(gain, 1, axis=0), np.roll(gain, -1, axis=0))
    padded = np.pad(gain, ((0, 0), (1, 1)), constant_values=-np.inf)
    beside = np.maximum(padded[:, :-2], padded[:, 2:])
    top = (gain >= around) & (gain >= beside) & np.isfinite(gain)
    order = np.argsort(np.where(top, gain, -np.inf).ravel())[::-1]
    return [int(k) for k in order[:_CARRIED] if np.isfinite(gain.ravel()[k]) and top.ravel()[k]]
