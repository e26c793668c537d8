"""A real Dask scheduler with workers, each a process of its own on this computer."""

from __future__ import annotations

import re
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Cluster:
    """Where the scheduler listens, and the worker processes."""

    address: str
    workers: tuple[subprocess.Popen[str], ...]


@contextmanager
def dask_cluster(n_workers: int, folder: Path) -> Iterator[Cluster]:
    """Start a scheduler and workers of one thread each; wait until they know each other; end them."""
    with ExitStack() as stack:
        common = ["--host", "127.0.0.1", "--no-dashboard"]
        scheduler = _started(stack, folder, "dask_scheduler", *common, "--port", "0")
        address = _line_with(scheduler, r"Scheduler at: +(tcp://\S+)")
        _drain(stack, scheduler)
        workers = []
        for number in range(n_workers):
            own = ["--nthreads", "1", "--no-nanny", "--name", f"worker {number}", "--local-directory", str(folder)]
            workers.append(_started(stack, folder, "dask_worker", address, *common, *own))
        for worker in workers:
            _line_with(worker, r"(Registered to)")
            _drain(stack, worker)
        yield Cluster(address, tuple(workers))


def _started(stack: ExitStack, folder: Path, module: str, *arguments: str) -> subprocess.Popen[str]:
    command = [sys.executable, "-m", f"distributed.cli.{module}", *arguments]
    process = subprocess.Popen(
        command, cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, encoding="utf-8", errors="replace"
    )
    stack.callback(_ended, process)
    return process


def _ended(process: subprocess.Popen[str]) -> None:
    process.kill()
    process.wait(timeout=20)


def _line_with(process: subprocess.Popen[str], pattern: str) -> str:
    said = []
    for line in process.stderr or ():
        said.append(line)
        if match := re.search(pattern, line):
            return match[1]
    raise AssertionError("".join(said))


def _drain(stack: ExitStack, process: subprocess.Popen[str]) -> None:
    """Read on, so that a full pipe never stops the process."""

    def read_on() -> None:
        for _ in process.stderr or ():
            pass

    thread = threading.Thread(target=read_on, name=f"stderr of {process.pid}")
    thread.start()

    def join() -> None:
        _ended(process)
        thread.join(timeout=20)
        if process.stderr:
            process.stderr.close()

    stack.callback(join)
