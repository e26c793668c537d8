"""The real recordings of others through each correction: verdict, image rejection, front end, speed, what is wrong."""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path

import numpy as np
from benchmarks.scoring.budget import timed, with_correction
from benchmarks.scoring.one_receiver import WRONG_SHARE, judge
from benchmarks.scoring.real_truth import SOURCES, Known, Source, corrected, known_of, read
from benchmarks.world.one_receiver.generator import one_receiver_setup
from benchmarks.world.one_receiver.scene import Echo, Scene, by_moment, moment_samples, runs

from radargui.model.arrays import FloatArray
from radargui.model.recording import Recording
from radargui.model.result import RunResult

CORRECTIONS = ("adaptive", "ellipse", "published", "none")
U_GAIN_RATIO, U_QUADRATURE_DEG = 0.004, 0.4
"""Of the README's own values."""
SPEED_LAG_S = 0.1
MIN_STRETCH_S = 0.2
"""Ways and speeds are compared over stretches of this length at least."""


def scene_of(name: str, source: Source, recording: Recording, known: Known, correction: str) -> Scene:
    """Return a recording as a scene: what is judged is where the truth is known."""
    setup = one_receiver_setup(source.frequency_hz, source.phase_sign, correction)
    step = moment_samples(recording.digitisation.sample_rate_hz)
    judged = by_moment(known.judged.astype(float), step).min(axis=1) > 0.0
    still = source.truth == "still"
    return Scene(
        name=name,
        kind=source.truth,
        recording=recording,
        setup=with_correction(setup, correction),
        echoes=() if still else (Echo(known.path_m, np.ones_like(known.path_m)),),
        knowable=np.zeros_like(judged) if still else judged,
        expected="refused" if still else "ok",
        gain_ratio=source.gain_ratio or np.nan,
        quadrature_error_deg=source.quadrature_error_deg or np.nan,
        judged=judged,
    )


def image_rejection_db(volts: FloatArray, judged: slice, gain_ratio: float, quadrature_error_deg: float) -> float:
    """Return 20 log10 of the Doppler line over its image after one set of constants, no filter.

    The line: bins within 6 dB of the strongest of the stronger side: farther ones hold more noise than image.
    """
    part = volts[:, judged]
    wave = corrected(part - part.mean(axis=1, keepdims=True), gain_ratio, quadrature_error_deg)
    power = np.abs(np.fft.fft(wave * np.hanning(len(wave)))) ** 2
    half = len(power) // 2
    up, down = power[3:half], power[-3 : -half if len(power) % 2 == 0 else -half - 1 : -1]
    count = min(len(up), len(down))
    up, down = up[:count], down[:count]
    line, image = (up, down) if up.max() >= down.max() else (down, up)
    inside = line >= 0.25 * line.max()
    return float(10.0 * np.log10(line[inside].sum() / image[inside].sum()))


def front_end(volts: FloatArray, moving: slice, source: Source, result: RunResult) -> str:
    """Return image rejection, gain ratio and quadrature error with u in words, and their distance from the README's."""
    if result.corrected is None:
        return ""
    one = result.corrected.channels[0]
    gain, angle_deg = one.gain_ratio, one.quadrature_error_deg
    if gain is None or angle_deg is None:
        return ""
    u_gain, u_angle_deg = one.u_gain_ratio or 0.0, one.u_quadrature_error_deg or 0.0
    words = f"gain {gain:.3f} +- {u_gain:.4f}, quadrature {angle_deg:.1f} +- {u_angle_deg:.2f} deg"
    if moving.stop > moving.start and source.truth != "plate":  # to and fro has a line at both sides
        words = f"{image_rejection_db(volts, moving, gain, angle_deg):.0f} dB, {words}"
    if source.gain_ratio is not None and source.quadrature_error_deg is not None:
        gain_sigmas = abs(gain - source.gain_ratio) / np.hypot(u_gain, U_GAIN_RATIO)
        angle_sigmas = abs(abs(angle_deg) - source.quadrature_error_deg) / np.hypot(u_angle_deg, U_QUADRATURE_DEG)
        words += f" (off by {gain_sigmas:.1f} u, {angle_sigmas:.1f} u)"
    return words


