"""What the sphere does to the paths, against the worked example with a floor and against the setup's angles."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from radargui.estimation.forward.sphere import PolarisedSphere, polarised_sphere
from radargui.model.setup import Setup
from radargui.physics.mirrors import FLOOR, WALL, MirrorPlane
from radargui.physics.path_length import place_antennas

PLACE_M, RELEASE_M = np.array([[0.01], [-0.005], [0.05]]), np.array([0.0, 0.0, 0.125])
PLANE = MirrorPlane(np.array([0.0, 0.0, -0.145]), np.array([0.0, 0.0, 1.0]), FLOOR)
LEVEL = np.zeros(6)  # the plane as it is; it reflects nothing, so without exchange


def setup(**transmitter: float) -> Setup:
    return Setup.model_validate(
        {
            "schema": 1,
            "radar": {},
            "transmitter": {"distance_m": 0.7, **transmitter},
            "receiver": [{"tilt_deg": 40.0, "azimuth_deg": 211.0, "distance_m": 0.7}],
            "tracer": {"diameter_m": 0.010},
        }
    )


def worked_example() -> tuple[PolarisedSphere, Setup]:
    given = setup(polarization_deg=0.0)
    body = polarised_sphere(given)
    assert body is not None
    return body, given


def test_a_world_that_is_turned_about_the_vertical_with_its_polarisation_scatters_the_same() -> None:
    found = []
    for turned_deg in (0.0, 90.0, 50.0):
        given = setup(polarization_deg=30.0 + turned_deg)
        (receiver,) = given.receiver
        receiver = receiver.model_copy(update={"azimuth_deg": receiver.azimuth_deg + turned_deg})
        given = given.model_copy(update={"receiver": (receiver,)})
        body, c, s = polarised_sphere(given), *(f(np.radians(turned_deg)) for f in (np.cos, np.sin))
        assert body is not None
        turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        fields = body.fields(turn @ PLACE_M, place_antennas(given), RELEASE_M, (PLANE,), LEVEL)
        factors = fields.factors(0, *body.angle_rad)
        found.append(np.append(factors.direct, factors.mirrored.ravel()))
    assert found[1] == pytest.approx(found[0])
    assert found[2] == pytest.approx(found[0])


def test_a_setup_without_polarisation_has_a_point() -> None:
    assert polarised_sphere(setup()) is None


def test_the_factors_are_those_of_the_worked_example() -> None:
    body, given = worked_example()
    fields = body.fields(PLACE_M, place_antennas(given), RELEASE_M, (PLANE,), LEVEL)
    found = fields.factors(0, *body.angle_rad)
    assert found.direct == pytest.approx(1.03274 + 0.01324j, abs=2e-5)
    assert found.mirrored[1, 0] == pytest.approx(0.4374 + 0.4004j, abs=1e-4)
    assert found.mirrored[0, 1] == pytest.approx(0.5513 + 0.4213j, abs=1e-4)
    assert found.mirrored[1, 1] == pytest.approx(1.0514 + 0.0334j, abs=1e-4)


def test_the_single_mirror_of_the_wall_search_is_that_of_all_paths() -> None:
    body, given = worked_example()
    antennas = place_antennas(given)
    angles = body.angle_rad + 0.2
    whole = body.fields(PLACE_M, antennas, RELEASE_M, (PLANE,), LEVEL).factors(0, *angles).mirrored
    by_transmitter, by_receiver = body.over_mirrors(PLACE_M, antennas, (PLANE, PLANE), angles)
    for number in range(2):
        assert by_transmitter[number, 0] == pytest.approx(whole[1, 0])
        assert by_receiver[number, 0] == pytest.approx(whole[0, 1])


def test_polarisations_that_the_setup_calls_exact_are_held() -> None:
    body = polarised_sphere(setup(polarization_deg=30.0, u_polarization_deg=0.0))
    assert body is not None
    assert np.degrees(body.angle_rad[0]) == pytest.approx(30.0)
    assert body.u_angle_rad[0] < 1e-5
    assert np.degrees(body.u_angle_rad[1]) == pytest.approx(5.0)


def test_what_the_sphere_scatters_over_a_wall_follows_the_wall() -> None:
    body, given = worked_example()
    antennas, planes = place_antennas(given), (PLANE, replace(PLANE, foot_m=np.array([0.2, 0.0, 0.0]), name=WALL))
    here, moved = np.zeros(11), np.zeros(11)
    moved[3:6] = 0.01, -0.01, 0.002
    at_first, there = (body.fields(PLACE_M, antennas, RELEASE_M, planes, one) for one in (here, moved))
    still, wanted = (one.factors(0, *body.angle_rad).mirrored for one in (at_first, there))
    found = at_first.moved(moved, PLACE_M).factors(0, *body.angle_rad).mirrored
    assert np.abs(wanted - still).max() > 0.01
    assert np.abs(found - wanted).max() < 0.05 * np.abs(wanted - still).max()
