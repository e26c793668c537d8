"""What sphere and floor send to and fro: two bodies against check values, another package and a simpler theory."""

from __future__ import annotations

import numpy as np
import pytest
from benchmarks.world.antenna import Antenna
from benchmarks.world.exchange import Exchange, incident, radiated, translation
from benchmarks.world.layers import reaction
from benchmarks.world.mirror import Conductor, Slab
from benchmarks.world.room import Room
from benchmarks.world.sphere import Sphere, coefficients

WAVENUMBER_RAD_M = 2.0 * np.pi * 10e9 / 299_792_458.0
FLOOR_M = -0.15
TILT = 0.7
UP = np.array([0.0, 0.0, 1.0])


def room(radius_m: float, reflection: float) -> Room:
    """The arrangement of the check values: point-like lobes, sphere on the axis."""
    outward = np.array([np.sin(TILT), 0.0, np.cos(TILT)])
    antennas = (
        Antenna(0.7 * UP, -UP, np.array([1.0, 0.0, 0.0]), 0.0),
        Antenna(0.7 * outward, -outward, np.array([np.cos(TILT), 0.0, -np.sin(TILT)]), 0.0),
    )
    floor = Conductor(UP, FLOOR_M, reflection * np.ones(2, complex))
    return Room(antennas, Sphere(radius_m, WAVENUMBER_RAD_M), (floor,))


def factor(radius_m: float, reflection: float, gaps_m: np.ndarray) -> np.ndarray:
    """All waves over those of image theory alone."""
    plain = room(radius_m, reflection)
    exchange = Exchange(radius_m, plain.sphere.series(), reflection, WAVENUMBER_RAD_M, 0.2)
    full = Room(plain.antennas, plain.sphere, plain.mirrors, exchange=exchange)
    place = np.zeros((3, gaps_m.size))
    place[2] = FLOOR_M + radius_m + gaps_m
    return full.received(0, place) / plain.received(0, place)


def test_waves_scattered_one_by_one_are_mies_amplitudes() -> None:
    rng = np.random.default_rng(4)
    ways = rng.standard_normal((2, 3, 30))
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    fields = rng.standard_normal((2, 3, 30)) + 1j * rng.standard_normal((2, 3, 30))
    fields -= ways * (ways * fields).sum(axis=1, keepdims=True)
    sphere = Sphere(0.005, WAVENUMBER_RAD_M)
    a, b = (np.concatenate([[0.0], -one[:8]])[:, None, None] for one in sphere.series())
    arriving, leaving = incident(ways[0], fields[0]), radiated(ways[1], fields[1])
    scattered = (leaving.m * b * arriving.m + leaving.n * a * arriving.n).sum(axis=(0, 1))
    np.testing.assert_allclose(scattered, sphere.scattered(ways[0], fields[0], ways[1], fields[1]), atol=1e-9)


# order l of the image, order v about the sphere, m, 2 K h; of M in M and of N in M: treams 0.4.7, whose B has the other
# sign where l + v is even, as its translation goes up
TRANSLATIONS = (
    (1, 1, 0, 1.5, 0.792346 - 1.392871j, 0.0),
    (1, 1, 1, 1.5, 0.601322 + 0.625698j, 1.044653 + 0.594259j),
    (2, 1, 1, 1.5, 0.438371 + 2.125974j, 2.605961 + 0.246611j),
    (3, 2, 1, 1.5, 0.531081 - 132.934580j, -33.382069 + 0.097420j),
    (2, 3, 2, 1.5, -0.440892 - 38.868552j, -23.630272 - 0.176635j),
    (1, 1, 1, 22.0, -0.003701 + 0.068011j, -0.003703 + 0.068152j),
    (3, 2, 1, 22.0, 0.120132 + 0.047432j, 0.124903 + 0.049054j),
    (5, 5, 3, 22.0, 0.035334 - 0.017123j, 0.038322 - 0.018775j),
)


@pytest.mark.parametrize(("order", "v", "m", "apart", "same", "other"), TRANSLATIONS)
def test_translations_are_those_of_another_package(
    order: int, v: int, m: int, apart: float, same: complex, other: complex
) -> None:
    matrix = translation(np.array([apart / 2.0]), m, 8)[0]
    half, first = len(matrix) // 2, max(m, 1)
    assert matrix[v - first, order - first] == pytest.approx(same, rel=2e-6, abs=1e-6)
    assert matrix[v - first + half, order - first] == pytest.approx(other, rel=2e-6, abs=1e-6)


