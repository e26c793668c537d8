"""Export of an hour at 6 x 33 kS/s: time, size, and memory, which must stay below one gigabyte."""

from __future__ import annotations

import argparse
import multiprocessing
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from support.file_samples import int16_digitisation

from radargui.files.formats import EXPORT_FORMATS, export_run
from radargui.files.run_writer import RunWriter
from radargui.model.recording import Block

RATE_HZ = 33333.0
LIMIT_MB = 1000.0


def make_run(path: Path, minutes: float) -> None:
    """Write a run of codes that are as hard to compress as a signal with noise."""
    chance = np.random.default_rng(1)
    piece = np.arange(1 << 18)
    wave = 9000.0 * np.sin(piece * 2.0 * np.pi * 130.0 / RATE_HZ)
    first, end = 0, round(minutes * 60.0 * RATE_HZ)
    with RunWriter(path, int16_digitisation(RATE_HZ), started_at="2026-11-20T15:04:05+00:00") as writer:
        while first < end:
            count = min(piece.size, end - first)
            codes = np.stack([wave[:count] + chance.normal(0.0, 30.0, count) for _ in range(6)])
            writer.write(Block(codes.astype(np.int16), first))
            first += count


def export(path: Path, name: str, folder: Path, pipe: object) -> None:
    """Export in a process of its own and send its peak memory in megabytes."""
    import resource

    export_run(path, EXPORT_FORMATS[name], folder)
    pipe.send(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0)  # type: ignore[attr-defined]


def main() -> int:
    """Print a line a format; return 1 where one takes more memory than allowed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--minutes", type=float, default=60.0)
    parser.add_argument("--format", choices=list(EXPORT_FORMATS), action="append")
    options = parser.parse_args()
    worst = 0.0
    context = multiprocessing.get_context("spawn")
    with tempfile.TemporaryDirectory() as place:
        run = Path(place, "run-0001.h5")
        begin = time.monotonic()
        make_run(run, options.minutes)
        print(f"recorded: {run.stat().st_size / 1e9:.2f} GB in {time.monotonic() - begin:.0f} s", flush=True)
        for name in options.format or EXPORT_FORMATS:
            begin = time.monotonic()
            here, there = context.Pipe()
            process = context.Process(target=export, args=(run, name, Path(place, name), there))
            process.start()
            peak = here.recv()
            process.join()
            made = list(Path(place, name).iterdir())
            size = sum(path.stat().st_size for path in made) / 1e9
            print(f"{name:6} {time.monotonic() - begin:6.0f} s {size:7.2f} GB, peak {peak:5.0f} MB", flush=True)
            worst = max(worst, peak)
            for path in made:
                path.unlink()
    return int(worst > LIMIT_MB)


if __name__ == "__main__":
    sys.exit(main())
