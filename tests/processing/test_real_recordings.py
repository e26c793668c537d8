"""The chain on real recordings made by others; skipped where they are not at hand."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest
from benchmarks.altered import altered
from benchmarks.scoring.real_truth import known_of, read

from radargui.files.reading import parse_channel_map, read_mapped
from radargui.model.arrays import FloatArray
from radargui.model.recording import Digitisation, Recording
from radargui.model.result import RunResult
from radargui.model.setup import Setup
from radargui.processing.process import process

MID_STROKE_S = 1.0


def one_receiver(frequency_hz: float, phase_sign: int, correction: str) -> Setup:
    """A monostatic radar: transmitter and receiver at one place."""
    return Setup.model_validate(
        {
            "schema": 1,
            "radar": {"frequency_hz": frequency_hz, "phase_sign": phase_sign},
            "transmitter": {"distance_m": 1.0},
            "receiver": [{"tilt_deg": 0.0, "azimuth_deg": 0.0, "distance_m": 1.0}],
            "processing": {"correction": correction},
        }
    )


def plate_radar(folder: Path, stem: str) -> Recording:
    """One receiver of the 9 GHz radar from its two MATLAB files."""
    paths = {part: folder / "radar-9ghz" / f"{stem}_{part}_C.mat" for part in "IQ"}
    mapping = parse_channel_map(",".join(f"{part}1={path}:src1.Data" for part, path in paths.items()))
    return read_mapped(mapping, name=stem)


def strokes(time_s: FloatArray, position_m: FloatArray) -> list[slice]:
    """The runs of samples in which the plate goes one way, at least two seconds long."""
    velocity = np.gradient(np.convolve(position_m, np.ones(101) / 101, "same"), time_s)
    edges = [0, *(np.flatnonzero(np.diff(np.sign(velocity)) != 0) + 1).tolist(), time_s.size]
    return [slice(a, b) for a, b in itertools.pairwise(edges) if time_s[b - 1] - time_s[a] > 2.0]


@pytest.mark.parametrize("correction", ["published", "ellipse"])
def test_the_plate_of_the_9_ghz_radar_runs_at_300_mm_s_and_never_bounces(test_data: Path, correction: str) -> None:
    recording = plate_radar(test_data, "TB2_PRG_9")
    assert recording.digitisation.sample_rate_hz == 500.0
    result = process(recording, one_receiver(9.0e9, 1, correction))
    assert result.status == "ok"
    assert result.bounces.impacts == ()
    assert result.paths is not None
    time, path = result.paths.time_s, result.paths.change_m[0]
    found = strokes(time, path)
    assert len(found) == 6
    for number, (stroke, published) in enumerate(zip(found[1:5], (-299.9, 298.3, -300.3, 298.6), strict=True)):
        middle = 0.5 * (time[stroke][0] + time[stroke][-1])
        inside = np.abs(time - middle) < MID_STROKE_S
        speed = np.polyfit(time[inside], path[inside], 1)[0]
        assert speed == pytest.approx((-1) ** (number + 1) * 0.600, rel=0.01)
        assert speed / 2 * 1e3 == pytest.approx(published, abs=0.5)
        length = abs(path[stroke.stop - 1] - path[stroke.start]) / 2 * 1e3
        assert length == pytest.approx(892.3, abs=3.0)


def test_the_noise_of_the_9_ghz_radar_is_no_motion(test_data: Path) -> None:
    result = process(plate_radar(test_data, "TB2_ruido"), one_receiver(9.0e9, 1, "published"))
    assert result.status == "no_motion"
    assert result.paths is None


def toy_car(folder: Path, name: str) -> Recording:
    """I and Q of the 24 GHz radar: a period in us, then five interleaved 12 bit channels over 3.3 V."""
    data = (folder / "radar-24ghz" / name).read_bytes()
    period_us = float(np.frombuffer(data[:8], "<f8")[0])
    count = (len(data) - 8) // 10
    columns = np.frombuffer(data[8 : 8 + 10 * count], "<u2").reshape(count, 5)[300:, [0, 4]]
    codes = np.ascontiguousarray(columns.T.astype(np.int16))
    scale = (0.0, 3.3 / 4096)
    return Recording(name, codes, Digitisation(("I1", "Q1"), 1e6 / period_us, (scale, scale)))


def total_speed(result: RunResult) -> float:
    paths = result.paths
    assert paths is not None
    piece = np.zeros(paths.time_s.size, dtype=np.intp) if paths.piece is None else paths.piece
    known = paths.valid[0] & (piece == np.argmax(np.bincount(piece[paths.valid[0]])))
    assert known.mean() > 0.4
    return float(np.polyfit(paths.time_s[known], paths.change_m[0, known] / 2, 1)[0])


@pytest.mark.parametrize(("name", "stopwatch"), [("fram_fort_1.bin", 0.53), ("fram_fort_2.bin", 0.49)])
@pytest.mark.parametrize("correction", ["published", "ellipse"])
def test_the_toy_car_comes_nearer_at_its_speed(test_data: Path, name: str, stopwatch: float, correction: str) -> None:
    result = process(toy_car(test_data, name), one_receiver(24.13e9, -1, correction))
    assert result.status == "ok"
    assert total_speed(result) == pytest.approx(-stopwatch, rel=0.1)


@pytest.mark.parametrize("correction", ["ellipse", "adaptive"])
def test_the_quadrature_error_of_the_24_ghz_radar_is_found_and_its_image_gone(test_data: Path, correction: str) -> None:
    found = []
    for name in ("fram_fort_1.bin", "fram_fort_2.bin"):
        result = process(toy_car(test_data, name), one_receiver(24.13e9, -1, correction))
        assert result.status == "ok"
        assert result.corrected is not None
        channel = result.corrected.channels[0]
        assert channel.quadrature_error_deg == pytest.approx(17.5, abs=0.4)
        assert channel.gain_ratio == pytest.approx(1.02, abs=0.01)
        assert channel.image_rejection_db is not None
        assert channel.image_rejection_db > 43.0
        found.append(channel.quadrature_error_deg)
    assert abs(found[0] - found[1]) < 0.5


@pytest.mark.parametrize(("first_s", "last_s"), [(4.55, 10.52), (17.46, 23.45), (32.67, 38.64)])
def test_the_plate_is_followed_through_the_beam_and_nowhere_else(
    test_data: Path, first_s: float, last_s: float
) -> None:
    recording = read(test_data, "DIA")
    setup = one_receiver(9.0e9, 1, "adaptive")
    result, known = process(recording, setup), known_of("DIA", recording, setup.radar.wavelength_m)
    paths = result.paths
    assert paths is not None
    assert paths.piece is not None
    assert not (paths.valid[0] & known.absent).any()
    stroke = slice(round(first_s * 500.0), round(last_s * 500.0))
    assert paths.valid[0, stroke].mean() > 0.98
    assert np.ptp(paths.piece[stroke][paths.valid[0, stroke]]) == 0
    told, true = (float(one[stroke.stop - 1] - one[stroke.start]) for one in (paths.change_m[0], known.path_m))
    assert told == pytest.approx(true, rel=0.005)


def test_an_ellipse_that_a_second_reflection_bends_is_refused_where_the_line_knows_better(test_data: Path) -> None:
    recording = read(test_data, "car_rev2")
    assert process(recording, one_receiver(24.13e9, 1, "ellipse")).status == "rejected"
    channel = process(recording, one_receiver(24.13e9, 1, "adaptive")).corrected.channels[0]  # type: ignore[union-attr]
    assert channel.gain_ratio == pytest.approx(0.762, abs=2 * 0.004)
    assert channel.quadrature_error_deg == pytest.approx(25.3, abs=2 * 0.4)


def test_a_plate_under_a_hum_and_noise_is_not_called_at_rest(test_data: Path) -> None:
    # backwards, noise and mains added: without the mains nothing shakes the voltages, and its line goes on
    name, how, one = altered(test_data, 77301, 32)
    assert (name, how) == ("PRG", "backwards, noisier, humming")
    recording = Recording(name, np.ascontiguousarray(one.volts), Digitisation(("I1", "Q1"), one.rate_hz))
    result = process(recording, one_receiver(9.0e9, 1, "adaptive"))
    assert result.status == "ok"
    assert result.paths is not None
    valid = result.paths.valid[0]
    assert valid.mean() > 0.9
