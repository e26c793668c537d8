"""A report of a hundred runs: time, memory of its processes, size; what one that is cancelled leaves."""

from __future__ import annotations

import argparse
import multiprocessing
import sys
import tempfile
import time
from datetime import UTC, datetime
from pathlib import Path

from support.simulated_recording import simulate_recording
from support.simulated_setup import simulated_setup

from radargui.experiment.reprocess import process_run
from radargui.model.errors import CancelledError
from radargui.model.recording import Block
from radargui.model.setup import changed
from radargui.processing.result_of_run import stored_or_computed
from radargui.report.report import PageLayout, write_report
from radargui.session.session import Session

NOW = datetime(2026, 11, 20, 15, 4, 5, tzinfo=UTC)
LIMIT_S, LIMIT_MB, LIMIT_FILES_MB = 30.0, 600.0, 20.0
MB = 1e6


def make_runs(folder: Path, count: int, rate_hz: float, correction: str) -> Session:
    """Write a session of copies of one drop with its results: the same drop, which counts once in the mean."""
    setup = changed(simulated_setup(daq={"rate_hz": rate_hz}), {"processing.correction": correction}, "benchmark")
    session = Session.create(folder, setup, sample="steel sphere", target="glass plate", now=NOW)
    recording, _ = simulate_recording(setup)
    with session.new_run(recording.digitisation, started_at=NOW.isoformat()) as writer:
        writer.write(Block(recording.raw, 0))
    first = session.run_paths()[0]
    process_run(first)
    content = first.read_bytes()
    for number in range(2, count + 1):
        (session.path / f"run-{number:04d}.h5").write_bytes(content)
    session.close()
    return session


def work(folder: Path, output: Path, details: bool, pipe: object) -> None:
    """Write the report in a process of its own and send time, peak memory and what is held afterwards."""
    import resource

    began = time.perf_counter()
    write_report(
        Session.open(folder, write=False), stored_or_computed, output, layout=PageLayout(details=details), ahead=True
    )
    took_s = time.perf_counter() - began
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    spent_s = [one.ru_utime + one.ru_stime for one in used]
    peaks = [one.ru_maxrss / 1e3 for one in used]
    held = int(Path("/proc/self/statm").read_text().split()[1]) * 4096 / MB if Path("/proc/self/statm").exists() else 0
    pipe.send((took_s, *spent_s, *peaks, held))


def cancelled(folder: Path, output: Path) -> list[str]:
    """Cancel a report in its middle and return the names of the files that are there."""

    def stop(share: float) -> None:
        if share > 0.3:
            raise CancelledError

    try:
        write_report(Session.open(folder, write=False), stored_or_computed, output, stop, ahead=True)
    except CancelledError:
        return [path.name for path in output.iterdir()]
    return ["it was not cancelled"]


def main() -> int:
    """Print the figures; 1 where a limit is missed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=100)
    parser.add_argument("--rate", type=float, default=33333.0)
    parser.add_argument("--correction", default="adaptive")
    parser.add_argument("--details", action="store_true")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        session = make_runs(folder / "data", options.runs, options.rate, options.correction)
        ours, theirs = multiprocessing.Pipe()
        arguments = (session.path, folder / "out", options.details, theirs)
        process = multiprocessing.get_context("spawn").Process(target=work, args=arguments)
        process.start()
        took_s, own_s, other_s, own_mb, other_mb, held_mb = ours.recv()
        process.join()
        files_mb = sum(path.stat().st_size for path in (folder / "out").iterdir()) / MB
        left = cancelled(session.path, folder / "cancelled")
    print(f"{options.runs} runs: {took_s:.1f} s (processor: {own_s:.1f} s, and {other_s:.1f} s where runs are read)")
    print(f"peak {own_mb:.0f} MB and {other_mb:.0f} MB in the process that reads")
    print(f"held afterwards {held_mb:.0f} MB; files {files_mb:.1f} MB; left by a cancelled report: {left or 'nothing'}")
    missed = took_s > LIMIT_S or own_mb + other_mb > LIMIT_MB or files_mb > LIMIT_FILES_MB or bool(left)
    return int(missed and options.runs == 100)


if __name__ == "__main__":
    sys.exit(main())
