"""A bed of grains: how deep and how long, and what its optical thickness adds to a way."""

from __future__ import annotations

import numpy as np
import pytest
from benchmarks.world.bed import Bed, Grains, friction_per_m, sinking
from benchmarks.world.draw import draw
from benchmarks.world.drop import Body
from benchmarks.world.mirror import Dielectric
from benchmarks.world.room import Room

BEADS = Body(0.005, 2700.0, 9.81)
UP = np.array([0.0, 0.0, 1.0])


def bed(index: float) -> Bed:
    return Bed(Grains(0.0, index), Dielectric(UP, 0.0, complex(index**2)))


@pytest.mark.parametrize(("depth", "drag"), [(0.01, 0.004), (0.03, 0.05), (0.06, 0.18)])
def test_it_stops_as_deep_as_the_equation_of_katsuragi_and_durian_says(depth: float, drag: float) -> None:
    arriving = np.array([0.0, 0.0, -1.7])
    friction = friction_per_m(BEADS, 1.7, depth, drag)
    position, stop_s = sinking(BEADS, arriving, friction, drag, 0.0, 0.1)
    assert position(np.array([stop_s, 2.0]))[2] == pytest.approx([-depth, -depth], rel=1e-4)
    time_s, step = np.linspace(0.1, 0.9, 9) * stop_s, 1e-5
    z = [-position(time_s + shift)[2] for shift in (-step, 0.0, step)]
    speed, acceleration = (z[2] - z[0]) / (2.0 * step), (z[2] - 2.0 * z[1] + z[0]) / step**2
    np.testing.assert_allclose(acceleration, 9.81 - speed**2 / drag - friction * z[1], rtol=1e-3, atol=0.02)


def test_it_goes_straight_on_at_first_and_sideways_less_and_less() -> None:
    position, stop_s = sinking(BEADS, np.array([0.05, 0.0, -1.5]), 400.0, 0.03, 0.0, 0.1)
    np.testing.assert_allclose(position(np.array([1e-5]))[:, 0], [5e-7, 0.0, -1.5e-5], rtol=1e-3)
    x = position(np.linspace(0.0, stop_s, 50))[0]
    assert (np.diff(x) > 0.0).all()
    assert x[-1] < 0.05 * stop_s


def test_it_settles_after_it_stopped() -> None:
    (still, stop_s), (settled, _) = (
        sinking(BEADS, np.array([0.0, 0.0, -1.5]), 400.0, 0.03, size, 0.2) for size in (0.0, 3e-4)
    )
    later = stop_s + np.array([-0.001, 0.2, 5.0])
    np.testing.assert_allclose((still(later) - settled(later))[2], [0.0, 3e-4 * (1.0 - np.exp(-1.0)), 3e-4], atol=1e-9)


def test_the_way_in_the_bed_is_longer_by_index_less_one_down_to_the_top_of_the_sphere() -> None:
    antenna, a = np.array([0.3, 0.0, 0.4]), 0.004
    deep = np.array([[0.0], [0.0], [-0.05]])
    slant = np.hypot(0.3, 0.45) / 0.45
    assert bed(1.02).longer_m(antenna, deep, a, None)[0] == pytest.approx(0.02 * (0.05 - a) * slant)
    high = np.array([[0.0], [0.0], [0.05]])
    assert bed(1.02).longer_m(antenna, high, a, None)[0] == 0.0
    # over a bottom at -0.1: from the surface down and up again, to a sphere above and to one inside
    image = np.array([0.3, 0.0, -0.6])
    assert bed(1.02).longer_m(image, high, a, -0.1)[0] == pytest.approx(0.02 * 0.2 * np.hypot(0.3, 0.65) / 0.65)
    assert bed(1.02).longer_m(image, deep, a, -0.1)[0] == pytest.approx(0.02 * 0.15 * np.hypot(0.3, 0.55) / 0.55)


def test_the_surface_mirrors_for_a_sphere_above_it_alone() -> None:
    z = np.array([-0.02, -0.004, 0.0, 0.004, 0.02])
    places = np.stack([np.zeros(5), np.zeros(5), z])
    np.testing.assert_allclose(bed(1.01).above(places, 0.004), [0.0, 0.0, 0.5, 1.0, 1.0])


def test_a_bed_of_air_changes_nothing_and_one_of_beads_turns_the_phase_by_its_thickness() -> None:
    scene = draw(3, motion="bed", floor=0.0, walls=0, index=1.02)
    room, grains = scene.room, scene.room.bed.grains
    # as deep as two radii: the top of the sphere lies one radius deep
    places = np.array([[0.0], [0.0], [grains.surface_z_m - 2.0 * scene.body.radius_m]])
    none, air = (
        Room(room.antennas, room.sphere, bed=b) for b in (None, Bed(Grains(grains.surface_z_m, 1.0), room.bed.surface))
    )
    np.testing.assert_allclose(air.received(0, places), none.received(0, places), rtol=1e-12)
    away = [places[:, 0] - room.antennas[k].position_m for k in (0, 1)]
    longer = sum(0.02 * scene.body.radius_m * np.linalg.norm(one) / abs(one[2]) for one in away)
    turned = np.angle(room.received(0, places) / none.received(0, places))[0]
    assert turned == pytest.approx(room.sphere.wavenumber_rad_m * longer, rel=1e-6)
