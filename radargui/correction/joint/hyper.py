"""Deviations of the priors re-estimated from the posterior (MacKay 1992), and the noise scale from the misfit."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
from scipy.ndimage import gaussian_filter1d
from scipy.sparse import eye_array, kron

from radargui.correction.joint.layout import Prior
from radargui.correction.joint.minimise import Solution, local_chi_square
from radargui.correction.joint.motion_spline import MotionSpline
from radargui.correction.joint.problem import JointProblem
from radargui.model.arrays import FloatArray

_LOWEST_JERK, _HIGHEST_JERK = 0.3, 1e5
_LARGEST_CHANGE = 10.0
_WINDOW_SPANS = 3.0
_LARGEST_NOISE_STEP = 1.3


def update_priors(solution: Solution) -> JointProblem:
    """Return the problem with map, mirror and jerk deviations re-estimated from a solution."""
    problem = solution.problem
    variance = solution.normal.border_variances()
    old = problem.prior
    sd = old.sd.copy()
    for index, lowest, highest in old.groups:
        w = solution.state.theta[index] - old.mean[index]
        determined = max(index.size - float((variance[index] / sd[index] ** 2).sum()), 1e-2)
        sd[index] = _limited(float(np.sqrt((w @ w) / determined)), float(sd[index[0]]), lowest, highest)
    prior = Prior(old.mean, sd, old.groups)
    return replace(problem, prior=prior, jerk_sd=_jerk_deviation(solution))


def _limited(new: float, old: float, lowest: float, highest: float) -> float:
    return float(np.clip(np.clip(new, old / _LARGEST_CHANGE, old * _LARGEST_CHANGE), lowest, highest))


def _jerk_deviation(solution: Solution) -> FloatArray:
    """Return sd = sqrt(sum j^2 / number well determined) in a window of spans that no break divides.

    Nor does the end of the release: its jerk is no reason to let the fall bend.
    """
    problem, spline = solution.problem, solution.at.spline
    matrix, middle, _ = spline.jerk()
    value = matrix @ solution.state.coefficients
    variance = solution.normal.row_variances([kron(matrix, eye_array(3), format="csr")])[0].reshape(-1, 3)
    square = (value**2).sum(axis=1)
    determined = np.clip(3.0 - variance.sum(axis=1) / problem.jerk_sd**2, 0.0, 3.0)
    out = np.empty_like(square)
    for part in spans_together(spline, middle, problem.settled_s):
        top = gaussian_filter1d(square[part], _WINDOW_SPANS, mode="nearest", truncate=2.0)
        low = gaussian_filter1d(determined[part], _WINDOW_SPANS, mode="nearest", truncate=2.0)
        out[part] = np.sqrt((top + 1e-3) / np.maximum(low, 1e-2))
    old = problem.jerk_sd
    limited = np.clip(out, old / _LARGEST_CHANGE, old * _LARGEST_CHANGE)
    return np.asarray(np.clip(limited, _LOWEST_JERK, _HIGHEST_JERK))


def spans_together(spline: MotionSpline, middle_s: FloatArray, settled_s: float) -> list[slice]:
    """Return the runs of spans that no break and not the end of the release divide.

    Parameters
    ----------
    spline, middle_s
        The motion and the middles of its spans.
    settled_s
        From here on the release is over.
    """
    ends = set(np.cumsum(spline.spans).tolist()) | {int(np.searchsorted(middle_s, settled_s))}
    edges = sorted(ends | {0, middle_s.size})
    return [slice(first, last) for first, last in pairwise(edges) if last > first]


def update_noise(solution: Solution) -> JointProblem:
    """Return the problem with each receiver's noise scaled up where the misfit asks for it.

    The median over the record counts, so that a short misfit (unresolved bounces) does not spoil the rest.
    """
    typical = np.median(local_chi_square(solution), axis=1)
    wanted = np.sqrt(np.maximum(typical, 1.0))
    return replace(solution.problem, noise_scale=np.minimum(wanted, _LARGEST_NOISE_STEP * solution.problem.noise_scale))
