"""The catalogue with 10,000 synthetic runs: first index, look at unchanged folders, search, one changed run."""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from datetime import UTC, date, datetime, timedelta
from pathlib import Path

from support.file_samples import codes, default_setup, int16_digitisation, result_of
from support.found_sessions import look

from radargui.files.run_file import read_run
from radargui.files.run_results import write_results
from radargui.files.run_writer import RunWriter
from radargui.model.recording import Block
from radargui.model.result import Bounces
from radargui.model.setup import dump_setup
from radargui.session.catalogue import Catalogue, Query
from radargui.session.session import Session

KINDS = 50
"""Different run files; the others are copies of them."""
LOOK_S = 1.0
"""Limit of a look at folders that have not changed."""


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sessions", type=int, default=500)
    parser.add_argument("--runs", type=int, default=20, help="in each session")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        data, index = Path(name) / "data", Path(name) / "index.sqlite3"
        made_s, _ = timed(lambda: make(data, options.sessions, options.runs))
        total = options.sessions * options.runs
        print(f"{total} runs in {options.sessions} sessions made in {made_s:.1f} s")
        with Catalogue(data, index) as catalogue:
            first_s, read = timed(catalogue.refresh)
        print(f"first index: {first_s:.2f} s for {read} files, {1e3 * first_s / read:.2f} ms each")
        print(f"index: {index.stat().st_size / 1e6:.1f} MB")
        worst = 0.0
        for title, query in (
            ("all", Query()),
            ("operator", Query(operator="ada 7")),
            ("a week", Query(since=date(2026, 2, 1), until=date(2026, 2, 7))),
            ("e range", Query(e_min=0.7, e_max=0.701)),
            ("two words", Query(text="floor dusty")),
            ("antennas", Query(antennas=default_setup())),
            ("all of it", Query(operator="ada", e_min=0.5, text="note", since=date(2026, 1, 1))),
        ):
            with Catalogue(data, index) as catalogue:
                look_s, found = timed(lambda query=query, catalogue=catalogue: look(catalogue, query))
            worst = max(worst, look_s)
            print(f"opened and searched by {title}: {1e3 * look_s:.0f} ms, {len(found)} sessions")
        changed = next(data.rglob("run-0002.h5"))
        write_results(changed, result_of(read_run(changed)))
        with Catalogue(data, index) as catalogue:
            again_s, read = timed(catalogue.refresh)
        print(f"one run processed again: {1e3 * again_s:.0f} ms, {read} files read")
    print(f"slowest look {worst:.2f} s (limit {LOOK_S} s)")
    return int(worst > LOOK_S)


def timed(work: Callable[[], object]) -> tuple[float, object]:
    begun = time.perf_counter()
    found = work()
    return time.perf_counter() - begun, found


def make(data: Path, n_sessions: int, n_runs: int) -> None:
    """Write sessions of small runs with results, each run file complete and by itself."""
    setup = default_setup()
    kinds = []
    for number in range(KINDS):
        path = data.parent / f"kind-{number}.h5"
        with RunWriter(path, int16_digitisation(), started_at="", setup_toml=dump_setup(setup)) as writer:
            writer.write(Block(codes(6, 100, seed=number), 0))
            writer.mark(f"kind {number}" + (" dusty" if number == 3 else ""))
        result = result_of(read_run(path))
        bounce = replace(result.bounces.impacts[0], e=0.5 + 0.4 * number / KINDS)
        write_results(path, replace(result, bounces=Bounces((bounce,), result.bounces.free_fall)))
        kinds.append(path.read_bytes())
    begun = datetime(2026, 1, 1, 8, tzinfo=UTC)
    for number in range(n_sessions):
        session = Session.create(
            data / f"{2026 + number // 300}",
            setup,
            operator=f"Ada {number % 20}",
            sample=f"sphere {number % 7}",
            notes=f"note {number}, floor {number % 11}",
            now=begun + timedelta(hours=7 * number),
        )
        for run in range(n_runs):
            content = kinds[(number * 7 + run) % KINDS]
            (session.path / f"run-{run + 1:04d}.h5").write_bytes(content)


if __name__ == "__main__":
    sys.exit(main())
