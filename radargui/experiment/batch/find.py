"""The runs below the paths that a batch is given."""

import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from radargui.files.formats import RUN
from radargui.model.errors import FileError, RadarGuiError
from radargui.session.session import run_paths


@dataclass(frozen=True, slots=True)
class FoundRun:
    """A run and where it lies below the path that was given.

    Attributes
    ----------
    path
        Absolute path of the run file.
    place
        Folder of its own for what is made from it, relative, without any way out.
    """

    path: Path
    place: Path


@dataclass(frozen=True, slots=True)
class FoundRuns:
    """What there is to work on.

    Attributes
    ----------
    runs
        Each once, in order.
    errors
        Paths that hold no run, with the reason.
    """

    runs: tuple[FoundRun, ...]
    errors: tuple[RadarGuiError, ...]


def find_runs(paths: Sequence[Path]) -> FoundRuns:
    """Return all runs in sessions, folders of sessions at any depth, and run files; links to folders are not followed.

    Parameters
    ----------
    paths
        Sessions, folders, run files.
    """
    runs: dict[Path, FoundRun] = {}
    errors: list[RadarGuiError] = []
    for path in paths:
        found = list(_below(path.absolute()))
        for one in found:
            runs.setdefault(Path(os.path.realpath(one.path)), one)
        if not found:
            errors.append(_nothing(path))
    return FoundRuns(tuple(runs.values()), tuple(errors))


def _below(path: Path) -> Iterator[FoundRun]:
    if path.is_file():
        if path.suffix.lower() in RUN.suffixes:
            yield FoundRun(path, Path(path.parent.name, path.stem))
        return
    base = path.resolve()
    for folder, inside, _ in os.walk(path):
        inside.sort()
        for run in run_paths(Path(folder)):
            below = run.parent.relative_to(path)
            yield FoundRun(run, (below if below.parts else Path(base.name)) / run.stem)


def _nothing(path: Path) -> FileError:
    if not path.exists():
        return FileError(f"{path}: no such file or folder.", remedy="Check the path.")
    if path.is_file():
        return FileError(f"{path} is no run file.", remedy="Give sessions, folders of sessions, or run files.")
    return FileError(f"{path} holds no runs.", remedy="Give sessions, folders of sessions, or run files.")
