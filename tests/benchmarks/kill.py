"""Recordings killed at random moments: every file opens with plain h5py, at most 0.6 s lost, all are recovered."""

from __future__ import annotations

import argparse
import random
import sys
import tempfile
import time
from datetime import UTC, datetime
from pathlib import Path

from support.killing import LOST_S, Killer

from radargui.experiment.reprocess import recover_run, unfinished_runs
from radargui.files.run_file import read_run, run_is_complete


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kills", type=int, default=30)
    parser.add_argument("--rate", type=float, default=33333.0, help="samples per second of each of 6 channels")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    chance = random.Random(options.seed)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        killer = Killer(folder, options.rate)
        killed = []
        for number in range(options.kills):
            one = killer.kill(chance.uniform(0.0, 2.5))
            killed.append(one)
            print(f"{number + 1:3} read {one.read:7} kept {one.kept:7} lost {one.lost_s:.3f} s right {one.right}")
        found = unfinished_runs(folder / "data", folder / "index.sqlite3")
        begun = time.perf_counter()
        recovered = [recover_run(one.path, now=datetime.now(UTC)) for one in found]
        took_s = time.perf_counter() - begun
        files = [(one.run, one.kept) for one in killed if one.run is not None]
        whole = sum(run_is_complete(run) and read_run(run).n_samples == kept for run, kept in files)
    worst = max(one.lost_s for one in killed)
    good = sum(one.good for one in killed)
    print(f"{len(killed)} kills, {len(files)} files; {good} good, at most {worst:.3f} s lost (limit {LOST_S} s)")
    print(f"{len(found)} found unfinished, {whole} recovered whole, {took_s / max(len(found), 1):.2f} s each")
    print(f"processed: {sum(one.result is not None for one in recovered)}")
    return int(not (good == len(killed) and whole == len(found) == len(files)))


if __name__ == "__main__":
    sys.exit(main())
