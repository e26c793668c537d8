"""Whether a process of this computer still runs."""

from __future__ import annotations

import os
import sys


def is_running(pid: int) -> bool:
    """Return whether a process with this number runs; True where it cannot be told."""
    if pid <= 0:
        return False
    if sys.platform == "win32":
        return _runs_on_windows(pid)
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    except OSError:
        return True
    return True


if sys.platform == "win32":
    import ctypes

    _MAY_ASK = 0x1000
    _STILL_ACTIVE = 259
    _NO_SUCH_PROCESS = 87

    def _runs_on_windows(pid: int) -> bool:
        # os.kill would end the process there
        kernel = ctypes.WinDLL("kernel32", use_last_error=True)
        kernel.OpenProcess.restype = ctypes.c_void_p
        handle = kernel.OpenProcess(_MAY_ASK, False, pid)
        if not handle:
            return ctypes.get_last_error() != _NO_SUCH_PROCESS
        code = ctypes.c_ulong()
        asked = kernel.GetExitCodeProcess(ctypes.c_void_p(handle), ctypes.byref(code))
        kernel.CloseHandle(ctypes.c_void_p(handle))
        return not asked or code.value == _STILL_ACTIVE
