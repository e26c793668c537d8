"""Find every session below a data folder by what is known of it."""

from __future__ import annotations

import json
import sqlite3
from dataclasses import dataclass, field
from datetime import date
from itertools import starmap
from pathlib import Path

from radargui.files.access import Progress, silent
from radargui.model.drop import Drop, RunOrigin, drop_of
from radargui.model.setup import Setup
from radargui.session.index import IN_MEMORY, antenna_key, bring_up_to_date, default_index_path, open_index

_SUMMARY = """
SELECT s.folder, s.name, s.created_at, s.operator, s.sample, s.target, s.notes, s.setup_name, s.problem,
    count(r.name), coalesce(sum(r.rejected != ''), 0), coalesce(sum(r.finished = 0 AND r.problem = ''), 0),
    coalesce(sum(r.problem != ''), 0),
    json_group_array(json_array(r.name, json(r.origin), json(r.summary)))
        FILTER (WHERE r.rejected = '' AND r.problem = '')
FROM sessions s LEFT JOIN runs r ON r.folder = s.folder
"""
_ORDER = "GROUP BY s.folder ORDER BY coalesce(nullif(s.created_at, ''), s.name) DESC, s.name DESC"


@dataclass(frozen=True, slots=True)
class Query:
    """All that is given must hold; upper and lower case are the same.

    Attributes
    ----------
    since, until
        First and last day, as the clock of the recording computer showed it.
    operator, sample
        A part of what the record says; the sample is looked for in the target too.
    setup_name
        A part of the setup's name.
    antennas
        A setup: the session was recorded with the same antennas, frequency and sign.
    e_min, e_max
        A run that counts has a first bounce with e within.
    text
        Words that all stand in notes, journal, names, markers of runs or reasons of rejection.
    """

    since: date | None = None
    until: date | None = None
    operator: str = ""
    sample: str = ""
    setup_name: str = ""
    antennas: Setup | None = None
    e_min: float | None = None
    e_max: float | None = None
    text: str = ""


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
    operator, sample, target, notes, setup_name
        As in the record.
    n_runs, n_rejected, n_unfinished, n_unreadable
        Run files in it; those of them that were set aside; those that were never closed; those that are damaged.
    drops
        Runs that were not set aside, with their figures; `restitution.series` says which of them count.
    problem
        Why the record cannot be read; empty where it can.
    """

    path: Path
    name: str
    created_at: str = ""
    operator: str = ""
    sample: str = ""
    target: str = ""
    notes: str = ""
    setup_name: str = ""
    problem: str = ""
    n_runs: int = 0
    n_rejected: int = 0
    n_unfinished: int = 0
    n_unreadable: int = 0
    drops: tuple[Drop, ...] = ()


@dataclass(frozen=True, slots=True)
class RunLine:
    """One line of the list of runs.

    Attributes
    ----------
    path
        Run file.
    started_at
        ISO 8601; empty where unknown.
    finished
        Whether its recording was closed.
    recovered_at
        When it was finished after a crash; empty for others.
    duration_s
        Stored samples / rate.
    summary
        See `files.run_card.summarise`; empty where not processed.
    rejected
        Why it was set aside; empty where it counts.
    problem
        Why the file cannot be read; empty where it can.
    """

    path: Path
    started_at: str
    finished: bool
    recovered_at: str
    duration_s: float
    summary: dict[str, object] = field(repr=False)
    rejected: str
    problem: str


class Catalogue:
    """All sessions below a data folder.

    Looks are quick because an index is kept; each one first takes in what has changed in the folders.
    May be used from any thread, one at a time.

    Parameters
    ----------
    data_folder
        Its sessions, at any depth.
    index
        File of the index; None: in the user's cache folder.
    """

    def __init__(self, data_folder: Path, index: Path | None = None) -> None:
        self._data_folder = data_folder
        self._path = index or default_index_path(data_folder)
        self._index = open_index(self._path)

    def __enter__(self) -> Catalogue:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the index; idempotent."""
        self._index.close()

    def refresh(self, progress: Progress = silent) -> int:
        """Take in what has changed in the folders, and return how many files were read for that.

        Parameters
        ----------
        progress
            Called with the share done; the first time takes a few milliseconds a run.
        """
        try:
            return bring_up_to_date(self._index, self._data_folder, progress)
        except sqlite3.Error:
            # damaged since it was opened, or another program keeps it to itself: go on without
            self._index.close()
            self._index = open_index(IN_MEMORY)
            return bring_up_to_date(self._index, self._data_folder, progress)

    def find(self, query: Query = Query()) -> tuple[SessionSummary, ...]:
        """Return the sessions that a query asks for, the newest first, as of the last look at the folders.

        Without a query these are all.
        """
        conditions, values = _conditions(query)
        where = f"WHERE {' AND '.join(conditions)} " if conditions else ""
        rows = self._index.execute(f"{_SUMMARY} {where}{_ORDER}", values)
        lines = ([self._data_folder / folder, *known, _drops(drops)] for folder, *known, drops in rows)
        return tuple(starmap(SessionSummary, lines))

    def runs(self, session: Path) -> tuple[RunLine, ...]:
        """Return the runs of a session in the order of their numbers, as of the last look at the folders."""
        return self._runs("WHERE folder = ?", (session.relative_to(self._data_folder).as_posix(),))

    def unfinished(self) -> tuple[RunLine, ...]:
        """Return the runs that were never closed, as of the last look at the folders, the newest last."""
        return self._runs("WHERE finished = 0", ())

    def to_compute(self) -> tuple[RunLine, ...]:
        """Return the runs that count and have no final result, as of the last look at the folders, the newest last."""
        no_result = "(status = '' OR json_extract(summary, '$.preliminary'))"
        return self._runs(f"WHERE finished AND rejected = '' AND problem = '' AND n_samples > 0 AND {no_result}", ())

    def _runs(self, where: str, values: tuple[str, ...]) -> tuple[RunLine, ...]:
        rows = self._index.execute(
            "SELECT folder, name, started_at, finished, recovered_at, "  # noqa: S608
            "coalesce(n_samples / nullif(sample_rate_hz, 0), 0.0), summary, rejected, problem "
            f"FROM runs {where} ORDER BY folder, length(name), name",
            values,
        )
        return tuple(
            RunLine(self._data_folder / folder / name, at, bool(finished), later, span_s, json.loads(summary), *said)
            for folder, name, at, finished, later, span_s, summary, *said in rows
        )


