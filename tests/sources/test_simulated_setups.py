"""The shipped setups are valid and can be simulated."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.simulated_recording import simulate_recording

from radargui.model.setup import Processing, read_setup
from radargui.sources.simulated.model import SimulatedRadar
from radargui.system.resources import shipped_setups

SETUPS = shipped_setups()


def test_setups_are_shipped_for_one_receiver_high_speed_a_bed_a_perfect_radar_and_physical_mismatch() -> None:
    names = {path.stem for path in SETUPS}
    assert {"default", "clean", "granular-bed", "high-speed", "one-receiver", "physical", "laboratory"} <= names


def test_what_is_shipped_takes_the_best_correction_that_its_receivers_allow() -> None:
    corrections = {path.stem: read_setup(path).processing.correction for path in SETUPS}
    others = {"one-receiver": "adaptive", "clean": "none"}
    assert corrections == {name: others.get(name, "joint") for name in corrections}
    assert Processing().correction == "joint"


@pytest.mark.parametrize("path", SETUPS, ids=lambda path: path.stem)
def test_a_shipped_setup_simulates_within_the_range_of_its_converter(path: Path) -> None:
    setup = read_setup(path)
    radar = SimulatedRadar(setup)
    assert radar.n_samples is not None
    volts = radar.digitisation.volts(radar.samples(0, min(radar.n_samples, 60_000)))
    assert np.isfinite(volts).all()
    assert 0.5 < np.abs(volts).max() < 0.9 * setup.daq.range_v


def test_a_perfect_radar_gives_volts_without_noise() -> None:
    recording, _ = simulate_recording(read_setup(next(path for path in SETUPS if path.stem == "clean")))
    assert recording.raw.dtype == np.float64
    resting = recording.raw[:, :10000]
    np.testing.assert_array_equal(resting, np.repeat(resting[:, :1], 10000, axis=1))
