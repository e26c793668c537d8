"""The linearised evidence of one more wall: its waves against image theory, the rest against dense algebra."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.sparse import eye_array, kron
from support.normal_matrices import dense_normal
from support.small_problem import FLOOR_PLANE, small_problem

from radargui.estimation.forward.signal_model import waves_at
from radargui.estimation.forward.signal_slopes import receiver_slopes
from radargui.estimation.forward.slow_noise import Drift
from radargui.estimation.select.wall_grid import (
    WALLS,
    DirectWave,
    LinearisedSearch,
    evidence_of,
    images_of,
    stiffened,
    upright_planes,
)
from radargui.estimation.solve.assemble import assemble
from radargui.estimation.solve.changed_problem import positions_at_bins, stiff_equation_sd
from radargui.estimation.solve.lobe_prior import main_lobes
from radargui.estimation.solve.minimise import Solution, minimise
from radargui.physics.mirrors import MirrorPlane

UP = np.array([0.0, 0.0, 1.0])


@pytest.fixture(scope="module")
def solution() -> Solution:
    drift = Drift(0.0, 0.45, 4, np.full((6, 4), 0.05), np.zeros(6))
    return minimise(small_problem((FLOOR_PLANE,), reflection=0.1, drift=drift, n_bins=120, delay_s=5e-5).start, 2)


def planes_of(solution: Solution) -> list[MirrorPlane]:
    return upright_planes(positions_at_bins(solution).mean(axis=1), UP, np.array([0.3, 2.0]), np.array([0.14, 0.3]))


def direct_of(solution: Solution, number: int) -> DirectWave:
    problem, at, theta = solution.problem, solution.at, solution.state.theta
    node_m = at.node_m[:, 2 * number : 2 * number + 2]
    waves = waves_at(node_m, theta, problem.layout, problem.inputs, number)
    return DirectWave.of(node_m, waves, problem.inputs, main_lobes(problem.layout, theta)[[0, 1 + number]])


def test_a_wave_over_a_wall_is_that_of_the_image_seen_by_the_turned_main_lobe(solution: Solution) -> None:
    inputs, plane = solution.problem.inputs, planes_of(solution)[1]
    for number in range(3):
        direct = direct_of(solution, number)
        place, release = direct.place_m, inputs.release_m
        antennas = inputs.antennas.transmitter_m, inputs.antennas.receivers_m[number]
        images = images_of(inputs.antennas, [plane])[[0, 1 + number]]
        columns = direct.columns((images[0], images[1]), None)[0]
        for leg, (antenna, exponent) in enumerate(zip(antennas, direct.main_lobes, strict=True)):
            image, aim = (plane.image(one, np.zeros(3)) for one in (antenna, np.zeros(3)))
            assert images[leg, 0] == pytest.approx(image)

            def wave(source: np.ndarray, aim: np.ndarray, point: np.ndarray, exponent: float = exponent) -> np.ndarray:
                away = point - source[:, None]
                length = np.linalg.norm(away, axis=0)
                cosine = (aim - source) @ away / np.linalg.norm(aim - source) / length
                lobe = np.sqrt(cosine ** (2.0 * exponent) + 0.01)
                return lobe * np.exp(1j * inputs.wavenumber * length) / length

            over, along = (wave(image, aim, p) for p in (place, release[:, None]))
            straight, at_rest = (wave(antenna, np.zeros(3), p) for p in (place, release[:, None]))
            # its lobe and its phase count from the release, its way from the direct one
            ratio = over / straight * (np.abs(along) / along) * (at_rest / np.abs(at_rest))
            lobe_at_rest = np.abs(along / at_rest) * np.linalg.norm(release - image) / np.linalg.norm(release - antenna)
            wanted = direct.field * ratio / lobe_at_rest
            assert columns[2 * leg] == pytest.approx(wanted.real, abs=1e-9)
            assert columns[2 * leg + 1] == pytest.approx(-wanted.imag, abs=1e-9)


def test_what_the_sphere_scatters_that_way_multiplies_the_wave(solution: Solution) -> None:
    direct, planes = direct_of(solution, 1), planes_of(solution)[:2]
    images = images_of(solution.problem.inputs.antennas, planes)[[0, 2]]
    plain = direct.columns((images[0], images[1]), None)
    scattered = [np.full((2, 120), one) for one in (0.8 + 0.3j, 1.1 - 0.2j)]
    found = direct.columns((images[0], images[1]), scattered)
    for leg, factor in enumerate((0.8 + 0.3j, 1.1 - 0.2j)):
        real, imaginary = plain[:, 2 * leg], plain[:, 2 * leg + 1]
        turned = factor * (real - 1j * imaginary)
        assert found[:, 2 * leg] == pytest.approx(turned.real)
        assert found[:, 2 * leg + 1] == pytest.approx(-turned.imag)


def dense_of(solution: Solution, planes: list[MirrorPlane]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the dense Jacobian, weights and misfits of the channels, the new T and R last, of one plane each."""
    problem, at, theta = solution.problem, solution.at, solution.state.theta
    layout, n_bins = problem.layout, problem.bins.n_bins
    motion = kron(at.design, eye_array(3)).toarray().reshape(n_bins, 3, -1)
    breaks = at.spline.break_slopes(problem.bins.time_s, solution.state.coefficients).toarray().reshape(n_bins, 3, -1)
    count, rows, new = motion.shape[2], [], []
    images = images_of(problem.inputs.antennas, planes)
    for n, own in enumerate(layout.receivers):
        pair = slice(2 * n, 2 * n + 2)
        node_m = at.node_m[:, pair]
        slopes = receiver_slopes(node_m, theta, layout, problem.inputs, n, at.excess[pair])
        columns = direct_of(solution, n).columns((images[0], images[1 + n]), None)
        for channel in range(2):
            row = np.zeros((n_bins, count + layout.size))
            by_place = slopes.by_position[channel]
            row[:, :count] = np.einsum("an,nak->nk", by_place, motion)
            of_global = row[:, count:]
            of_global[:, layout.breaks] += np.einsum("an,nak->nk", by_place, breaks)
            of_global[:, layout.shared] += slopes.by_shared[channel]
            of_global[:, own.without_drift] += slopes.by_own[channel]
            of_global[:, (own.drift_i, own.drift_q)[channel]] += problem.inputs.drift[2 * n + channel]
            rows.append(row)
            last = np.zeros((len(planes), n_bins, 8))
            last[..., [0, 1, 2 + 2 * n, 3 + 2 * n]] = columns[:, :, channel].transpose(0, 2, 1)
            new.append(last)
    shown = np.concatenate([one.value for one in at.signals]) - problem.bins.value
    return np.concatenate(rows), np.concatenate(new, axis=1), shown.ravel()


