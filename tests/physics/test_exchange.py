"""What sphere and floor send to and fro: check values, conservation of energy, and the generator's own two bodies."""

from __future__ import annotations

import numpy as np
import pytest
from benchmarks.world.exchange import Exchange, incident, radiated
from benchmarks.world.sphere import coefficients

from radargui.model.scattering import mie_sphere, scattered_signals, unit_vectors
from radargui.physics.plate import Plate, exchanged_signals

WAVENUMBER_RAD_M = 2.0 * np.pi * 10e9 / 299_792_458.0
WAVELENGTH_M = 2.0 * np.pi / WAVENUMBER_RAD_M
UP, MIRROR = np.array([0.0, 0.0, 1.0]), np.array([1.0, 1.0, -1.0])
TILT_RAD = 0.7


def signals(radius_m: float, height_m: np.ndarray, reflection: complex, *ways: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return what is exchanged, and scattered once, for one field of every way in and out, (n_in, n_out, n)."""
    sphere = mie_sphere(radius_m, WAVELENGTH_M)
    way_in, sent, way_out, got = ways
    found = exchanged_signals(sphere, height_m, reflection, UP, way_in, sent[:, None], way_out, got[:, None])
    once = scattered_signals(sphere, way_in[:, None], sent[:, None, None], way_out[None], got[None, :, None])
    return found.signal[:, :, 0, 0], once[:, :, 0, 0]


def random_ways(rng: np.random.Generator, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Return directions (n, 3, 1) and fields across them, (n, 3)."""
    ways, fields = unit_vectors(rng.standard_normal((2, 3, n)))
    fields -= ways * (ways * fields).sum(axis=0)
    return ways.T[..., None], fields.T


# path in mm and modulus of all waves over those of image theory by gap under the sphere in mm: the shared check values;
# where the waves of image theory all but cancel (10 and 20 mm under the large spheres) they hang on the antennas' ways
TABLE = {
    (0.0025, 0.66): {2: (-0.180, 0.981), 5: (0.035, 1.023), 10: (-0.093, 0.982), 20: (-0.014, 1.007)},
    (0.0025, 1.0): {2: (-0.607, 0.994), 5: (0.068, 1.046), 20: (-0.022, 1.016)},
    (0.005, 0.12): {2: (0.085, 0.995), 5: (0.012, 0.983), 10: (-0.033, 1.006), 20: (0.011, 0.995)},
    (0.005, 0.66): {2: (0.495, 1.094), 5: (0.558, 0.892), 10: (0.241, 1.019), 20: (0.181, 0.980)},
    (0.005, 1.0): {2: (0.819, 1.240), 5: (1.045, 0.871), 10: (0.287, 0.939), 20: (0.336, 0.977)},
    (0.008, 1.0): {2: (1.937, 0.960), 5: (1.777, 0.937), 10: (0.411, 0.931)},
}


@pytest.mark.parametrize(("radius_m", "reflection"), TABLE)
def test_the_factor_near_the_floor_is_that_of_the_check_values(radius_m: float, reflection: float) -> None:
    told = TABLE[radius_m, reflection]
    height_m = radius_m + 1e-3 * np.array(list(told))
    place = np.zeros((3, height_m.size))
    place[2] = height_m
    floor_m = -0.15
    ends, ways, fields = [], [], []
    out = np.array([np.sin(TILT_RAD), 0.0, np.cos(TILT_RAD)])
    for end, field in ((0.7 * UP, [1.0, 0.0, 0.0]), (0.7 * out, [np.cos(TILT_RAD), 0.0, -np.sin(TILT_RAD)])):
        above = end - floor_m * UP
        points = np.array([above, above * MIRROR])
        from_point = place - points[..., None]
        length_m = np.linalg.norm(from_point, axis=1)
        ends.append(np.array([[1.0], [-reflection]]) * np.exp(1j * WAVENUMBER_RAD_M * length_m) / length_m)
        ways.append(unit_vectors(from_point))
        fields.append(np.array([field, field * MIRROR]))
    weight = ends[0][:, None] * ends[1]
    exchanged, once = signals(radius_m, height_m, reflection, ways[0], fields[0], -ways[1], fields[1])
    factor = (weight * (once + exchanged)).sum(axis=(0, 1)) / (weight * once).sum(axis=(0, 1))
    path_mm, modulus = np.array(list(told.values())).T
    np.testing.assert_allclose(1e3 * np.angle(factor) / WAVENUMBER_RAD_M, path_mm, atol=0.04)
    np.testing.assert_allclose(np.abs(factor), modulus, atol=0.01)


@pytest.mark.parametrize("radius_m", [0.0025, 0.0063, 0.008])
def test_the_exchange_is_that_of_the_generators_two_bodies_of_eight_orders(radius_m: float) -> None:
    rng = np.random.default_rng(7)
    gaps_m = np.array([0.001, 0.003, 0.02, 0.1])
    reflection = 0.9 * np.exp(0.4j)
    other = Exchange(radius_m, coefficients(WAVENUMBER_RAD_M * radius_m), reflection, WAVENUMBER_RAD_M, 0.12)
    size = np.abs(mie_sphere(radius_m, WAVELENGTH_M).parts(np.array([0.0]))[0])[0]
    for _ in range(4):
        (way_in, way_out), (sent, got) = random_ways(rng, 2)
        wide = np.ones(gaps_m.size)
        found, _ = signals(
            radius_m, radius_m + gaps_m, reflection, way_in[None] * wide, sent[None], way_out[None] * wide, got[None]
        )
        arriving = incident(way_in * wide, sent[:, None] * (wide + 0j))
        leaving = radiated(way_out * wide, got[:, None] * (wide + 0j))
        np.testing.assert_allclose(found[0, 0], other.received(gaps_m, arriving, [leaving])[0], atol=3e-3 * size)


def test_the_way_back_exchanges_as_the_way_there() -> None:
    ways, fields = random_ways(np.random.default_rng(2), 6)
    there, _ = signals(0.006, np.array([0.009]), 0.8 + 0.3j, ways[:3], fields[:3], ways[3:], fields[3:])
    back, _ = signals(0.006, np.array([0.009]), 0.8 + 0.3j, -ways[3:], fields[3:], -ways[:3], fields[:3])
    assert np.abs(there).max() > 0.01
    np.testing.assert_allclose(back[..., 0], there[..., 0].T, atol=1e-12)


@pytest.mark.parametrize(("radius_m", "gap_m"), [(0.0025, 0.002), (0.005, 0.001), (0.008, 0.005)])
def test_sphere_and_image_scatter_as_much_power_as_they_take_from_the_waves(radius_m: float, gap_m: float) -> None:
    # the optical theorem (Bohren & Huffman, eq. 3.24) of two spheres in two plane waves
    height = WAVENUMBER_RAD_M * (radius_m + gap_m)
    cosine, weight = np.polynomial.legendre.leggauss(24)
    azimuth = np.arange(24) * np.pi / 12.0
    z, phi = (one.ravel() for one in np.meshgrid(cosine, azimuth, indexing="ij"))
    out = np.stack([np.sqrt(1.0 - z**2) * np.cos(phi), np.sqrt(1.0 - z**2) * np.sin(phi), z], axis=1)
    around = np.stack([-np.sin(phi), np.cos(phi), 0.0 * phi], axis=1)
    way = unit_vectors(np.array([[0.3], [0.1], [-1.0]]))[:, 0]
    field = np.cross(way, [0.0, 1.0, 0.0])
    field /= np.linalg.norm(field)
    ways_in, fields_in = np.array([way, way * MIRROR]), np.array([field, field * MIRROR])
    arriving = np.array([1.0, -1.0]) * np.exp(1j * height * ways_in[:, 2])

    def scattered(ways: np.ndarray, fields: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        exchanged, once = signals(
            radius_m, np.array([radius_m + gap_m]), 1.0, ways_in[..., None], fields_in,
            np.concatenate([ways, ways * MIRROR])[..., None], np.concatenate([fields, fields * MIRROR]),
        )  # fmt: skip
        leaving = np.stack([np.exp(-1j * height * ways[:, 2]), -np.exp(1j * height * ways[:, 2])])
        by_way = [(arriving[:, None] * one[..., 0]).sum(axis=0).reshape(2, -1) for one in (once + exchanged, once)]
        return tuple((leaving * one).sum(axis=0) for one in by_way)

    def power(number: int) -> tuple[float, float]:
        fields = [scattered(out, one)[number] for one in (around, np.cross(around, out))]
        sent = (np.repeat(weight, 24) * (np.abs(np.array(fields)) ** 2).sum(axis=0)).sum() * np.pi / 12.0
        forward = scattered(ways_in, fields_in)[number] @ np.array([1.0, -1.0])
        return float(sent), float(4.0 * np.pi * forward.real)

    sent, taken = power(0)
    assert sent == pytest.approx(taken, rel=2e-3)
    sent, taken = power(1)
    assert abs(sent / taken - 1.0) > 0.02  # image theory alone does not


def test_a_plane_that_sends_nothing_back_exchanges_nothing_and_one_above_the_sphere_counts_as_touching() -> None:
    ways, fields = random_ways(np.random.default_rng(3), 2)
    given = ways[:1], fields[:1], ways[1:], fields[1:]
    assert not signals(0.005, np.array([0.007]), 0.0, *given)[0].any()
    touching, below = (signals(0.005, np.array([one]), 0.9, *given)[0] for one in (0.005, 0.002))
    assert np.abs(below) > 0.2 * np.abs(touching)
    assert np.abs(below) < 5.0 * np.abs(touching)


@pytest.mark.parametrize("plate", [Plate(2.55 + 0.005j, 0.01), Plate(1.61 + 0.01j, 0.01, None)])
@pytest.mark.parametrize("radius_m", [0.0025, 0.008])
def test_over_a_plate_each_direction_has_its_own_reflection(radius_m: float, plate: Plate) -> None:
    rng = np.random.default_rng(11)
    gaps_m = np.array([0.002, 0.006, 0.02])
    straight = plate.straight_down(WAVENUMBER_RAD_M)
    series = coefficients(WAVENUMBER_RAD_M * radius_m)
    other = Exchange(
        radius_m, series, straight, WAVENUMBER_RAD_M, 0.02, layers=lambda c: plate.coefficients(c, WAVENUMBER_RAD_M)
    )
    sphere = mie_sphere(radius_m, WAVELENGTH_M)
    size = np.abs(sphere.parts(np.array([0.0]))[0])[0]
    (way_in, way_out), (sent, got) = random_ways(rng, 2)
    wide = np.ones(gaps_m.size)
    ways = way_in[None] * wide, sent[None, None], way_out[None] * wide, got[None, None]
    found = exchanged_signals(sphere, radius_m + gaps_m, straight, UP, *ways, plate).signal[0, 0, 0, 0]
    one_reflection = exchanged_signals(sphere, radius_m + gaps_m, straight, UP, *ways).signal[0, 0, 0, 0]
    arriving = incident(way_in * wide, sent[:, None] * (wide + 0j))
    exact = other.received(gaps_m, arriving, [radiated(way_out * wide, got[:, None] * (wide + 0j))])[0]
    np.testing.assert_allclose(found, exact, atol=3e-3 * size)
    assert np.abs(one_reflection - exact).max() > 5.0 * np.abs(found - exact).max()


def test_a_plate_that_is_all_but_metal_exchanges_as_metal() -> None:
    ways, fields = random_ways(np.random.default_rng(5), 2)
    height_m = np.array([0.006, 0.05, 0.4])
    wide = np.ones(height_m.size)
    given = ways[:1] * wide, fields[:1, None], ways[1:] * wide, fields[1:, None]
    sphere = mie_sphere(0.005, WAVELENGTH_M)
    metal, mirror = (
        exchanged_signals(sphere, height_m, 0.9, UP, *given, plate).signal
        for plate in (Plate(None), Plate(1e6 + 1e6j, 0.01))
    )
    np.testing.assert_allclose(mirror, metal, rtol=2e-4)
