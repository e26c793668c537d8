"""The bordered block tridiagonal solver against dense algebra."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from scipy.sparse import csr_matrix, eye_array, kron

from radargui.estimation.forward.banded_rows import BandedRows
from radargui.estimation.forward.motion_spline import make_spline
from radargui.estimation.solve.motion_covariance import MotionCovariance
from radargui.estimation.solve.normal import Reduced, lower_band, solve_sparse
from radargui.model.errors import SolveError


def random_blocks(seed: int, n_global: int, length: float) -> tuple[csr_matrix, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    spline = make_spline(0.0, length, np.array([0.4 * length]))
    design = kron(spline.design(np.sort(rng.uniform(0, length, 400))), eye_array(3), format="csr")
    s = csr_matrix(design.T @ design + 0.1 * eye_array(design.shape[1]))
    return s, 0.01 * rng.standard_normal((s.shape[0], n_global)), np.eye(n_global) * 5.0


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 10**6), st.integers(1, 9), st.floats(0.08, 0.9))
def test_bordered_solver_equals_the_dense_one(seed: int, n_global: int, length: float) -> None:
    s, c, m = random_blocks(seed, n_global, length)
    dense = np.block([[s.toarray(), c], [c.T, m]])
    normal = Reduced.of(lower_band(s), c, m).factor()
    count = s.shape[0]
    right = np.random.default_rng(seed).standard_normal(dense.shape[0])
    found = np.concatenate(normal.solve(right[:count], right[count:]))
    assert found == pytest.approx(np.linalg.solve(dense, right), rel=1e-8, abs=1e-10)
    assert normal.log_determinant() == pytest.approx(np.linalg.slogdet(dense)[1], rel=1e-9)
    inverse = np.linalg.inv(dense)
    assert normal.global_variances() == pytest.approx(np.diag(inverse)[count:], rel=1e-8)


def dense_rows(rows: BandedRows) -> np.ndarray:
    return np.asarray(kron(rows.matrix, eye_array(3)).toarray())


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 10**6), st.integers(1, 9), st.floats(0.08, 0.9))
def test_covariances_of_the_motion_equal_the_dense_ones(seed: int, n_global: int, length: float) -> None:
    s, c, m = random_blocks(seed, n_global, length)
    rng, spline = np.random.default_rng(seed), make_spline(0.0, length, np.array([0.4 * length]))
    rows = spline.rows(np.sort(rng.uniform(0.0, length, 30)))
    # neighbours, some of them of the next span, the first beside the release
    others = BandedRows(rng.standard_normal(rows.value.shape), np.minimum(rows.first + 3, spline.size - 3), rows.size)
    some = slice(n_global // 2, min(n_global // 2 + 3, n_global))
    by_global = csr_matrix(rng.standard_normal((90, some.stop - some.start)))
    inverse = np.linalg.inv(np.block([[s.toarray(), c], [c.T, m]]))
    one, other = (np.hstack([dense_rows(each), np.zeros((90, n_global))]) for each in (rows, others))
    both = one.copy()
    both[:, s.shape[0] :][:, some] = by_global.toarray()
    covariance = MotionCovariance(Reduced.of(lower_band(s), c, m).factor())
    for found, left, right in (
        (covariance.of(rows), one, one),
        (covariance.of(rows, others), one, other),
        (covariance.of(rows, by_global=by_global, places=some), both, both),
    ):
        dense = (left @ inverse @ right.T).reshape(30, 3, 30, 3)
        wanted = dense[np.arange(30), :, np.arange(30)]
        assert found == pytest.approx(wanted, rel=1e-8, abs=1e-10 * np.abs(wanted).max())


@pytest.mark.parametrize("fault", ["motion", "global", "not a number"])
def test_what_is_not_positive_definite_raises_the_solvers_own_error(fault: str) -> None:
    s, c, m = random_blocks(6, 3, 0.2)
    if fault == "motion":
        s = csr_matrix(s - 1e3 * eye_array(s.shape[0]))
    elif fault == "global":
        m = m - 1e3 * np.eye(3)
    else:
        m = m + np.nan
    with pytest.raises(SolveError, match=r"not positive definite|not finite"):
        Reduced.of(lower_band(s), c, m).factor()


def test_a_singular_sparse_system_raises_the_solvers_own_error() -> None:
    assert solve_sparse(csr_matrix(np.diag([2.0, 4.0])), np.array([1.0, 1.0])) == pytest.approx([0.5, 0.25])
    with pytest.raises(SolveError, match="singular"):
        solve_sparse(csr_matrix((2, 2)), np.ones(2))
