"""Worker processes end with the process that began them."""

from __future__ import annotations

import signal
import subprocess
import sys

import pytest

BEGINS_ONE = """
import time
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from radargui.system.cores import begin_worker
pool = ProcessPoolExecutor(1, get_context("spawn"), begin_worker)
print(pool.submit(abs, -7).result(), flush=True)
pool.submit(time.sleep, 1000.0)
time.sleep(1000.0)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="no signals there")
def test_workers_of_a_killed_process_end_at_once_whatever_they_do() -> None:
    process = subprocess.Popen([sys.executable, "-c", BEGINS_ONE], stdout=subprocess.PIPE, encoding="utf-8")
    assert process.stdout is not None
    assert process.stdout.readline() == "7\n"
    process.kill()
    # the worker holds the other end of this pipe: it comes to its end with the last of them
    assert process.communicate(timeout=30) == ("", None)
    assert process.returncode == -signal.SIGKILL