# path in mm and modulus of the factor by gap under the sphere in mm: the shared table of check values
TABLE = {
    (0.0025, 0.66): {5: (0.035, 1.023), 10: (-0.093, 0.982), 20: (-0.014, 1.007), 50: (0.019, 1.001)},
    (0.0025, 1.0): {5: (0.068, 1.046), 20: (-0.022, 1.016)},
    (0.005, 0.12): {2: (0.085, 0.995), 5: (0.012, 0.983), 10: (-0.033, 1.006), 20: (0.011, 0.995), 50: (0.001, 0.997)},
    (0.005, 0.66): {2: (0.495, 1.094), 5: (0.558, 0.892), 10: (0.241, 1.019), 20: (0.181, 0.980)},
    (0.005, 1.0): {2: (0.819, 1.240), 5: (1.045, 0.871), 10: (0.287, 0.939), 20: (0.336, 0.977)},
    (0.008, 1.0): {2: (1.937, 0.960), 5: (1.777, 0.937), 10: (0.411, 0.931)},
}


@pytest.mark.parametrize(("radius_m", "reflection"), TABLE)
def test_near_the_floor_the_factor_is_that_of_the_table(radius_m: float, reflection: float) -> None:
    # plane waves there, spherical ones here: 0.04 mm and a hundredth
    told = TABLE[radius_m, reflection]
    found = factor(radius_m, reflection, 1e-3 * np.array(list(told)))
    path_mm, modulus = np.array(list(told.values())).T
    np.testing.assert_allclose(1e3 * np.angle(found) / WAVENUMBER_RAD_M, path_mm, atol=0.04)
    np.testing.assert_allclose(np.abs(found), modulus, atol=0.01)


def test_far_from_the_floor_one_plane_wave_comes_back() -> None:
    gaps_m = np.array([0.1, 0.15])
    plain = room(0.005, 1.0)
    once = Room(plain.antennas, plain.sphere, plain.mirrors, coupled=plain.mirrors)
    place = np.zeros((3, 2))
    place[2] = FLOOR_M + 0.005 + gaps_m
    simple = once.received(0, place) / plain.received(0, place) - 1.0
    assert np.abs(factor(0.005, 1.0, gaps_m) - 1.0 - simple).max() < 0.05 * np.abs(simple).max()


def test_two_more_orders_change_nothing_and_no_reflection_no_exchange() -> None:
    series = coefficients(WAVENUMBER_RAD_M * 0.008)
    gaps_m = np.array([0.0, 0.001, 0.03])
    way = np.array([[0.1, 0.2, 0.3], [0.0, 0.1, 0.0], [-1.0, -1.0, -1.0]])
    way /= np.linalg.norm(way, axis=0)
    field = np.cross(way, [[0.0], [1.0], [0.0]], axis=0).astype(complex)

    def sent(orders: int, reflection: float) -> np.ndarray:
        exchange = Exchange(0.008, series, reflection, WAVENUMBER_RAD_M, 0.05, orders)
        return exchange.received(gaps_m, incident(way, field, orders), [radiated(-way, field, orders)])[0]

    change = np.abs(sent(10, 0.95) - sent(8, 0.95))
    assert change[0] < 0.01  # touching
    assert change[1:].max() < 1e-3
    assert np.abs(sent(8, 0.0)).max() < 1e-12


@pytest.mark.parametrize("m", [0, 1, 3])
def test_plane_waves_of_all_directions_come_back_from_a_conductor_as_its_image_sends_them(m: int) -> None:
    heights = np.array([0.55, 1.2, 5.0, 60.0])
    order = np.arange(max(m, 1), 7)
    parity = (-1.0) ** (order + m)
    image = translation(heights, m, 6) * np.concatenate([parity, -parity])
    found = reaction(heights, m, 6, lambda cosine: (np.ones_like(cosine), np.ones_like(cosine)))
    size = np.sqrt(np.abs(np.einsum("nii->ni", image)))
    assert (np.abs(found - image) / (size[:, :, None] * size[:, None])).max() < 1e-6


def test_a_plate_is_no_mirror_of_one_reflection() -> None:
    series = coefficients(WAVENUMBER_RAD_M * 0.005)
    gaps_m = np.array([0.003, 0.008])
    glass = Slab(UP, 0.0, (2.55 + 0.005j) ** 2, thickness_m=0.01, wavenumber_rad_m=WAVENUMBER_RAD_M)
    way, field = np.array([[0.0], [0.0], [-1.0]]) * np.ones(2), np.array([[1.0], [0.0], [0.0]]) * np.ones(2) + 0j
    one, each = (
        Exchange(0.005, series, glass.straight_down(), WAVENUMBER_RAD_M, 0.01, layers=layers).received(
            gaps_m, incident(way, field), [radiated(-way, field)]
        )[0]
        for layers in (None, glass.over_conductor)
    )
    assert (np.abs(one / each - 1.0) > 0.03).all()
