"""What the setup leaves open of floor and clock: impacts that last."""

import numpy as np
import pytest
from support.changed import changed

from radargui.model.assumed import CONTACT_S
from radargui.model.result import Bounce, Bounces
from radargui.model.setup import read_setup
from radargui.physics.contact import contact_time_s
from radargui.restitution.track_response import tilt_and_clock
from radargui.system.resources import default_setup_path


def test_an_impact_that_lasts_as_long_as_hard_floors_do_is_within_the_uncertainty_of_e() -> None:
    before, e, lasts_s = 1.1, 0.7, CONTACT_S
    after, g = e * before, 9.81
    # the parabolas before and after the contact, which begins at 0 and ends at `lasts_s` at the same height, meet at t
    t = np.linspace(0.0, lasts_s, 100001)
    down, up = -before * t - g / 2.0 * t**2, after * (t - lasts_s) - g / 2.0 * (t - lasts_s) ** 2
    meet = t[np.argmin(np.abs(down - up))]
    seen = (after + g * (lasts_s - meet)) / (before + g * meet)
    bounces = Bounces((Bounce(0.5, before, after, e, 1e-5, "flights", True),), None, (0.0, 0.0, 1.0))
    time = np.linspace(0.0, 1.0, 5)
    side = np.array([[0.0, 0.0, before]])
    (change,) = tilt_and_clock(time, lambda: (-side, e * side), bounces, read_setup(default_setup_path()))[-1:]
    assert seen - e > 1e-4
    assert change.e == pytest.approx([seen - e], rel=0.01)
    assert not change.moved_m.any()
    # on steel after a fall of 25 cm it is a ten-thousandth, and nothing where nothing was hit
    assert tilt_and_clock(time, lambda: (-side, e * side), Bounces(), read_setup(default_setup_path())) == []


@pytest.mark.parametrize(
    ("sphere", "floor", "lasts_us"),
    [("metal", "steel", 45.0), ("metal", "acrylic", 139.0), ("PTFE", "steel", 167.0), ("PMMA", "glass", 65.6)],
)
def test_what_sphere_and_floor_are_of_says_how_long_an_impact_lasts(sphere: str, floor: str, lasts_us: float) -> None:
    density = {"metal": 7800.0, "PTFE": 2200.0, "PMMA": 1190.0}[sphere]
    setup = changed(
        read_setup(default_setup_path()),
        tracer={"diameter_m": 0.01, "density_kg_m3": density, "material": sphere},
        floor={"material": floor, "thickness_m": 0.02, "backing": 1.5},
    )
    found = contact_time_s(setup, np.array([1.0, 32.0]))
    assert found is not None
    # as v^-1/5
    assert 1e6 * found == pytest.approx([lasts_us, 0.5 * lasts_us], rel=0.02)
    bounces = Bounces((Bounce(0.5, 1.0, 0.7, 0.7, 1e-5, "flights", True),), None, (0.0, 0.0, 1.0))
    side = np.array([[0.0, 0.0, 1.0]])
    (change,) = tilt_and_clock(np.linspace(0.0, 1.0, 5), lambda: (-side, 0.7 * side), bounces, setup)[-1:]
    assert change.e == pytest.approx([9.81 * 1e-6 * lasts_us * 0.3], rel=0.03)


def test_nobody_knows_how_long_an_impact_lasts_where_the_floor_is_not_stated() -> None:
    assert contact_time_s(read_setup(default_setup_path()), np.array([1.0])) is None
