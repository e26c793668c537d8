"""The room: conventions of polarisation, ratios of mirrored fields, boundary conditions, reciprocity."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from benchmarks.world.antenna import Antenna, receiver, transmitter
from benchmarks.world.mirror import Conductor, Dielectric
from benchmarks.world.room import Room
from benchmarks.world.sphere import Sphere

WAVENUMBER = 2.0 * np.pi * 10e9 / 299_792_458.0
UP = np.array([0.0, 0.0, 1.0])
P, P0 = np.array([[0.01], [-0.005], [0.05]]), np.array([[0.0], [0.0], [0.125]])


def tabulated_room(*reflection: complex) -> Room:
    """A 10 mm sphere, the transmitter along x, a receiver of 40 and 211 degrees for the strongest signal."""
    antennas = (transmitter(0.7, 0.0, 0.0), receiver(40.0, 211.0, 0.7, 56.05, 0.0))
    mirrors = (Conductor(UP, -0.145, np.array(reflection)),) if reflection else ()
    return Room(antennas, Sphere(0.005, WAVENUMBER), mirrors)


def image_factor(room: Room, antenna: int) -> complex:
    """What range and phase change between an antenna and its image in z = -0.145, seen from P."""
    place = room.antennas[antenna].position_m
    image = place * [1.0, 1.0, -1.0] - [0.0, 0.0, 0.29]
    near, far = (np.linalg.norm(P[:, 0] - one) for one in (place, image))
    return near / far * np.exp(1j * WAVENUMBER * (far - near))


def crowded_room() -> Room:
    wall = Conductor(np.array([-1.0, 0.0, 0.0]), -0.4, np.array([0.3j, 0.2]))
    floor = Dielectric(UP, -0.2, 2.0 + 0j)
    antennas = (transmitter(0.7, 25.0, 6.0), receiver(38.0, 100.0, 0.65, 70.0, 9.0))
    return Room(antennas, Sphere(0.006, WAVENUMBER), (floor, wall), ((wall, floor),), (floor,))


def test_a_receiver_turned_for_the_strongest_signal_has_the_tabulated_field() -> None:
    angles = np.concatenate([np.arange(0.0, 180.0, 2.0), np.arange(54.0, 58.0, 0.02)])
    source, centre = transmitter(0.7, 0.0, 0.0), np.zeros((3, 1))
    antennas = [receiver(40.0, 211.0, 0.7, angle, 0.0) for angle in angles]
    sphere = Sphere(0.005, WAVENUMBER)
    strengths = [abs(Room((source, one), sphere).direct(0, centre)[0]) for one in antennas]
    best = antennas[int(np.argmax(strengths))]
    np.testing.assert_allclose(best.polarization, [0.83232, -0.15138, 0.53322], atol=5e-4)


def test_the_direct_field_changes_over_the_fall_as_tabulated() -> None:
    room = tabulated_room()
    at, start = room.direct(0, P)[0], room.direct(0, P0)[0]
    ranges = [
        np.prod([np.linalg.norm(p[:, 0] - one.position_m) for one in room.antennas])
        * np.exp(-1j * WAVENUMBER * room.path_m(p)[0, 0])
        for p in (P, P0)
    ]
    assert at * ranges[0] / (start * ranges[1]) == pytest.approx(1.03274 + 0.01324j, abs=1e-5)


def test_mirrored_fields_relative_to_the_direct_one_are_those_tabulated() -> None:
    direct = tabulated_room().received(0, P)[0]
    by_sender = tabulated_room(1.0, 0.0).received(0, P)[0] / direct - 1.0
    by_receiver = tabulated_room(0.0, 1.0).received(0, P)[0] / direct - 1.0
    by_both = tabulated_room(1.0, 1.0).received(0, P)[0] / direct - 1.0 - by_sender - by_receiver
    factors = [image_factor(tabulated_room(), antenna) for antenna in (0, 1)]
    # the mirrored field keeps its sign in the table; the minus of a conductor stands outside
    assert -by_sender / factors[0] == pytest.approx(0.4374 + 0.4004j, abs=1e-4)
    assert -by_receiver / factors[1] == pytest.approx(0.5513 + 0.4213j, abs=1e-4)
    assert by_both / (factors[0] * factors[1]) == pytest.approx(1.0514 + 0.0334j, abs=1e-4)


def test_the_phase_of_a_tiny_sphere_grows_with_the_path() -> None:
    room = Room(tabulated_room().antennas, Sphere(1e-5, WAVENUMBER))
    step = np.array([[0.3e-4], [-0.2e-4], [-1e-4]])
    turned = np.angle(room.received(0, P + step)[0] / room.received(0, P)[0])
    assert turned == pytest.approx(WAVENUMBER * (room.path_m(P + step) - room.path_m(P))[0, 0], rel=1e-3)


def test_sender_and_receiver_may_change_places_in_a_crowded_room() -> None:
    room = crowded_room()
    floor, wall = room.mirrors
    assert isinstance(wall, Conductor)
    swapped_wall = replace(wall, reflection=wall.reflection[::-1])
    swapped = Room(room.antennas[::-1], room.sphere, (floor, swapped_wall), ((swapped_wall, floor),), (floor,))
    places = np.random.default_rng(3).uniform(-0.1, 0.1, (3, 20))
    np.testing.assert_allclose(swapped.received(0, places), room.received(0, places), rtol=1e-9)


@pytest.mark.parametrize("on", ["floor", "wall"])
def test_in_a_conducting_corner_the_field_along_both_surfaces_vanishes(on: str) -> None:
    ones = np.ones(1, complex)
    floor, wall = Conductor(UP, -0.2, ones), Conductor(np.array([0.0, -1.0, 0.0]), -0.3, ones)
    antenna = Antenna(np.array([0.1, 0.0, 0.7]), np.array([0.0, 0.6, -0.8]), np.array([0.36, 0.48, 0.8]), 0.0)
    room = Room((antenna,), Sphere(0.005, WAVENUMBER), (floor, wall), ((wall, floor),))
    rng = np.random.default_rng(4)
    places = rng.uniform([[-0.1], [0.0], [-0.2]], [[0.1], [0.3], [0.1]], (3, 10))
    if on == "floor":
        places[2] = -0.2
    else:
        places[1] = 0.3
    ways = [field for _, field in room._ways(0, places)]
    assert len(ways) == 4
    normal = (floor if on == "floor" else wall).normal
    along = np.cross(normal, sum(ways), axisb=0, axisc=0)
    assert np.abs(along).max() < 1e-12 * np.abs(ways[0]).max()


def test_a_wall_between_antenna_and_sphere_reflects_nothing_of_that_antenna() -> None:
    behind = receiver(40.0, 0.0, 0.7, 0.0, 4.0)  # 0.45 m along x: behind a wall at 0.3 m
    wall = Conductor(np.array([-1.0, 0.0, 0.0]), -0.3, np.ones(2, complex))
    room = Room((transmitter(0.7, 0.0, 4.0), behind), Sphere(0.005, WAVENUMBER), (wall,))
    assert len(list(room._ways(0, P))) == 2
    assert len(list(room._ways(1, P))) == 1


def test_a_large_sphere_sends_a_mirror_what_a_convex_mirror_of_its_curvature_would() -> None:
    """A wave straight up meets a mirror of focal length a / 2 and comes back over a conductor, 2 h away."""
    radius_m, height_m = 0.5, 400.0
    antenna = transmitter(5000.0, 30.0, 0.0)
    floor = Conductor(UP, -height_m, np.ones(1, complex))
    room = Room((antenna,), Sphere(radius_m, WAVENUMBER))
    straight = list(room._ways(0, np.zeros((3, 1))))
    upward = [(-straight[0][0], straight[0][1])]
    direction, field = room._returned(floor, upward, np.zeros((3, 1)))
    np.testing.assert_allclose(direction[:, 0], UP, atol=1e-12)
    expected = radius_m / 2.0 / (2.0 * height_m)
    assert np.linalg.norm(field) / np.linalg.norm(straight[0][1]) == pytest.approx(expected, rel=0.01)
