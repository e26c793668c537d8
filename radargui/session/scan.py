"""The sessions below a folder as the disk shows them: names and dates of files, nothing opened."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from radargui.session.info import FILE_NAME
from radargui.session.session import is_run_name

DEEPEST = 8
Stamp = str


@dataclass(frozen=True, slots=True)
class SeenSession:
    """A session folder.

    Attributes
    ----------
    path
        The folder.
    stamp
        Date and size of its record; empty where it has none. Another stamp: another content.
    runs
        Stamp of each run file, by name.
    """

    path: Path
    stamp: Stamp
    runs: dict[str, Stamp] = field(default_factory=dict)


def sessions_below(folder: Path, depth: int = DEEPEST) -> Iterator[SeenSession]:
    """Yield the session folders at any depth; links are not followed, hidden folders and sessions not searched."""
    try:
        with os.scandir(folder) as entries:
            found = sorted(entries, key=lambda entry: entry.name)
    except OSError:
        return
    stamp, runs, folders = "", {}, []
    for entry in found:
        if entry.name == FILE_NAME:
            stamp = _stamp(entry)
        elif is_run_name(entry.name):
            runs[entry.name] = _stamp(entry)
        elif not entry.name.startswith(".") and _is_folder(entry):
            folders.append(Path(entry.path))
    if stamp or runs:
        yield SeenSession(folder, stamp, runs)
        return
    for below in folders if depth else ():
        yield from sessions_below(below, depth - 1)


def _is_folder(entry: os.DirEntry[str]) -> bool:
    try:
        return entry.is_dir(follow_symlinks=False)
    except OSError:
        return False


def _stamp(entry: os.DirEntry[str]) -> Stamp:
    try:
        found = entry.stat()
    except OSError:
        return "gone"
    return f"{found.st_mtime_ns}-{found.st_size}"