def test_slope_and_curvature_of_new_reflections_are_the_dense_schur_complement(solution: Solution) -> None:
    planes, problem = planes_of(solution), solution.problem
    jacobian, new, misfit = dense_of(solution, planes)
    weight = solution.at.weight.ravel()
    stiff = replace(stiffened(problem), equation_sd=stiff_equation_sd(solution))
    blocks = assemble(stiff, solution.state, solution.at)
    hessian = dense_normal(blocks.normal)
    slope = blocks.slope
    slopes, a, _ = LinearisedSearch(solution, WALLS).marginal(planes)
    for number in range(len(planes)):
        j = new[number]
        coupled = jacobian.T @ (weight[:, None] * j)
        explained = np.linalg.solve(hessian, coupled)
        wanted_slope = j.T @ (weight * misfit) - explained.T @ slope
        wanted = j.T @ (weight[:, None] * j) + np.eye(8) / WALLS.reflection**2 - coupled.T @ explained
        assert a[number] == pytest.approx(wanted, rel=1e-6, abs=1e-6 * np.abs(wanted).max())
        assert slopes[number] == pytest.approx(wanted_slope, rel=1e-6, abs=1e-6 * np.abs(wanted_slope).max())


def test_linearised_evidence_is_laplaces_of_the_reflections_alone() -> None:
    rng = np.random.default_rng(2)
    root, slope = rng.standard_normal((3, 4, 4)), rng.standard_normal((3, 4))
    a = root @ root.transpose(0, 2, 1) + np.eye(4)
    for one, g, found in zip(a, slope, evidence_of(slope, a, 0.03), strict=True):
        wanted = 0.5 * g @ np.linalg.inv(one) @ g - 0.5 * np.log(np.linalg.det(one * 0.03**2))
        assert found == pytest.approx(wanted)
    # what rounding left without a curvature is no place at all
    lost = a.copy()
    lost[1] = np.diag([1.0, 1.0, 1.0, -1e-9])
    assert evidence_of(slope, lost, 0.03)[1] == -np.inf
