"""The sphere's own phase, looked up: against Mie's sums themselves."""

from __future__ import annotations

import numpy as np
import pytest
from support.simulated_setup import perfect_setup

from radargui.model.setup import Setup
from radargui.physics.scattering import path_delay, scattering_delay_m


def polarised(diameter_m: float, transmitter_deg: float = 25.0) -> Setup:
    plain = perfect_setup().model_dump(by_alias=True)
    plain["transmitter"]["polarization_deg"] = transmitter_deg
    plain["tracer"]["diameter_m"] = diameter_m
    return Setup.model_validate(plain)


@pytest.mark.parametrize("diameter_m", [0.003, 0.010, 0.016])
def test_the_delay_looked_up_is_that_of_the_sums_within_a_fifth_of_a_micrometre(diameter_m: float) -> None:
    setup = polarised(diameter_m)
    delay = path_delay(setup)
    assert delay is not None
    place = np.random.default_rng(3).uniform(-0.16, 0.16, (3, 200))
    exact = scattering_delay_m(place, setup)
    assert delay.at(place) == pytest.approx(exact, abs=0.2e-6)
    assert np.abs(exact).max() > 5e-6 * (diameter_m / 0.003) ** 2


def test_the_worked_example_has_the_phase_of_its_ratio() -> None:
    plain = polarised(0.010, 0.0).model_dump(by_alias=True)
    plain["receiver"][0].update(tilt_deg=40.0, azimuth_deg=211.0)
    plain["tracer"]["release_position_m"] = (0.0, 0.0, 0.125)
    setup = Setup.model_validate(plain)
    found = scattering_delay_m(np.array([[0.01], [-0.005], [0.05]]), setup)[0, 0]
    # f / f0 = 1.03274 + .01324j, published with the equations
    expected = np.angle(1.03274 + 0.01324j) * setup.radar.wavelength_m / (2.0 * np.pi)
    assert found == pytest.approx(expected, abs=5e-5 * setup.radar.wavelength_m / (2.0 * np.pi))


def test_an_unknown_place_has_an_unknown_delay_and_a_point_none() -> None:
    delay = path_delay(polarised(0.010))
    assert delay is not None
    place = np.array([[0.0, np.nan], [0.0, 0.0], [0.1, 0.1]])
    assert np.isnan(delay.at(place)).tolist() == [[False, True]] * 3
    assert path_delay(perfect_setup()) is None
