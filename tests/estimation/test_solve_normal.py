"""The bordered block tridiagonal solver against dense algebra."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from scipy.sparse import csr_matrix, eye_array, kron
from support.normal_blocks import random_blocks

from radargui.estimation.forward.banded_rows import BandedRows
from radargui.estimation.forward.motion_spline import MotionSpline, make_spline
from radargui.estimation.solve.motion_covariance import MotionCovariance
from radargui.estimation.solve.normal import NormalBlocks, Reduced, solve_sparse
from radargui.model.errors import SolveError

LENGTHS = st.lists(st.floats(0.004, 0.3), min_size=1, max_size=8)


def drawn(seed: int, n_rest: int, lengths: list[float]) -> tuple[NormalBlocks, np.ndarray, MotionSpline]:
    edges = np.cumsum([0.0, *lengths])
    # neighbours within a span, and none at all, too
    spline = make_spline(0.0, float(edges[-1]), edges[1:-1])
    return *random_blocks(np.random.default_rng(seed), spline, n_rest), spline


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10**6), st.integers(1, 20), LENGTHS)
def test_bordered_solver_equals_the_dense_one(seed: int, n_rest: int, lengths: list[float]) -> None:
    blocks, dense, spline = drawn(seed, n_rest, lengths)
    n_motion = 3 * spline.size
    normal = Reduced.of(blocks).factor()
    # many vectors block by block, one by LAPACK
    right = np.random.default_rng(seed).standard_normal((len(dense), 14))
    for vector in (right, right[:, 0]):
        found = np.concatenate(normal.solve(vector[:n_motion], vector[n_motion:]))
        assert found == pytest.approx(np.linalg.solve(dense, vector), rel=1e-8, abs=1e-10)
    half = normal.half_solve(right[:n_motion], right[n_motion:])
    assert half.T @ half == pytest.approx(right.T @ np.linalg.solve(dense, right), rel=1e-9)
    assert normal.log_determinant() == pytest.approx(np.linalg.slogdet(dense)[1], rel=1e-9)
    of_global = np.linalg.inv(dense)[n_motion:, n_motion:]
    assert normal.global_variances() == pytest.approx(np.diag(of_global), rel=1e-8)
    some = slice(len(lengths) // 2, len(lengths) // 2 + 3)
    assert normal.global_covariance(some) == pytest.approx(of_global[some, some], rel=1e-8, abs=1e-12)


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 10**6), st.integers(1, 20), LENGTHS)
def test_what_is_added_to_the_diagonal_of_global_parameters_stands_there(
    seed: int, n_rest: int, lengths: list[float]
) -> None:
    blocks, dense, spline = drawn(seed, n_rest, lengths)
    added = np.random.default_rng(seed).uniform(0.0, 3.0, len(blocks.m))
    dense[np.diag_indices(len(dense))] += np.concatenate([np.zeros(3 * spline.size), added])
    found = Reduced.of(blocks).factor(added).global_variances()
    assert found == pytest.approx(np.diag(np.linalg.inv(dense))[3 * spline.size :], rel=1e-8)


def dense_rows(rows: BandedRows) -> np.ndarray:
    return np.asarray(kron(rows.matrix, eye_array(3)).toarray())


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10**6), st.integers(1, 20), LENGTHS)
def test_covariances_of_the_motion_equal_the_dense_ones(seed: int, n_rest: int, lengths: list[float]) -> None:
    blocks, dense, spline = drawn(seed, n_rest, lengths)
    rng, n_breaks, segments = np.random.default_rng(seed), spline.break_s.size, spline.segments
    rows = spline.rows(np.sort(rng.uniform(0.0, spline.edge_s[-1], 30)))
    # neighbours, some of them of the next segment, the first beside the release
    last = np.append(segments.joint, segments.size)
    near = np.minimum(rows.first + 3, last[np.minimum(segments.of(rows.first) + 1, n_breaks)] - 3)
    shared = segments.of(near + 3) != segments.of(near)
    near = np.where(shared & (near + 3 > last[segments.of(near)]), last[segments.of(near)] - 3, near)
    others = BandedRows(rng.standard_normal(rows.value.shape), near, rows.size)
    by_breaks = rng.standard_normal((30, 3, 2))
    inverse = np.linalg.inv(dense)
    one, other = (np.hstack([dense_rows(each), np.zeros((90, len(blocks.m)))]) for each in (rows, others))
    both = one.copy()
    for row, segment in enumerate(segments.of(rows.first)):
        for side in range(2):
            if 0 <= segment - 1 + side < n_breaks:
                both[3 * row : 3 * row + 3, 3 * spline.size + segment - 1 + side] = by_breaks[row, :, side]
    covariance = MotionCovariance(Reduced.of(blocks).factor())
    for found, left, right in (
        (covariance.of(rows), one, one),
        (covariance.of(rows, others), one, other),
        (covariance.of(rows, by_breaks=by_breaks), both, both),
    ):
        wanted = (left @ inverse @ right.T).reshape(30, 3, 30, 3)[np.arange(30), :, np.arange(30)]
        assert found == pytest.approx(wanted, rel=1e-8, abs=1e-10 * np.abs(wanted).max())


@pytest.mark.parametrize("fault", ["motion", "break", "global", "not a number"])
def test_what_is_not_positive_definite_raises_the_solvers_own_error(fault: str) -> None:
    blocks, _, _ = drawn(6, 3, [0.1, 0.1])
    if fault == "motion":
        blocks.band[0] -= 1e3
    elif fault == "break":
        blocks.m[0, 0] -= 1e3
    elif fault == "global":
        blocks.m[2, 2] -= 1e3
    else:
        blocks.m[:] += np.nan
    with pytest.raises(SolveError, match=r"not positive definite|not finite"):
        Reduced.of(blocks).factor()


def test_a_singular_sparse_system_raises_the_solvers_own_error() -> None:
    assert solve_sparse(csr_matrix(np.diag([2.0, 4.0])), np.array([1.0, 1.0])) == pytest.approx([0.5, 0.25])
    with pytest.raises(SolveError, match="singular"):
        solve_sparse(csr_matrix((2, 2)), np.ones(2))
