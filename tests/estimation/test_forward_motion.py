"""The motion's spline in closed form, and the slopes of the signals against finite differences."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.receiver_signal import receiver_signal
from support.small_problem import ANTENNAS, LARGE_SPHERE

from radargui.estimation.forward.banded_rows import BandedRows
from radargui.estimation.forward.motion_spline import make_spline
from radargui.estimation.forward.parameters import Sizes, make_layout
from radargui.estimation.forward.signal_model import EVERY, ModelInputs, signal_of, waves_at
from radargui.estimation.forward.signal_slopes import receiver_slopes
from radargui.estimation.forward.sphere import PolarisedSphere
from radargui.estimation.solve.break_velocities import one_sided_slopes
from radargui.physics.edges import StatedEdges
from radargui.physics.mirrors import MirrorPlane


def test_the_motion_is_continuous_at_breaks_and_its_velocity_is_not() -> None:
    rng = np.random.default_rng(3)
    spline = make_spline(0.0, 0.5, np.array([0.2]))
    c = np.cumsum(rng.standard_normal(spline.size))
    at = spline.design(np.array([0.2 - 1e-7, 0.2, 0.2 + 1e-7])) @ c
    assert np.ptp(at) < 1e-3
    assert abs((at[2] - at[1]) - (at[1] - at[0])) > 1e-7


def test_jerk_matrix_is_exact_for_a_cubic() -> None:
    spline = make_spline(0.1, 0.4, np.array([0.25]), np.array([0.3]))
    t = np.linspace(0.1, 0.4, 500)
    design = spline.design(t).toarray()
    c = np.linalg.lstsq(design, 5.0 * (t - 0.1) ** 3 - (t - 0.1), rcond=None)[0]
    matrix, _, _ = spline.jerk()
    assert matrix @ c == pytest.approx(30.0, rel=1e-4)


def test_the_series_of_each_span_are_the_motion_and_its_derivatives() -> None:
    spline = make_spline(0.1, 0.6, np.array([0.25, 0.4]), np.array([0.3]))
    moved = spline.with_breaks(np.array([0.26, 0.39]))
    c = np.cumsum(np.random.default_rng(5).standard_normal((spline.size, 3)), axis=0)
    times = np.sort(np.random.default_rng(6).uniform(0.05, 0.65, 300))
    for own in (spline, moved):
        series = own.series(times)
        place, velocity, _, jerk = series.motion(c)
        assert place == pytest.approx(own.offset(times, c).T, abs=1e-12)
        assert velocity == pytest.approx(own.velocity(times, c).T * ((times > 0.1) & (times < 0.6)), abs=1e-8)
        # in the same span the series goes on as the spline does
        step = 0.3 * np.minimum(series.high_s - times, 1.0)
        away = sum(series.motion(c)[k] * step**k / (1.0, 1.0, 2.0, 6.0)[k] for k in range(4))
        assert away == pytest.approx(own.offset(times + step, c).T, abs=1e-9)
        assert not series.beyond(times + step).any()
        assert series.beyond(series.high_s + 1e-9)[times < 0.6].all()
        assert np.isfinite(jerk).all()


def test_banded_rows_multiply_as_their_matrix_does() -> None:
    rng = np.random.default_rng(7)
    rows = BandedRows(rng.standard_normal((30, 4)), np.sort(rng.integers(0, 17, 30)), 19)
    dense, right, weight = rows.matrix.toarray(), rng.standard_normal((19, 3)), rng.uniform(0.5, 2.0, 30)
    assert rows @ right == pytest.approx(dense @ right)
    assert rows @ right[:, 0] == pytest.approx(dense @ right[:, 0])
    assert rows.transposed(rows @ right) == pytest.approx(dense.T @ dense @ right)
    gram = dense.T @ (weight[:, None] * dense)
    for distance, diagonal in enumerate(rows.gram(weight)):
        assert diagonal[1 : 20 - distance] == pytest.approx(np.diag(gram, distance))
    assert rows[5:9].above(rows[:2]).matrix.toarray() == pytest.approx(np.concatenate([dense[5:9], dense[:2]]))


def test_what_a_break_moves_equals_the_motion_with_the_break_moved() -> None:
    spline = make_spline(0.1, 0.6, np.array([0.25, 0.4]))
    c = np.cumsum(np.random.default_rng(4).standard_normal((spline.size, 3)), axis=0)
    t = np.concatenate([np.linspace(0.0, 0.2499, 50), np.linspace(0.2501, 0.3999, 50), np.linspace(0.4001, 0.7, 50)])
    slopes = spline.break_slopes(t, c).toarray()
    for k in range(2):
        moved = [spline.with_breaks(spline.break_s + step * np.eye(2)[k]).offset(t, c) for step in (-1e-6, 1e-6)]
        assert slopes[:, k] == pytest.approx((moved[1] - moved[0]).ravel() / 2e-6, rel=1e-6, abs=1e-5)


def test_slopes_on_both_sides_of_a_break_are_the_motions() -> None:
    spline = make_spline(0.1, 0.6, np.array([0.25, 0.4]), np.array([0.3]))
    c = np.cumsum(np.random.default_rng(4).standard_normal((spline.size, 3)), axis=0)
    for rows, side in zip(one_sided_slopes(spline), (-1.0, 1.0), strict=True):
        beside = [spline.offset(spline.break_s + side * step, c) for step in (0.0, 1e-7)]
        assert rows @ c == pytest.approx(side * (beside[1] - beside[0]) / 1e-7, rel=1e-3, abs=0.1)


EDGES = StatedEdges(np.array([0.05, 0.04, 0.3, 0.005, -0.008]), np.full(5, 0.005))


def inputs_and_layout(body: PolarisedSphere | None = None, edges: StatedEdges | None = None):
    rng = np.random.default_rng(5)
    n = 40
    planes = (
        MirrorPlane(np.array([0.0, 0.0, -0.15]), np.array([0.0, 0.0, 1.0]), "floor", edges=edges),
        MirrorPlane(np.array([0.15, 0.0, 0.0]), np.array([-1.0, 0.0, 0.0]), "wall"),
    )
    layout = make_layout(Sizes(0, 2, 3, 3, 2, 2, 0 if body is None else 1, walls=1, edges=edges is not None))
    inputs = ModelInputs(
        ANTENNAS,
        np.array([0.0, 0.01, 0.12]),
        209.6,
        planes,
        rng.standard_normal((n, 3)),
        rng.standard_normal((n, 2)),
        rng.uniform(0.8, 1.2, (3, n)),
        rng.standard_normal((6, n, 2)),
    )
    theta = 0.1 * rng.standard_normal(layout.size)
    theta[layout.planes] *= 0.05
    if edges is not None:
        theta[layout.edges] = edges.values
    # what little a mixer makes of the echo counts as constant in all other slopes
    for own in layout.receivers:
        theta[own.harmonics] = 0.0
    z = np.linspace(0.12, -0.1, n)
    node = np.stack([0.02 * z, 0.01 + 0 * z, z])[:, None, None, :] + 1e-4 * rng.standard_normal((3, 2, 2, n))
    if body is not None:
        fields = body.fields(node[:, 0, 0], ANTENNAS, inputs.release_m, planes, theta[layout.mirrors])
        inputs = replace(inputs, sphere=fields)
    return inputs, layout, theta, node


@pytest.mark.parametrize(
    ("body", "edges"), [(None, None), (LARGE_SPHERE, None), (None, EDGES)], ids=["point", "sphere", "plate that ends"]
)
def test_signal_derivatives_equal_numerical_ones(body: PolarisedSphere | None, edges: StatedEdges | None) -> None:
    inputs, layout, theta, node = inputs_and_layout(body, edges)
    own = layout.receivers[1]
    at = receiver_slopes(node, theta, layout, inputs, 1)
    drift = np.zeros((2, 40, 4))
    drift[0, :, :2], drift[1, :, 2:] = inputs.drift[2:4]
    by_own = np.concatenate([at.by_own, drift], axis=2)
    for column in range(own.first, own.last):
        step = np.zeros_like(theta)
        step[column] = 1e-6
        up, down = (receiver_signal(node, theta + s * step, layout, inputs, 1).value for s in (1, -1))
        assert by_own[:, :, column - own.first] == pytest.approx((up - down) / 2e-6, abs=1e-6)
    for column in range(layout.shared.start, layout.shared.stop):
        step = np.zeros_like(theta)
        step[column] = 1e-6
        up, down = (receiver_signal(node, theta + s * step, layout, inputs, 1).value for s in (1, -1))
        slope = (up - down) / 2e-6
        # how strong the waves over edges are counts as constant
        within = 1e-5 if edges is None else 0.05 * np.abs(slope).max() + 1e-5
        assert at.by_shared[:, :, column - layout.planes.start] == pytest.approx(slope, abs=within)


@pytest.mark.parametrize(
    ("body", "edges"), [(None, None), (LARGE_SPHERE, None), (None, EDGES)], ids=["point", "sphere", "plate that ends"]
)
def test_all_receivers_at_once_show_what_each_shows_by_itself(
    body: PolarisedSphere | None, edges: StatedEdges | None
) -> None:
    inputs, layout, theta, node = inputs_and_layout(body, edges)
    nodes = np.stack([node + 1e-4 * n for n in range(3)])
    together = waves_at(nodes, theta, layout, inputs, EVERY)
    slopes = receiver_slopes(nodes, theta, layout, inputs, EVERY)
    for n, signal in enumerate(signal_of(together, theta, layout, inputs, EVERY).each()):
        alone = waves_at(nodes[n], theta, layout, inputs, n)
        own = signal_of(together.of(n), theta, layout, inputs, n)
        by_itself = signal_of(alone, theta, layout, inputs, n)
        for name in ("value", "direct", "field", "besides"):
            assert getattr(signal, name) == pytest.approx(getattr(by_itself, name), abs=1e-12)
            assert getattr(own, name) == pytest.approx(getattr(by_itself, name), abs=1e-12)
        of_one = receiver_slopes(nodes[n], theta, layout, inputs, n, waves=together.of(n))
        assert slopes.columns[n] == pytest.approx(of_one.columns, abs=1e-9)
        assert slopes.at_nodes[n] == pytest.approx(of_one.at_nodes, abs=1e-9)


@pytest.mark.parametrize("edges", [None, EDGES], ids=["endless", "plate that ends"])
def test_position_derivative_is_right_up_to_the_amplitudes_slope(edges: StatedEdges | None) -> None:
    inputs, layout, theta, node = inputs_and_layout(edges=edges)
    at = receiver_slopes(node, theta, layout, inputs, 0)
    for axis in range(3):
        step = np.zeros((3, 1, 1, 1))
        step[axis] = 1e-7
        up, down = (receiver_signal(node + s * step, theta, layout, inputs, 0).value for s in (1, -1))
        slope = (up - down) / 2e-7
        within = 0.01 if edges is None else 0.02
        assert np.abs(at.by_position[:, axis] - slope).max() < within * np.abs(slope).max()


def test_a_motion_without_breaks_has_no_one_sided_slopes() -> None:
    spline = make_spline(0.0, 0.4, np.empty(0))
    assert [side.matrix.shape for side in one_sided_slopes(spline)] == [(0, spline.size)] * 2