def _drops(text: str) -> tuple[Drop, ...]:
    """Return drops in the order of their numbers from the rows that the index joined: name, origin, summary."""
    rows = sorted(json.loads(text), key=lambda row: (len(row[0]), row[0]))
    return tuple(drop_of(Path(name).stem, RunOrigin(*origin), summary) for name, origin, summary in rows)


def _conditions(query: Query) -> tuple[list[str], list[object]]:
    conditions: list[str] = []
    values: list[object] = []

    def want(condition: str, *given: object) -> None:
        conditions.append(condition)
        values.extend(given)

    if query.since:
        want("s.day >= ?", query.since.isoformat())
    if query.until:
        want("s.day != '' AND s.day <= ?", query.until.isoformat())
    words = {"operator": query.operator, "sample || char(10) || s.target": query.sample, "setup_name": query.setup_name}
    for column, part in words.items():
        if part:
            want(f"instr(fold(s.{column}), ?)", part.casefold())
    if query.antennas is not None:
        want("s.antennas = ?", antenna_key(query.antennas))
    if query.e_min is not None or query.e_max is not None:
        limits = query.e_min or 0.0, 1e9 if query.e_max is None else query.e_max
        want("s.folder IN (SELECT folder FROM runs WHERE e BETWEEN ? AND ? AND rejected = '')", *limits)
    for word in query.text.casefold().split():
        want("(instr(s.searched, ?) OR s.folder IN (SELECT folder FROM runs WHERE instr(searched, ?)))", word, word)
    return conditions, values
