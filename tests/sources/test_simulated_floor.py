"""A floor that the setup states: what sphere and floor send to and fro, and where a plate ends."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from benchmarks.world.exchange import Exchange, incident, radiated, sum_of
from benchmarks.world.mirror import Conductor, Mirror, Plate, Slab
from support.changed import changed
from support.simulated_recording import simulate_recording
from support.simulated_setup import perfect_setup, simulated_setup

from radargui.model.radar import PLATES
from radargui.model.scattering import received_direction, scattered_signals, tracer_sphere, transmitted_direction
from radargui.model.setup import Setup
from radargui.physics.path_length import place_antennas
from radargui.processing.process import process
from radargui.sources.simulated.model import SimulatedRadar
from radargui.sources.simulated.scene import Scene
from radargui.sources.simulated.waves import Lobe, make_waves

UP = np.array([0.0, 0.0, 1.0])
FLOOR_M, WAVENUMBER = -0.15, 2.0 * np.pi * 10e9 / 299_792_458.0
STEEL, GLASS = {"material": "steel"}, {"material": "glass", "thickness_m": 0.01}
OF_STEEL = Conductor(UP, FLOOR_M)


def glass(plate: Plate | None = None) -> Slab:
    """Return the generator's floor of 10 mm of glass."""
    return Slab(
        UP, FLOOR_M, plate=plate, permittivity=PLATES["glass"] ** 2, thickness_m=0.01, wavenumber_rad_m=WAVENUMBER
    )


def sides(azimuth_deg: float) -> np.ndarray:
    """Return unit vectors along the sides of a level plate, shape (2, 3)."""
    along = np.array([np.cos(np.radians(azimuth_deg)), np.sin(np.radians(azimuth_deg)), 0.0])
    return np.array([along, np.cross(UP, along)])


def over(floor: dict[str, Any], *, diameter_m: float = 0.01, polarization_deg: float | None = 25.0, **kw: Any) -> Setup:
    """Return a setup with this floor at z = -0.15 and nothing else that disturbs."""
    settings = {"beamwidth_deg": 180.0, "reflection": None, **kw}
    setup = perfect_setup(floor={"height_m": FLOOR_M + 0.5 * diameter_m, **floor}, **settings)
    return changed(setup, transmitter={"polarization_deg": polarization_deg}, tracer={"diameter_m": diameter_m})


def received(setup: Setup, place: np.ndarray) -> np.ndarray:
    waves = make_waves(setup, place_antennas(setup))
    field = waves.at_tracer(place)
    return np.array([waves.received(receiver, place, field) for receiver in range(setup.n_receivers)])


def at_sphere(
    setup: Setup, antenna_m: np.ndarray, field: np.ndarray, place: np.ndarray, floor: Mirror
) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return direction and field (3, n) of the two waves of an antenna at places: directly, and over the floor."""
    out = []
    for is_low in (False, True):
        at, aim = (floor.image(one) if is_low else one for one in (antenna_m, np.zeros(3)))
        away, axis = place - at[:, None], (aim - at) / np.linalg.norm(aim - at)
        distance = np.linalg.norm(away, axis=0)
        gain = Lobe.of_beamwidth(setup.simulation.beamwidth_deg).gain(axis @ away / distance)
        sent = field[:, None] * (gain / distance * np.exp(1j * WAVENUMBER * distance))
        if is_low:
            sent = floor.reflected(floor.mirrored(away / distance), sent, 0)
            if floor.plate is not None:
                sent = sent * floor.plate.seen(antenna_m, place, UP, sent, WAVENUMBER)
        out.append((away / distance, sent))
    return out


def by_hand(setup: Setup, place: np.ndarray, floor: Mirror, *, exchange: bool = True) -> np.ndarray:
    """Return the signals of a sphere over a floor by the generator's reflection, edges and two bodies."""
    antennas, sphere = place_antennas(setup), tracer_sphere(setup.tracer, setup.radar)
    got = [received_direction(one.angle_deg, one.horizontal, one.vertical) for one in setup.received_fields()]
    sent = transmitted_direction(setup.transmitter.polarization_deg or 0.0)
    arriving = at_sphere(setup, antennas.transmitter_m, sent, place, floor)
    leaving = [
        [(-way, field) for way, field in at_sphere(setup, rx, own, place, floor)]
        for rx, own in zip(antennas.receivers_m, got, strict=True)
    ]
    out = np.zeros((len(got), place.shape[1]), complex)
    for row, ways in zip(out, leaving, strict=True):
        for way_in, one in arriving:
            for way_out, other in ways:
                for n in range(row.size):
                    fields = one[None, :, n], way_out[:, n : n + 1], other[None, :, n]
                    row[n] += scattered_signals(sphere, way_in[:, n : n + 1], *fields)[0, 0, 0]
    if exchange:
        radius_m = sphere.radius_m
        layers = floor.over_conductor if isinstance(floor, Slab) else None
        series, straight = (sphere.electric, sphere.magnetic), floor.straight_down()
        bodies = Exchange(radius_m, series, straight, WAVENUMBER, float(place[2].max()) - FLOOR_M, layers=layers)
        waves = sum_of(incident(*one) for one in arriving)
        out += bodies.received(
            place[2] - FLOOR_M - radius_m, waves, [sum_of(radiated(*one) for one in ways) for ways in leaving]
        )
    return out


