"""A stand-in NI-DAQmx driver library in C, for the local path of the real nidaqmx client.

It is compiled where there is a compiler, and found only by a process that is started with `environment`.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

HERE = Path(__file__).resolve().parent


def build(folder: Path) -> Path:
    """Compile the library into a folder of its own and return that; skips the test where that cannot be done."""
    compiler = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
    if not sys.platform.startswith("linux"):
        pytest.skip("the stand-in driver library is for Linux: elsewhere NI's own names its library otherwise")
    if compiler is None or shutil.which("ld") is None:
        pytest.skip("no C compiler here: the stand-in driver library cannot be made")
    library = folder / "libnidaqmx.so.1"
    sources = [str(path) for path in sorted(HERE.glob("*.c"))]
    strict = ["-std=gnu11", "-O1", "-Wall", "-Wextra", "-Werror"]
    name = "-Wl,-soname,libnidaqmx.so.1"
    subprocess.run([compiler, *strict, "-shared", "-fPIC", name, "-o", str(library), *sources, "-lpthread"], check=True)
    shutil.copy(library, folder / "libnidaqmx.so")
    return folder


def environment(
    folder: Path,
    codes: np.ndarray,
    *,
    realtime: bool = False,
    overflow_at: int | None = None,
    replugged: Path | None = None,
) -> dict[str, str]:
    """Return the environment of a process that finds the library and gets these codes, shape (6, n), int16.

    Once the file `replugged` is there a process that asked before it was is not told the devices' rates any more.
    """
    path = folder / f"codes-{codes.shape[1]}.bin"
    path.write_bytes(np.ascontiguousarray(codes, dtype=np.int16).tobytes())
    kept = {key: value for key, value in os.environ.items() if not key.startswith("RADARGUI_STAND_IN")}
    found = {**kept, "LD_LIBRARY_PATH": str(folder), "RADARGUI_STAND_IN_CODES": str(path)}
    if realtime:
        found["RADARGUI_STAND_IN_REALTIME"] = "1"
    if overflow_at is not None:
        found["RADARGUI_STAND_IN_OVERFLOW_AT"] = str(overflow_at)
    if replugged is not None:
        found["RADARGUI_STAND_IN_REPLUGGED"] = str(replugged)
    return found
