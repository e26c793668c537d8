"""The Doppler signal out of the ring: lines read their frequency and amplitude, nothing beyond the band folds in."""

from __future__ import annotations

import numpy as np
import pytest

from radargui.acquisition.baseband import Baseband
from radargui.acquisition.ring import Ring
from radargui.model.recording import Block

RATE_HZ = 20_000.0


def filled(
    seconds: float, *, tones: dict[float, float], hum: dict[float, float] | None = None, noise: float = 1e-3
) -> Ring:
    """Return a ring of one receiver: rotating pointers (frequency: amplitude) and voltages that do not rotate."""
    count = round(seconds * RATE_HZ)
    time_s = np.arange(count) / RATE_HZ
    rng = np.random.default_rng(5)
    z = noise * (rng.standard_normal(count) + 1j * rng.standard_normal(count)) + 0.3 - 0.2j
    for frequency, amplitude in tones.items():
        z += amplitude * np.exp(2j * np.pi * frequency * time_s)
    for frequency, amplitude in (hum or {}).items():
        z += (1.0 + 1.0j) * amplitude * np.cos(2.0 * np.pi * frequency * time_s)
    ring = Ring(2, count, np.float64)
    for first in range(0, count, 400):
        ring.append(Block(np.stack([z.real, z.imag])[:, first : first + 400], first))
    return ring


def followed(ring: Ring, half_band_hz: float = 300.0, window_s: float = 3.0, sign: int = 1) -> Baseband:
    band = Baseband(ring, RATE_HZ, half_band_hz, window_s, sign)
    while band.pull(ring.latest):
        pass
    return band


@pytest.mark.parametrize("frequency", [131.3, -47.9, 249.0])
def test_a_line_reads_its_frequency_and_amplitude(frequency: float) -> None:
    spectrum = followed(filled(4.0, tones={frequency: 0.5})).spectrum()
    assert spectrum is not None
    assert spectrum.resolution_hz == pytest.approx(1.0 / 3.0, rel=1e-3)
    line = spectrum.strongest(0)
    assert line is not None
    assert line.frequency_hz == pytest.approx(frequency, abs=0.05 * spectrum.resolution_hz)
    assert line.amplitude_v == pytest.approx(0.5, rel=0.01)


def test_an_inverted_q_turns_the_sign_of_the_frequency() -> None:
    spectrum = followed(filled(4.0, tones={100.0: 0.5}), sign=-1).spectrum()
    assert spectrum is not None
    line = spectrum.strongest(0)
    assert line is not None
    assert line.frequency_hz == pytest.approx(-100.0, abs=0.05)


def test_what_lies_beyond_the_band_does_not_fold_into_it() -> None:
    # 1250 Hz is the rate that is kept of +-300 Hz: thinned without a low-pass it would lie at 150 Hz
    spectrum = followed(filled(4.0, tones={1250.0 + 150.0: 1.0, 3000.0: 1.0})).spectrum()
    assert spectrum is not None
    assert spectrum.amplitude_v.max() < 10.0 ** (-70.0 / 20.0)


def test_noise_alone_has_no_line() -> None:
    spectrum = followed(filled(4.0, tones={})).spectrum()
    assert spectrum is not None
    assert spectrum.strongest(0) is None
    assert spectrum.mains(0) == []


def test_hum_is_found_at_its_multiples_and_a_doppler_line_there_is_none() -> None:
    spectrum = followed(filled(4.0, tones={70.0: 0.5}, hum={50.0: 0.02, 150.0: 0.01})).spectrum()
    assert spectrum is not None
    assert [round(line.frequency_hz, 1) for line in spectrum.mains(0)] == [50.0, 150.0]
    moving = followed(filled(4.0, tones={50.0: 0.5})).spectrum()
    assert moving is not None
    assert moving.mains(0) == []


def test_the_amplitude_is_the_radius_of_the_circle_whatever_the_offset() -> None:
    band = followed(filled(4.0, tones={80.0: 0.4}))
    assert band.amplitude_v(1.0) == pytest.approx([0.4], rel=0.01)


def test_a_gap_is_left_out_of_the_spectrum() -> None:
    ring = filled(4.0, tones={100.0: 0.5})
    rng = np.random.default_rng(1)
    after = Block(1e-3 * rng.standard_normal((2, 8000)), ring.latest + 100)
    ring.append(after)
    spectrum = followed(ring).spectrum()
    assert spectrum is not None
    assert spectrum.span_s == pytest.approx(0.4, abs=0.02)
    assert spectrum.strongest(0) is None, "the line is older than the gap"


def test_the_pieces_it_comes_in_change_nothing() -> None:
    ring = filled(4.0, tones={100.0: 0.5})
    whole, piecewise = followed(ring), Baseband(ring, RATE_HZ, 300.0, 3.0, 1)
    for until in (30_000, 30_007, 61_111, ring.latest):
        while piecewise.pull(until):
            pass
    count = min(whole.samples_v.shape[1], piecewise.samples_v.shape[1])
    a, b = whole.spectrum(), piecewise.spectrum()
    assert count > 3000
    assert a is not None
    assert b is not None
    assert a.strongest(0).frequency_hz == pytest.approx(b.strongest(0).frequency_hz, abs=0.02)
    assert a.strongest(0).amplitude_v == pytest.approx(b.strongest(0).amplitude_v, rel=1e-3)


def test_a_waterfall_shows_when_a_line_was_there() -> None:
    ring = filled(2.0, tones={100.0: 0.5})
    # with another offset
    quiet = 1e-3 * np.random.default_rng(2).standard_normal((2, 40_000))
    ring2 = Ring(2, 80_000, np.float64)
    ring2.append(Block(ring.span(0, 40_000).volts, 0))
    ring2.append(Block(quiet, 40_000))
    band = followed(ring2, window_s=4.0)
    picture = band.waterfall(256, 32)[0]
    loud = picture.max(axis=1) > 0.1
    edge = loud.argmin() / loud.size
    assert loud[0]
    assert not loud[-1]
    assert edge == pytest.approx(0.5, abs=0.05)
