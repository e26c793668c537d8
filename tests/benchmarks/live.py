"""The live position against the truth and against the result of the same run, on simulated bouncing drops.

And on motions of the laboratory: what is shown without a word and is wrong. In blocks as the worker feeds them.

Then e of the first bounce, live and preliminary: on drops recorded in real time, how long after touch-down it is told,
and on *modelled* drops, what processor time it costs and how often 2u holds the truth.

python3 packaging/dev.py bench live [--part places e] [--offline published,ellipse,joint] [--laboratory 8] [--drops 8] \
    [--scenes 40] [--seed N]
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
import time
from collections.abc import Iterable
from datetime import datetime
from pathlib import Path
from typing import get_args

os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np
from benchmarks.gate.statistics import share as share_of
from benchmarks.world import kinds
from benchmarks.world.draw import MOTIONS, draw
from benchmarks.world.scene import make_record
from support.changed import changed
from support.simulated_recording import simulate_recording

from radargui.acquisition.stream import LIVE_BLOCK_S
from radargui.experiment.event import LIVE, Event, EventKind
from radargui.experiment.finished import BegunJob, early_result, live_agreement
from radargui.experiment.live_bounce import first_bounce
from radargui.experiment.series import Experiment
from radargui.files.access import silent
from radargui.live.processor import LiveMemory, LiveProcessor
from radargui.live.track import LiveTrack
from radargui.model.errors import RadarGuiError
from radargui.model.recording import Recording
from radargui.model.setup import Correction, Setup, read_setup
from radargui.processing.process import process
from radargui.session.session import Session
from radargui.sources.simulated.model import SimulatedSource
from radargui.system.cores import one_blas_thread
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


MIN_INSIDE = 0.92
"""Share of e within their 2u, at least, within what the number of drops tells."""
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


class TimedSource(SimulatedSource):
    """The simulated source in real time, which knows when it began."""

    began_s = np.nan

    def start(self) -> None:
        self.began_s = time.perf_counter()
        super().start()


def told_s(setup: Setup) -> tuple[float, float, float, float]:
    """Return when live and preliminary e, the closed file and the preliminary result were told of a run in real time.

    In s after the true touch-down. The final result is not waited for.
    """
    source, heard = TimedSource(setup, realtime=True), list[tuple[float, Event]]()
    touch_s = source.truth(0, round(10.0 * setup.daq.rate_hz)).impact_time_s[0]

    def hear(event: Event) -> None:
        heard.append((time.perf_counter() - source.began_s - touch_s, event))
        # others wait for the computer
        if event.kind is EventKind.PRELIMINARY:
            experiment.cancel()

    def first(kind: EventKind, method: str = "") -> float:
        own = (at_s for at_s, one in heard if one.kind is kind and (not one.bounce or one.bounce.method == method))
        return next(own, np.nan)

    with tempfile.TemporaryDirectory() as folder:
        session = Session.create(Path(folder), setup, now=datetime.now().astimezone())
        experiment = Experiment(setup, lambda _run: source, session, listener=hear)
        list(experiment.record(1))
        session.close()
    preliminary = first(EventKind.PRELIMINARY)
    # told with the whole result where the file was closed before
    early = min(first(EventKind.BOUNCE, "flights"), preliminary, key=lambda at_s: np.nan_to_num(at_s, nan=np.inf))
    return first(EventKind.BOUNCE, LIVE), early, first(EventKind.RECORDED), preliminary


def times(count: int) -> None:
    """Print when e is told of drops from low to high restitution."""

    def show(name: str, values: Iterable[float]) -> None:
        print(f"{name:36} " + " ".join(f"{one:9.2f}" for one in values), flush=True)

    print(f"{'s after touch-down':36} {'live e':>9} {'prelim. e':>9} {'closed':>9} {'result':>9}")
    rows = []
    for number, e in enumerate(np.linspace(0.4, 0.85, count)):
        # the process that computes has begun when the operator lets go
        simulation = {"restitution": float(e), "seed": number + 1, "rest_s": 6.0}
        rows.append(told_s(changed(read_setup(default_setup_path()), simulation=simulation)))
        show(f"e = {e:.2f}", rows[-1])
    show("median", np.median(rows, axis=0))
    show("worst", np.max(rows, axis=0))


def of_scene(seed: int, number: int) -> tuple[list[tuple[float, float]], tuple[float, float]]:
    """Return error and u of the live e and of the preliminary one of a *modelled* drop, and processor time of each.

    None of either where it was not told.
    """
    scene = kinds.draw("modelled", seed, number, {"rest_s": 1.0})
    record, setup = scene.record(), Setup.model_validate(scene.setup)
    recording, rate_hz = record.recording, record.recording.digitisation.sample_rate_hz
    live, block = LiveProcessor(setup, recording.digitisation), round(LIVE_BLOCK_S * rate_hz)
    track, found = LiveTrack(setup.n_receivers, rate_hz, recording.n_samples / rate_hz), list[tuple[float, float]]()
    impact_s, _, _, e, _ = record.impacts[0]
    for first in range(0, recording.n_samples, block):
        track.append(live.push(recording.raw[:, first : first + block], first))
        began_s = time.process_time()
        bounce = first_bounce(track, 0, setup) if first > impact_s * rate_hz else None
        if bounce is None:
            continue
        live_s = time.process_time() - began_s
        found.append((bounce.e - e, bounce.u_stated))
        begun = Recording(scene.name, recording.raw[:, : first + block], recording.digitisation)
        began_s = time.process_time()
        result = early_result(BegunJob(begun, setup), silent)
        if result is not None and (impacts := result.bounces.impacts):
            found.append((impacts[0].e - e, impacts[0].u_stated))
        return found, (live_s, time.process_time() - began_s)
    return found, (np.nan, np.nan)


def e_of_scenes(count: int, seed: int) -> bool:
    """Print how near e is to the truth, and what it costs; return whether 2u holds it too seldom."""
    with one_blas_thread():
        scenes = [of_scene(seed, number) for number in range(count)]
    is_missed = False
    title = f"{count} modelled drops, seed {seed}"
    print(f"{title:36} {'told':>8} {'inside 2u':>22} {'median %':>8} {'processor s':>14}")
    for part, name in enumerate(("live e", "preliminary e")):
        rows = np.array([found[part] for found, _ in scenes if len(found) > part])
        took = np.array([spent[part] for found, spent in scenes if len(found) > part])
        inside = int((np.abs(rows[:, 0]) < 2.0 * rows[:, 1]).sum())
        held = share_of(inside, len(rows))
        is_missed |= held.high < MIN_INSIDE
        share = f"{held.value:.1%} ({held.low:.1%} to {held.high:.1%})"
        error = 100.0 * float(np.median(np.abs(rows[:, 0])))
        print(f"{name:36} {len(rows):8} {share:>22} {error:8.4f} {np.median(took):6.2f}, {took.max():6.2f}")
    return is_missed


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    known = get_args(Correction)
    best = "joint" if "joint" in known else "published"
    parser.add_argument("--offline", default=best, help="corrections of the results to compare with; none: -")
    parser.add_argument("--laboratory", type=int, default=4, help="seeds of each motion")
    parser.add_argument("--part", nargs="+", choices=("places", "e"), default=("places", "e"))
    parser.add_argument("--drops", type=int, default=8, help="in real time")
    parser.add_argument("--scenes", type=int, default=40, help="modelled drops")
    parser.add_argument("--seed", type=int, default=1, help="of these")
    options = parser.parse_args()
    failed = False
    if "places" in options.part:
        failed |= places(options)
    if "e" in options.part:
        times(options.drops)
        failed |= e_of_scenes(options.scenes, options.seed)
    print("a limit was missed" if failed else "all limits kept")
    return int(failed)


def places(options: argparse.Namespace) -> bool:
    """Print how far live positions are from truth and result, and on motions; return whether one is too far."""
    known = get_args(Correction)
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
    print(f"limits: 0.3 mm rms for the first eight, {MAX_FAR:.0%} far off")
    return failed | laboratory(options.laboratory)


if __name__ == "__main__":
    sys.exit(main())
