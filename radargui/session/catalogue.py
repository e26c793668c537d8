"""The catalogue: sessions found in a data folder."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from radargui.model.errors import SessionError
from radargui.session.info import FILE_NAME, read_info
from radargui.session.session import run_paths


@dataclass(frozen=True, slots=True)
class SessionSummary:
    """One line of the list of sessions.

    Attributes
    ----------
    path
        The folder.
    name
        Its name.
    created_at
        ISO 8601 date and time; empty where the record is damaged.
    operator, notes
        As in the record.
    n_runs
        Run files in it.
    problem
        Why the record cannot be read; empty where it can.
    """

    path: Path
    name: str
    created_at: str = ""
    operator: str = ""
    notes: str = ""
    n_runs: int = 0
    problem: str = ""


def find_sessions(data_folder: Path) -> tuple[SessionSummary, ...]:
    """Return the sessions directly in a folder, newest first; damaged ones are listed with their problem."""
    try:
        folders = [folder for folder in data_folder.iterdir() if folder.is_dir()]
    except OSError:
        return ()
    found = [_summary(folder) for folder in folders if _is_session(folder)]
    return tuple(sorted(found, key=lambda one: (one.created_at or one.name, one.name), reverse=True))


def _is_session(folder: Path) -> bool:
    return (folder / FILE_NAME).is_file() or bool(run_paths(folder))


def _summary(folder: Path) -> SessionSummary:
    n_runs = len(run_paths(folder))
    try:
        info = read_info(folder)
    except SessionError as error:
        return SessionSummary(folder, folder.name, n_runs=n_runs, problem=str(error))
    return SessionSummary(folder, folder.name, info.created_at, info.operator, info.notes, n_runs)
