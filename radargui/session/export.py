"""Export of a session, or of one run of it."""

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from radargui.files.export import ExportFormat, export_run
from radargui.files.fresh_file import refuse_existing
from radargui.files.progress import Progress, silent
from radargui.model.errors import RadarGuiError, SessionError
from radargui.session.folder import own_subfolder
from radargui.session.info import FILE_NAME, read_info
from radargui.session.session import run_paths

FOLDER = "export"


@dataclass(frozen=True, slots=True)
class ExportedRun:
    """What became of one run.

    Attributes
    ----------
    run
        The run file.
    paths
        Files made; empty where it failed.
    error
        Why it failed, or None.
    """

    run: Path
    paths: tuple[Path, ...] = ()
    error: RadarGuiError | None = None


@dataclass(frozen=True, slots=True)
class ExportPlan:
    """What an export will do; made by `plan_export`, done by iterating over `carry_out`."""

    runs: tuple[Path, ...]
    kind: ExportFormat
    folder: Path
    session: dict[str, str]
    force: bool

    def carry_out(self, progress: Progress = silent) -> Iterator[ExportedRun]:
        """Export run after run; one that fails does not stop the others.

        Parameters
        ----------
        progress
            Called with the share of the whole that is done.
        """
        for number, run in enumerate(self.runs):

            def whole(share: float, done: int = number) -> None:
                progress((done + share) / len(self.runs))

            try:
                paths = export_run(run, self.kind, self.folder, session=self.session, force=self.force, report=whole)
            except RadarGuiError as error:
                yield ExportedRun(run, error=error)
            else:
                yield ExportedRun(run, paths)


def plan_export(path: Path, kind: ExportFormat, output: Path | None = None, *, force: bool = False) -> ExportPlan:
    """Return what there is to export, after a look at what is there already.

    Parameters
    ----------
    path
        Session folder or run file.
    kind
        The format.
    output
        Folder of the new files; None: the folder `export` beside the runs.
    force
        Whether files that are there are replaced.

    Raises
    ------
    SessionError
        A folder without runs, or nothing there.
    FileError
        A file is there already, and not `force`.
    """
    folder = path if path.is_dir() else path.parent
    runs = run_paths(path) if path.is_dir() else (path,)
    if not runs:
        raise SessionError(f"{path} holds no runs.", remedy="Give a session folder or a run file.")
    if not path.exists():
        raise SessionError(f"{path}: no such file or folder.", remedy="Check the path.")
    target = output or own_subfolder(folder, FOLDER)
    refuse_existing([one for run in runs for one in kind.paths(target, run.stem)], force=force)
    return ExportPlan(runs, kind, target, _session_facts(folder), force)


def _session_facts(folder: Path) -> dict[str, str]:
    """Return what session.json says in texts; a damaged one does not keep the samples from being exported."""
    if not (folder / FILE_NAME).is_file():
        return {}
    try:
        info = read_info(folder)
    except SessionError:
        return {}
    return dict(_texts(info.model_dump(mode="json", exclude={"setup"})))


def _texts(table: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, str]]:
    """Yield name and text of all that is said, tables laid out flat, lists as JSON."""
    for key, value in table.items():
        if isinstance(value, dict):
            yield from _texts(value, f"{prefix}{key}_")
        elif value not in ("", None, []):
            yield prefix + key, value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)
