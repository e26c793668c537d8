"""Walls that reflect: searched over azimuth and distance where the misfit asks for them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import solve_triangular
from scipy.sparse import csr_matrix, eye_array, kron

from radargui.correction.adaptive.rounds import Ground
from radargui.correction.joint.layout import Prior
from radargui.correction.joint.minimise import Solution, log_evidence
from radargui.correction.joint.mirrors import WALL, MirrorPlane, detour_ratio
from radargui.correction.joint.problem import JointProblem, State, assemble, linearise
from radargui.correction.joint.repose import carried_places, repose
from radargui.correction.joint.rounds import converge, positions
from radargui.correction.joint.signal_model import FrontEnd, field_at_nodes
from radargui.correction.joint.signal_slopes import receiver_slopes
from radargui.model.arrays import FloatArray

_AZIMUTHS, _DISTANCES_M = 40, (0.08, 0.11, 0.14, 0.17, 0.20)
_FINE_RAD, _FINE_M, _NEAREST_M = np.radians(np.arange(-16.0, 17.0, 4.0)), np.arange(-0.03, 0.031, 0.01), 0.05
_CARRIED, _CARRIED_AGAIN = 4, 2
_STIFF_BIAS, _STIFF_LEVEL = 0.003, 0.07
_COEFFICIENT_SD = 0.03
_U_AZIMUTH = 0.15
_ROUNDS = 3
_SEARCHES, _WORTHWHILE, _PROMISING = 4, 2.0, 3.0


@dataclass(frozen=True)
class WallSearch:
    """What was found.

    Attributes
    ----------
    tried
        Converged solutions with one more wall, each with what it gains in log evidence; the best first.
    """

    tried: tuple[tuple[Solution, float], ...]

    @property
    def gain(self) -> float:
        """What the best wall gains, -inf where none was tried."""
        return self.tried[0][1] if self.tried else -np.inf


def search_wall(
    ground: Ground, solution: Solution, normal: FloatArray, tick: Callable[[], None], *, thorough: bool
) -> WallSearch:
    """Search one more wall over azimuth and distance.

    Every wall of a grid gets its linearised evidence with everything else marginalised; the best few are converged,
    because the linearised ranking is not reliable. The search is repeated, finer, around what was found, as long as
    that gains: a motion bent by a wall that is not in the model hides where the wall stands.

    Parameters
    ----------
    ground, solution
        Data; the model without the wall, converged.
    normal
        Upward normal of the floor, shape (3,).
    tick
        Called once a round; may raise to cancel.
    thorough
        False: converge fewer, and stop after the coarse search unless it finds something.
    """
    mirrors, middle = solution.problem.stage.planes, positions(ground, solution).mean(axis=1)
    azimuth, distance = np.linspace(0.0, 2.0 * np.pi, _AZIMUTHS, endpoint=False), np.array(_DISTANCES_M)
    # evidence moves while priors are re-estimated: the model without the wall goes through the same rounds
    without = log_evidence(converge(ground, repose(solution, mirrors), _ROUNDS, tick))
    base, tried = solution, WallSearch(())
    for number in range(_SEARCHES):
        planes = _upright(middle, normal, azimuth, distance)
        numbers = _peaks(_gains(base, planes, tick), around=number == 0)[
            : _CARRIED if thorough and number == 0 else _CARRIED_AGAIN
        ]
        trials = [converge(ground, repose(base, (*mirrors, planes[k])), _ROUNDS, tick) for k in numbers]
        before, more = tried.gain, [(trial, log_evidence(trial) - without) for trial in trials]
        tried = WallSearch(tuple(sorted([*tried.tried, *more], key=lambda one: -one[1])))
        if tried.gain < before + _WORTHWHILE or not (thorough or tried.gain > _PROMISING):
            break
        best = tried.tried[0][0]
        base = _without_last_mirror(best, solution.problem)
        found = _place_of_last(best, middle, normal)
        azimuth, distance = found[0] + _FINE_RAD, np.maximum(found[1] + _FINE_M, _NEAREST_M)
    return tried


def _gains(solution: Solution, planes: list[MirrorPlane], tick: Callable[[], None]) -> FloatArray:
    search, gains = _LinearisedSearch(solution), []
    for number, plane in enumerate(planes):
        if number % 20 == 0:
            tick()
        gains.append(search.gain(plane))
    return np.array(gains)


def _without_last_mirror(solution: Solution, problem: JointProblem) -> Solution:
    """Return a solution's state in the problem that lacks its last mirror: not a minimum, a place to search from."""
    place, there = carried_places(problem.layout, solution.problem.layout)
    theta = np.zeros(problem.layout.size)
    theta[place] = solution.state.theta[there]
    state = State(solution.state.coefficients, theta)
    bare = replace(problem, spline=solution.problem.spline)
    at = linearise(bare, state)
    return Solution(bare, state, at, assemble(bare, state, at).factor(), False)


