"""The sphere's own phase, looked up: against Mie's sums themselves."""

from __future__ import annotations

import numpy as np
import pytest
from support.simulated_setup import perfect_setup

from radargui.geometry.antennas import place_antennas
from radargui.geometry.sphere_delay import sphere_delay
from radargui.model.polarization import received_direction, transmitted_direction
from radargui.model.scattering import conducting_sphere, scattered_field
from radargui.model.setup import Setup


def polarised(diameter_m: float, transmitter_deg: float = 25.0) -> Setup:
    plain = perfect_setup().model_dump(by_alias=True)
    plain["transmitter"]["polarization_deg"] = transmitter_deg
    plain["tracer"]["diameter_m"] = diameter_m
    return Setup.model_validate(plain)


@pytest.mark.parametrize("diameter_m", [0.003, 0.010, 0.016])
def test_the_delay_looked_up_is_that_of_the_sums_within_a_fifth_of_a_micrometre(diameter_m: float) -> None:
    setup = polarised(diameter_m)
    delay, antennas = sphere_delay(setup), place_antennas(setup)
    assert delay is not None
    place = np.random.default_rng(3).uniform(-0.16, 0.16, (3, 200))
    place[:, 0] = setup.tracer.release_position_m
    found, k = delay.at(place), 2.0 * np.pi / setup.radar.wavelength_m
    sphere, sent = conducting_sphere(0.5 * diameter_m, setup.radar.wavelength_m), transmitted_direction(25.0)
    for row, rx, own in zip(found, antennas.receivers_m, setup.received_fields(), strict=True):
        got = received_direction(own.angle_deg, own.horizontal, own.vertical)
        field = got @ scattered_field(sphere, place, antennas.transmitter_m, sent, rx)
        assert row == pytest.approx(np.angle(field / field[0]) / k, abs=0.2e-6)
    assert np.abs(found).max() > 5e-6 * (diameter_m / 0.003) ** 2


def test_an_unknown_place_has_an_unknown_delay_and_a_point_none() -> None:
    delay = sphere_delay(polarised(0.010))
    assert delay is not None
    place = np.array([[0.0, np.nan], [0.0, 0.0], [0.1, 0.1]])
    assert np.isnan(delay.at(place)).tolist() == [[False, True]] * 3
    assert sphere_delay(perfect_setup()) is None
