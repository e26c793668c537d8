"""Mirrors, layout, map functions and range factor of the forward model against closed forms and finite differences."""

from __future__ import annotations

import numpy as np
import pytest
from support.small_problem import ANTENNAS, FLOOR_PLANE, RELEASE_M, WALL_PLANE

from radargui.estimation.forward.position_map import MapSettings, make_basis
from radargui.physics.mirrors import MirrorPlane, turned
from radargui.physics.path_length import range_factor

UNKNOWN = np.array([0.02, -0.015, 0.006])


def test_an_image_stands_as_far_behind_the_plane_as_the_antenna_before_it() -> None:
    image = FLOOR_PLANE.image(np.array([0.1, 0.2, 0.7]), np.zeros(3))
    assert image == pytest.approx([0.1, 0.2, 2.0 * -0.11 - 0.7])
    shifted = FLOOR_PLANE.image(np.array([0.1, 0.2, 0.7]), np.array([0.0, 0.0, 0.01]))
    assert shifted == pytest.approx([0.1, 0.2, 2.0 * -0.10 - 0.7])


@pytest.mark.parametrize("plane", [FLOOR_PLANE, WALL_PLANE])
def test_what_an_images_unknowns_move_equals_finite_differences(plane: MirrorPlane) -> None:
    antenna = ANTENNAS.receivers_m[1]
    slope = plane.image_slope(antenna, UNKNOWN)
    for k in range(3):
        up, down = (plane.image(antenna, UNKNOWN + sign * 1e-6 * np.eye(3)[k]) for sign in (1, -1))
        assert slope[k] == pytest.approx((up - down) / 2e-6, abs=1e-8)


def test_tilts_are_radians_by_which_the_normal_turns_wherever_it_points() -> None:
    for normal in (np.array([0.0, 0.0, 1.0]), np.array([0.6, 0.0, 0.8]), np.array([1.0, 1.0, 1.0]) / np.sqrt(3.0)):
        plane = MirrorPlane(np.zeros(3), normal, FLOOR_PLANE.name)
        axes = []
        for k in range(2):
            tilt = 1e-4 * np.eye(3)[k]
            # the image of a point lies along the normal of the plane as it is tilted
            along = normal - plane.image(normal, tilt)
            along /= np.linalg.norm(along)
            assert np.linalg.norm(np.cross(normal, along)) == pytest.approx(1e-4, rel=1e-3)
            axes.append(along - normal)
        assert abs(axes[0] @ axes[1]) < 1e-11


def test_turning_by_half_tangents_equals_the_exponential() -> None:
    phase = np.linspace(-200.0, 200.0, 5001)
    assert turned(phase) == pytest.approx(np.exp(1j * phase), abs=1e-12)


def test_the_range_factor_is_one_at_release_and_falls_with_both_distances() -> None:
    place = np.array([[0.0], [0.01], [-0.10]])
    assert range_factor(RELEASE_M[:, None], ANTENNAS, RELEASE_M) == pytest.approx(1.0)
    found = range_factor(place, ANTENNAS, RELEASE_M)[:, 0]
    for own, value in zip(ANTENNAS.receivers_m, found, strict=True):
        there, back = np.linalg.norm(place[:, 0] - ANTENNAS.transmitter_m), np.linalg.norm(place[:, 0] - own)
        was = np.linalg.norm(RELEASE_M - ANTENNAS.transmitter_m) * np.linalg.norm(RELEASE_M - own)
        assert value == pytest.approx(was / (there * back))


def test_the_strongest_functions_carry_the_kernel_of_the_process() -> None:
    place = np.stack([np.linspace(0.0, 0.02, 200), np.zeros(200), np.linspace(0.0, 0.25, 200)])
    functions = make_basis(place, 0.09)(place)
    square = ((place[:, :, None] - place[:, None]) ** 2).sum(axis=0)
    assert functions @ functions.T == pytest.approx(np.exp(-square / (2.0 * 0.09**2)), abs=5e-3)
    assert make_basis(place, 0.09, MapSettings(max_functions=4)).size == 4
    # as many as are not weaker than the weakest, a share of the strongest
    chosen = make_basis(place, 0.09).centre
    apart = ((chosen[:, :, None] - chosen[:, None]) ** 2).sum(axis=0)
    strength = np.linalg.eigvalsh(np.exp(-apart / (2.0 * 0.09**2)))
    for weakest in (0.2, 1e-3):
        few = make_basis(place, 0.09, MapSettings(weakest=weakest))
        assert few.size == (strength > weakest * strength[-1]).sum()