def _tangents(normal: FloatArray) -> tuple[FloatArray, FloatArray]:
    first = np.cross(normal, np.array([0.0, 1.0, 0.0]))
    first /= np.linalg.norm(first)
    return first, np.cross(normal, first)


def _upright(
    middle_m: FloatArray, normal: FloatArray, azimuth_rad: FloatArray, distance_m: FloatArray
) -> list[MirrorPlane]:
    """Return planes along the floor's normal around the middle of the motion, azimuth by azimuth."""
    first, second = _tangents(normal)
    out = []
    for angle in azimuth_rad:
        outward = np.cos(angle) * first + np.sin(angle) * second
        out += [MirrorPlane(middle_m + away * outward, -outward, WALL, _U_AZIMUTH) for away in distance_m]
    return out


def _place_of_last(solution: Solution, middle_m: FloatArray, normal: FloatArray) -> tuple[float, float]:
    """Return azimuth and distance of a solution's last mirror."""
    problem = solution.problem
    unknown = solution.state.theta[problem.layout.planes][-3:]
    outward = problem.stage.planes[-1].image(middle_m, unknown) - middle_m
    first, second = _tangents(normal)
    return float(np.arctan2(outward @ second, outward @ first)), 0.5 * float(np.linalg.norm(outward))


class _LinearisedSearch:
    """What a new mirror would explain of the residuals with everything else marginalised, computed once a solution."""

    def __init__(self, solution: Solution) -> None:
        self.solution, problem = solution, solution.problem
        stiff = _stiffened(problem)
        assembled = assemble(stiff, solution.state, solution.at)
        self.normal = assembled.factor()
        self.half_slope = self.normal.motion.half_solve(assembled.slope_motion[:, None])
        self.lower_slope = solve_triangular(
            self.normal.border[0],
            assembled.slope_border[:, None] - self.normal.half.T @ self.half_slope,
            lower=True,
            check_finite=False,
        )
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
        mirrors = old.mirrors
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
            to_border[own.first : own.drift_i.start] += before.by_own.reshape(2 * self.n_bins, -1).T @ flat
            to_border[own.drift_i] += stage.drift.T @ weighed[0]
            to_border[own.drift_q] += stage.drift.T @ weighed[1]
            to_border[mirrors] += before.by_mirrors.reshape(2 * self.n_bins, -1).T @ flat
            for part in range(2):
                pulled += before.by_position[part].T[:, :, None] * weighed[part][:, None, :]
        pull = pulled.reshape(3 * self.n_bins, n_new)
        to_border[old.breaks] = self.breaks @ pull
        normal = self.normal
        half = normal.motion.half_solve(self.motion @ pull)
        lower = solve_triangular(normal.border[0], to_border - normal.half.T @ half, lower=True, check_finite=False)
        a = curvature - half.T @ half - lower.T @ lower + np.eye(n_new) / _COEFFICIENT_SD**2
        slope = slope - (half.T @ self.half_slope + lower.T @ self.lower_slope)[:, 0]
        sign, log_determinant = np.linalg.slogdet(a)
        if sign <= 0:
            return -np.inf
        return float(0.5 * slope @ np.linalg.solve(a, slope) - 0.5 * log_determinant - n_new * np.log(_COEFFICIENT_SD))


def _stiffened(problem: JointProblem) -> JointProblem:
    """Return the problem with maps as stiff as if nothing were left to explain.

    Maps that have grown to explain a wall would hide it.
    """
    sd = problem.prior.sd.copy()
    for own in problem.layout.receivers:
        for places, most in ((own.bias_i, _STIFF_BIAS), (own.bias_q, _STIFF_BIAS), (own.level, _STIFF_LEVEL)):
            sd[places] = np.minimum(sd[places], most)
    prior = Prior(problem.prior.mean, sd, problem.prior.groups)
    return replace(problem, prior=prior)


def _peaks(gain: FloatArray, *, around: bool) -> list[int]:
    """Return the flat indices of the local maxima, the highest first.

    Parameters
    ----------
    gain
        Flat, azimuth by azimuth.
    around
        Whether the azimuths go round.
    """
    table = gain.reshape(_AZIMUTHS if around else _FINE_RAD.size, -1)
    wide = (
        np.pad(table, ((1, 1), (0, 0)), mode="wrap")
        if around
        else np.pad(table, ((1, 1), (0, 0)), constant_values=-np.inf)
    )
    high = np.pad(table, ((0, 0), (1, 1)), constant_values=-np.inf)
    beside = np.maximum(np.maximum(wide[:-2], wide[2:]), np.maximum(high[:, :-2], high[:, 2:]))
    top = ((table >= beside) & np.isfinite(table)).ravel()
    return [int(k) for k in np.argsort(np.where(top, gain, -np.inf))[::-1] if top[k]]
