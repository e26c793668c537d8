"""A recording that is killed at a random moment, and what is left of it."""

from __future__ import annotations

import os
import signal
import struct
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np
from support.simulated_recording import simulate_recording
from support.simulated_setup import simulated_setup

from radargui.model.setup import Setup, write_setup

ROOT = Path(__file__).resolve().parents[2]
LOST_S = 0.6


def hear_signals() -> None:
    """Hear Ctrl-C and hang-up in a child of the tests, also where whoever started them (nohup, `&`) ignores both."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
    if hasattr(signal, "SIGHUP"):
        signal.signal(signal.SIGHUP, signal.SIG_DFL)


def killed_setup(rate_hz: float) -> Setup:
    return simulated_setup(daq={"rate_hz": rate_hz}, rest_s=0.3, settle_s=4.0, restitution=0.6)


@dataclass(frozen=True)
class Killed:
    """What is left of a recording: samples read by the child, samples in the file, whether those are the right ones.

    `run` is None where the kill came before there was a file.
    """

    run: Path | None
    read: int
    kept: int
    right: bool
    lost_s: float

    @property
    def good(self) -> bool:
        return self.right and self.lost_s <= LOST_S


class Killer:
    """Kills recordings of one known scene.

    Parameters
    ----------
    folder
        Where sessions go.
    rate_hz
        Of each of 6 channels.
    """

    def __init__(self, folder: Path, rate_hz: float) -> None:
        self._folder = folder
        self._setup_file = folder / "setup.toml"
        self._setup = killed_setup(rate_hz)
        write_setup(self._setup, self._setup_file)
        self._truth = simulate_recording(self._setup)[0].raw

    def kill(self, after_s: float) -> Killed:
        """Start a recording, kill it when it has read so much, and look at its file with plain h5py.

        The recording runs in real time and nothing here waits: reads of 20 ms fall all over the chunks of 0.5 s that
        the writer flushes, whose compression is under way or not as the machine has it.
        """
        data = self._folder / "data"
        before = set(data.glob("*/*.h5"))
        command = [sys.executable, "-m", "support.killed_child", str(self._setup_file), str(data)]
        environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT / "tests"), str(ROOT)])}
        with subprocess.Popen(command, stdout=subprocess.PIPE, env=environment) as child:
            assert child.stdout is not None
            told = child.stdout.read(8)
            while len(told) == 8 and struct.unpack("<q", told)[0] < after_s * self._setup.daq.rate_hz:
                told = child.stdout.read(8)
            child.kill()
            told += child.stdout.read()
        (read,) = struct.unpack_from("<q", told, len(told) // 8 * 8 - 8)
        run = next(iter(set(data.glob("*/*.h5")) - before), None)
        if run is None:
            return Killed(None, read, 0, True, read / self._setup.daq.rate_hz)
        with h5py.File(run) as file:
            raw = file["raw"][:]
            rate_hz = file["raw"].attrs["sample_rate_hz"]
        kept = raw.shape[1]
        return Killed(run, read, kept, np.array_equal(raw, self._truth[:, :kept]), (read - kept) / rate_hz)
