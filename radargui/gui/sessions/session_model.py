"""The sessions found as a table; and what is read of one before it is opened: its runs, and who writes to it."""

from dataclasses import dataclass, replace
from datetime import datetime
from pathlib import Path
from typing import Any

from PySide6.QtCore import Qt

from radargui.files.run_card import Thumbnail, read_run_card, read_thumbnail
from radargui.gui.runs.run_model import RunEntry
from radargui.gui.table import RowModel
from radargui.model.errors import RadarGuiError
from radargui.restitution.series import drop_labels, series_of
from radargui.session.catalogue import SessionSummary
from radargui.session.info import read_info
from radargui.session.lock import owner_of
from radargui.session.session import run_paths

COLUMNS = ("Date", "Operator", "Sample", "Target", "Runs", "e", "Setup", "Notes")


def cells(found: SessionSummary) -> tuple[str, ...]:
    """Return the texts of the columns."""
    return (
        _when(found),
        found.operator,
        found.sample,
        found.target,
        _runs(found),
        _restitution(found),
        found.setup_name,
        found.problem or " ".join(found.notes.split()),
    )


def _when(found: SessionSummary) -> str:
    try:
        return datetime.fromisoformat(found.created_at).strftime("%Y-%m-%d %H:%M")
    except ValueError:
        return found.name


def _runs(found: SessionSummary) -> str:
    more = [f"{found.n_rejected} set aside"] if found.n_rejected else []
    more += [f"{found.n_unfinished} unfinished"] if found.n_unfinished else []
    return f"{found.n_runs} ({', '.join(more)})" if more else str(found.n_runs)


def _restitution(found: SessionSummary) -> str:
    series = series_of(found.drops)
    many = f" (n = {series.e.n})" if series.e.n > 1 else ""
    mark = "" if series.kind in (None, "measured") else f", {series.kind}"
    return f"{series.e.words()}{many}{mark}"


class SessionModel(RowModel[SessionSummary]):
    """The sessions that were found."""

    def __init__(self) -> None:
        super().__init__(COLUMNS)

    def cell(self, entry: SessionSummary, column: int, role: int) -> Any:
        """Return a cell's text or full text."""
        if role == Qt.ItemDataRole.DisplayRole:
            return cells(entry)[column]
        if role == Qt.ItemDataRole.ToolTipRole:
            # a tool tip that looks like markup would be taken for it
            return (entry.problem or entry.notes or str(entry.path)).replace("<", "‹")
        return None


@dataclass(frozen=True, slots=True)
class RunLook:
    """A run and its picture; None where it has none."""

    entry: RunEntry
    thumbnail: Thumbnail | None = None


@dataclass(frozen=True, slots=True)
class SessionLook:
    """Runs of a session, and why it can only be looked at now; empty where nobody writes to it."""

    path: Path
    runs: tuple[RunLook, ...]
    busy: str = ""


def look_at(session: Path) -> SessionLook:
    """Read what there is to show of a session; takes some milliseconds a run."""
    owner = owner_of(session)
    return SessionLook(
        session, _looks(session), f"{owner} writes to it" if owner is not None and not owner.is_me else ""
    )


def entry_of(path: Path) -> RunEntry:
    """Return what lists show of a run, read without its samples."""
    try:
        card = read_run_card(path)
    except RadarGuiError as error:
        return RunEntry(path, problem=str(error))
    problem = "" if card.finished else "not finished"
    return RunEntry(path, card.started_at, card.summary or None, problem, origin=card.origin)


def _looks(session: Path) -> tuple[RunLook, ...]:
    rejected = read_info(session).rejected
    looks = [_look(path) for path in run_paths(session)]
    entries = [replace(look.entry, rejected=rejected.get(look.entry.path.name)) for look in looks]
    labels = drop_labels((entry.name, entry.origin, entry.is_drop) for entry in entries)
    return tuple(
        replace(look, entry=replace(entry, label=labels[entry.name]))
        for look, entry in zip(looks, entries, strict=True)
    )


def _look(path: Path) -> RunLook:
    entry = entry_of(path)
    try:
        return RunLook(entry, read_thumbnail(path))
    except RadarGuiError:
        return RunLook(entry)
