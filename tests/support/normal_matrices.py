"""Normal matrices drawn at random with the structure of the joint problem, and written out; one of even weights."""

from __future__ import annotations

import numpy as np
from scipy.sparse import eye_array, kron

from radargui.estimation.forward.motion_spline import MotionSpline
from radargui.estimation.posterior.flight_information import Eliminated, MotionInformation, QuadraticForm
from radargui.estimation.posterior.free_motion import FreeMotion
from radargui.estimation.solve.normal import WIDTH, NormalMatrix


def dense_normal(normal: NormalMatrix) -> np.ndarray:
    """Return a normal matrix written out."""
    band, n = normal.band, len(normal.coupling)
    lower = sum(np.diag(band[below, : n - below], -below) for below in range(min(WIDTH, n)))
    motion = lower + np.tril(lower, -1).T
    return np.block([[motion, normal.coupling], [normal.coupling.T, normal.corner]])


def random_normal(
    rng: np.random.Generator, spline: MotionSpline, n_global: int, coupling: float = 0.02
) -> NormalMatrix:
    """Return a matrix for a spline with its breaks and so many global parameters in all."""
    time_s = np.sort(rng.uniform(spline.edge_s[0], spline.edge_s[-1], 400))
    design = kron(spline.design(time_s), eye_array(3), format="csr")
    motion = (design.T @ design + 0.1 * eye_array(design.shape[1])).toarray()
    band = np.zeros((WIDTH, len(motion)))
    for below in range(min(WIDTH, len(motion))):
        band[below, : len(motion) - below] = np.diagonal(motion, -below)
    corner = coupling * rng.standard_normal((n_global, n_global))
    corner = 5.0 * np.eye(n_global) + corner + corner.T
    return NormalMatrix(band, coupling * rng.standard_normal((len(motion), n_global)), corner)


def even_information(free: FreeMotion, weight: float) -> MotionInformation:
    """Return what samples say that know all coefficients of a motion, and the time of its one break, alike."""
    x0 = np.concatenate([free.motion.coefficients.ravel(), free.motion.spline.break_s])
    n_motion, lost = x0.size - 1, np.zeros((x0.size, 1))
    band = np.zeros((WIDTH, n_motion))
    band[0] = weight
    form = QuadraticForm(NormalMatrix(band, np.zeros((n_motion, 2)), np.diag([weight, 1.0])), lost)
    eliminated = Eliminated(n_motion, n_motion, 1, None, np.eye(1), lost)
    return MotionInformation(free, free.motion.spline.size, 1, x0, form, np.zeros(x0.size), eliminated)
