"""Right or refused: a small seeded part of the benchmark `robust`, whose truth is fixed beforehand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from benchmarks.scoring.broken import judge_drop
from benchmarks.scoring.one_receiver import RIGHT_SHARE, judge
from benchmarks.world.broken.drops import drop_setup, make_drop
from benchmarks.world.broken.garbage import GARBAGE, make_garbage
from benchmarks.world.draw import draw
from benchmarks.world.one_receiver.disturbances import Mixer
from benchmarks.world.one_receiver.generator import make_scene
from benchmarks.world.one_receiver.scene import Scene
from benchmarks.world.scene import make_record
from support.changed import changed

from radargui.model.arrays import FloatArray
from radargui.model.result import PathLengths, RunResult
from radargui.processing.process import process

SEED = 0

SCENES = (0, 1, 3, 4, 5, 9, 10, 13, 15, 19, 21, 22, 24, 25, 26, 27)
"""Numbers of scenes that come out right, or are refused where that is expected or allowed."""
KNOWN_SCENES = (14, 18, 20, 23)
"""Not yet right: fading, stops, a mixture and a second target: valid in too small a share."""

LONG = (("dead", 0, 3), ("dead with noise", 1, 3), ("swapped", 3, 3))
"""Take seconds; of each kind but the last one there is a quick one of four receivers."""
BROKEN: tuple[tuple[str, int, int], ...] = (
    ("whole", 0, 3),
    ("dead", 0, 3),
    ("dead with noise", 1, 3),
    ("copied", 2, 3),
    ("swapped", 3, 3),
    ("doubled cable", 4, 3),
    ("constant", 5, 3),
    ("clipped", 6, 3),
    ("dead", 10, 4),
    ("dead with noise", 12, 4),
)
"""Kind, seed and number of receivers of drops that come out right."""


@pytest.mark.parametrize("number", SCENES)
def test_a_scene_is_right_or_refused_as_was_fixed_beforehand(number: int) -> None:
    scene = make_scene(SEED, number)
    judgement = judge(scene, process(scene.recording, scene.setup), 0.0)
    assert not judgement.wrong, f"{scene.name}: {judgement.wrong}"
    assert judgement.right or scene.expected != "ok", f"{scene.name}: {judgement.status}, {judgement.reason}"


@pytest.mark.parametrize(
    ("kind", "seed", "n_receivers"),
    [pytest.param(*one, marks=pytest.mark.slow if one in LONG else ()) for one in BROKEN],
)
def test_a_broken_channel_is_named_and_gives_no_track(kind: str, seed: int, n_receivers: int) -> None:
    drop = make_drop(seed, kind, n_receivers)
    # sound receivers go on as any do, see `test_by_estimate`: the joint estimate says no more of the fourth
    sound = n_receivers == 4 or kind == "whole"
    setup = changed(drop.setup, processing={"correction": "adaptive"}) if sound else drop.setup
    judgement = judge_drop(drop, process(drop.recording, setup), 0.0)
    assert not judgement.called_good, f"{drop.name}: receivers {judgement.called_good} called good"
    assert not judgement.false_track
    assert judgement.right, f"{drop.name}: {judgement.status}, {judgement.reason}"


@pytest.mark.parametrize("kind", list(GARBAGE))
def test_garbage_is_refused(kind: str) -> None:
    assert process(make_garbage(SEED, kind), drop_setup(3)).status != "ok"


def said(scene: Scene, path_m: FloatArray, valid: FloatArray | None = None) -> RunResult:
    """A result that says this path."""
    claimed = np.ones((1, len(path_m)), dtype=np.bool_) if valid is None else valid[None].astype(np.bool_)
    change_m = np.where(claimed, path_m, np.nan)
    paths = PathLengths(scene.recording.time_s(), change_m, change_m, np.full_like(change_m, 1e-4), claimed)
    return RunResult(scene.recording, scene.setup, "ok", paths=paths)


@pytest.mark.parametrize("number", [2, 5, 6, 17, 18, 24])
def test_what_is_called_knowable_is_followed_by_who_knows_mixer_and_offset(number: int) -> None:
    scene = make_scene(SEED, number)
    echo, rate_hz = scene.echoes[0], scene.recording.digitisation.sample_rate_hz
    assert scene.expected == "ok"
    inverse = Mixer(scene.gain_ratio, float(np.deg2rad(scene.quadrature_error_deg))).inverse(scene.recording.volts())
    turns = scene.setup.radar.phase_sign * echo.path_m / scene.setup.radar.wavelength_m
    wave = inverse[0] + 1j * inverse[1]
    late = np.linspace(-1.0, 1.0, len(wave))
    inputs = np.column_stack([*(late**power for power in range(8)), echo.amplitude_v * np.exp(2j * np.pi * turns)])
    offsets = np.linalg.lstsq(inputs[::10], wave[::10], rcond=None)[0][:-1]
    wave = wave - inputs[:, :-1] @ offsets
    doppler_hz = np.abs(np.gradient(turns)).max() * rate_hz
    spectrum, frequency_hz = np.fft.fft(wave), np.fft.fftfreq(len(wave), 1.0 / rate_hz)
    wave = np.fft.ifft(np.where(np.abs(frequency_hz) < doppler_hz + 50.0, spectrum, 0.0))
    path_m = scene.setup.radar.phase_sign * np.unwrap(np.angle(wave)) / (2 * np.pi) * scene.setup.radar.wavelength_m
    assert judge(scene, said(scene, path_m), 0.0).right_share >= 0.97


def test_the_truth_is_right_and_a_path_that_stands_still_in_a_fade_is_silently_wrong() -> None:
    scene = make_scene(SEED, 2)
    path_m = scene.echoes[0].path_m
    assert judge(scene, said(scene, path_m), 0.0).right
    faded = scene.echoes[0].amplitude_v < 0.05 * scene.echoes[0].amplitude_v.max()
    still_m = np.cumsum(np.where(faded, 0.0, np.gradient(path_m)))
    assert "moments called valid" in judge(scene, said(scene, still_m), 0.0).wrong
    assert judge(scene, said(scene, still_m, ~faded), 0.0).wrong.startswith("path joined over")
    honest = judge(scene, said(scene, path_m, ~faded), 0.0)
    assert honest.right
    assert honest.valid_share >= RIGHT_SHARE


def test_motion_where_nothing_moves_and_no_motion_where_a_target_moves_are_silently_wrong() -> None:
    still, moving = make_scene(SEED, 19), make_scene(SEED, 0)
    assert still.expected == "refused"
    assert judge(still, said(still, np.zeros(still.recording.n_samples)), 0.0).wrong
    nothing = RunResult(moving.recording, moving.setup, "no_motion")
    assert judge(moving, nothing, 0.0).wrong
    assert not judge(moving, replace(nothing, status="rejected"), 0.0).wrong


@pytest.mark.parametrize(("receiver", "late"), [(0, True), (1, False)])
def test_one_receiver_that_missed_the_slow_beginning_says_from_where_its_lengths_count(
    receiver: int, late: bool
) -> None:
    record, pair = make_record(draw(602009, "exact")), slice(2 * receiver, 2 * receiver + 2)
    digitisation = replace(record.recording.digitisation, channel_names=("I1", "Q1"), scaling=None)
    volts = record.recording.volts()[pair]
    alone = replace(record.recording, raw=volts, digitisation=digitisation)
    setup = record.scene.setup.model_copy(update={"receiver": record.scene.setup.receiver[receiver : receiver + 1]})
    result = process(alone, setup)
    assert result.paths is not None
    assert any("path lengths count from there" in warning for warning in result.warnings) is late
    known = result.paths.valid[0]
    assert (result.paths.time_s[known][0] > record.scene.drop.start_s) is np.bool_(late)
