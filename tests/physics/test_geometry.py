"""Path lengths, T, the exact bistatic solution and mirrors against worked truth."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from radargui.model.setup import read_setup
from radargui.physics.path_length import (
    Antennas,
    condition_number,
    locate_exact,
    locate_falling,
    locate_plane,
    mirror,
    path_gradient,
    path_lengths,
    place_antennas,
    position_uncertainty,
    solve_gradient,
    t_matrix,
)
from radargui.system.resources import default_setup_path

RELEASE = np.array([0.0, 0.0, 0.12])
coordinate = st.floats(-0.15, 0.15)


@pytest.fixture(scope="module")
def antennas() -> Antennas:
    return place_antennas(read_setup(default_setup_path()))


def test_a_receiver_stands_where_tilt_azimuth_and_distance_say(antennas: Antennas) -> None:
    assert antennas.transmitter_m == pytest.approx([0.0, 0.0, 0.70])
    assert antennas.receivers_m[0] == pytest.approx([0.0, 0.70 * np.sin(np.radians(40)), 0.70 * np.cos(np.radians(40))])


def test_path_length_is_the_sum_of_two_distances(antennas: Antennas) -> None:
    p = np.array([0.03, -0.02, 0.05])
    expected = [np.linalg.norm(p - antennas.transmitter_m) + np.linalg.norm(p - rx) for rx in antennas.receivers_m]
    assert path_lengths(p[:, None], antennas)[:, 0] == pytest.approx(expected, abs=1e-15)


def test_the_gradient_of_a_path_is_its_numerical_derivative(antennas: Antennas) -> None:
    p, h = np.array([0.03, -0.02, 0.05]), 1e-6
    steps = h * np.eye(3)
    numerical = np.stack(
        [path_lengths((p + d)[:, None], antennas) - path_lengths((p - d)[:, None], antennas) for d in steps], axis=1
    )[:, :, 0] / (2 * h)
    assert path_gradient(p[:, None], antennas)[:, :, 0] == pytest.approx(numerical, abs=1e-9)


def test_rows_of_t_are_sin_t_cos_a_and_sin_t_sin_a_and_one_plus_cos_t(antennas: Antennas) -> None:
    tilt, azimuth = np.radians(40.0), np.radians([90.0, 210.0, 330.0])
    expected = np.stack(
        [np.sin(tilt) * np.cos(azimuth), np.sin(tilt) * np.sin(azimuth), np.full(3, 1 + np.cos(tilt))], axis=1
    )
    assert t_matrix(antennas) == pytest.approx(expected, abs=1e-12)


def test_a_path_growing_in_all_receivers_is_a_tracer_going_down(antennas: Antennas) -> None:
    position = locate_plane(np.full((3, 1), 0.01), antennas, RELEASE)
    assert position[2, 0] < RELEASE[2]
    assert position[:2, 0] == pytest.approx([0.0, 0.0], abs=1e-12)


def test_two_receivers_tell_a_fall_and_the_side_that_they_see(antennas: Antennas) -> None:
    # those at 210 and 330 degrees see x by their difference
    place = np.stack([np.linspace(0.0, 0.02, 50), np.zeros(50), np.linspace(0.12, -0.15, 50)])
    two = Antennas(antennas.transmitter_m, antennas.receivers_m[1:])
    change = path_lengths(place, two) - path_lengths(RELEASE[:, None], two)
    assert locate_falling(change, two, RELEASE, np.array([0.0, 0.0, 1.0])) == pytest.approx(place, abs=2e-4)


@settings(max_examples=50, deadline=None)
@given(x=coordinate, y=coordinate, z=coordinate)
def test_the_exact_solution_returns_any_place_in_the_field_of_view(x: float, y: float, z: float) -> None:
    antennas = place_antennas(read_setup(default_setup_path()))
    p = np.array([[x], [y], [z]])
    change = path_lengths(p, antennas) - path_lengths(RELEASE[:, None], antennas)
    assert locate_exact(change, antennas, RELEASE) == pytest.approx(p, abs=1e-10)


def test_the_plane_wave_is_wrong_by_millimetres_where_the_exact_solution_is_not(antennas: Antennas) -> None:
    p = np.zeros((3, 100))
    p[2] = np.linspace(0.12, -0.13, 100)
    change = path_lengths(p, antennas) - path_lengths(RELEASE[:, None], antennas)
    plane = np.sqrt(np.mean((locate_plane(change, antennas, RELEASE) - p)[2] ** 2))
    assert 0.5e-3 < plane < 20e-3
    assert locate_exact(change, antennas, RELEASE) == pytest.approx(p, abs=1e-10)


def test_four_receivers_are_solved_by_least_squares(antennas: Antennas) -> None:
    four = Antennas(antennas.transmitter_m, np.concatenate([antennas.receivers_m, [[0.5, 0.1, 0.5]]]))
    p = np.array([[0.02], [0.03], [-0.05]])
    change = path_lengths(p, four) - path_lengths(RELEASE[:, None], four)
    assert locate_exact(change, four, RELEASE) == pytest.approx(p, abs=1e-10)


def test_an_unknown_path_gives_an_unknown_position_and_leaves_the_others(antennas: Antennas) -> None:
    change = np.zeros((3, 3))
    change[1, 1] = np.nan
    position = locate_exact(change, antennas, RELEASE)
    assert np.isnan(position[:, 1]).all()
    assert position[:, [0, 2]] == pytest.approx(np.stack([RELEASE, RELEASE], axis=1))


def test_paths_no_place_can_have_give_an_unknown_position(antennas: Antennas) -> None:
    assert np.isnan(locate_exact(np.array([[-2.0], [-2.0], [-2.0]]), antennas, RELEASE)).all()


def test_uncertainty_of_position_is_the_scatter_of_solutions(antennas: Antennas) -> None:
    rng = np.random.default_rng(3)
    p, u = np.array([[0.02], [0.01], [-0.05]]), np.array([[1e-5], [2e-5], [3e-5]])
    exact = path_lengths(p, antennas) - path_lengths(RELEASE[:, None], antennas)
    scattered = locate_exact(exact + u * rng.normal(size=(3, 20000)), antennas, RELEASE)
    assert position_uncertainty(p, u, antennas)[:, 0] == pytest.approx(scattered.std(axis=1), rel=0.03)


def test_uncertainties_of_places_along_a_fall_are_those_of_each_of_them(antennas: Antennas) -> None:
    z = np.linspace(0.1, -0.1, 4003)
    position = np.stack([0.02 + 0.1 * z, 0.01 - 0.05 * z, z])
    position[:, 700:709] = np.nan
    u = np.repeat([[1e-5], [2e-5], [3e-5]], z.size, axis=1)
    found = position_uncertainty(position, u, antennas)
    # another uncertainty at one place: then each is looked at by itself
    one_by_one = position_uncertainty(position, np.concatenate([u[:, :-1], 1.01 * u[:, -1:]], axis=1), antennas)
    assert np.isnan(found[:, 700:709]).all()
    known = np.isfinite(position[0])
    known[-1] = False
    assert np.isfinite(found[:, known]).all()
    assert found[:, known] == pytest.approx(one_by_one[:, known], rel=3e-3)
    assert not (found[:, known] == one_by_one[:, known]).all()


def test_of_two_places_the_nearer_to_the_guess_is_taken_however_far_the_sphere_has_gone(antennas: Antennas) -> None:
    # a live block begins at the release: its guess stays there while the sphere falls by the length of the field
    p = np.stack([np.full(50, 0.02), np.full(50, -0.01), np.linspace(0.12, -0.14, 50)])
    change = path_lengths(p, antennas) - path_lengths(RELEASE[:, None], antennas)
    guess = np.repeat(RELEASE[:, None], 50, axis=1)
    assert locate_exact(change, antennas, RELEASE, guess) == pytest.approx(p, abs=1e-10)
    guess[:, 10:20] = np.nan
    assert np.isnan(locate_exact(change, antennas, RELEASE, guess)[:, 10:20]).all()


def test_a_mirrored_point_is_as_far_behind_the_plane() -> None:
    normal = np.array([0.0, 0.6, 0.8])
    point = np.array([0.3, -0.2, 0.5])
    image = mirror(point, normal, -0.1)
    assert (image + point) @ normal / 2 == pytest.approx(-0.1)
    assert np.cross(image - point, normal) == pytest.approx(np.zeros(3), abs=1e-12)


def test_the_condition_number_grows_when_receivers_stand_together(antennas: Antennas) -> None:
    near = antennas.receivers_m.copy()
    near[1] = near[0] + [0.01, 0.0, 0.0]
    assert condition_number(Antennas(antennas.transmitter_m, near)) > 10 * condition_number(antennas)


def test_a_sample_whose_equations_have_no_single_solution_is_unknown_and_spoils_no_other() -> None:
    gradient = np.random.default_rng(0).normal(size=(3, 3, 5))
    gradient[1, :, 2] = gradient[0, :, 2]
    wanted = np.random.default_rng(1).normal(size=(3, 5))
    found = solve_gradient(gradient, np.einsum("ran,an->rn", gradient, wanted))
    assert np.isnan(found[:, 2]).all()
    assert np.delete(found, 2, axis=1) == pytest.approx(np.delete(wanted, 2, axis=1), abs=1e-9)


def test_four_receivers_in_one_plane_with_the_sphere_tell_no_uncertainty_and_beside_it_a_large_one() -> None:
    rng = np.random.default_rng(1)
    across = np.stack([rng.uniform(-0.8, 0.8, 4), np.zeros(4), rng.uniform(-0.1, 0.9, 4)], axis=1)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    antennas = Antennas(turn @ [0.1, 0.0, 0.7], across @ turn.T)
    inside = np.stack([rng.uniform(-0.2, 0.2, 200), np.zeros(200), rng.uniform(-0.2, 0.2, 200)])
    u = np.full((4, 200), 1e-5)
    assert np.isnan(position_uncertainty(turn @ inside, u, antennas)).all()
    beside = turn @ (inside + np.array([[0.0], [0.02], [0.0]]))
    gradient = path_gradient(beside, antennas)
    expected = [np.sqrt(np.diag(np.linalg.inv(1e10 * one.T @ one))) for one in gradient.transpose(2, 0, 1)]
    # eight neighbours share a Jacobian, which these places do not
    u[0, 0] = 1.0001e-5
    assert position_uncertainty(beside, u, antennas)[:, 1:] == pytest.approx(np.array(expected).T[:, 1:], rel=1e-6)
