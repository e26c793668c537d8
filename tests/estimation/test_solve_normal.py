"""The band with its border against dense algebra."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from scipy.sparse import eye_array, kron
from support.normal_matrices import dense_normal, random_normal

from radargui.estimation.forward.banded_rows import BandedRows
from radargui.estimation.forward.motion_spline import MotionSpline, make_spline
from radargui.estimation.solve.normal import NormalMatrix, band_times, solve_band
from radargui.model.errors import SolveError

LENGTHS = st.lists(st.floats(0.004, 0.1), min_size=1, max_size=8)


def drawn(seed: int, n_rest: int, lengths: list[float]) -> tuple[NormalMatrix, MotionSpline]:
    edges = np.cumsum([0.0, *lengths])
    # neighbours within a span, and none at all, too
    spline = make_spline(0.0, float(edges[-1]), edges[1:-1])
    return random_normal(np.random.default_rng(seed), spline, n_rest + len(lengths) - 1), spline


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10**6), st.integers(1, 20), LENGTHS)
def test_the_bordered_band_is_solved_as_the_dense_matrix_is(seed: int, n_rest: int, lengths: list[float]) -> None:
    normal, spline = drawn(seed, n_rest, lengths)
    whole, factored, n_motion = dense_normal(normal), normal.factor(), 3 * spline.size
    right = np.random.default_rng(seed).standard_normal((len(whole), 14))
    for vector in (right, right[:, 0]):
        assert factored.solve(vector) == pytest.approx(np.linalg.solve(whole, vector), rel=1e-8, abs=1e-10)
    half = factored.half_solve(right)
    assert half.T @ half == pytest.approx(right.T @ np.linalg.solve(whole, right), rel=1e-9)
    assert factored.log_determinant() == pytest.approx(np.linalg.slogdet(whole)[1], rel=1e-9)
    of_global = np.linalg.inv(whole)[n_motion:, n_motion:]
    assert factored.global_variances() == pytest.approx(np.diag(of_global), rel=1e-8)
    assert factored.global_covariance == pytest.approx(of_global, rel=1e-8, abs=1e-12)
    motion = right[:n_motion]
    assert band_times(normal.band, motion) == pytest.approx(whole[:n_motion, :n_motion] @ motion)
    assert band_times(normal.band, motion[:, 0]) == pytest.approx(whole[:n_motion, :n_motion] @ motion[:, 0])


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 10**6), st.integers(1, 20), LENGTHS)
def test_what_is_added_to_the_diagonal_stands_there(seed: int, n_rest: int, lengths: list[float]) -> None:
    normal, spline = drawn(seed, n_rest, lengths)
    whole, added = dense_normal(normal), np.random.default_rng(seed).uniform(0.0, 3.0, len(normal.corner))
    raised = whole + 0.5 * np.diag(np.diag(whole))
    assert dense_normal(normal.diagonal_raised(0.5)) == pytest.approx(raised)
    whole[np.diag_indices(len(whole))] += np.concatenate([np.zeros(3 * spline.size), added])
    found = normal.factor().with_added(added)
    assert found.global_variances() == pytest.approx(np.diag(np.linalg.inv(whole))[3 * spline.size :], rel=1e-8)
    assert found.log_determinant() == pytest.approx(np.linalg.slogdet(whole)[1], rel=1e-9)


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10**6), st.integers(1, 20), LENGTHS)
def test_covariances_of_the_motion_equal_the_dense_ones(seed: int, n_rest: int, lengths: list[float]) -> None:
    normal, spline = drawn(seed, n_rest, lengths)
    rng, n_global = np.random.default_rng(seed), len(normal.corner)
    rows = spline.rows(np.sort(rng.uniform(0.0, spline.edge_s[-1], 30)))
    # neighbours on either side, the first ones beside the release
    near = np.clip(rows.first + rng.integers(-5, 6, 30), 0, spline.size - 3)
    others = BandedRows(rng.standard_normal(rows.value.shape), near, rows.size)
    by_global, places = rng.standard_normal((30, 3, 2)), rng.integers(0, n_global, (30, 2))
    one, other = (
        np.hstack([kron(each.matrix, eye_array(3)).toarray(), np.zeros((90, n_global))]) for each in (rows, others)
    )
    both = one.copy()
    for row, own in enumerate(places):
        for side, place in enumerate(own):
            both[3 * row : 3 * row + 3, 3 * spline.size + place] += by_global[row, :, side]
    covariance, inverse = normal.factor().covariance(), np.linalg.inv(dense_normal(normal))
    for found, left, right in (
        (covariance.of_rows(rows), one, one),
        (covariance.of_rows(rows, others), one, other),
        (covariance.of_rows(rows, by_global=by_global, places=places), both, both),
    ):
        wanted = (left @ inverse @ right.T).reshape(30, 3, 30, 3)[np.arange(30), :, np.arange(30)]
        assert found == pytest.approx(wanted, rel=1e-8, abs=1e-10 * np.abs(wanted).max())


@pytest.mark.parametrize("fault", ["motion", "global", "not a number"])
def test_what_is_not_positive_definite_raises_the_solvers_own_error(fault: str) -> None:
    normal, _ = drawn(6, 3, [0.1, 0.1])
    if fault == "motion":
        normal.band[0] -= 1e3
    elif fault == "global":
        normal.corner[2, 2] -= 1e3
    else:
        normal.corner[:] += np.nan
    with pytest.raises(SolveError, match=r"not positive definite|not finite"):
        normal.factor()


def test_a_band_that_is_not_a_number_raises_the_solvers_own_error() -> None:
    normal, _ = drawn(6, 3, [0.1, 0.1])
    with pytest.raises(SolveError, match=r"not positive definite|not finite"):
        replace(normal, band=np.full_like(normal.band, np.nan)).factor()


def test_a_band_alone_is_solved_and_a_singular_one_raises_the_solvers_own_error() -> None:
    band = np.array([[2.0, 4.0, 3.0], [1.0, -1.0, 0.0]])
    whole = np.array([[2.0, 1.0, 0.0], [1.0, 4.0, -1.0], [0.0, -1.0, 3.0]])
    right = np.array([[1.0, 0.0], [2.0, 1.0], [3.0, -1.0]])
    assert solve_band(band, right) == pytest.approx(np.linalg.solve(whole, right))
    with pytest.raises(SolveError, match="singular"):
        solve_band(np.zeros((2, 3)), right)
