"""Speed of the whole chain beside a copy of the input, arctan2 of the receivers, and a plain script of the procedure.

And the memory it takes, how long the program takes to start, and what a short run file costs beside reading it.

python3 packaging/dev.py bench speed [--rate slow fast] [--correction published adaptive ...] [--repeats 5] [--no-start]
"""

from __future__ import annotations

import argparse
import os
import statistics
import subprocess
import sys
import tempfile
import time
import tracemalloc
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from benchmarks.accuracy import with_method
from benchmarks.plain_script import plain_track
from benchmarks.world.generic import motion
from benchmarks.world.generic.draw import draw_scene
from benchmarks.world.generic.scene import SceneRecord, make_record
from threadpoolctl import threadpool_limits

from radargui.files.run_writer import RunWriter
from radargui.model.recording import Block
from radargui.model.setup import dump_setup
from radargui.processing.process import process

RATES: dict[str, tuple[float, float, float]] = {"slow": (33333.0, 2.0, 10.0), "fast": (1e6, 0.4, 2.0)}
"""Samples per second, seconds at rest, seconds in all."""
SCRIPT_COPIES = {"slow": 110.0, "fast": 70.0}
"""Copies of the input that the script itself may take: a slow one would flatter us."""
MOST = {
    ("published", "slow"): 1.0 / 1.2,
    ("published", "fast"): 0.25,
    ("adaptive", "slow"): 4.0,
    ("adaptive", "fast"): 1.0,
}
"""Times the script that a correction may take."""
MAX_MEMORY = 100.0
"""Bytes a frame of the record, beyond input and output."""
MAX_START, MAX_FILE = 0.15, 8.0
"""`radargui --version` in times of importing what the window is made of; a run file of 10 s in times of reading it."""
WINDOW = "import PySide6.QtWidgets, pyqtgraph, scipy.signal"
READER = "import numpy, h5py; h5py.File({path!r})['raw'][...]"


def record_of(rate: str) -> SceneRecord:
    """Return one drop of 20 cm that bounces for 4 s: 35 dB, generic mismatch, three receivers."""
    rate_hz, rest_s, duration_s = RATES[rate]
    scene = draw_scene(3, "generic", "drop", snr_db=35.0, rate_hz=rate_hz, skew_s=1e-7, amplitude_v=1.0, n_receivers=3)
    release_m = np.asarray(scene.setup.tracer.release_position_m)
    moving = motion.drop(
        np.random.default_rng(3),
        release_m=release_m,
        height_m=0.2,
        restitution=0.9,
        drift_m_s=0.03,
        rest_s=rest_s,
        duration_s=duration_s,
    )
    return make_record(replace(scene, motion=moving))


def median_s(work: Callable[[], Any], repeats: int) -> float:
    """Return the median processor time, after one run that does not count."""
    work()
    took = []
    for _ in range(repeats):
        begun = time.process_time()
        work()
        took.append(time.process_time() - begun)
    return statistics.median(took)


