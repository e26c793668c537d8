"""What is read of a session before it is opened: its runs with their thumbnails, and who writes to it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

from radargui.files.run_card import read_run_card
from radargui.files.thumbnail import Thumbnail, read_thumbnail
from radargui.gui.runs.run_model import RunEntry
from radargui.model.errors import RadarGuiError
from radargui.restitution.series import drop_labels
from radargui.session.info import read_info
from radargui.session.lock import owner_of
from radargui.session.session import run_paths


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
        session,
        _looks(session),
        f"{owner} writes to it" if owner is not None and not owner.is_me else "",
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
