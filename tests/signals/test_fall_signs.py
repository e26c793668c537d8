"""Phases that turn the wrong way in a fall: which receivers, and never of another motion."""

from __future__ import annotations

import pytest
from benchmarks.world.draw import draw
from benchmarks.world.mistaken.draw import mistaken
from benchmarks.world.scene import Scene, make_record

from radargui.signals.condition import condition
from radargui.signals.conditioned import Conditioned
from radargui.signals.fall_signs import FallSigns, fall_signs

QUICK = {"rate_hz": 2000.0, "skew_s": 0.0, "walls": 0}
SEEDS = range(81500, 81502)


def signs_of(scene: Scene) -> FallSigns:
    conditioned = condition(make_record(scene).recording, scene.setup)
    assert isinstance(conditioned, Conditioned)
    return fall_signs(conditioned, scene.setup)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_fall_told_rightly_turns_no_phase_backwards(seed: int) -> None:
    assert signs_of(draw(seed, "drawn", **QUICK)) == FallSigns((False, False, False))


@pytest.mark.parametrize("seed", SEEDS)
def test_a_wrong_sign_turns_all_phases_and_an_exchanged_pair_its_own(seed: int) -> None:
    assert signs_of(mistaken("sign/wiring", seed, **QUICK)).backwards == (True, True, True)
    for variant in ("pair", "inverted"):
        scene = mistaken(f"wires/{variant}", seed, **QUICK)
        (wiring,) = scene.disturbances
        wrong = {k for k in range(6) if wiring.order[k] != k or wiring.sizes[k] < 0.0}  # type: ignore[attr-defined]
        assert signs_of(scene).backwards == tuple(bool({2 * n, 2 * n + 1} & wrong) for n in range(3))


def test_a_clock_twice_too_fast_makes_falls_of_four_g() -> None:
    signs = signs_of(mistaken("clock/double", SEEDS[0], **QUICK))
    assert not any(signs.backwards)
    assert signs.times_g == pytest.approx(4.3, abs=0.4)  # a tenth more than 4: the antennas are near


@pytest.mark.parametrize("which", ["receivers/exchanged", "tilt/horizon", "tilt/one", "distance/all"])
def test_other_mistakes_turn_no_phase_backwards(which: str) -> None:
    assert not any(signs_of(mistaken(which, SEEDS[1], strength=0.9, **QUICK)).backwards)


@pytest.mark.parametrize("motion", ["circle", "hand", "throw", "incline", "stage", "box"])
def test_no_other_motion_looks_like_a_fall_upwards(motion: str) -> None:
    assert signs_of(draw(81604, "drawn", motion=motion, rate_hz=2000.0, skew_s=0.0)) == FallSigns((False,) * 3)


def test_of_fewer_than_three_receivers_nothing_is_said() -> None:
    scene = mistaken("sign/wiring", SEEDS[0], **QUICK)
    conditioned = condition(make_record(scene).recording, scene.setup)
    assert isinstance(conditioned, Conditioned)
    some = scene.setup.model_copy(update={"receiver": scene.setup.receiver[:2]})
    assert fall_signs(conditioned.of_receivers((0, 1)), some) == FallSigns((False, False))
