"""Where a plate ends: against the generator's integral, far edges, and slopes against differences."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from benchmarks.world.mirror import Plate

from radargui.model.setup import parse_setup
from radargui.physics.edges import OverPlate, StatedEdges, sides_of

K = 2.0 * np.pi / 0.03
ANTENNAS_M = np.array([[0.02, -0.01, 0.7], [0.4, 0.15, 0.5]])
PLACE_M = np.array([0.003, -0.002, 0.0])[:, None] + np.array([0.0, 0.0, 1.0])[:, None] * np.geomspace(0.003, 0.25, 60)
HALF_M, AZIMUTH_RAD, MIDDLE_M = np.array([0.05, 0.035]), 0.4, np.array([0.008, -0.005])
UPRIGHT = np.array([0.0, 0.0, 1.0])


def over(half_m: np.ndarray = HALF_M) -> OverPlate:
    sides = sides_of(UPRIGHT, AZIMUTH_RAD)
    across = sides @ PLACE_M - (ANTENNAS_M @ sides.T)[..., None]
    aside = np.broadcast_to(sides @ (PLACE_M - np.array([*MIDDLE_M, 0.0])[:, None]), across.shape)
    height = np.broadcast_to(PLACE_M[2], (2, PLACE_M.shape[1]))
    return OverPlate(height, ANTENNAS_M[:, 2:], across, aside, half_m, np.array([0.5, 0.5]), K)


def test_the_wave_over_a_plate_is_that_of_the_generator() -> None:
    sides = sides_of(UPRIGHT, AZIMUTH_RAD)
    plate = Plate(np.array([*MIDDLE_M, 0.0]), sides, (float(HALF_M[0]), float(HALF_M[1])))
    # half of this field is across each edge
    field = np.repeat((sides[0] + sides[1])[:, None].astype(complex), PLACE_M.shape[1], axis=1)
    for antenna_m, found in zip(ANTENNAS_M, over().value(), strict=True):
        np.testing.assert_allclose(found, plate.seen(antenna_m, PLACE_M, UPRIGHT, field, K), atol=1e-9)
    # a receiver's spot leaves a plate of 7 cm when the sphere is some centimetres up
    assert np.abs(over().value()[1, -1]) < 0.2


def kirchhoff(antenna_m: np.ndarray, place_m: np.ndarray) -> complex:
    """Return the integral over the plate itself, over the wave of the antenna's image."""
    nodes, weights = np.polynomial.legendre.leggauss(160)
    u, v = (half * nodes for half in HALF_M)
    spot = (sides_of(UPRIGHT, AZIMUTH_RAD).T @ np.stack([*np.meshgrid(u, v, indexing="ij")]).reshape(2, -1)).T
    spot = spot + np.array([*MIDDLE_M, 0.0])
    there, here = np.linalg.norm(spot - antenna_m, axis=1), np.linalg.norm(spot - place_m, axis=1)
    slopes = ((1.0 / one - 1j * K) * height / one for one, height in ((there, antenna_m[2]), (here, place_m[2])))
    waves = 0.5 * sum(slopes) * np.exp(1j * K * (there + here)) / (there * here) * np.outer(weights, weights).ravel()
    length = np.linalg.norm(place_m - antenna_m * [1, 1, -1])
    return complex(HALF_M.prod() / (2.0 * np.pi) * waves.sum() * length * np.exp(-1j * K * length))


def test_it_is_kirchhoffs_integral_but_for_the_corners() -> None:
    for antenna_m, found in zip(ANTENNAS_M, over().value(), strict=True):
        expected = [kirchhoff(antenna_m, place_m) for place_m in PLACE_M.T]
        assert np.abs(found - expected).max() < 0.12
        assert np.abs(np.array(expected) - 1.0).max() > 0.4


def test_a_large_plate_counts_as_endless() -> None:
    assert np.abs(over(np.array([30.0, 30.0])).value() - 1.0).max() < 0.02


@pytest.mark.parametrize("name", ["half", "height_m", "antenna_m", "across_m", "aside_m"])
def test_slopes_are_those_of_differences_up_to_the_strength_of_tails(name: str) -> None:
    ways = over()
    by_half, by_length = ways.slopes()
    for side in (0, 1):
        step = 1e-7 * np.eye(2)[side]
        if name == "half":
            changed = [replace(ways, half_m=HALF_M + sign * step) for sign in (1.0, -1.0)]
            found = by_half[:, side]
        elif name in ("across_m", "aside_m"):
            changed = [replace(ways, **{name: getattr(ways, name) + sign * step[:, None]}) for sign in (1.0, -1.0)]
            found = by_length[:, (2 if name == "across_m" else 4) + side]
        else:
            changed = [replace(ways, **{name: getattr(ways, name) + sign * 1e-7}) for sign in (1.0, -1.0)]
            found = by_length[:, 0 if name == "height_m" else 1]
        expected = (np.log(changed[0].value()) - np.log(changed[1].value())) / 2e-7
        assert np.sqrt((np.abs(found - expected) ** 2).mean()) < 0.1 * np.sqrt((np.abs(expected) ** 2).mean())


def test_edges_that_are_stated_are_unknowns_about_what_is_said() -> None:
    text = (
        "schema = 1\n[radar]\n[transmitter]\ndistance_m = 0.7\n[[receiver]]\ntilt_deg = 40\nazimuth_deg = 90\n"
        "distance_m = 0.7\n[tracer]\nrelease_position_m = [0.01, 0.02, 0.1]\n[floor]\n"
    )
    assert StatedEdges.of(parse_setup(text)) is None
    plain = StatedEdges.of(parse_setup(f"{text}size_m = [0.1, 0.08]\n"))
    assert plain is not None
    np.testing.assert_allclose(plain.values, [0.05, 0.04, 0.0, 0.01, 0.02])
    told = StatedEdges.of(parse_setup(f"{text}size_m = [0.1, 0.08]\nmiddle_m = [0.0, 0.0]\nu_middle_m = 0.001\n"))
    assert told is not None
    np.testing.assert_allclose(told.values[3:], 0.0)
    np.testing.assert_allclose(told.u[3:], 0.001)
