"""The sessions found as a table, and what is read of one before it is opened."""

from collections.abc import Callable
from dataclasses import replace
from operator import attrgetter
from pathlib import Path

from radargui.gui.runs.run_model import RunEntry
from radargui.gui.runs.thumbnails import entry_of
from radargui.model.calibrated_setup import calibration_words
from radargui.model.words import written_time
from radargui.restitution.series import drop_labels, series_of
from radargui.session.catalogue import SessionSummary
from radargui.session.info import read_info
from radargui.session.lock import owner_of
from radargui.session.session import run_paths


def _runs(found: SessionSummary) -> str:
    counts = {"set aside": found.n_rejected, "unfinished": found.n_unfinished, "unreadable": found.n_unreadable}
    more = ", ".join(f"{count} {words}" for words, count in counts.items() if count)
    return f"{found.n_runs} ({more})" if more else str(found.n_runs)


def _restitution(found: SessionSummary) -> str:
    series = series_of(found.drops)
    many = f" (n = {series.e.n})" if series.e.n > 1 else ""
    return ", ".join(filter(None, (f"{series.e.words()}{many}", series.mark)))


COLUMNS: dict[str, Callable[[SessionSummary], str]] = {
    "Date": lambda found: written_time(found.created_at, "%Y-%m-%d %H:%M", found.name),
    "Operator": attrgetter("operator"),
    "Sample": attrgetter("sample"),
    "Target": attrgetter("target"),
    "Runs": _runs,
    "e": _restitution,
    "Setup": attrgetter("setup_name"),
    "Notes": lambda found: found.problem or " ".join(found.notes.split()),
}


def look_at(session: Path) -> tuple[tuple[RunEntry, ...], str, str]:
    """Return the runs of a session, some milliseconds each, its calibration, and who writes to it now; else empty."""
    owner, info = owner_of(session), read_info(session)
    busy = f"{owner} writes to it" if owner is not None and not owner.is_me else ""
    entries = [replace(entry_of(path), rejected=info.rejected.get(path.name)) for path in run_paths(session)]
    labels = drop_labels((entry.name, entry.origin, entry.is_drop) for entry in entries)
    labelled = tuple(replace(entry, label=labels[entry.name]) for entry in entries)
    return labelled, calibration_words(info.setup), busy
