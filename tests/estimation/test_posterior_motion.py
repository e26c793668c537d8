"""The posterior of a motion: places, segments and uncertainties against closed forms and dense algebra."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.sparse import eye_array, kron
from support.normal_matrices import dense_normal, random_normal

from radargui.estimation.forward.motion_spline import SplineMotion, make_spline
from radargui.estimation.motion_estimate import few_fringes_factor
from radargui.estimation.posterior.floor_slope import floor_slope
from radargui.estimation.posterior.free_motion import FreeMotion
from radargui.estimation.posterior.motion_posterior import MotionPosterior
from radargui.estimation.posterior.samples import hidden_m, uncertainties, with_alternatives
from radargui.estimation.solve.break_velocities import one_sided_slopes
from radargui.model.gravity import NOMINAL_GRAVITY_M_S2, UNKNOWN_DRAG
from radargui.physics.mirrors import FLOOR, MirrorPlane
from radargui.physics.path_length import Antennas, path_gradient, path_lengths

RELEASE = np.array([0.01, -0.02, 0.12])
ANTENNAS = Antennas(np.array([0.0, 0.0, 0.7]), np.array([[0.45, 0.0, 0.53], [-0.2, 0.4, 0.55], [-0.25, -0.4, 0.5]]))


def wandering(seed: int = 1) -> FreeMotion:
    spline = make_spline(0.1, 0.5, np.array([0.22, 0.4]), np.array([0.3]))
    steps = np.random.default_rng(seed).standard_normal((spline.size, 3))
    return FreeMotion(SplineMotion(spline, 0.003 * np.cumsum(steps, axis=0)), RELEASE, NOMINAL_GRAVITY_M_S2)


@pytest.fixture
def solved() -> tuple[SimpleNamespace, np.ndarray]:
    """Return what the posterior takes of a solution, and the dense inverse of its normal matrix."""
    rng, free = np.random.default_rng(7), wandering()
    spline, n_global = free.motion.spline, 5
    series = spline.series(np.linspace(0.1, 0.5, 300))
    normal = random_normal(rng, spline, n_global)
    inverse = np.linalg.inv(dense_normal(normal))
    inputs = SimpleNamespace(release_m=RELEASE, antennas=ANTENNAS)
    problem = SimpleNamespace(
        gravity_m_s2=NOMINAL_GRAVITY_M_S2,
        inputs=inputs,
        bins=SimpleNamespace(time_s=np.linspace(0.1, 0.5, 300)),
        layout=SimpleNamespace(breaks=slice(0, 2)),
        drag=UNKNOWN_DRAG,
    )
    return SimpleNamespace(
        problem=problem,
        state=SimpleNamespace(coefficients=free.motion.coefficients),
        at=SimpleNamespace(spline=spline, design=series.rows().matrix, series=series),
        normal=normal.factor(),
    ), inverse


def test_velocities_at_breaks_have_the_covariance_of_the_dense_inverse(
    solved: tuple[SimpleNamespace, np.ndarray],
) -> None:
    solution, inverse = solved
    posterior = MotionPosterior(solution, 0.13)
    sides = [kron(side.matrix, eye_array(3)).toarray() for side in one_sided_slopes(solution.at.spline)]
    n_motion = sides[0].shape[1]
    normal = np.array([0.1, -0.2, 0.97])
    speeds = posterior.breaks.along(normal)
    for number in range(2):
        rows = np.concatenate([side[3 * number : 3 * number + 3] for side in sides])
        dense = rows @ inverse[:n_motion, :n_motion] @ rows.T
        assert posterior.breaks.covariance[number] == pytest.approx(dense, rel=1e-7, abs=1e-9 * dense.max())
        along = np.concatenate([-normal, normal])
        assert speeds.u_jump_m_s[number] == pytest.approx(np.sqrt(along @ dense @ along), rel=1e-7)
    step = 1e-7
    for side, sign in ((posterior.breaks.before_m_s, -1.0), (posterior.breaks.after_m_s, 1.0)):
        beside = posterior.free.position_m(posterior.breaks.time_s + sign * step)
        at = posterior.free.position_m(posterior.breaks.time_s)
        assert side == pytest.approx(sign * (beside - at).T / step, rel=1e-3, abs=0.05)


def test_uncertainties_at_the_bins_are_those_of_the_dense_inverse(solved: tuple[SimpleNamespace, np.ndarray]) -> None:
    solution, inverse = solved
    u_position, u_change = uncertainties(solution)
    time, coefficients = solution.problem.bins.time_s, solution.state.coefficients
    by_breaks = solution.at.spline.break_slopes(time, coefficients).toarray()
    rows = np.zeros((3 * time.size, inverse.shape[0]))
    rows[:, : 3 * solution.at.spline.size] = kron(solution.at.design, eye_array(3)).toarray()
    rows[:, 3 * solution.at.spline.size :][:, :2] = by_breaks
    variance = np.einsum("ij,jk,ik->i", rows, inverse, rows).reshape(-1, 3)
    assert u_position == pytest.approx(np.sqrt(variance).T, rel=1e-6, abs=1e-9)
    place = (solution.at.design @ coefficients + RELEASE).T
    for receiver, gradient in enumerate(path_gradient(place, ANTENNAS)):
        toward = np.einsum("an,nak->nk", gradient, rows.reshape(-1, 3, rows.shape[1]))
        wanted = np.sqrt(np.einsum("ij,jk,ik->i", toward, inverse, toward))
        assert u_change[receiver] == pytest.approx(wanted, rel=1e-6, abs=1e-9)


def test_an_alternative_widens_by_its_own_u_and_by_its_distance(solved: tuple[SimpleNamespace, np.ndarray]) -> None:
    solution, _ = solved
    at_once = 0.002 * np.array([1.0, -2.0, 0.5])
    other = SimpleNamespace(**vars(solution))
    other.state = SimpleNamespace(coefficients=solution.state.coefficients + at_once)
    excess = np.full((3, 300), 1.5)
    excess[1] = 2.0
    u_position, u_change = uncertainties(solution)
    here, there = (one.at.design @ one.state.coefficients + RELEASE for one in (solution, other))
    away = (path_lengths(there.T, ANTENNAS) - path_lengths(here.T, ANTENNAS)) ** 2
    alternatives: Any = (SimpleNamespace(solution=other, weight=0.25),)
    wide, wide_change = with_alternatives(solution, alternatives, excess)
    far = (there - here).T ** 2
    assert np.sqrt(far.max(axis=1)) == pytest.approx(np.abs(at_once))
    # the misfit of the worst receiver widens the place, that of each its path
    assert wide**2 == pytest.approx((4.0 * u_position**2 + 0.25 * (u_position**2 + far)) / 1.25)
    wanted = (excess**2 * u_change**2 + 0.25 * (u_change**2 + away)) / 1.25
    assert wide_change**2 == pytest.approx(wanted)


def test_the_slope_of_the_floor_that_reflects_has_the_covariance_of_the_dense_inverse(
    solved: tuple[SimpleNamespace, np.ndarray],
) -> None:
    solution, inverse = solved
    n_motion, plane = 3 * solution.at.spline.size, MirrorPlane(np.zeros(3), np.array([0.1, 0.0, 0.995]), FLOOR)
    theta, step = np.array([0.0, 0.0, 0.01, -0.02, 0.003]), 1e-6
    places = SimpleNamespace(planes=slice(2, 5), plane_unknowns=lambda theta: theta[2:5].reshape(-1, 3))
    solution.problem.layout, solution.state.theta = places, theta
    solution.problem.inputs = SimpleNamespace(planes=(plane,))
    found = floor_slope(solution)
    assert found is not None

    def slope(tilts: np.ndarray) -> np.ndarray:
        # the image of a point lies along the normal
        along = plane.image(np.array([0.1, 0.2, 0.7]), tilts) - np.array([0.1, 0.2, 0.7])
        return along[:2] / along[2]

    turns = step * np.eye(3)[:2]
    by_tilts = np.array([(slope(theta[2:5] + t) - slope(theta[2:5] - t)) / (2.0 * step) for t in turns]).T
    dense = by_tilts @ inverse[n_motion + 2 : n_motion + 4, n_motion + 2 : n_motion + 4] @ by_tilts.T
    assert found.slope == pytest.approx(slope(theta[2:5]), abs=1e-12)
    assert found.covariance == pytest.approx(dense, rel=1e-5)
    solution.problem.inputs = SimpleNamespace(planes=())
    solution.problem.layout = SimpleNamespace(plane_unknowns=lambda _: np.zeros((0, 3)))
    assert floor_slope(solution) is None


def test_few_fringes_widen_and_many_do_not() -> None:
    fringes = np.stack([np.linspace(0.0, span, 50) for span in (0.0, 3.0, 300.0)])
    assert few_fringes_factor(2.0 * np.pi * fringes) == pytest.approx([4.0, np.sqrt(2.0), 1.0], rel=1e-3)


def test_what_a_wave_beside_the_direct_one_does_to_the_amplitude_it_does_to_the_path() -> None:
    # 1 + r exp(i psi): its phase in radians scatters as its log amplitude does
    wavenumber, r = 2.0 * np.pi / 0.03, 0.05
    place = RELEASE[:, None] + np.linspace(0.0, 0.5, 4001) * np.array([[1.0], [0.0], [0.0]])
    wave = 1.0 + r * np.exp(1j * 2.0 * np.pi * place[0] / 0.04)
    inputs = SimpleNamespace(release_m=RELEASE, wavenumber=wavenumber, amplitude_map=np.log(np.abs(wave))[:, None])
    layout = SimpleNamespace(receivers=[SimpleNamespace(amplitude_map=slice(0, 1))])
    problem = SimpleNamespace(inputs=inputs, layout=layout, amplitude_basis=SimpleNamespace(length_m=0.02))
    solution = SimpleNamespace(problem=problem, state=SimpleNamespace(theta=np.ones(1)))
    (hidden,) = hidden_m(solution, place)
    # far from the rest both places are off, each by as much
    assert hidden[-1] == pytest.approx(np.sqrt(2.0) * np.angle(wave).std() / wavenumber, rel=0.02)
    assert hidden[0] < 1e-6
    assert (np.diff(hidden) >= 0.0).all()
