"""Find every session below a data folder by what is known of it.

The index of a data folder: a small database in the user's cache folder; the folders are the truth.

Each look compares the dates and sizes of all files with those in the index and reads what has changed, and once more
what was written only just before it was read: that may be written again under the same date and size. An index that is
missing, damaged, or of another version is made anew; where none can be kept, it is made in memory.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import logging
import os
import sqlite3
import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import astuple, dataclass, field
from datetime import date, datetime
from itertools import starmap
from pathlib import Path
from typing import Any

import platformdirs

from radargui.files.access import Progress, silent
from radargui.files.run_card import RunCard, read_run_card
from radargui.model.drop import Drop, RunOrigin, drop_of
from radargui.model.errors import FileError, SessionError
from radargui.model.setup import Setup
from radargui.session.info import FILE_NAME, SessionInfo, read_info
from radargui.session.session import is_run_name

DEEPEST = 8
"""Folders below the data folder. Chosen by hand: deeper sessions are not found, no whole disk is searched."""
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
    with contextlib.suppress(OSError):
        return entry.is_dir(follow_symlinks=False)
    return False


def _stamp(entry: os.DirEntry[str]) -> Stamp:
    with contextlib.suppress(OSError):
        found = entry.stat()
        return f"{found.st_mtime_ns}-{found.st_size}"
    return "gone"


_ANTENNAS = ("radar", "transmitter", "receiver")
SCHEMA = 3
"""Of the tables below: an index of another one is made anew."""
IN_MEMORY = Path(":memory:")
_SETTLES_NS = 2_000_000_000
"""A file of a younger date may change and keep it: disks keep dates in steps, of FAT in two seconds."""
_WAIT_S = 2.0
"""For another program that writes the index; then it is made in memory instead."""
_log = logging.getLogger(__name__)

_SESSION_KEYS = (
    "folder", "stamp", "name", "created_at", "day", "operator", "sample", "target", "notes", "setup_name", "antennas",
    "searched", "problem",
)  # fmt: skip
_RUN_KEYS = (
    "folder", "name", "stamp", "started_at", "finished", "recovered_at", "n_samples", "sample_rate_hz", "status", "e",
    "u_e", "summary", "origin", "searched", "rejected", "problem",
)  # fmt: skip
_TABLES = (
    f"CREATE TABLE sessions ({', '.join(_SESSION_KEYS)}, PRIMARY KEY (folder))",
    f"CREATE TABLE runs ({', '.join(_RUN_KEYS)}, PRIMARY KEY (folder, name)) WITHOUT ROWID",
    "CREATE INDEX runs_e ON runs (e)",
    f"PRAGMA user_version = {SCHEMA}",
)


def default_index_path(data_folder: Path) -> Path:
    """Return where the index of a data folder is kept; it may not be there yet."""
    real = os.path.normcase(os.path.realpath(data_folder))
    name = f"catalogue-{hashlib.sha256(real.encode('utf-8', 'surrogatepass')).hexdigest()[:16]}.sqlite3"
    return platformdirs.user_cache_path("radargui", appauthor=False) / name


def open_index(path: Path) -> sqlite3.Connection:
    """Return the index in a file; made anew where it cannot be used, in memory where it cannot be kept."""
    index = None
    for attempt in (_opened, _made_anew) if path != IN_MEMORY else ():
        try:
            index = attempt(path)
            break
        except (sqlite3.Error, OSError) as error:
            _log.info("The index %s cannot be used: %s", path, error)
            if getattr(error, "sqlite_errorcode", None) in (sqlite3.SQLITE_BUSY, sqlite3.SQLITE_LOCKED):
                # another program is at it
                break
    if index is None:
        index = _with_tables(sqlite3.connect(IN_MEMORY, check_same_thread=False))
    index.create_function("fold", 1, str.casefold, deterministic=True)
    return index


def bring_up_to_date(index: sqlite3.Connection, data_folder: Path, progress: Callable[[float], None]) -> int:
    """Read what has changed since the last time, and return how many files that were.

    Parameters
    ----------
    index
        The index.
    data_folder
        The truth.
    progress
        Called with the share done.
    """
    seen = {one.path.relative_to(data_folder).as_posix(): one for one in sessions_below(data_folder)}
    settled_ns = time.time_ns() - _SETTLES_NS
    known: dict[str, tuple[str, dict[str, str]]]
    known = {folder: (stamp, {}) for folder, stamp in index.execute("SELECT folder, stamp FROM sessions")}
    for folder, name, stamp in index.execute("SELECT folder, name, stamp FROM runs"):
        if folder in known:
            known[folder][1][name] = stamp
    changed = [folder for folder, one in seen.items() if known.get(folder) != (one.stamp, one.runs)]
    gone = known.keys() - seen.keys()
    if not changed and not gone:
        return 0
    with index:
        for table in ("sessions", "runs"):
            index.executemany(f"DELETE FROM {table} WHERE folder = ?", [(folder,) for folder in gone])  # noqa: S608
    n_read, total = 0, sum(1 + len(seen[folder].runs) for folder in changed)
    for folder in changed:
        with index:
            n_read += _renew(index, folder, seen[folder], *known.get(folder, (None, {})))
            for table in ("sessions", "runs"):
                index.execute(
                    f"UPDATE {table} SET stamp = '?' WHERE folder = ? AND CAST(stamp AS INTEGER) > ?",  # noqa: S608
                    (folder, settled_ns),
                )
        progress(min(n_read / total, 1.0))
    return n_read


def _renew(index: sqlite3.Connection, folder: str, one: SeenSession, old_stamp: str | None, old: dict[str, str]) -> int:
    rejected: dict[str, str] = {}
    try:
        info = read_info(one.path)
    except SessionError as error:
        row = folder, one.stamp, one.path.name, *[""] * 8, one.path.name.casefold(), str(error)
    else:
        row, rejected = _session_row(folder, one, info), info.rejected
    _put(index, "sessions", _SESSION_KEYS, [row])
    gone = [(folder, name) for name in old if name not in one.runs]
    index.executemany("DELETE FROM runs WHERE folder = ? AND name = ?", gone)
    if one.stamp != old_stamp:
        # the reason of a rejection stands in the record of the session
        index.executemany(
            "UPDATE runs SET rejected = ? WHERE folder = ? AND name = ?",
            [(rejected.get(name, ""), folder, name) for name in one.runs],
        )
    fresh = [name for name, stamp in one.runs.items() if old.get(name) != stamp]
    _put(index, "runs", _RUN_KEYS, (_run_row(folder, name, one, rejected.get(name, "")) for name in fresh))
    return 1 + len(fresh)


def _session_row(folder: str, one: SeenSession, info: SessionInfo) -> tuple[Any, ...]:
    name = one.path.name
    words = [info.name, name, info.operator, info.sample, info.target, info.notes, info.setup_name]
    words += [entry.text for entry in info.journal] + list(info.rejected.values())
    return (
        folder, one.stamp, name, info.created_at, _day(info.created_at), info.operator, info.sample, info.target,
        info.notes, info.setup_name, antenna_key(info.setup), "\n".join(words).casefold(), "",
    )  # fmt: skip


def _run_row(folder: str, name: str, one: SeenSession, rejected: str) -> tuple[Any, ...]:
    try:
        card, problem = read_run_card(one.path / name), ""
    except FileError as error:
        card, problem = RunCard(finished=False), str(error)
    return (
        folder, name, one.runs[name], card.started_at, card.finished, card.recovered_at, card.n_samples,
        card.sample_rate_hz, str(card.summary.get("status", "")), card.summary.get("e"), card.summary.get("u_e"),
        json.dumps(card.summary), json.dumps(astuple(card.origin)), "\n".join(card.markers).casefold(), rejected,
        problem,
    )  # fmt: skip


def _put(index: sqlite3.Connection, table: str, keys: tuple[str, ...], rows: Iterable[tuple[Any, ...]]) -> None:
    marks = ", ".join("?" * len(keys))
    index.executemany(f"INSERT OR REPLACE INTO {table} ({', '.join(keys)}) VALUES ({marks})", rows)  # noqa: S608


def _day(created_at: str) -> str:
    with contextlib.suppress(ValueError):
        return datetime.fromisoformat(created_at).date().isoformat()
    return ""


def _opened(path: Path) -> sqlite3.Connection:
    path.parent.mkdir(parents=True, exist_ok=True)
    index = sqlite3.connect(path, timeout=_WAIT_S, check_same_thread=False)
    try:
        # it can always be made again: no waiting for the disk
        index.execute("PRAGMA synchronous = OFF")
        (empty,) = index.execute("SELECT count(*) = 0 FROM sqlite_master").fetchone()
        if empty:
            return _with_tables(index)
        _want_sound(index)
    except BaseException:
        index.close()
        raise
    return index


def _want_sound(index: sqlite3.Connection) -> None:
    (version,) = index.execute("PRAGMA user_version").fetchone()
    if version != SCHEMA:
        raise sqlite3.DatabaseError(f"it is of version {version}")
    for table, keys in (("sessions", _SESSION_KEYS), ("runs", _RUN_KEYS)):
        index.execute(f"SELECT {', '.join(keys)} FROM {table} LIMIT 1").fetchone()  # noqa: S608
    if index.execute("PRAGMA quick_check(1)").fetchone() != ("ok",):
        raise sqlite3.DatabaseError("it is damaged")


def _made_anew(path: Path) -> sqlite3.Connection:
    with contextlib.suppress(FileNotFoundError):
        path.unlink()
    return _opened(path)


def _with_tables(index: sqlite3.Connection) -> sqlite3.Connection:
    with index:
        for statement in _TABLES:
            index.execute(statement)
    return index


def antenna_key(setup: Setup) -> str:
    """Return a short text that two setups share where their antennas, frequency and sign are the same."""
    content = {name: setup.model_dump(mode="json")[name] for name in _ANTENNAS}
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()[:24]


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
