"""The simulated 1/f noise has its spectrum and size, and is the same however a run is read."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from scipy.signal import periodogram
from support.simulated_recording import simulate_recording
from support.simulated_setup import perfect_setup

from radargui.model.simulation import Simulation
from radargui.sources.simulated.model import CHUNK, SimulatedRadar
from radargui.sources.simulated.noise import CORNERS_HZ, Flicker, unit_scale


def _noise(rate_hz: float, n_chunks: int, n_channels: int = 12, *, chunk: int = CHUNK, size: float = 1.0) -> np.ndarray:
    flicker = Flicker(Simulation(flicker=min(size, 0.5), amplitude_v=size / 0.5), rate_hz, n_channels, 0, chunk)
    volts = np.zeros((n_channels, n_chunks * chunk))
    for number in range(n_chunks):
        flicker.add_to(volts[:, number * chunk : (number + 1) * chunk], number)
    return volts


def test_the_density_meant_is_one_over_f_within_3_percent_and_of_size_1_in_its_band() -> None:
    frequency = np.geomspace(0.1, 1000.0, 4001)
    corners = CORNERS_HZ[:, None]
    density = unit_scale() ** 2 * 2.0 / np.pi * (1.0 / (corners * (1.0 + (frequency / corners) ** 2))).sum(axis=0)
    np.testing.assert_allclose(density * frequency * np.log(1e4), 1.0, atol=0.03)
    assert np.trapezoid(density, frequency) == pytest.approx(1.0, abs=1e-3)


@pytest.mark.parametrize(
    ("rate_hz", "chunks", "decades"), [(4e3, 60, (0.1, 1.0, 10.0, 100.0)), (20e3, 20, (10.0, 100.0, 1000.0))]
)
def test_every_decade_of_the_spectrum_holds_half_the_root_mean_square(
    rate_hz: float, chunks: int, decades: tuple[float, ...]
) -> None:
    noise = _noise(rate_hz, chunks)
    frequency, density = periodogram(noise, rate_hz, window="hann", detrend="constant")
    for low, high in pairwise(decades):
        inside = (frequency >= low) & (frequency < high)
        power = density[:, inside].sum(axis=1).mean() * frequency[1]
        assert np.sqrt(power) == pytest.approx(0.5, rel=0.06), (low, high)


def test_the_edges_of_chunks_leave_no_trace_in_the_steps_between_samples() -> None:
    chunk = 64
    noise = _noise(20e3, 400, chunk=chunk)
    steps = np.diff(noise, axis=1)
    edge = np.arange(chunk - 1, steps.shape[1], chunk)
    inside = np.delete(steps, edge, axis=1)
    assert steps[:, edge].std() == pytest.approx(inside.std(), rel=0.05)
    # longer steps, over an edge or inside a chunk
    longer = noise[:, 40:] - noise[:, :-40]
    within, over = longer[:, 10::chunk], longer[:, 50::chunk]
    assert over.std() == pytest.approx(within.std(), rel=0.05)
    assert np.abs(np.corrcoef(noise) - np.eye(12)).max() < 0.7


def test_channels_and_runs_are_independent_and_the_size_is_of_the_amplitude() -> None:
    still = {"scene": "rest", "rest_s": 20.0, "settle_s": 0.0, "daq": {"rate_hz": 2000.0}, "amplitude_v": 3.0}
    setup = perfect_setup(**still, flicker=0.02)
    clean = simulate_recording(perfect_setup(**still))[0].volts()
    noise = np.concatenate([simulate_recording(setup, run=run)[0].volts() - clean for run in (0, 1)])
    frequency, density = periodogram(noise, 2000.0, detrend="constant")
    inside = (frequency >= 1.0) & (frequency < 100.0)
    size = np.sqrt(density[:, inside].sum(axis=1).mean() * frequency[1])
    assert size == pytest.approx(3.0 * 0.02 * np.sqrt(0.5), rel=0.07)
    fast = np.diff(noise, axis=1)
    assert np.abs(np.corrcoef(fast) - np.eye(12)).max() < 0.03


@pytest.mark.parametrize("order", [(3, 0, 1, 2), (700, 2, 699, 700)])
def test_a_chunk_is_the_same_whatever_was_read_before(order: tuple[int, ...]) -> None:
    def chunk_of(flicker: Flicker, number: int) -> np.ndarray:
        volts = np.zeros((2, 32))
        flicker.add_to(volts, number)
        return volts

    def fresh() -> Flicker:
        return Flicker(Simulation(flicker=0.1), 10e3, 2, 5, 32)

    used, forward = fresh(), fresh()
    in_turn = {number: chunk_of(forward, number) for number in range(701)}
    for number in order:
        np.testing.assert_array_equal(chunk_of(used, number), in_turn[number])
        np.testing.assert_array_equal(chunk_of(fresh(), number), in_turn[number])


def test_pieces_of_a_run_with_flicker_are_pieces_of_the_whole() -> None:
    setup = perfect_setup(flicker=0.05)
    whole = SimulatedRadar(setup, run=1).samples(0, 3 * CHUNK)
    radar = SimulatedRadar(setup, run=1)
    for first, count in ((2 * CHUNK + 7, 900), (5, 2 * CHUNK), (CHUNK - 1, 2)):
        np.testing.assert_array_equal(radar.samples(first, count), whole[:, first : first + count])


def test_flicker_is_off_unless_asked_for_whatever_the_mismatch_and_on_without_white_noise() -> None:
    assert Simulation(mismatch=0.1).flicker == 0.0
    still = {"scene": "rest", "rest_s": 1.0, "settle_s": 0.0}
    assert np.ptp(simulate_recording(perfect_setup(**still))[0].volts(), axis=1).max() == 0.0
    assert np.ptp(simulate_recording(perfect_setup(**still, flicker=0.01))[0].volts(), axis=1).min() > 0.005
