"""Walls that reflect: searched over azimuth and distance where the misfit asks for them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy.linalg import solve_triangular
from scipy.sparse import csr_matrix, eye_array, kron

from radargui.correction.adaptive.rounds import Ground
from radargui.correction.joint.first_state import Posed
from radargui.correction.joint.layout import Layout, make_layout, make_prior
from radargui.correction.joint.minimise import Solution, log_evidence
from radargui.correction.joint.mirrors import MirrorPlane, detour_ratio
from radargui.correction.joint.problem import JointProblem, State
from radargui.correction.joint.rounds import converge
from radargui.correction.joint.signal_model import FrontEnd, field_at_nodes
from radargui.correction.joint.signal_slopes import receiver_slopes
from radargui.model.arrays import FloatArray, IntArray

_AZIMUTHS, _DISTANCES_M = 40, (0.08, 0.11, 0.14, 0.17, 0.20)
_CARRIED = 2
_COEFFICIENT_SD = 0.03
_ROUNDS = 3


def search_wall(
    ground: Ground, solution: Solution, normal: FloatArray, tick: Callable[[], None]
) -> tuple[Solution, float]:
    """Return the best solution with one more wall and what it gains in log evidence.

    Every wall of a grid gets its linearised evidence with everything else marginalised; the best two are converged,
    because the linearised ranking is not reliable.
    """
    candidates = _grid(solution, normal)
    search, gains = _LinearisedSearch(solution), []
    for number, plane in enumerate(candidates):
        if number % 20 == 0:
            tick()
        gains.append(search.gain(plane))
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
        layout,
        old_problem.prior.mean[old.breaks],
        np.array([old_problem.prior.mean[own.log_amplitude] for own in old.receivers]),
        _drift_sd(old_problem),
    )
    for before, after in zip(old.receivers, layout.receivers, strict=True):
        for a, b in ((before.log_gain, after.log_gain), (before.skew, after.skew)):
            prior.mean[b], prior.sd[b] = old_problem.prior.mean[a], old_problem.prior.sd[a]
    stage = replace(old_problem.stage, planes=(*old_problem.stage.planes, plane))
    spline = solution.at.spline
    problem = replace(old_problem, layout=layout, prior=prior, stage=stage, spline=spline)
    return Posed(problem, State(solution.state.coefficients, new_theta))


def _drift_sd(problem: JointProblem) -> FloatArray:
    rows = []
    for own in problem.layout.receivers:
        rows += [problem.prior.sd[own.drift_i], problem.prior.sd[own.drift_q]]
    return np.array(rows)


def _carried_places(old: Layout, new: Layout) -> IntArray:
    """Return where each old unknown stands in a layout with more mirrors."""
    out = np.arange(old.size)
    pairs: list[tuple[slice, slice]] = [(old.breaks, new.breaks), (old.planes, new.planes), (old.forward, new.forward)]
    for own, now in zip(old.receivers, new.receivers, strict=True):
        pairs += [(slice(own.phase, own.skew + 1), slice(now.phase, now.skew + 1))]
        pairs += [(own.bias_i, now.bias_i), (own.bias_q, now.bias_q), (own.level, now.level)]
        pairs += [(own.backward, now.backward), (own.ghost, now.ghost)]
        pairs += [(own.drift_i, now.drift_i), (own.drift_q, now.drift_q)]
    for before, after in pairs:
        out[before] = np.arange(after.start, after.start + before.stop - before.start)
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
        out += [MirrorPlane(middle + distance * outward, -outward, "wall") for distance in _DISTANCES_M]
    return out


class _LinearisedSearch:
    """What a new mirror would explain of the residuals with everything else marginalised, computed once a solution."""

    def __init__(self, solution: Solution) -> None:
        self.solution, problem = solution, solution.problem
        self.n_bins, self.n_receivers = problem.bins.n_bins, problem.n_receivers
        self.motion = csr_matrix(kron(solution.at.design, eye_array(3), format="csr")).T
        self.breaks = solution.at.spline.break_slopes(problem.bins.time_s, solution.state.coefficients).T
        theta, layout, stage = solution.state.theta, problem.layout, problem.stage
        self.nodes = [solution.at.node_m[:, 2 * n : 2 * n + 2] for n in range(self.n_receivers)]
        self.fields = [field_at_nodes(node, theta, layout, stage, n) for n, node in enumerate(self.nodes)]
        self.slopes = [receiver_slopes(node, theta, layout, stage, n) for n, node in enumerate(self.nodes)]

    def gain(self, plane: MirrorPlane) -> float:
        """Return g^T A^-1 g / 2 - ln det(A sd^2) / 2, A the Schur complement of T and R, g their slope."""
        n_new = 2 + 2 * self.n_receivers
        problem, at = self.solution.problem, self.solution.at
        old, stage = problem.layout, problem.stage
        slope, curvature = np.zeros(n_new), np.zeros((n_new, n_new))
        to_border = np.zeros((old.size, n_new))
        pulled = np.zeros((self.n_bins, 3, n_new))
        mirrors = slice(old.planes.start, old.forward.stop)
        for receiver, before in enumerate(self.slopes):
            own = old.receivers[receiver]
            front, j = FrontEnd(self.solution.state.theta, own), np.zeros((2, self.n_bins, n_new))
            antennas = stage.antennas.transmitter_m, stage.antennas.receivers_m[receiver]
            for first, antenna in zip((0, 2 + 2 * receiver), antennas, strict=True):
                ratio = detour_ratio(
                    self.nodes[receiver], antenna, plane, np.zeros(3), stage.release_m, stage.wavenumber
                )
                z = (self.fields[receiver] * ratio).mean(axis=1)
                j[:, :, first], j[:, :, first + 1] = front(z), front(1j * z)
            pair = slice(2 * receiver, 2 * receiver + 2)
            weighed = at.weight[pair][:, :, None] * j
            misfit = at.signals[receiver].value - problem.bins.value[pair]
            slope += np.einsum("pnk,pn->k", weighed, misfit)
            flat = weighed.reshape(2 * self.n_bins, n_new)
            curvature += flat.T @ j.reshape(2 * self.n_bins, n_new)
            to_border[own.first : own.last] += before.by_own.reshape(2 * self.n_bins, -1).T @ flat
            to_border[mirrors] += before.by_mirrors.reshape(2 * self.n_bins, -1).T @ flat
            for part in range(2):
                pulled += before.by_position[part].T[:, :, None] * weighed[part][:, None, :]
        pull = pulled.reshape(3 * self.n_bins, n_new)
        to_border[old.breaks] = self.breaks @ pull
        normal = self.solution.normal
        half = normal.motion.half_solve(self.motion @ pull)
        lower = solve_triangular(normal.border[0], to_border - normal.half.T @ half, lower=True, check_finite=False)
        a = curvature - half.T @ half - lower.T @ lower + np.eye(n_new) / _COEFFICIENT_SD**2
        sign, log_determinant = np.linalg.slogdet(a)
        if sign <= 0:
            return -np.inf
        return float(0.5 * slope @ np.linalg.solve(a, slope) - 0.5 * log_determinant - n_new * np.log(_COEFFICIENT_SD))


def _peaks(gain: FloatArray) -> list[int]:
    """Return the flat indices of the highest few local maxima over azimuth (around) and distance."""
    around = np.maximum(np.roll(gain, 1, axis=0), np.roll(gain, -1, axis=0))
    padded = np.pad(gain, ((0, 0), (1, 1)), constant_values=-np.inf)
    beside = np.maximum(padded[:, :-2], padded[:, 2:])
    top = (gain >= around) & (gain >= beside) & np.isfinite(gain)
    order = np.argsort(np.where(top, gain, -np.inf).ravel())[::-1]
    return [int(k) for k in order[:_CARRIED] if np.isfinite(gain.ravel()[k]) and top.ravel()[k]]
