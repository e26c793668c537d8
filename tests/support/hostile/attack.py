"""Many damaged files read by watched processes."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

TESTS = Path(__file__).resolve().parents[2]
FROM_LIBRARY_S = 600.0


@dataclass
class Toll:
    """What became of the inputs: refused and read by kind, and every one that was neither."""

    counts: Counter[tuple[str, str]] = field(default_factory=Counter)
    bad: list[str] = field(default_factory=list)

    @property
    def n_inputs(self) -> int:
        """How many were read."""
        return self.counts.total()


def attack(first: int, count: int, kind: str | None = None) -> Toll:
    """Read `count` damaged files in a process of their own; where it dies, the next one goes on behind that input."""
    toll, end = Toll(), first + count
    while first < end:
        with tempfile.TemporaryDirectory() as folder:
            last, said = _run(Path(folder), first, end - first, kind, toll)
        if last + 1 < end:
            toll.bad.append(f"seed {last + 1}: the process ended: {said[-1500:]}")
            toll.counts["?", "bad"] += 1
            last += 1
        first = last + 1
    return toll


def _run(folder: Path, first: int, count: int, kind: str | None, toll: Toll) -> tuple[int, str]:
    command = [sys.executable, "-m", "support.hostile.child", str(folder), str(first), str(count)]
    ended = subprocess.run(
        command + ([kind] if kind else []),
        capture_output=True,
        encoding="utf-8",
        errors="replace",
        timeout=FROM_LIBRARY_S,
        check=False,
        env={**os.environ, "PYTHONPATH": str(TESTS), "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"},
    )
    last = first - 1
    for line in ended.stdout.splitlines():
        if not line.startswith("["):
            continue
        last, name, outcome, text = json.loads(line)
        toll.counts[name, outcome] += 1
        if outcome == "bad":
            toll.bad.append(f"seed {last}, {name}: {text}")
    return last, ended.stderr
