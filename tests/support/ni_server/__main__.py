"""The stand-in server as a process of its own that streams a precomputed drop again and again, for benchmarks.

python -m support.ni_server --setup SETUP.toml

The first line on stdout (JSON) tells where it listens. It ends when stdin ends; the last line (JSON) is its report.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from pathlib import Path
from typing import Any

from support.ni_server.devices import daqpad_6015, usb_6356
from support.ni_server.pace import RealTime
from support.ni_server.precomputed import Precomputed
from support.ni_server.server import NiServer

from radargui.model.recording import Recording
from radargui.model.setup import read_setup
from radargui.sources.simulated.model import SimulatedRadar


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--setup", type=Path, required=True, help="its [simulation] is streamed as its [daq] says")
    setup = read_setup(parser.parse_args().setup)
    began = time.perf_counter()
    radar = SimulatedRadar(setup, repeat=True)
    block = max(1, round(setup.daq.rate_hz * setup.daq.read_interval_s))
    n_blocks = int(radar.scene.period_s * setup.daq.rate_hz / block)
    codes = radar.samples(0, n_blocks * block)
    recording = Recording("generator", codes, radar.digitisation)
    made = Precomputed(codes, block)
    name, n_channels = setup.daq.device, codes.shape[0]
    pad, fast = daqpad_6015(name), usb_6356(name)
    device = pad if n_channels * setup.daq.rate_hz <= pad.max_multi_hz * (1 + 1e-6) else fast
    server = NiServer(recording, (device,), RealTime(time.perf_counter), "repeat", made)
    ready, ready_cpu = time.perf_counter(), time.process_time()
    say(
        address=server.address,
        device=device.product_type,
        block_samples=block,
        period_samples=codes.shape[1],
        prepared_s=ready - began,
        pid=os.getpid(),
    )
    sys.stdin.read()
    streamed_s, cpu_s = time.perf_counter() - ready, time.process_time() - ready_cpu
    tasks = {"made": server.calls["CreateTask"], "cleared": server.calls["ClearTask"], "left": len(server.tasks)}
    server.kill()
    say(streamed_s=streamed_s, cpu_s=cpu_s, cpu_share=cpu_s / streamed_s, tasks=tasks, **vars(server.meter))


def say(**facts: Any) -> None:
    print(json.dumps(facts), flush=True)


if __name__ == "__main__":
    main()
