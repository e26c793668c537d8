"""Impacts that last: told by how deep flights meet at each speed, and by the round corner between them."""

from __future__ import annotations

import numpy as np
import pytest
from benchmarks.accuracy import with_method
from benchmarks.world.draw import draw
from benchmarks.world.scene import make_record

from radargui.model.result import RunResult
from radargui.processing.process import process
from radargui.restitution.contact_time import contact_of_places_s, depth_per_s

BEFORE = np.array([2.0, 1.5, 1.1, 0.8])
AFTER = 0.75 * BEFORE
DEPTH_PER_S = depth_per_s(BEFORE, AFTER)
COVARIANCE = np.diag(np.full(4, 5e-5**2))


@pytest.mark.parametrize("contact_s", [5e-4, 4e-3, 2e-2])
def test_flights_that_meet_deeper_the_faster_they_are_tell_how_long_impacts_last(contact_s: float) -> None:
    noise = 2e-5 * np.random.default_rng(1).standard_normal(4)
    found = contact_of_places_s(0.3 - contact_s * DEPTH_PER_S + noise, COVARIANCE, DEPTH_PER_S)
    assert found == pytest.approx(contact_s, abs=1.5e-4)


@pytest.mark.parametrize(
    "height_m",
    [
        [0.0, 0.0, 0.0, 0.0],
        # shorter than what the budget holds
        (-1e-4 * DEPTH_PER_S).tolist(),
        # deeper the slower: no floor does that
        (4e-3 * DEPTH_PER_S).tolist(),
        # one step, and heights without an order
        [0.0, 1e-3, 0.0, 0.0],
        [1e-3, -1e-3, 1e-3, -1e-3],
        # a table above the floor
        [0.2, 0.2, 0.0, 0.0],
    ],
)
def test_other_heights_are_no_contact(height_m: list[float]) -> None:
    assert contact_of_places_s(np.array(height_m), COVARIANCE, DEPTH_PER_S) is None


def test_equal_speeds_tell_no_contact() -> None:
    same = np.full(4, DEPTH_PER_S[0])
    assert contact_of_places_s(np.array([0.0, 1e-3, 2e-3, 3e-3]), COVARIANCE, same) is None


def dropped_on(contact_s: float, correction: str, **held: float) -> RunResult:
    scene = draw(7303002, "exact", contact_s=contact_s, walls=0, rate_hz=10_000.0, **held)
    return process(make_record(scene).recording, with_method(scene.setup, f"{correction}-exact"))


@pytest.mark.parametrize(("correction", "contact"), [("adaptive", "4 ms"), ("published", "3.9 ms")])
def test_a_soft_floor_gives_no_e_and_a_hard_one_does(correction: str, contact: str) -> None:
    """4 ms: e was up to 34 u off, and valid."""
    soft = dropped_on(0.004, correction)
    assert soft.bounces is not None
    assert len(soft.bounces.impacts) > 4
    assert not any(one.valid for one in soft.bounces.impacts)
    (sentence,) = (one for one in soft.warnings if one.startswith("the floor gives way"))
    assert f"an impact lasts some {contact}, in which" in sentence
    hard = dropped_on(0.0, correction)
    assert hard.bounces is not None
    assert any(one.valid for one in hard.bounces.impacts)
    assert not any("gives way" in one for one in hard.warnings)


def test_a_single_impact_on_a_soft_floor_shows_in_its_round_corner() -> None:
    found = dropped_on(0.008, "adaptive", e=0.4, scatter=0.0, height_m=0.06)
    assert found.bounces is not None
    assert found.bounces.impacts
    assert not any(one.valid for one in found.bounces.impacts)
    assert any(one.startswith("the floor gives way") for one in found.warnings)
