"""Falls and known paths of a calibration: their slopes are those of their places, and a leaning gravity leans them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from radargui.calibration.known_path import KnownMotion, read_known
from radargui.calibration.likelihood import MotionModel, World, motion_slopes, own_values
from radargui.calibration.preparing import Falls
from radargui.calibration.unknowns import GRAVITY, GRAVITY_X, antenna_unknowns, fall_unknowns, place_unknowns
from radargui.model.arrays import FloatArray
from radargui.model.errors import SolveError
from radargui.model.setup import read_setup

RESOURCES = Path(__file__).parents[2] / "resources"
FALL = Falls("place.1", 0.3, np.array([0.52, 0.85]), np.array([[0.05, -0.03, 1.6], [0.04, -0.02, 1.3]]), 1.1)


def world() -> World:
    setup = read_setup(RESOURCES / "setups" / "laboratory.toml")
    place = place_unknowns(setup, (0.08, 0.02, 0.10), "place.1")
    return World(setup, (*antenna_unknowns(setup), *place, *fall_unknowns(setup)))


def turntable() -> KnownMotion:
    return KnownMotion(read_known(RESOURCES / "paths" / "turntable.toml"), 0.3, 0.01)


@pytest.mark.parametrize("motion", [FALL, turntable()], ids=["fall", "turntable"])
def test_slopes_of_places_and_of_impacts_on_the_floor_are_their_differences(motion: MotionModel) -> None:
    here, rng = world(), np.random.default_rng(3)
    z, own = 0.5 * rng.standard_normal(len(here.unknowns)), 0.2 * rng.standard_normal(len(motion.own))
    moments = own_values(motion, own)[[0, *range(4, len(own), 4)]] if motion is FALL else np.empty(0)
    time_s = np.linspace(0.0, 1.05, 400)
    # where a flight begins a velocity jumps, and so does a difference across it
    time_s = time_s[(np.abs(time_s[:, None] - moments) > 2e-3).all(axis=1)]

    def at(step: FloatArray) -> tuple[FloatArray, FloatArray]:
        values = here.values(z + step[: z.size])
        series, ties = motion.at(time_s, values, own_values(motion, own + step[z.size :]))
        return series[0], ties

    _, slopes, _, ties = motion_slopes(motion, here, z, own, time_s)
    for number in range(z.size + own.size):
        step = 1e-4 * (np.arange(z.size + own.size) == number)
        (high, above), (low, below) = at(step), at(-step)
        assert slopes[:, :, number] == pytest.approx(
            (high - low) / 2e-4, abs=2e-8 + 2e-5 * np.abs(high - low).max() / 2e-4
        )
        assert ties[:, number] == pytest.approx((above - below) / 2e-4, rel=1e-3, abs=0.02)


def test_velocity_and_acceleration_are_those_of_the_places() -> None:
    here = world()
    values, own = here.values(np.zeros(len(here.unknowns))), own_values(FALL, np.zeros(len(FALL.own)))
    time_s = np.linspace(0.54, 0.83, 300)
    (place, velocity, acceleration), _ = FALL.at(time_s, values, own)
    assert np.gradient(place, time_s, axis=1)[:, 1:-1] == pytest.approx(velocity[:, 1:-1], abs=1e-5)
    assert np.gradient(velocity, time_s, axis=1)[:, 1:-1] == pytest.approx(acceleration[:, 1:-1], abs=1e-3)
    at_rest, _ = FALL.at(np.array([0.0, 0.29, 1.2]), values, own)
    assert not at_rest[1:].any()


def test_a_sphere_falls_to_where_gravity_leans() -> None:
    here = world()
    values, own = here.values(np.zeros(len(here.unknowns))), own_values(FALL, np.zeros(len(FALL.own)))
    time_s = np.array([0.3, 0.5])
    straight, leaning = (FALL.at(time_s, {**values, GRAVITY_X: lean}, own)[0][0] for lean in (0.0, 1.0))
    fallen_m = 0.5 * values[GRAVITY] * 0.2**2
    assert leaning[0, 1] - straight[0, 1] == pytest.approx(np.sin(np.radians(1.0)) * fallen_m, rel=0.01)
    assert leaning[:, 0] == pytest.approx(straight[:, 0])


def test_impacts_out_of_their_order_are_no_fall() -> None:
    here = world()
    own = own_values(FALL, np.zeros(len(FALL.own)))
    own[4], own[8] = own[8], own[4]
    with pytest.raises(SolveError, match="out of their order"):
        FALL.at(np.linspace(0.0, 1.0, 50), here.values(np.zeros(len(here.unknowns))), own)
