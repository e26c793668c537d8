"""The generator of benchmarks: the stand-in device server as a process of its own.

with generator(setup) as stream:
    ...  # acquire with stream.setup; its daq.remote is the generator
print(stream.report)
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from support.changed import changed

from radargui.model.setup import Setup, write_setup

_TESTS = Path(__file__).resolve().parents[1]


@dataclass
class Generator:
    """A running generator.

    Attributes
    ----------
    setup
        The setup asked for, with `daq.remote`.
    about
        What it said when it was ready: address, device, block_samples, period_samples, prepared_s, pid.
    report
        What it said at its end: streamed_s, cpu_s, cpu_share (of one core), reads, samples, longest_backlog_s,
        overwritten, tasks (made, cleared, left), started_at_s (`time.perf_counter` of each start of a task: sample k
        was taken at started_at_s + k / rate); empty before.
    """

    setup: Setup
    about: dict[str, Any]
    report: dict[str, Any]


@contextmanager
def generator(setup: Setup) -> Iterator[Generator]:
    """Stream the repeated scene of a setup in real time from a process of its own.

    The sphere falls, bounces, rests, is carried back and falls again; one such round is computed and encoded before
    the generator is ready. Up to 200 kS/s in all the device is a multiplexed DAQPad-6015, above it a simultaneous
    USB-6356. `daq.rate_hz` is best a whole fraction of 20 MHz, and `daq.channel_skew_s` what the device will tell.
    """
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "setup.toml"
        write_setup(setup, path)
        command = [sys.executable, "-m", "support.ni_server", "--setup", str(path)]
        threads = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
        with subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            env={**os.environ, **threads, "PYTHONPATH": str(_TESTS)},
        ) as process:
            try:
                about = _heard(process)
                running = Generator(changed(setup, daq={"remote": about["address"]}), about, {})
                yield running
            finally:
                if process.stdin is not None:
                    process.stdin.close()
            running.report = _heard(process)


def _heard(process: subprocess.Popen[str]) -> dict[str, Any]:
    line = process.stdout.readline() if process.stdout is not None else ""
    if not line:
        raise RuntimeError("the generator ended early; its own words are above")
    heard: dict[str, Any] = json.loads(line)
    return heard
