"""Mirrors: a conductor's boundary condition, Fresnel's limits."""

from __future__ import annotations

import numpy as np
import pytest
from benchmarks.world.mirror import Conductor, Dielectric, permittivity_of

NORMAL = np.array([0.2, -0.1, 1.0]) / np.linalg.norm([0.2, -0.1, 1.0])
ACROSS = np.cross(NORMAL, [1.0, 0.0, 0.0]) / np.linalg.norm(np.cross(NORMAL, [1.0, 0.0, 0.0]))


def wave(degrees: float, turned: float) -> tuple[np.ndarray, np.ndarray]:
    """A wave that falls on the plane under an angle, its field turned from the plane of incidence."""
    angle = np.radians(degrees)
    direction = np.sin(angle) * ACROSS - np.cos(angle) * NORMAL
    side = np.cross(NORMAL, ACROSS)
    field = np.cos(turned) * np.cross(side, direction) + np.sin(turned) * side
    return direction[:, None], field[:, None].astype(complex)


def test_points_on_the_plane_are_their_own_images_and_mirroring_twice_is_nothing() -> None:
    mirror = Conductor(NORMAL, -0.15)
    point = np.array([0.1, 0.3, 0.6])
    on_plane = point - mirror.height_m(point) * NORMAL
    np.testing.assert_allclose(mirror.image(on_plane), on_plane, atol=1e-15)
    np.testing.assert_allclose(mirror.image(mirror.image(point)), point, atol=1e-15)
    assert mirror.height_m(mirror.image(point)) == pytest.approx(-mirror.height_m(point))


@pytest.mark.parametrize("degrees", [0.0, 20.0, 70.0])
def test_on_a_conductor_the_field_along_the_surface_vanishes(degrees: float) -> None:
    direction, field = wave(degrees, 0.7)
    total = field + Conductor(NORMAL, 0.0).reflected(direction, field, 0)
    np.testing.assert_allclose(np.cross(NORMAL, total[:, 0]), 0.0, atol=1e-14)


@pytest.mark.parametrize("degrees", [0.0, 20.0, 70.0])
def test_a_dielectric_of_large_permittivity_is_a_conductor(degrees: float) -> None:
    direction, field = wave(degrees, 0.7)
    reflected = Dielectric(NORMAL, 0.0, 1e12 + 0j).reflected(direction, field, 0)
    np.testing.assert_allclose(reflected, Conductor(NORMAL, 0.0).reflected(direction, field, 0), atol=1e-5)


def test_at_brewsters_angle_nothing_of_the_field_in_the_plane_of_incidence_comes_back() -> None:
    permittivity = 2.5
    direction, field = wave(np.degrees(np.arctan(np.sqrt(permittivity))), 0.0)
    reflected = Dielectric(NORMAL, 0.0, permittivity + 0j).reflected(direction, field, 0)
    np.testing.assert_allclose(reflected, 0.0, atol=1e-14)


@pytest.mark.parametrize("turned", [0.0, 0.7])
def test_straight_down_a_dielectric_sends_back_the_share_asked_for(turned: float) -> None:
    direction, field = wave(0.0, turned)
    reflected = Dielectric(NORMAL, 0.0, complex(permittivity_of(0.2))).reflected(direction, field, 0)
    np.testing.assert_allclose(reflected, -0.2 * field, atol=1e-14)


def test_what_comes_back_across_grows_with_the_angle_and_stays_across_the_new_direction() -> None:
    mirror = Dielectric(NORMAL, 0.0, 2.5 + 0.1j)
    sizes = []
    for degrees in (10.0, 45.0, 80.0):
        direction, field = wave(degrees, np.pi / 2.0)
        reflected = mirror.reflected(direction, field, 0)
        sizes.append(np.linalg.norm(reflected))
        assert abs(mirror.mirrored(direction)[:, 0] @ reflected[:, 0]) < 1e-14
    assert sizes[0] < sizes[1] < sizes[2] < 1.0
