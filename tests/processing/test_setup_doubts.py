"""What a setup is doubted for: values no laboratory has, wires, a g unknown on Earth, a floor that is elsewhere."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from benchmarks.world.draw import draw
from benchmarks.world.mistaken.draw import mistaken
from benchmarks.world.population import modelled
from benchmarks.world.scene import make_record
from benchmarks.world.stated import Stated
from support.words import words

from radargui.model.channel_quality import UnexplainedStretch
from radargui.model.finding import Finding, warn
from radargui.model.result import Bounce, Bounces, FreeFall, Track
from radargui.model.setup import Setup, changed, read_setup
from radargui.model.uncertainty_budget import BudgetLine, UncertaintyBudget
from radargui.processing.checks.motion import flights_bend, g_impossible, setup_contradicted
from radargui.processing.checks.setup import OF_SETUP, floor_elsewhere, release_assumed
from radargui.processing.process import process
from radargui.restitution.flight_test import FlightTest
from radargui.system.resources import default_setup_path

SHIPPED = sorted((Path(__file__).resolve().parents[2] / "resources" / "setups").glob("*.toml"))
QUICK = {"rate_hz": 2000.0, "skew_s": 0.0, "walls": 0}


def plain(**tables: Any) -> Setup:
    receivers = tuple({"tilt_deg": 40.0, "azimuth_deg": a, "distance_m": 0.7} for a in (90.0, 210.0, 330.0))
    tracer = {"release_position_m": (0.0, 0.0, 0.12), "density_kg_m3": 7800.0}
    told = {"schema": 1, "radar": {}, "transmitter": {"distance_m": 0.7}, "receiver": receivers, "tracer": tracer}
    return Setup.model_validate({**told, **tables})


def unlikely(setup: Setup) -> list[Finding]:
    """What is said of values that no laboratory has."""
    return [found for check in OF_SETUP if check is not release_assumed and (found := check(setup))]


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_shipped_setups_hold_nothing_unlikely(path: Path) -> None:
    assert unlikely(read_setup(path)) == []


def test_setups_of_the_laboratorys_drops_hold_nothing_unlikely() -> None:
    assert [one for seed in range(8) for one in unlikely(draw(seed, "drawn", **QUICK).setup)] == []


@pytest.mark.parametrize(
    ("which", "said"),
    [
        ("distance/centimetres", "transmitter.distance_m"),
        ("distance/inches", "give metres"),
        ("tilt/radians", "if these are radians"),
        ("floor/down", "floor.normal points down"),
        ("air/vacuum", "is that of a vacuum"),
    ],
)
def test_values_that_no_laboratory_has_are_told(which: str, said: str) -> None:
    (finding,) = unlikely(mistaken(which, 3, **QUICK).setup)
    assert said in finding.text


def test_a_floor_above_the_release_is_told_unless_the_release_was_left_out() -> None:
    (finding,) = unlikely(plain(floor={"height_m": 0.2}))
    assert "floor.height_m = 0.2 is not below" in finding.text
    assert unlikely(plain(floor={"height_m": -0.2})) == []
    assert unlikely(plain(floor={"height_m": 0.2}, tracer={})) == []


def measured(g_m_s2: float, u_m_s2: float, touch_m: float = -0.14, geometry: str = "exact") -> tuple[Any, ...]:
    """Track, bounces and budget of a fall that ends at a height."""
    time = np.linspace(0.0, 1.0, 101)
    place = np.zeros((3, time.size))
    place[2] = np.where(time < 0.5, 0.12, touch_m)
    track = Track(time, place, np.full((3, time.size), 1e-4), np.ones(time.size, bool), geometry)
    fall = FreeFall(g_m_s2, u_m_s2 / 3.0, 0.1, 0.4, 0.12, 0.26, (0.0, 0.0, 0.0), 1e-5)
    bounces = Bounces((Bounce(0.6, 2.0, 1.6, 0.8, 0.001, "flights", True),), fall, (0.0, 0.0, 1.0))
    line = BudgetLine(combined=u_m_s2)
    return track, bounces, UncertaintyBudget(line, line, line)


def doubts(setup: Setup, track: Track, bounces: Bounces, budget: UncertaintyBudget | None) -> list[Finding]:
    exact = track if track.geometry == "exact" and budget is not None else None
    part = SimpleNamespace(conditioned=SimpleNamespace(sample_rate_hz=5000.0))
    evidence: Any = SimpleNamespace(setup=setup, part=part, exact_track=exact, bounces=bounces, budget=budget)
    return [found for check in (g_impossible, floor_elsewhere) if (found := check(evidence))]


@pytest.mark.parametrize(
    ("g_m_s2", "u_m_s2"), [(9.81, 0.001), (9.764, 0.001), (9.83, 0.001), (9.70, 0.03), (9.95, 0.05)]
)
def test_a_g_of_some_place_on_earth_within_its_u_says_nothing(g_m_s2: float, u_m_s2: float) -> None:
    assert doubts(plain(), *measured(g_m_s2, u_m_s2)) == []


def test_what_is_thrown_upwards_falls_at_no_place_that_could_be_named() -> None:
    # a plate that lifts the sphere while it lies on it
    assert doubts(plain(), *measured(-0.33, 0.01)) == []


def test_a_g_of_no_place_on_earth_is_told_with_what_would_explain_it() -> None:
    (finding,) = doubts(plain(), *measured(9.81 * 1.02**2, 0.02))
    assert "on Earth it is 9.76 to 9.84" in finding.text
    assert "4902 Hz" in finding.text
    assert "10.40 GHz" in finding.text
    assert "9.612(20)" in doubts(plain(), *measured(9.612, 0.02))[0].text


def test_a_site_says_which_g_is_expected() -> None:
    assert "the site has 9.8000" in doubts(plain(site={"g_m_s2": 9.80}), *measured(9.83, 0.003))[0].text
    moon = plain(site={"g_m_s2": 1.62})
    assert doubts(moon, *measured(1.62, 0.003)) == []


def test_without_a_density_air_may_take_off_what_it_takes_off_plastic() -> None:
    light = plain(tracer={"release_position_m": (0.0, 0.0, 0.12)})
    assert doubts(light, *measured(9.75, 0.001)) == []
    assert len(doubts(plain(), *measured(9.75, 0.001))) == 1


def test_what_has_no_uncertainty_of_the_setup_contradicts_nothing() -> None:
    track, bounces, _ = measured(8.0, 0.01)
    assert doubts(plain(), track, bounces, None) == []
    assert doubts(plain(), *measured(8.0, 0.01, geometry="plane")) == []


def test_a_floor_that_is_met_elsewhere_than_stated_is_told() -> None:
    told = plain(floor={"height_m": -0.14})
    assert doubts(told, *measured(9.81, 0.01, touch_m=-0.135)) == []
    (finding,) = doubts(told, *measured(9.81, 0.01, touch_m=-0.17))
    assert "z = -170 mm" in finding.text
    assert "-140 mm" in finding.text


def test_a_floor_that_leans_is_met_lower_away_from_the_axis_and_a_table_below_it_contradicts_nothing() -> None:
    leaning = plain(floor={"height_m": -0.14, "normal": (0.17, 0.0, 1.0)})
    track, bounces, budget = measured(9.81, 0.01, touch_m=-0.157)
    track.position_m[0] = 0.1
    assert doubts(leaning, track, bounces, budget) == []
    track.position_m[0] = 0.0
    assert "z = -157 mm on the z axis" in doubts(leaning, track, bounces, budget)[0].text
    track, bounces, budget = measured(9.81, 0.01)
    track.position_m[2, 80:] = -0.25
    below = replace(bounces, impacts=(*bounces.impacts, replace(bounces.impacts[0], time_s=0.9)))
    for stated_m in (-0.14, -0.25):
        assert doubts(plain(floor={"height_m": stated_m}), track, below, budget) == []
    assert len(doubts(plain(floor={"height_m": -0.2}), track, below, budget)) == 1


def test_exchanged_wires_are_named_before_anything_is_measured() -> None:
    scene = mistaken("wires/pair", 81500, **QUICK)
    result = process(make_record(scene).recording, scene.setup)
    assert result.status == "rejected"
    assert "its I and Q are exchanged" in result.reason
    assert result.reason.count("receiver") == 1
    scene = mistaken("sign/wiring", 81500, **QUICK)
    result = process(make_record(scene).recording, scene.setup)
    assert result.status == "rejected"
    assert f"set radar.phase_sign to {-scene.setup.radar.phase_sign}" in result.reason


@pytest.mark.parametrize("stated", [pytest.param("drawn", marks=pytest.mark.slow), "exact"])
def test_a_release_five_centimetres_off_is_named_with_where_it_is_and_the_uncertainty_holds_it(stated: Stated) -> None:
    clear = {"floor": 0.0, "snr_db": 40.0, "crosstalk": 0.0, "lobes": False, "lively": False, "e": 0.5}
    scene = mistaken("release/sideways", 3, stated, 0.9, **QUICK, **clear)
    record = make_record(scene)
    result = process(record.recording, scene.setup)
    right = scene.drop.position(np.zeros(1))[:, 0] - scene.setup.tracer.release_position_m
    (told,) = (one for one in result.warnings if "likely tracer.release_position_m" in one)
    # a named cause takes the place of the guess
    assert not any("likely a reflector" in one for one in result.warnings)
    named = {axis: float(mm) for axis, mm in re.findall(r"([xyz]) ([+-]\d+) mm", told)}
    assert abs(right[:2]).min() > 0.02
    assert [named["x"], named["y"]] == pytest.approx(1e3 * right[:2], abs=8.0)
    track = result.track
    assert track is not None
    assert track.u_combined_m is not None
    moving = track.valid & (track.time_s > scene.drop.start_s)
    off = np.abs(track.position_m - record.truth.position_m)[:, moving]
    assert np.sqrt((off**2).mean()) < 2.0 * np.sqrt((track.u_combined_m[:, moving] ** 2).mean())


def test_antennas_where_none_stands_are_the_cause_of_flights_that_bend() -> None:
    """What flights say of other places, and the guess at a reflector, would only lead astray."""
    named = warn("setup_contradicted", explains=False, what_in_part="place", place="receiver[1]")
    bent = warn("flights_bend", chi_square=500.0, expected=100, widening=2.2, guess="reflector", remedy="reflector")
    setup = read_setup(default_setup_path())
    none = SimpleNamespace(measured=object(), exact_track=None, budget=None, bounces=Bounces())
    part, motion = SimpleNamespace(has_room=True, left_out=()), SimpleNamespace(flights=FlightTest(bent, named))
    right: Any = SimpleNamespace(**vars(none), setup=setup, part=part, motion=motion)
    assert setup_contradicted(right) == named
    assert flights_bend(right) == bent
    far: Any = SimpleNamespace(**vars(none), setup=changed(setup, {"transmitter.distance_m": 70.0}))
    far.part, far.motion = part, motion
    assert setup_contradicted(far) is None
    assert "likely a reflector" not in words(flights_bend(far))
    # delays that do not fit are a cause, too
    right.part = SimpleNamespace(has_room=False, left_out=())
    assert "likely a reflector" not in words(flights_bend(right))
    # an impact in milliseconds that were left out bends them as well; a place that explains all of it is one still
    hole = (UnexplainedStretch(1, 0.2, 0.22),)
    right.part = SimpleNamespace(has_room=True, left_out=hole)
    assert setup_contradicted(right) is None
    assert "likely a reflector" not in words(flights_bend(right))
    right.motion = SimpleNamespace(flights=FlightTest(bent, named.with_facts(explains=True)))
    assert setup_contradicted(right) is not None
    # of a run that is refused nothing was held against the setup
    far.measured = None
    assert (setup_contradicted(far), flights_bend(far)) == (named, bent)


@pytest.mark.slow
@pytest.mark.parametrize("variant", ["radius", "double"])
def test_a_sphere_of_another_size_is_named_and_no_polarisation(variant: str) -> None:
    scene = mistaken(f"sphere/{variant}", 1, **QUICK)
    result = process(make_record(scene).recording, scene.setup)
    of_setup = {one.code: one for one in result.findings if one.code in ("setup_contradicted", "polarization_off")}
    assert of_setup.keys() <= {"setup_contradicted"}
    assert all(one.facts["place"] == "tracer.diameter_m" for one in of_setup.values())


@pytest.mark.slow
@pytest.mark.parametrize("number", [0, 1])
def test_beside_a_wall_a_sphere_of_another_size_is_named_and_nothing_else(number: int) -> None:
    held = {"walls": 1, "wall": 0.1, "told": True, "diameter_m": 0.008, "rate_hz": 8000.0, "skew_s": 0.0}
    (scene,) = modelled((number,), "wall", 1, {**held, "height_m": 0.15})
    tracer = {**scene.setup["tracer"], "diameter_m": 0.016}
    result = process(scene.record().recording, Setup.model_validate({**scene.setup, "tracer": tracer}))
    named = {one.facts["place"] for one in result.findings if one.code == "setup_contradicted"}
    assert named == {"tracer.diameter_m"}
    assert all(one.code != "polarization_off" for one in result.findings)
    assert result.corrected is not None
    assert all(one.finding is None for one in result.corrected.channels)
