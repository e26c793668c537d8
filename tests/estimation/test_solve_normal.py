"""The bordered block tridiagonal solver against dense algebra."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from scipy.sparse import csr_matrix, eye_array, kron

from radargui.estimation.forward.motion_spline import make_spline
from radargui.estimation.solve.normal import BlockTridiagonal, NormalMatrix, solve_sparse
from radargui.model.errors import SolveError


def random_blocks(seed: int, n_global: int, length: float) -> tuple[csr_matrix, np.ndarray, np.ndarray, csr_matrix]:
    rng = np.random.default_rng(seed)
    spline = make_spline(0.0, length, np.array([0.4 * length]))
    design = kron(spline.design(np.sort(rng.uniform(0, length, 400))), eye_array(3), format="csr")
    s = csr_matrix(design.T @ design + 0.1 * eye_array(design.shape[1]))
    return s, 0.01 * rng.standard_normal((s.shape[0], n_global)), np.eye(n_global) * 5.0, csr_matrix(design)


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 10**6), st.integers(1, 9), st.floats(0.08, 0.9))
def test_bordered_solver_equals_the_dense_one(seed: int, n_global: int, length: float) -> None:
    s, c, m, design = random_blocks(seed, n_global, length)
    dense = np.block([[s.toarray(), c], [c.T, m]])
    normal = NormalMatrix.factor(s, c, m)
    count = s.shape[0]
    right = np.random.default_rng(seed).standard_normal(dense.shape[0])
    found = np.concatenate(normal.solve(right[:count], right[count:]))
    assert found == pytest.approx(np.linalg.solve(dense, right), rel=1e-8, abs=1e-10)
    assert normal.log_determinant() == pytest.approx(np.linalg.slogdet(dense)[1], rel=1e-9)
    inverse = np.linalg.inv(dense)
    assert normal.global_variances() == pytest.approx(np.diag(inverse)[count:], rel=1e-8)
    wanted = np.einsum("ij,jk,ik->i", design.toarray(), inverse[:count, :count], design.toarray())
    assert normal.row_variances([design])[0] == pytest.approx(wanted, rel=1e-8)


def test_variances_of_rows_that_act_on_global_parameters_too_equal_the_dense_ones() -> None:
    s, c, m, design = random_blocks(3, 6, 0.3)
    rng = np.random.default_rng(4)
    some = slice(1, 4)
    by_global = csr_matrix(rng.standard_normal((design.shape[0], 3)))
    inverse = np.linalg.inv(np.block([[s.toarray(), c], [c.T, m]]))
    rows = np.zeros((design.shape[0], inverse.shape[0]))
    rows[:, : s.shape[0]] = design.toarray()
    rows[:, s.shape[0] + some.start : s.shape[0] + some.stop] = by_global.toarray()
    found = NormalMatrix.factor(s, c, m).row_variances([design], [by_global], some)[0]
    assert found == pytest.approx(np.einsum("ij,jk,ik->i", rows, inverse, rows), rel=1e-8)


def test_the_selected_inverse_holds_the_blocks_beside_the_diagonal() -> None:
    s, _, _, _ = random_blocks(5, 1, 0.5)
    selected = BlockTridiagonal(s).selected_inverse().toarray()[: s.shape[0], : s.shape[0]]
    inverse = np.linalg.inv(s.toarray())
    kept = selected != 0.0
    assert kept.mean() < 0.9
    assert selected[kept] == pytest.approx(inverse[kept], rel=1e-7, abs=1e-12)


@pytest.mark.parametrize("fault", ["motion", "global", "not a number"])
def test_what_is_not_positive_definite_raises_the_solvers_own_error(fault: str) -> None:
    s, c, m, _ = random_blocks(6, 3, 0.2)
    if fault == "motion":
        s = csr_matrix(s - 1e3 * eye_array(s.shape[0]))
    elif fault == "global":
        m = m - 1e3 * np.eye(3)
    else:
        m = m + np.nan
    with pytest.raises(SolveError, match=r"not positive definite|not finite"):
        NormalMatrix.factor(s, c, m)


def test_a_singular_sparse_system_raises_the_solvers_own_error() -> None:
    assert solve_sparse(csr_matrix(np.diag([2.0, 4.0])), np.array([1.0, 1.0])) == pytest.approx([0.5, 0.25])
    with pytest.raises(SolveError, match="singular"):
        solve_sparse(csr_matrix((2, 2)), np.ones(2))