def at_release(setup: Setup) -> np.ndarray:
    """Return how strong the direct wave of each receiver is at the release, where its amplitude is one."""
    nothing, release = Conductor(UP, FLOOR_M, reflection=np.zeros(9, complex)), setup.tracer.release_position_m
    return np.abs(by_hand(setup, np.array(release)[:, None], nothing, exchange=False))


def above(gaps_mm: list[float], diameter_m: float = 0.01, aside_m: float = 0.0) -> np.ndarray:
    """Return places with these gaps between sphere and floor, shape (3, n)."""
    place = np.outer(UP, FLOOR_M + 0.5 * diameter_m + 1e-3 * np.array(gaps_mm))
    place[0] += aside_m
    return place


# path in mm and modulus of all waves over those of image theory by gap under the sphere in mm, R = 1: the shared check
# values; where the waves of image theory all but cancel they hang on the antennas' ways
TABLE = {
    0.005: {2: (-0.607, 0.994), 5: (0.068, 1.046), 20: (-0.022, 1.016)},
    0.010: {2: (0.819, 1.240), 5: (1.045, 0.871), 10: (0.287, 0.939), 20: (0.336, 0.977)},
    0.016: {2: (1.937, 0.960), 5: (1.777, 0.937), 10: (0.411, 0.931)},
}


@pytest.mark.parametrize("diameter_m", TABLE)
def test_over_steel_a_sphere_that_hangs_near_the_floor_is_heard_as_the_check_values_say(diameter_m: float) -> None:
    plain, told = over(STEEL, diameter_m=diameter_m, polarization_deg=0.0).model_dump(by_alias=True), TABLE[diameter_m]
    one = {"tilt_deg": float(np.degrees(0.7)), "azimuth_deg": 0.0, "distance_m": 0.7, "polarization_deg": 90.0}
    setup = Setup.model_validate({**plain, "receiver": [one], "daq": {"rate_hz": 10000.0}})
    place = above([*map(float, told)], diameter_m)
    factor = received(setup, place)[0] / by_hand(setup, place, OF_STEEL, exchange=False)[0] * at_release(setup)[0]
    path_mm, modulus = np.array(list(told.values())).T
    np.testing.assert_allclose(1e3 * np.angle(factor) / WAVENUMBER, path_mm, atol=0.04)
    np.testing.assert_allclose(np.abs(factor), modulus, atol=0.02)


@pytest.mark.parametrize(
    ("stated", "floor", "index"), [(STEEL, OF_STEEL, None), (GLASS, glass(), None), (STEEL, OF_STEEL, 2.5)]
)
def test_over_a_stated_floor_the_signal_is_that_of_the_generators_two_bodies(
    stated: dict[str, Any], floor: Mirror, index: float | None
) -> None:
    setup, place = changed(over(stated), tracer={"refractive_index": index}), above([0.5, 3.0, 12.0], aside_m=0.01)
    found, scale = received(setup, place), at_release(setup)
    np.testing.assert_allclose(found, by_hand(setup, place, floor) / scale, atol=0.01)
    assert np.abs(found - by_hand(setup, place, floor, exchange=False) / scale).max() > 0.1