def path_in_words(source: Source, known: Known, result: RunResult) -> tuple[str, float]:
    """Return speed or strokes against the truth in words, and the share of valid samples without an echo."""
    if result.paths is None:
        return "", 0.0
    first = 0 if result.recording.excerpt is None else result.recording.excerpt.first_stored
    time_s, change_m, valid = result.paths.time_s, result.paths.change_m[0], result.paths.valid[0]
    here = slice(first, first + len(valid))
    absent = float((valid & known.absent[here]).sum() / max(int(valid.sum()), 1))
    told, strokes = valid & known.judged[here], []
    speeds = []
    for begin, end in runs(told):
        if time_s[end - 1] - time_s[begin] < MIN_STRETCH_S:
            continue
        strokes.append(np.ptp(change_m[begin:end]) / np.ptp(known.path_m[here][begin:end]) - 1.0)
        lag = min(int(np.searchsorted(time_s, time_s[begin] + SPEED_LAG_S)) - begin, (end - begin) // 2)
        later_m, earlier_m = change_m[begin + lag : end], change_m[begin : end - lag]
        speeds.append(float(np.median(np.abs(later_m - earlier_m) / (time_s[begin + lag] - time_s[begin]))) / 2.0)
    if not speeds:
        return "", absent
    words = f"speed {np.median(speeds):.3f} m/s" + (f" ({source.speed_m_s})" if source.speed_m_s else "")
    words += f", way {100.0 * max(strokes, key=abs):+.1f} %"
    return words + (f", {100.0 * absent:.0f} % of valid without an echo" if known.absent.any() else ""), absent


def run(folder: Path, name: str, correction: str, limit_s: float) -> str:
    """Print one line; return in which way it is silently wrong, empty where it is not."""
    source, recording = SOURCES[name], read(folder, name)
    setup = one_receiver_setup(source.frequency_hz, source.phase_sign, correction)
    known = known_of(name, recording, setup.radar.wavelength_m)
    scene = scene_of(name, source, recording, known, correction)
    result, processor_s = timed(recording, scene.setup, limit_s)
    if isinstance(result, str):
        print(f"{name:14}{correction:10}{processor_s:6.1f} s  {result[:100]}", flush=True)
        return ""
    one = judge(scene, result, processor_s)
    moving = slice(*max(runs(known.judged), key=lambda part: part[1] - part[0], default=(0, 0)))
    way, absent = path_in_words(source, known, result)
    wrong = one.wrong or ("valid where there is no echo" if result.status == "ok" and absent > WRONG_SHARE else "")
    verdict = result.corrected.channels[0].verdict if result.corrected is not None else "-"
    shares = f"valid {one.valid_share:.2f}, right {one.right_share:.2f}"
    told = [front_end(recording.volts(), moving, source, result), way, one.reason[:70]]
    outcome = f"WRONG: {wrong}" if wrong else "right" if one.right else "not wrong"
    words = "; ".join([outcome, shares, *filter(None, told)])
    print(f"{name:14}{correction:10}{processor_s:6.1f} s  {one.status:9} {verdict:9} {words}", flush=True)
    return wrong


def main() -> int:
    """Print the table, and return 1 where a recording is silently wrong."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--recording", nargs="+", choices=SOURCES, default=list(SOURCES))
    parser.add_argument("--correction", nargs="+", choices=CORRECTIONS, default=list(CORRECTIONS))
    parser.add_argument("--limit-s", type=float, default=120.0, help="processor time after which one is given up")
    options = parser.parse_args()
    folder = Path(os.environ.get("RADARGUI_TEST_DATA", ""))
    if not (folder / "radar-24ghz").is_dir():
        print("RADARGUI_TEST_DATA is unset or not the folder of the real recordings.", file=sys.stderr)
        return 2
    total = dict.fromkeys(options.correction, 0)
    for name in options.recording:
        for correction in options.correction:
            total[correction] += bool(run(folder, name, correction, options.limit_s))
    for correction, wrong in total.items():
        print(f"{correction}: silently wrong {wrong} of {len(options.recording)}")
    return int(any(total.values()))


if __name__ == "__main__":
    sys.exit(main())
