"""A free fall is told from everything else that moves, by the signals alone."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from support.changed import changed
from support.simulated_recording import simulate_recording
from support.simulated_setup import simulated_setup

from radargui.live.trigger import FallTest
from radargui.model.arrays import FloatArray, RawArray
from radargui.model.recording import Digitisation, iq_names
from radargui.model.setup import Setup
from radargui.physics.path_length import path_lengths, place_antennas
from radargui.sources.simulated.model import SimulatedRadar

SETUP = simulated_setup(rest_s=0.3, settle_s=0.2)


def has_fall(setup: Setup, digitisation: Digitisation, raw: RawArray) -> bool:
    test = FallTest(setup, digitisation)
    for first in range(0, raw.shape[1], 200):
        test.push(raw[:, first : first + 200])
    assert (test.refusal() == "") == test.has_fall()
    return test.has_fall()


@pytest.mark.parametrize(
    "simulation",
    [
        {},
        {"reflection": 0.2},
        {"mismatch": 0.1},
        {"drop_height_m": 0.03},
        {"drop_height_m": 0.05, "snr_db": 25.0},
        {"restitution": 0.0},
        {"lateral_speed_m_s": 0.2},
        {"scene": "bed"},
    ],
)
@pytest.mark.parametrize("n_receivers", [1, 3])
def test_a_drop_is_a_fall(simulation: dict[str, object], n_receivers: int) -> None:
    setup = simulated_setup(n_receivers=n_receivers, **{"rest_s": 0.3, "settle_s": 0.2, **simulation})
    recording, _ = simulate_recording(setup)
    assert has_fall(setup, recording.digitisation, recording.raw)


def test_an_inverted_q_does_not_matter() -> None:
    setup = changed(SETUP, radar={"phase_sign": -1})
    recording, _ = simulate_recording(setup)
    assert has_fall(setup, recording.digitisation, recording.raw)


@pytest.mark.parametrize(
    "simulation",
    [
        {"scene": "rest"},
        {"scene": "rest", "mains": 0.3},
        {"scene": "circle", "circle_period_s": 1.0},
        {"scene": "pendulum", "turns": 1.0},
    ],
)
def test_other_motion_is_no_fall(simulation: dict[str, object]) -> None:
    setup = simulated_setup(rest_s=0.3, settle_s=0.2, **simulation)
    recording, _ = simulate_recording(setup)
    assert not has_fall(setup, recording.digitisation, recording.raw)


def test_the_hand_that_carries_the_sphere_back_is_no_fall() -> None:
    radar = SimulatedRadar(SETUP, repeat=True)
    end = round(radar.scene.run_s * 10000)
    assert not has_fall(SETUP, radar.digitisation, radar.samples(end - 500, 16000))


def hand(seed: int) -> FloatArray:
    """Return a random way of a hand, shape (3, n): within 10 cm, accelerations of 3 m/s^2 rms, up to 3 Hz."""
    draw = np.random.default_rng(seed)
    time = np.arange(30000) / 10000.0
    way = np.zeros((3, time.size))
    for frequency in draw.uniform(0.3, 3.0, 6):
        turn = 2.0 * np.pi * frequency
        size = min(1.2 / turn**2, 0.04)
        way += size * np.sin(turn * time + draw.uniform(0.0, 6.28, (3, 1))) * draw.normal(0.0, 1.0, (3, 1))
    return way


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10_000))
def test_a_hand_is_no_fall(seed: int) -> None:
    place = np.array([[0.0], [0.0], [0.0]]) + hand(seed)
    phase = 2.0 * np.pi * path_lengths(place, place_antennas(SETUP)) / SETUP.radar.wavelength_m
    volts = np.stack([part(row) for row in phase for part in (np.cos, np.sin)])
    volts = volts + np.random.default_rng(seed).normal(0.0, 0.01, volts.shape)
    assert not has_fall(SETUP, Digitisation(iq_names(3), 10000.0), volts)


def test_nothing_is_no_fall() -> None:
    digitisation = Digitisation(iq_names(3), 10000.0)
    assert FallTest(SETUP, digitisation).refusal() == "nothing in it falls freely"
    assert not has_fall(SETUP, digitisation, np.zeros((6, 4000)))
    assert not has_fall(SETUP, digitisation, np.random.default_rng(1).normal(0.0, 1.0, (6, 40000)))
