"""Keep the computer awake while runs are recorded or waited for; a computer that falls asleep loses them.

This prevents sleep after a time without keys and mouse only: a shut lid, an empty battery and the power button still
end the recording.
"""

import ctypes
import logging
import os
import select
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

_log = logging.getLogger(__name__)

_COMMANDS = {
    "linux": ("systemd-inhibit", "--what=sleep:idle", "--mode=block", "--who=RadarGUI", "--why=A run is recorded"),
    "darwin": ("caffeinate", "-i"),
}
"""What holds sleep off while a command that is put behind it runs."""
_UNTIL_CLOSED = ("sh", "-c", "echo held; exec cat")
"""Says that it runs, and ends with its input: also where this process is killed."""
ANSWER_S = 3.0
"""The system's bus answers in some milliseconds; a run shall not wait long for one that hangs. Chosen by hand."""
_CONTINUOUS, _SYSTEM_REQUIRED = 0x80000000, 0x1
"""ES_CONTINUOUS, ES_SYSTEM_REQUIRED of the Windows API: from now on, for this thread, until it says otherwise."""


@contextmanager
def kept_awake(
    *, reports: bool = True, system: str = sys.platform, kernel: Any = None, answer_s: float = ANSWER_S
) -> Iterator[str]:
    """Keep the computer awake inside the block, which one thread enters and leaves.

    Gives why it may fall asleep all the same, in a few words; empty where it will not.

    Parameters
    ----------
    reports
        Whether to give that; else it is in the log only.
    system
        As `sys.platform` names it.
    kernel
        Of Windows, kernel32; None: that of this process.
    answer_s
        Longest wait for an answer of the system.
    """
    with _by_thread(kernel) if system == "win32" else _by_command(_COMMANDS.get(system), answer_s) as why:
        if why:
            _log.info("The computer is not kept awake: %s", why)
        yield why if reports else ""


@contextmanager
def _by_thread(kernel: Any) -> Iterator[str]:
    held = (kernel or ctypes.windll.kernel32).SetThreadExecutionState  # type: ignore[attr-defined,unused-ignore]
    # 0: refused; else what was in force
    granted = held(ctypes.c_uint(_CONTINUOUS | _SYSTEM_REQUIRED))
    try:
        yield "" if granted else "Windows refused it"
    finally:
        held(ctypes.c_uint(_CONTINUOUS))


@contextmanager
def _by_command(command: tuple[str, ...] | None, answer_s: float) -> Iterator[str]:
    if command is None:
        yield "how to is not known for this system"
        return
    # a frozen program's own libraries are not those of the system's programs
    kept = {name: value for name, value in os.environ.items() if name != "LD_LIBRARY_PATH"}
    try:
        holder = subprocess.Popen(
            [*command, *_UNTIL_CLOSED],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            env=kept,
            # Ctrl-C ends the recording first, then this
            start_new_session=True,
        )
    except OSError as error:
        yield f"{command[0]} cannot be started: {error.strerror}"
        return
    # leaving closes its input, and waits for it
    with holder:
        why = _refusal(holder, command[0], answer_s)
        if why:
            holder.kill()
        yield why


def _refusal(holder: subprocess.Popen[bytes], name: str, answer_s: float) -> str:
    """Return why sleep is not held off; empty where it is."""
    said = b""
    out = holder.stdout.fileno() if holder.stdout else -1
    while select.select([out], [], [], answer_s)[0]:
        more = os.read(out, 4096)
        said += more
        if b"held" in said:
            return ""
        if not more:
            return " ".join(said.decode(errors="replace").split()) or f"{name} refused it"
    return f"{name} does not answer"
