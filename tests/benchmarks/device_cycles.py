"""200 start/stop cycles of the NI device: no thread, task, file or memory may be left behind.

python3 packaging/dev.py bench device_cycles [CYCLES]
"""

from __future__ import annotations

import gc
import os
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

import psutil
import pytest
from support.ni_driver import build, environment
from support.ni_generator import generator
from support.ni_samples import code_recording, ni_setup

from radargui.acquisition.acquisition import Acquisition
from radargui.model.setup import Setup
from radargui.sources.factory import make_source

WARM_UP = 100
LARGEST_GROWTH_BYTES = 40_000
"""A cycle, over the allocator's own wandering of some MB; one ring, task or channel left behind is more."""


def cycle(setup: Setup) -> None:
    """Open, start, read some blocks with ring and live track, stop, close."""
    acquisition = Acquisition(make_source("ni", setup), setup, ring_s=1.0)
    acquisition.start()
    while not acquisition.wait(0.0) and acquisition.health.samples_read < 600:
        time.sleep(0.005)
    acquisition.stop()
    if acquisition.error is not None:
        raise acquisition.error


def measure(setup: Setup, cycles: int, name: str) -> bool:
    process = psutil.Process()
    marks: list[tuple[int, int, int]] = []
    began = time.perf_counter()
    for number in range(WARM_UP + cycles):
        cycle(setup)
        if number + 1 in (WARM_UP, WARM_UP + cycles):
            gc.collect()
            marks.append((threading.active_count(), process.num_fds(), process.memory_info().rss))
    (threads, files, memory), (threads_after, files_after, memory_after) = marks
    growth = memory_after - memory
    print(
        f"{name}: {cycles} cycles in {time.perf_counter() - began:.1f} s, threads {threads} -> {threads_after}, "
        f"open files {files} -> {files_after}, memory {growth / 1e6:+.2f} MB"
    )
    # gRPC keeps a few sockets of its own open for a moment
    return threads_after <= threads and files_after <= files + 3 and growth <= cycles * LARGEST_GROWTH_BYTES


def main() -> int:
    if sys.argv[1:2] == ["--local"]:
        return 0 if measure(ni_setup(None, read_interval_s=0.01), int(sys.argv[2]), "local driver") else 1
    cycles = int(sys.argv[1]) if len(sys.argv) > 1 else 200
    setup = ni_setup(None, read_interval_s=0.01)
    with generator(setup) as stream:
        good = measure(stream.setup, cycles, "device server")
    tasks = stream.report["tasks"]
    print(f"device server: {tasks['made']} tasks made, {tasks['cleared']} cleared, {tasks['left']} left")
    with tempfile.TemporaryDirectory() as folder:
        try:
            library = build(Path(folder))
        except pytest.skip.Exception as reason:
            print(f"local driver: not measured, {reason}")
            return 0 if good and not tasks["left"] else 1
        found = environment(library, code_recording(20_000).raw, realtime=True)
        found["PYTHONPATH"] = os.pathsep.join(sys.path)
        local = subprocess.run([sys.executable, __file__, "--local", str(cycles)], env=found, check=False)
    passed = good and not tasks["left"] and local.returncode == 0
    print("passed" if passed else "FAILED")
    return 0 if passed else 1


if __name__ == "__main__":
    sys.exit(main())
