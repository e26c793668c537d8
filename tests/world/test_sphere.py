"""The simulator's Mie series against tabulated values, the optical theorem, both limits of size, and reciprocity."""

from __future__ import annotations

import numpy as np
import pytest
from benchmarks.world.sphere import Sphere, coefficients

ANGLES = np.cos(np.radians([0.0, 40.0, 140.0]))
TABULATED = {
    0.52: (
        (0.01718 - 0.08830j, 0.01660 - 0.10342j, 0.01283 - 0.19161j),
        (0.01718 - 0.08830j, 0.01373 - 0.05160j, -0.00882 + 0.17186j),
    ),
    1.05: (
        (0.59347 - 0.40550j, 0.57179 - 0.51013j, 0.43605 - 0.89180j),
        (0.59347 - 0.40550j, 0.47229 - 0.16892j, -0.30120 + 0.83147j),
    ),
    1.68: (
        (1.49874 - 0.45164j, 1.26741 - 0.77224j, 0.04741 - 0.67578j),
        (1.49874 - 0.45164j, 1.12290 + 0.35852j, 0.05323 + 0.87969j),
    ),
}


def unit(rng: np.random.Generator, count: int) -> np.ndarray:
    vectors = rng.standard_normal((3, count))
    return vectors / np.linalg.norm(vectors, axis=0)


def across(rng: np.random.Generator, direction: np.ndarray) -> np.ndarray:
    field = rng.standard_normal(direction.shape) + 1j * rng.standard_normal(direction.shape)
    return field - direction * (direction * field).sum(axis=0)


@pytest.mark.parametrize("size", TABULATED)
def test_amplitudes_are_those_tabulated(size: float) -> None:
    s1, s2 = Sphere(size, 1.0).amplitudes(ANGLES)
    np.testing.assert_allclose(s1, TABULATED[size][0], atol=1.1e-5)
    np.testing.assert_allclose(s2, TABULATED[size][1], atol=1.1e-5)


@pytest.mark.parametrize("size", [0.05, 0.5, 1.7, 12.0, 60.0])
def test_a_conductor_scatters_all_that_it_takes_from_the_wave(size: float) -> None:
    cosine, weight = np.polynomial.legendre.leggauss(400)
    sphere = Sphere(size, 1.0)
    s1, s2 = sphere.amplitudes(cosine)
    scattered = np.pi * weight @ (np.abs(s1) ** 2 + np.abs(s2) ** 2)
    taken = 4.0 * np.pi * sphere.amplitudes(np.array([1.0]))[0][0].real
    assert scattered == pytest.approx(taken, rel=1e-9)


@pytest.mark.parametrize("size", [0.3, 1.0, 2.0, 40.0])
def test_each_coefficient_of_a_body_without_loss_lies_on_its_circle(size: float) -> None:
    for one in coefficients(size):
        np.testing.assert_allclose(np.abs(one - 0.5), 0.5, rtol=1e-12)


def test_a_small_sphere_is_an_electric_and_half_a_magnetic_dipole() -> None:
    size = 0.003
    cosine = np.linspace(-1.0, 1.0, 9)
    s1, s2 = Sphere(size, 1.0).amplitudes(cosine)
    np.testing.assert_allclose(s1 / size**3, -1j * (1.0 - cosine / 2.0), atol=3e-5)
    np.testing.assert_allclose(s2 / size**3, -1j * (cosine - 0.5), atol=3e-5)


def test_a_large_sphere_sends_back_what_its_disc_takes() -> None:
    size = 300.0
    s1, _ = Sphere(size, 1.0).amplitudes(np.array([-1.0]))
    assert 4.0 * np.abs(s1[0]) ** 2 == pytest.approx(size**2, rel=0.01)


def test_sender_and_receiver_may_change_places() -> None:
    rng = np.random.default_rng(1)
    sphere = Sphere(0.006, 210.0)
    way, back = unit(rng, 50), unit(rng, 50)
    field, receiving = across(rng, way), across(rng, back)
    there = sphere.scattered(way, field, back, receiving)
    np.testing.assert_allclose(sphere.scattered(-back, receiving, -way, field), there, rtol=1e-9)


@pytest.mark.parametrize("straight", [1.0, -1.0], ids=["forward", "backward"])
def test_straight_on_and_straight_back_are_the_limits_of_nearby_directions(straight: float) -> None:
    rng = np.random.default_rng(2)
    sphere = Sphere(0.006, 210.0)
    way = unit(rng, 20)
    field, receiving = across(rng, way), across(rng, way)
    near = straight * way + 1e-6 * np.cross(way, unit(rng, 20), axis=0)
    near /= np.linalg.norm(near, axis=0)
    exact = sphere.scattered(way, field, straight * way, receiving)
    np.testing.assert_allclose(sphere.scattered(way, field, near, receiving), exact, atol=1e-4)
