"""Walls of a container in the rays: what they delay, where they end, who must say all of them."""

from __future__ import annotations

import numpy as np
import pytest
from support.changed import changed
from support.simulated_setup import perfect_setup

from radargui.model.errors import SetupError
from radargui.model.radar import Walls
from radargui.model.result import PathLengths
from radargui.model.setup import Setup, parse_setup
from radargui.physics.path_length import locate_exact, path_lengths, place_antennas
from radargui.physics.scattering import path_delay, wall_factor
from radargui.processing.measured_motion import locate_body
from radargui.sources.simulated.waves import make_waves

WAVENUMBER = 2.0 * np.pi / 0.03
FOAM = Walls(wall_m=0.03, refractive_index=1.02, height_m=0.2, inner_m=(0.3, 0.3))
TABLE = {"wall_m": 0.03, "refractive_index": 1.02, "height_m": 0.2, "inner_m": (0.3, 0.3)}


def delayed_mm(place_m: tuple[float, float, float], antenna_m: tuple[float, float, float]) -> float:
    factor = wall_factor(np.array([place_m]).T, np.array(antenna_m), FOAM, WAVENUMBER)
    assert abs(factor[0]) == pytest.approx(1.0, abs=0.1)
    return float(1e3 * np.angle(factor[0]) / WAVENUMBER)


def test_a_wall_lengthens_the_way_by_what_it_is_denser_along_the_ray() -> None:
    # 20 cm below the rim the edge leaves a few per cent of 0.6 mm
    assert delayed_mm((0.0, 0.0, 0.0), (0.7, 0.0, 0.0)) == pytest.approx(0.6, abs=0.04)
    assert delayed_mm((0.0, 0.0, 0.0), (0.7, 0.5, 0.0)) == pytest.approx(0.6 / np.cos(np.arctan2(0.5, 0.7)), abs=0.05)


def test_nothing_is_delayed_over_the_rim_from_above_or_within() -> None:
    assert delayed_mm((0.0, 0.0, 0.45), (0.7, 0.0, 0.5)) == pytest.approx(0.0, abs=0.05)
    assert delayed_mm((0.0, 0.0, 0.1), (0.0, 0.0, 0.7)) == 0.0
    assert delayed_mm((0.0, 0.0, 0.0), (0.1, 0.0, 0.1)) == 0.0


def test_a_box_of_no_index_is_none() -> None:
    nothing = FOAM._replace(refractive_index=1.0)
    places = np.random.default_rng(1).uniform(-0.1, 0.1, (3, 50))
    assert np.array_equal(wall_factor(places, np.array([0.5, 0.2, 0.4]), nothing, WAVENUMBER), np.ones(50))


def foamy() -> Setup:
    return changed(perfect_setup(), container=TABLE)


def test_a_track_by_circles_has_the_delay_taken_off() -> None:
    setup = foamy()
    delay = path_delay(setup)
    assert delay is not None
    antennas, release = place_antennas(setup), np.array(setup.tracer.release_position_m)
    truth = np.array([np.full(200, 0.01), np.full(200, -0.02), np.linspace(0.12, -0.14, 200)])
    truth[:, 0] = release
    change = path_lengths(truth, antennas) - path_lengths(release[:, None], antennas) + delay.at(truth)
    assert np.abs(delay.at(truth)).max() > 2e-4
    off = locate_exact(change, antennas, release) - truth
    assert np.nanmax(np.abs(off)) > 1e-4
    time, known = np.arange(200.0), np.ones(change.shape, dtype=np.bool_)
    _, track = locate_body(PathLengths(time, change, change, np.full_like(change, 1e-6), known), setup)
    assert track is not None
    # in one step a hundredth of it is left
    assert np.abs(track.position_m - truth)[:, 1:].max() < 0.02 * np.abs(delay.at(truth)).max()


def test_the_simulated_source_has_the_same_walls() -> None:
    setup, plain = foamy(), perfect_setup()
    antennas = place_antennas(setup)
    place = np.array([[0.0, 0.01], [0.0, 0.02], [0.1, -0.12]])
    with_walls, without = (make_waves(one, antennas) for one in (setup, plain))
    ratio = with_walls.received(1, place, with_walls.at_tracer(place)) / without.received(
        1, place, without.at_tracer(place)
    )
    walls = setup.container.walls
    assert walls is not None
    expected = wall_factor(place, antennas.receivers_m[1], walls, 2.0 * np.pi / setup.radar.wavelength_m)
    # the amplitude is one at the release with its walls
    assert ratio[1] / ratio[0] == pytest.approx(expected[1] / expected[0], abs=1e-9)


def test_a_container_is_said_as_a_whole() -> None:
    text = "schema = 1\n[radar]\n[transmitter]\ndistance_m = 0.7\n[[receiver]]\ntilt_deg = 40\nazimuth_deg = 0\n"
    text += "distance_m = 0.7\n[container]\nwall_m = 0.03\n"
    with pytest.raises(SetupError, match=r"container\.inner_m left out, allowed: all of a container"):
        parse_setup(text)
