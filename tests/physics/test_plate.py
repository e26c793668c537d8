"""What plates reflect: the values of Fresnel and Airy, and what fields over a plate are against a conductor's image."""

from __future__ import annotations

import numpy as np
import pytest
from support.changed import changed

from radargui.model.radar import PLATES
from radargui.model.setup import parse_setup
from radargui.physics.plate import Plate, StatedSurface

WAVENUMBER = 2.0 * np.pi / 0.02997
GLASS, ACRYLIC, GRANITE = PLATES["glass"], PLATES["acrylic"], PLATES["granite"]
SETUP = parse_setup(
    "schema = 1\n[radar]\n[transmitter]\ndistance_m = 0.7\n"
    "[[receiver]]\ntilt_deg = 40\nazimuth_deg = 90\ndistance_m = 0.7"
)


@pytest.mark.parametrize(
    ("plate", "straight", "electric", "magnetic"),
    [
        (Plate(GLASS, 0.01), 0.66, 0.78, 0.55),
        (Plate(GLASS, 0.02), 0.72, 0.73, 0.50),
        (Plate(GRANITE, 0.03), 0.29, 0.68, 0.45),
        (Plate(ACRYLIC, 0.01), 0.12, 0.04, 0.02),
        (Plate(ACRYLIC, 0.02), 0.22, 0.07, 0.03),
        (Plate(ACRYLIC, 0.01, None), 0.96, 0.97, 0.96),
        (Plate(GLASS, 0.01, None), 0.97, 0.97, 0.97),
        (Plate(GLASS, 0.01, 1.5), 0.56, 0.67, 0.48),
        (Plate(None), 1.0, 1.0, 1.0),
    ],
)
def test_plates_reflect_what_the_tables_say_straight_down_and_at_forty_degrees(
    plate: Plate, straight: float, electric: float, magnetic: float
) -> None:
    r_te, r_tm = plate.coefficients(np.cos(np.radians([0.0, 40.0])), WAVENUMBER)
    found = [abs(plate.straight_down(WAVENUMBER)), abs(r_te[1]), abs(r_tm[1])]
    assert found == pytest.approx([straight, electric, magnetic], abs=0.02)
    assert r_te[0] == pytest.approx(r_tm[0])


def test_a_plate_reflects_each_polarisation_by_its_own_coefficient() -> None:
    plate, normal = Plate(GLASS, 0.01), np.array([0.0, 0.0, 1.0])
    tilt = np.radians([25.0, 40.0])
    direction = np.array([np.sin(tilt), np.zeros(2), np.cos(tilt)])
    # across the plane of incidence, and in it
    across, along = np.array([0.0, 1.0, 0.0]), np.array([np.cos(tilt[1]), 0.0, -np.sin(tilt[1])])
    share, of_normal = plate.parts(direction, normal, np.array([across, along]), WAVENUMBER)
    field = share[:, None, None] * np.array([across, along]) + of_normal.T[..., None] * normal
    r_te, r_tm = plate.coefficients(np.cos(tilt), WAVENUMBER) / np.array(plate.straight_down(WAVENUMBER))
    assert field[1, 0] @ across == pytest.approx(r_te[1])
    assert field[1, 1] @ along == pytest.approx(r_tm[1])
    assert field[1, 0] @ along == pytest.approx(0.0, abs=1e-12)


def test_a_setup_says_the_modulus_or_the_plate() -> None:
    assert StatedSurface.of(SETUP) is None
    by_modulus = StatedSurface.of(changed(SETUP, floor={"reflection": 0.7, "u_reflection": 0.02}))
    assert by_modulus == StatedSurface(0.7, 0.02)
    on_metal = {"material": "acrylic", "thickness_m": 0.01, "backing": "metal"}
    stated = StatedSurface.of(changed(SETUP, floor=on_metal))
    assert stated is not None
    assert stated.reflection == pytest.approx(0.97, abs=0.01)
    assert stated.plate == Plate(ACRYLIC, 0.01, None)
    assert StatedSurface.of(changed(SETUP, floor={"material": "steel"})).plate == Plate(None)  # type: ignore[union-attr]
    of_wood = changed(SETUP, floor={"refractive_index": 2.5, "thickness_m": 0.01, "backing": 1.5})
    assert Plate.of(of_wood.floor) == Plate(2.5, 0.01, 1.5)
