"""The check of g against the place: what is expected there, and what is said of it."""

from __future__ import annotations

import math

import pytest
from support.changed import changed

from radargui.model.gravity import normal_gravity_m_s2, share_in_air
from radargui.model.setup import Setup, read_setup
from radargui.restitution.site_gravity import check_against_site
from radargui.system.resources import default_setup_path

STEEL = 7800.0


def at_site(density_kg_m3: float | None = STEEL, **site: float) -> Setup:
    return changed(read_setup(default_setup_path()), site=site, tracer={"density_kg_m3": density_kg_m3})


def test_steel_in_air_falls_slower_than_the_sites_g_and_the_check_knows() -> None:
    in_air = 9.81 * share_in_air(STEEL)
    check = check_against_site(in_air, 1e-4, at_site(g_m_s2=9.81, u_g_m_s2=1e-4), 2e-4)
    assert check is not None
    assert check.expected_m_s2 == in_air
    assert check.difference_m_s2 == 0.0
    assert check.agrees
    assert "0.023 % that air takes off a sphere of 7800 kg/m³" in check.compared


def test_what_differs_by_more_than_two_u_of_both_is_said_to_differ() -> None:
    setup = at_site(g_m_s2=9.81, u_g_m_s2=3e-4)
    expected = 9.81 * share_in_air(STEEL)
    u = math.hypot(4e-4, 3e-4, 0.1 * (9.81 - expected))
    near, far = (check_against_site(expected + k * u, 1e-4, setup, 4e-4) for k in (1.9, 2.1))
    assert near is not None
    assert far is not None
    assert near.u_difference_m_s2 == pytest.approx(u, rel=1e-12)
    assert near.agrees is True
    assert near.verdict == "g agrees with the site's within 1.9 u"
    assert far.verdict == "g differs from the site's by 2.1 u: the calibration is suspect"
    assert far.agrees is False
    assert "differ by more than 2 u" in far.compared


def test_without_the_antennas_uncertainty_nothing_is_said_of_agreement() -> None:
    check = check_against_site(9.7, 1e-4, at_site(g_m_s2=9.81), None)
    assert check is not None
    assert check.agrees is None
    assert check.u_difference_m_s2 is None
    assert "cannot be compared" in check.verdict
    assert "no more can be said without the antennas' uncertainty" in check.compared


def test_latitude_and_height_give_normal_gravity_known_to_50_mgal() -> None:
    check = check_against_site(9.81, 1e-4, at_site(None, latitude_deg=49.6, height_m=280.0), 1e-3)
    assert check is not None
    assert check.site_g_m_s2 == normal_gravity_m_s2(49.6, 280.0)
    assert check.u_site_g_m_s2 == 5e-4
    assert check.expected_m_s2 == check.site_g_m_s2
    assert "normal gravity at 49.6°, 280 m" in check.compared
    assert "density is not given" in check.compared


def test_a_wavelength_of_vacuum_is_told_and_no_site_is_no_check() -> None:
    setup = at_site(g_m_s2=9.81)
    vacuum = changed(setup, radar={"refractive_index": None})
    told = [check_against_site(9.81, 1e-4, one, 1e-3) for one in (setup, vacuum)]
    assert [one is not None and "of vacuum" in one.compared for one in told] == [False, True]
    assert check_against_site(9.81, 1e-4, at_site(), 1e-3) is None
