"""Which coefficients lie between which breaks, against the spline itself."""

from __future__ import annotations

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
