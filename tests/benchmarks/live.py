"""The live position against the truth and against the result of the same run, on simulated bouncing drops.

And on motions of the laboratory: what is shown without a word and is wrong. In blocks as the worker feeds them.

python3 packaging/dev.py bench live [--offline published,ellipse,joint] [--laboratory 8]
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from typing import get_args

os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np
from benchmarks.world.draw import MOTIONS, draw
from benchmarks.world.scene import make_record
from support.changed import changed
from support.simulated_recording import simulate_recording

from radargui.acquisition.stream import LIVE_BLOCK_S
from radargui.experiment.finished import live_agreement
from radargui.live.processor import LiveMemory, LiveProcessor
from radargui.live.track import LiveTrack
from radargui.model.errors import RadarGuiError
from radargui.model.setup import Correction, Setup, read_setup
from radargui.processing.process import process
from radargui.system.resources import default_setup_path

LIMIT_M = 0.3e-3
CASES: dict[str, dict[str, object]] = {
    "default (mismatch 0.02)": {},
    "default, seed 2": {"seed": 2},
    "default, seed 3": {"seed": 3},
    "reflection 0.1": {"reflection": 0.1},
    "reflection 0.1, seed 2": {"reflection": 0.1, "seed": 2},
    "reflection 0.1, seed 3": {"reflection": 0.1, "seed": 3},
    "reflection 0.2": {"reflection": 0.2},
    "SNR 30 dB": {"snr_db": 30.0},
}
BEYOND: dict[str, dict[str, object]] = {
    "mismatch 0.05": {"mismatch": 0.05},
    "mismatch 0.1": {"mismatch": 0.1},
    "mismatch 0.1, seed 3": {"mismatch": 0.1, "seed": 3},
    "reflection 0.1, lateral 0.03 m/s": {"reflection": 0.1, "lateral_speed_m_s": 0.03},
}
"""Told, without a limit."""


def followed(setup: Setup, run: int, memory: LiveMemory) -> tuple[str, float, LiveTrack, object]:
    """Return figures in mm, the root mean square against the truth in m, the live track and the recording."""
    recording, truth = simulate_recording(setup, run=run)
    live = LiveProcessor(setup, recording.digitisation, memory)
    rate_hz = recording.digitisation.sample_rate_hz
    track = LiveTrack(setup.n_receivers, rate_hz, recording.n_samples / rate_hz)
    block = round(LIVE_BLOCK_S * rate_hz)
    began = time.process_time()
    for first in range(0, recording.n_samples, block):
        track.append(live.push(recording.raw[:, first : first + block], first))
    share = (time.process_time() - began) * rate_hz / recording.n_samples
    span = track.since(0)
    error = np.linalg.norm(span.position_m - truth.position_m[:, span.index], axis=0)
    moved = np.abs(truth.path_m[:, span.index] - truth.path_m[:, :1]).max(axis=0) > setup.radar.wavelength_m
    after = error[int(np.argmax(moved)) :]
    rms = float(np.sqrt(np.mean(after**2)))
    return f"{1e3 * rms:8.3f} {1e3 * after.max():8.2f} {share:7.1%}", rms, track, recording


FAR_M = 5e-3
MAX_FAR = 0.02
"""Share of all motions that may be shown wrong by more without a word: moments before a motion or a fault is found."""


def shown(motion: str, seed: int) -> tuple[float, float, float, str]:
    """Return the share of a laboratory motion that is shown, the median error there in mm, the share that is far off.

    And what was said. What is told to start anew counts as not shown.
    """
    record = make_record(draw(seed, motion=motion, rest=1.0))
    recording, truth = record.recording, record.truth
    rate_hz = recording.digitisation.sample_rate_hz
    live, block, doubts = LiveProcessor(record.scene.setup, recording.digitisation), round(LIVE_BLOCK_S * rate_hz), {""}
    errors = []
    begins = int(np.argmax(np.linalg.norm(truth.position_m - truth.position_m[:, :1], axis=0) > 1e-3))
    for first in range(0, recording.n_samples, block):
        one = live.push(recording.raw[:, first : first + block], first)
        doubts.add(one.doubt)
        error = np.linalg.norm(one.position_m - truth.position_m[:, one.index], axis=0)[one.index >= begins]
        errors.append(np.full(error.shape, np.nan) if one.began_anew else error)
    error = np.concatenate(errors)
    known = error[np.isfinite(error)]
    share, far = known.size / max(1, error.size), float((known > FAR_M).sum() / max(1, error.size))
    return share, 1e3 * float(np.median(known)) if known.size else np.nan, far, ", ".join(sorted(doubts - {""}))


def laboratory(count: int) -> bool:
    """Print a line for each kind of motion and for what was said; return whether one is wrong too often."""
    all_far = []
    print(f"{'laboratory':36} {'shown':>8} {'mm':>8} {'far off':>8}")
    for motion in MOTIONS:
        found = [shown(motion, seed) for seed in range(1, count + 1)]
        share, median_mm, far = (float(np.nanmean([one[k] for one in found])) for k in range(3))
        all_far.append(far)
        print(f"{motion:36} {share:8.0%} {median_mm:8.2f} {far:8.2%}", flush=True)
        for seed, (*_, said) in enumerate(found, 1):
            if said:
                print(f"{'':4}{motion}-{seed}: {said}")
    print(f"{'of all':36} {'':8} {'':8} {np.mean(all_far):8.2%}")
    return bool(np.mean(all_far) > MAX_FAR)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    known = get_args(Correction)
    best = "joint" if "joint" in known else "published"
    parser.add_argument("--offline", default=best, help="corrections of the results to compare with; none: -")
    parser.add_argument("--laboratory", type=int, default=4, help="seeds of each motion")
    options = parser.parse_args()
    offline = [name for name in options.offline.split(",") if name in known]
    print(f"{'mm, after the first fringe':36} {'live rms':>8} {'worst':>8} {'1 core':>7}", end="")
    print("".join(f" {'against ' + name:>18}" for name in offline))
    failed = False
    for name, simulation in {**CASES, **BEYOND}.items():
        setup = changed(read_setup(default_setup_path()), simulation=simulation)
        memory = LiveMemory()
        for run in range(2):
            figures, rms, track, recording = followed(setup, run, memory)
            line = f"{name + (', next run' if run else ''):36} {figures}"
            good = rms <= LIMIT_M
            for correction in offline:
                try:
                    result = process(recording, changed(setup, processing={"correction": correction}))
                except RadarGuiError as error:
                    line += f" {error}"
                    continue
                agreement = live_agreement(track.since(0), 0, result)
                if agreement is None:
                    line += f" {'-':>18}"
                    continue
                line += f" {1e3 * agreement.rms_m:10.3f} {1e3 * agreement.max_m:7.2f}"
                good &= correction != "joint" or agreement.rms_m <= LIMIT_M
            limited = name in CASES
            failed |= limited and not good
            print(line + ("" if good or not limited else "  MISSED"), flush=True)
    failed |= laboratory(options.laboratory)
    print("a limit was missed" if failed else f"all limits kept: 0.3 mm rms for the first eight, {MAX_FAR:.0%} far off")
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
