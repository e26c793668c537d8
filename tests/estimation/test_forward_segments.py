"""Which coefficients lie between which breaks, against the spline itself."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from radargui.estimation.forward.motion_spline import make_spline

SPLINE = make_spline(0.0, 0.5, np.array([0.2, 0.205, 0.37]))


def test_the_coefficient_of_a_joint_is_the_place_at_its_break() -> None:
    segments = SPLINE.segments
    for number, joint in enumerate(segments.joint):
        at_break = np.zeros(segments.size)
        at_break[joint - 1] = 1.0
        assert SPLINE.design(SPLINE.break_s[number : number + 1]).toarray()[0] == pytest.approx(at_break)


def test_rows_belong_to_the_segment_of_their_time() -> None:
    time_s = np.array([0.001, 0.199, 0.201, 0.204, 0.206, 0.36, 0.38, 0.499])
    assert SPLINE.segments.of(SPLINE.rows(time_s).first).tolist() == [0, 0, 1, 1, 2, 2, 3, 3]


def test_functions_are_the_coefficients_segment_by_segment() -> None:
    segments = SPLINE.segments
    assert segments.n_functions == segments.size + 1 + 3
    assert (np.diff(segments.segment) >= 0).all()
    for number, end in enumerate(segments.ends):
        assert segments.coefficient[[end, end + 1]].tolist() == [segments.joint[number]] * 2
        assert segments.segment[[end, end + 1]].tolist() == [number, number + 1]
    values = np.random.default_rng(3).standard_normal((segments.n_functions, 2))
    wanted = np.zeros((segments.size + 1, 2))
    np.add.at(wanted, segments.coefficient, values)
    assert segments.folded(values) == pytest.approx(wanted)


def test_what_segments_say_of_breaks_is_the_transpose_of_the_breaks_beside_them() -> None:
    segments, rng = SPLINE.segments, np.random.default_rng(4)
    of_breaks, of_segments = rng.standard_normal(3), rng.standard_normal((4, 2))
    assert segments.breaks_beside(of_breaks)[0, 0] == segments.breaks_beside(of_breaks)[3, 1] == 0.0
    assert (segments.breaks_beside(of_breaks) * of_segments).sum() == pytest.approx(
        of_breaks @ segments.of_breaks(of_segments)
    )


def test_elements_beside_breaks_are_those_of_the_dense_matrix() -> None:
    segments, rng = SPLINE.segments, np.random.default_rng(5)
    n_rows = 3 * segments.size
    row, column = np.indices((n_rows, n_rows))
    dense = rng.standard_normal((n_rows, n_rows))
    dense = np.where(np.abs(row - column) < 12, dense + dense.T, 0.0)
    band = np.array([np.append(np.diagonal(dense, -away), np.zeros(away)) for away in range(12)])
    beside, joints = segments.beside_joints, segments.joint_rows
    between = np.setdiff1d(np.arange(n_rows), joints)
    found, wanted = np.zeros((n_rows, 8)), np.zeros((n_rows, 8))
    found[beside.row, beside.side] = band[beside.near[0], beside.near[1]]
    for one in between:
        number = int((joints[:, 0] < one).sum())
        if number:
            wanted[one, :3] = dense[one, joints[number - 1]]
        if number < segments.n_breaks:
            wanted[one, 4:7] = dense[one, joints[number]]
    assert found.tolist() == wanted.tolist()
    for number, own in enumerate(joints):
        assert band[*beside.own[:, number]].tolist() == dense[np.ix_(own, own)].tolist()
    for number, (one, other) in enumerate(pairwise(joints)):
        # far from each other: the element that stands for all is zero
        assert band[*beside.to_next[:, number]].tolist() == dense[np.ix_(other, one)].tolist()
    band[beside.all[0], beside.all[1]] = 0.0
    left = dense.copy()
    left[joints.ravel()], left[:, joints.ravel()] = 0.0, 0.0
    left[joints.ravel(), joints.ravel()] = np.diagonal(dense)[joints.ravel()]
    assert [np.diagonal(left, -away).tolist() for away in range(12)] == [
        band[away, : n_rows - away].tolist() for away in range(12)
    ]
