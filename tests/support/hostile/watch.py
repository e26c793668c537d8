"""What reading a file must never do: start programs, load pickles, connect, open files elsewhere, fill memory."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from types import TracebackType

SPARE_BYTES = 1_000_000_000
_NEVER = (
    "os.system",
    "os.exec",
    "os.fork",
    "os.posix_spawn",
    "os.spawn",
    "os.startfile",
    "subprocess.Popen",
    "pickle.find_class",
    "socket.connect",
    "urllib.Request",
    "webbrowser.open",
    "shutil.rmtree",
    "code.__new__",
)


def limit_memory() -> None:
    """Let this process take one gigabyte more than it has now; without effect on Windows."""
    if sys.platform == "win32":
        return
    import resource

    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
    limit = pages * os.sysconf("SC_PAGE_SIZE") + SPARE_BYTES
    resource.setrlimit(resource.RLIMIT_AS, (limit, limit))


class Watch:
    """A context that notes forbidden acts in `seen`.

    Parameters
    ----------
    folder
        Where files may be opened; program files may be read, too.
    """

    def __init__(self, folder: Path) -> None:
        root = Path(__file__).resolve().parents[3]
        self._folder = str(folder)
        self._program = tuple(str(Path(place).resolve()) for place in (sys.prefix, sys.base_prefix, root))
        self._program += ("/usr/share/zoneinfo", "/proc/self", "/dev/null", "/etc/localtime")
        self._on = False
        self.seen: list[str] = []
        sys.addaudithook(self._look)

    def __enter__(self) -> Watch:
        self.seen = []
        self._on = True
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._on = False
        if self.seen:
            raise AssertionError("; ".join(self.seen))

    def _look(self, event: str, arguments: tuple[object, ...]) -> None:
        if not self._on:
            return
        if event in _NEVER:
            self.seen.append(f"{event}{arguments!r}"[:300])
        elif event == "open" and isinstance(arguments[0], str | bytes):
            path = os.path.abspath(os.fsdecode(arguments[0]))  # noqa: PTH100  without a look at the disk
            mode = str(arguments[1] or "r")
            writes = any(sign in mode for sign in "wax+")
            if not path.startswith(self._folder) and (writes or not path.startswith(self._program)):
                self.seen.append(f"open {path} {mode}")
