"""An hour at 6 x 33 kS/s: processed and stored in less than 1.5 GB, its first picture in less than 2 s."""

from __future__ import annotations

import argparse
import multiprocessing
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from support.simulated_recording import simulate_recording
from support.simulated_setup import simulated_setup

from radargui.files.run_writer import RunWriter
from radargui.model.recording import Block
from radargui.model.setup import Setup, dump_setup

RATE_HZ = 33333.0
LIMIT_MB = 1500.0
PICTURE_S = 2.0
WIDTH = 2000


def make_run(path: Path, setup: Setup, minutes: float) -> None:
    """Write a run that is at rest, but for one drop in the middle."""
    recording, _ = simulate_recording(setup)
    quiet = recording.raw[:, : round(0.5 * RATE_HZ)]
    # as hard to compress as noise, and without a jump where it is joined
    pieces: Iterator[Any] = iter([np.concatenate([quiet, quiet[:, ::-1]], axis=1)] * round(minutes * 60.0))
    first, drop = 0, round(minutes * 30.0)
    with RunWriter(
        path, recording.digitisation, started_at="2026-11-20T15:04:05+00:00", setup_toml=dump_setup(setup)
    ) as writer:
        for second, piece in enumerate(pieces):
            samples = recording.raw if second == drop else piece
            writer.write(Block(samples, first))
            first += samples.shape[1]


def process(path: Path) -> str:
    """Process the run and store its results."""
    from radargui.experiment.reprocess import process_run

    result = process_run(path)
    bounce = result.bounces.impacts[0]
    reason = result.recording.excerpt.reason if result.recording.excerpt else "the whole is processed"
    return f"{result.status}, e = {bounce.e:.4f} ± {bounce.u_e:.4f} at {bounce.time_s:.2f} s, {reason}"


def show(path: Path) -> str:
    """Read what the first picture needs."""
    from radargui.files.overview import read_overview
    from radargui.files.run_card import read_run_card, read_thumbnail

    begun = time.perf_counter()
    card, overview, thumbnail = read_run_card(path), read_overview(path, WIDTH), read_thumbnail(path)
    took_s = time.perf_counter() - begun
    points = thumbnail.time_s.size if thumbnail else 0
    return f"{took_s:.3f} s for {overview.lowest.shape[1]} bins of {card.n_samples} samples and {points} points of z(t)"


def apart(work: Callable[[Path], str], path: Path) -> tuple[str, float, float]:
    """Do work in a process of its own; return what it says, its peak memory in MB, and its time in s with its start."""
    context = multiprocessing.get_context("spawn")
    here, there = context.Pipe()
    begun = time.perf_counter()
    process = context.Process(target=_work, args=(work, path, there))
    process.start()
    there.close()
    said, peak = here.recv()
    process.join()
    return said, peak, time.perf_counter() - begun


def _work(work: Callable[[Path], str], path: Path, pipe: Any) -> None:
    import resource

    said = work(path)
    pipe.send((said, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0))


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--minutes", type=float, default=60.0)
    options = parser.parse_args()
    setup = simulated_setup(daq={"rate_hz": RATE_HZ}, restitution=0.7)
    with tempfile.TemporaryDirectory() as place:
        run = Path(place, "run-0001.h5")
        begun = time.perf_counter()
        make_run(run, setup, options.minutes)
        print(f"recorded: {run.stat().st_size / 1e9:.2f} GB in {time.perf_counter() - begun:.0f} s", flush=True)
        said, peak, took_s = apart(process, run)
        print(f"processed and stored in {took_s:.0f} s, peak {peak:.0f} MB (limit {LIMIT_MB:.0f}): {said}", flush=True)
        shown, shown_peak, whole_s = apart(show, run)
        print(f"first picture: {shown}; {whole_s:.1f} s with the start of Python, peak {shown_peak:.0f} MB")
    return int(peak > LIMIT_MB or float(shown.split()[0]) > PICTURE_S)


if __name__ == "__main__":
    sys.exit(main())
