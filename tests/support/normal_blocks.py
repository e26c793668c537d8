"""Normal matrices drawn at random with the structure of the joint problem, and the same written out."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_matrix, eye_array, kron

from radargui.estimation.forward.motion_spline import MotionSpline
from radargui.estimation.solve.block_tridiagonal import lower_band
from radargui.estimation.solve.normal import NormalBlocks


def random_blocks(
    rng: np.random.Generator, spline: MotionSpline, n_rest: int, coupling: float = 0.02
) -> tuple[NormalBlocks, np.ndarray]:
    """Return blocks for a spline with its breaks and `n_rest` other global parameters, and the dense matrix."""
    n_breaks, segments = spline.break_s.size, spline.segments
    time_s = np.sort(rng.uniform(spline.edge_s[0], spline.edge_s[-1], 400))
    design = kron(spline.design(time_s), eye_array(3), format="csr")
    s = csr_matrix(design.T @ design + 0.1 * eye_array(design.shape[1]))
    beside = coupling * rng.standard_normal((segments.n_functions, 3, 2))
    c = coupling * rng.standard_normal((s.shape[0], n_rest))
    m = 5.0 * np.eye(n_breaks + n_rest)
    m[n_breaks:, :n_breaks] = coupling * rng.standard_normal((n_rest, n_breaks))
    m[:n_breaks, n_breaks:] = m[n_breaks:, :n_breaks].T
    for k in range(n_breaks - 1):
        m[k, k + 1] = m[k + 1, k] = coupling * rng.standard_normal()
    by_breaks = np.zeros((s.shape[0], n_breaks))
    for function, (segment, coefficient) in enumerate(zip(segments.segment, segments.coefficient, strict=True)):
        if coefficient == 0:
            continue
        for side in range(2):
            if 0 <= segment - 1 + side < n_breaks:
                rows = slice(3 * coefficient - 3, 3 * coefficient)
                by_breaks[rows, segment - 1 + side] += beside[function, :, side]
    whole = np.concatenate([by_breaks, c], axis=1)
    lower, band = lower_band(s), np.zeros((12, s.shape[0]))
    band[: len(lower)] = lower
    return NormalBlocks(band, beside, c, m, segments), np.block([[s.toarray(), whole], [whole.T, m]])
