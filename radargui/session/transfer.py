"""Import recordings of other programs as a session, and export its runs in formats that others open."""

import json
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from datetime import datetime
from functools import partial
from pathlib import Path
from typing import Any, Unpack

from radargui.files.access import Outcome, Progress, each_run, refuse_existing, silent
from radargui.files.formats import ExportFormat, export_run, format_of, source_program
from radargui.files.reading import ImportInput
from radargui.files.run_layout import PIECE
from radargui.model.errors import FileError, RadarGuiError, SessionError, worded
from radargui.model.setup import Setup
from radargui.session.info import SessionDetails, own_subfolder, read_info
from radargui.session.session import Session, run_paths


@dataclass(frozen=True, slots=True)
class ImportedRun:
    """What became of an input: a run file, or why not."""

    source: ImportInput
    path: Path | None = None
    error: RadarGuiError | None = None


class SessionImport:
    """Recordings of other programs written as the runs of a new session.

    The session is made with the first recording that can be read: where none can, none appears. Its runs hold the
    samples as they were (codes stay codes), and where they came from.

    Parameters
    ----------
    parent
        Folder of sessions.
    setup
        Geometry and processing of the session.
    now
        Date and time with offset from UTC.
    about
        As for any session.
    """

    def __init__(self, parent: Path, setup: Setup, *, now: datetime, **about: Unpack[SessionDetails]) -> None:
        self.parent, self.setup, self.now, self._about = parent, setup, now, about
        self.session: Session | None = None

    def carry_out(self, inputs: Sequence[ImportInput], progress: Progress = silent) -> Iterator[ImportedRun]:
        """Import one input after the other, then close the session; one that fails does not stop the others.

        Parameters
        ----------
        inputs
            What to import.
        progress
            Called with the share done.

        Raises
        ------
        SessionError
            The session cannot be made.
        """
        try:
            for done, one in enumerate(inputs, start=1):
                yield self._imported(one)
                progress(done / len(inputs))
        finally:
            if self.session is not None:
                self.session.close()

    def _imported(self, one: ImportInput) -> ImportedRun:
        try:
            recording = one.read()
            if recording.n_receivers != self.setup.n_receivers:
                counts = {"pairs": recording.n_receivers, "receivers": self.setup.n_receivers}
                raise worded(FileError, "pairs_to_import", label=one.label, **counts)
        except RadarGuiError as error:
            return ImportedRun(one, error=error)
        # outside: a folder that cannot be written ends the import
        if self.session is None:
            self.session = Session.create(self.parent, self.setup, now=self.now, **self._about)
        try:
            with self.session.new_run(
                recording.digitisation,
                started_at=recording.started_at,
                trigger_index=recording.trigger_index,
                attributes=_origin(one, self.now),
            ) as writer:
                for block in recording.blocks(PIECE):
                    writer.write(block)
        except RadarGuiError as error:
            return ImportedRun(one, error=error)
        return ImportedRun(one, writer.path)


def _origin(one: ImportInput, now: datetime) -> Mapping[str, str]:
    origin = {
        "source": "import",
        "imported_from": "; ".join(file.name for file in one.files),
        "imported_format": format_of(one.files[0], one.raw).name,
        "imported_program": ", ".join(dict.fromkeys(filter(None, map(source_program, one.files)))),
        "imported_at": now.isoformat(timespec="seconds"),
    }
    if one.raw is not None:
        origin["imported_layout"] = one.raw.text
    if one.channel_map is not None:
        entries = (f"{entry.target}={entry.variable}" for entry in one.channel_map.entries)
        origin["imported_channels"] = ",".join(entries)
    return origin


FOLDER = "export"


@dataclass(frozen=True, slots=True)
class ExportPlan:
    """What an export will do; made by `plan_export`, done by iterating over `carry_out`."""

    runs: tuple[Path, ...]
    kind: ExportFormat
    folder: Path
    session: dict[str, str]
    force: bool

    def carry_out(self, progress: Progress = silent) -> Iterator[Outcome[tuple[Path, ...]]]:
        """Export run after run and yield the files made of each; one that fails does not stop the others.

        Parameters
        ----------
        progress
            Called with the share of the whole that is done.
        """
        export = partial(export_run, kind=self.kind, folder=self.folder, session=self.session, force=self.force)
        return each_run(self.runs, lambda run, report: export(run, report=report), progress)


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
    return ExportPlan(runs, kind, target, session_facts(folder), force)


def session_facts(folder: Path) -> dict[str, str]:
    """Return what session.json says in texts; a damaged one does not keep the samples from being exported."""
    # a folder without a record is refused as well
    with suppress(SessionError):
        return dict(_texts(read_info(folder).model_dump(mode="json", exclude={"setup"})))
    return {}


def _texts(table: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, str]]:
    """Yield name and text of all that is said, tables laid out flat, lists as JSON."""
    for key, value in table.items():
        if isinstance(value, dict):
            yield from _texts(value, f"{prefix}{key}_")
        elif value not in ("", None, []):
            yield prefix + key, value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)