@pytest.mark.parametrize("stated", [STEEL, GLASS, {"reflection": 0.6}])
def test_samples_along_a_drop_are_those_of_each_place_by_itself(stated: dict[str, Any]) -> None:
    setup = over(stated, lateral_speed_m_s=0.05, kick_m_s=0.03, restitution=0.5, floor_tilt_deg=0.5, rest_s=0.01)
    radar, first_s = SimulatedRadar(setup), float(Scene(setup).trajectory.impact_time_s[0]) + 0.01
    first = round(first_s * 10000.0)
    for begin, step in ((0, 71), (first - 40, 2), (first + 40, 97)):
        samples = radar.samples(begin, 40 * step)[:, ::step]
        expected = received(setup, radar.truth(begin, 40 * step).position_m[:, ::step])
        np.testing.assert_allclose(samples[::2] + 1j * samples[1::2], expected, atol=2e-4)


@pytest.mark.parametrize("polarization_deg", [25.0, None])
def test_what_the_simulation_says_itself_of_the_bottom_goes_before_the_floor_that_is_stated(
    polarization_deg: float | None,
) -> None:
    place = above([1.0, 5.0, 100.0])
    own = over({}, reflection=0.3, polarization_deg=polarization_deg)
    stated = over(STEEL, reflection=0.3, polarization_deg=polarization_deg)
    np.testing.assert_array_equal(received(own, place), received(stated, place))


def test_over_a_plate_that_ends_the_signal_is_that_of_the_generators_edges() -> None:
    place = above([1.0, 4.0, 12.0], aside_m=0.004)
    size = {"size_m": [0.10, 0.08], "azimuth_deg": 20.0, "middle_m": [0.002, -0.003]}
    plate = Plate(np.array([0.002, -0.003, FLOOR_M]), sides(20.0), (0.05, 0.04))
    for stated, floor in ((STEEL, Conductor(UP, FLOOR_M, plate=plate)), (GLASS, glass(plate))):
        setup = over({**stated, **size})
        found, scale = received(setup, place), at_release(setup)
        np.testing.assert_allclose(found, by_hand(setup, place, floor) / scale, atol=0.01)
        assert np.abs(received(over(stated), place) - found).max() > 0.1


@pytest.mark.parametrize(("stated", "reflection"), [(STEEL, None), ({"reflection": 0.5}, None), ({}, 0.3)])
def test_beyond_the_edge_of_a_plate_the_wave_over_the_floor_fades(
    stated: dict[str, Any], reflection: float | None
) -> None:
    # above the middle, and beside the plate
    place, size = np.array([[0.0, 0.0], [0.0, 0.35], [FLOOR_M + 0.006, FLOOR_M + 0.02]]), {"size_m": [0.2, 0.2]}
    ends, endless, bare = (
        received(over(one, polarization_deg=None, reflection=by), place)
        for one, by in (({**stated, **size}, reflection), (stated, reflection), (stated, 0.0))
    )
    share = np.abs(ends - bare) / np.abs(endless - bare)
    assert (np.abs(share[:, 0] - 1.0) < 0.25).all()
    assert (share[:, 1] < 0.25).all()


@pytest.mark.slow
def test_a_drop_over_stated_steel_is_measured_within_its_uncertainty() -> None:
    setup = simulated_setup(
        floor={"height_m": FLOOR_M + 0.005, **STEEL}, daq={"rate_hz": 8000.0}, snr_db=36.0, restitution=0.6,
        rest_s=0.3, settle_s=0.2, bias=0.0, amplitude_variation=0.0, drag_per_m=0.0042, drag_slow_m_s=0.42,
    )  # fmt: skip
    setup = changed(setup, transmitter={"polarization_deg": 0.0}, processing={"correction": "flights"})
    result = process(simulate_recording(setup)[0], setup)
    assert result.status == "ok"
    assert result.quality is not None
    assert result.quality.method == "flights"
    assert result.warnings == ()
    impacts = [one for one in result.bounces.impacts[:3] if one.valid]
    assert len(impacts) >= 2
    for one in impacts:
        assert abs(one.e - 0.6) < 2.0 * one.u_e_combined
    assert impacts[0].u_e_combined < 1e-3