def measure(rate: str, corrections: list[str], repeats: int) -> list[str]:
    """Print the table of one rate and return what misses its limit."""
    record = record_of(rate)
    recording, setup = record.recording, record.setup
    volts = recording.volts()
    n = recording.n_samples
    track, found = plain_track(volts, recording.digitisation.sample_rate_hz, setup)
    off_m = track - record.truth.position_m[:, found]
    copied = median_s(volts.copy, repeats)
    turned = median_s(lambda: np.arctan2(volts[1::2], volts[0::2]), repeats)
    script = median_s(lambda: plain_track(volts, recording.digitisation.sample_rate_hz, setup), repeats)
    print(f"{rate}: {n / recording.digitisation.sample_rate_hz:.0f} s at {RATES[rate][0] / 1e3:.0f} kS/s, {n} samples")
    print(f"{'':24}{'ns a frame':>12}{'copies':>9}{'arctan2':>9}{'scripts':>9}")

    def line(name: str, took_s: float, said: str = "") -> None:
        ratios = (1e9 * took_s / n, took_s / copied, took_s / turned, took_s / script)
        print(f"{name:24}{ratios[0]:12.1f}{ratios[1]:9.1f}{ratios[2]:9.2f}{ratios[3]:9.2f}  {said}", flush=True)

    line("copy of the volts", copied)
    line("arctan2", turned)
    line("plain script", script, f"{1e3 * np.sqrt(np.mean(off_m**2)):.2f} mm off the truth")
    missed = (
        [] if script <= SCRIPT_COPIES[rate] * copied else [f"{rate}: the script takes {script / copied:.0f} copies"]
    )
    for correction in corrections:
        chosen = with_method(setup, f"{correction}-exact")
        result = process(recording, chosen)
        took = median_s(lambda chosen=chosen: process(recording, chosen), repeats)
        line(correction, took, f"{result.status}, {len(result.bounces.impacts)} impacts")
        memory = extra_bytes(lambda chosen=chosen: process(recording, chosen)) / n
        print(f"{'  memory':24}{memory:12.1f} bytes a frame")
        if memory > MAX_MEMORY:
            missed.append(f"{rate}: {correction} takes {memory:.0f} bytes a frame")
        whole = median_s(lambda chosen=chosen: process(recording, chosen).track, repeats)
        line("  with the track", whole)
        if took > MOST.get((correction, rate), np.inf) * script:
            missed.append(f"{rate}: {correction} takes {took / script:.2f} times the script")
    return missed


def extra_bytes(work: Callable[[], Any]) -> float:
    """Return the most memory that work takes beyond what it leaves behind."""
    tracemalloc.start()
    try:
        result = work()
        left, most = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    del result
    return float(most - left)


def command_s(arguments: list[str], repeats: int) -> float:
    """Return the median processor time of a Python command, its start included, after one that does not count."""
    took = []
    for _ in range(repeats + 1):
        before = os.times()
        subprocess.run([sys.executable, *arguments], check=True, capture_output=True)
        after = os.times()
        took.append(sum(after[2:4]) - sum(before[2:4]))
    return statistics.median(took[1:])


def measure_start(repeats: int) -> list[str]:
    """Print what starting the program and processing a short run file cost; return what misses its limit."""
    version, window = command_s(["-m", "radargui", "--version"], repeats), command_s(["-c", WINDOW], repeats)
    print(f"{'radargui --version':24}{1e3 * version:9.0f} ms {version / window:9.2f} times its libraries")
    record = record_of("slow")
    setup = with_method(record.setup, "published-exact")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "run-0001.h5"
        with RunWriter(path, record.recording.digitisation, started_at="", setup_toml=dump_setup(setup)) as writer:
            writer.write(Block(record.recording.raw, 0))
        read = command_s(["-c", READER.format(path=str(path))], repeats)
        whole = command_s(["-m", "radargui", "process", str(path), "--output", folder, "--force"], repeats)
    print(
        f"{'process a run of 10 s':24}{1e3 * whole:9.0f} ms {whole / read:9.2f} times reading it ({1e3 * read:.0f} ms)"
    )
    missed = [] if version <= MAX_START * window else [f"--version takes {version / window:.2f} of the libraries"]
    return missed + ([] if whole <= MAX_FILE * read else [f"a run file takes {whole / read:.1f} times reading it"])


def main() -> int:
    """Print the tables; 1 where a limit is missed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rate", nargs="+", choices=tuple(RATES), default=list(RATES))
    parser.add_argument("--correction", nargs="+", default=["published", "adaptive"])
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--no-start", action="store_true", help="neither start-up nor the short file")
    options = parser.parse_args()
    with threadpool_limits(limits=1, user_api="blas"):
        missed = [one for rate in options.rate for one in measure(rate, options.correction, options.repeats)]
    missed += [] if options.no_start else measure_start(options.repeats)
    print("\n".join(missed) or "all within their limits")
    return int(bool(missed))


if __name__ == "__main__":
    sys.exit(main())
