"""CSV files: a header with names, comma, decimal point, one row a sample."""

from __future__ import annotations

import csv
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TextIO

import numpy as np

from radargui.files.refusal import reading, resolved
from radargui.files.signals import TIME_NAME, ChannelInfo, Signal, Signals
from radargui.files.time_axis import uniform
from radargui.model.arrays import FloatArray
from radargui.model.errors import FileError

LONGEST_HEADER = 100_000
WHAT = "CSV"


def list_csv(path: Path) -> tuple[ChannelInfo, ...]:
    """Return the columns of a CSV file but its time.

    Raises
    ------
    FileError
        Unreadable or no CSV.
    """
    with reading(path, WHAT), _opened(path) as file:
        names = _header(file, path)
        timed = TIME_NAME in names
        table = _table(file, path, names, [TIME_NAME]) if timed else None
        count = table.shape[0] if table is not None else sum(1 for _ in _rows(file, path, len(names)))
        rate_hz = uniform(table[:, 0], f"{path}, column {TIME_NAME}")[0] if table is not None and count > 1 else None
        return tuple(ChannelInfo(name, count, rate_hz) for name in names if name not in ("", TIME_NAME))


def read_csv(path: Path, names: Sequence[str]) -> Signals:
    """Return columns of a CSV file; a column `time_s` gives the file's own time.

    Raises
    ------
    FileError
        Unreadable, no CSV, a column missing, a cell that is not a number.
    """
    with reading(path, WHAT), _opened(path) as file:
        present = _header(file, path)
        own = resolved(path, names, [name for name in present if name not in ("", TIME_NAME)])
        timed = TIME_NAME in present
        table = _table(file, path, present, [*own, TIME_NAME] if timed else own)
        signals = tuple(Signal(name, np.ascontiguousarray(table[:, k])) for k, name in enumerate(names))
        return Signals(signals, time_s=np.ascontiguousarray(table[:, -1]) if timed else None)


def _opened(path: Path) -> TextIO:
    # newline=None: lines end as Windows, Unix or old Macs end them; utf-8-sig: a mark at the start is no part of a name
    return path.open(encoding="utf-8-sig", newline=None)


def _header(file: TextIO, path: Path) -> list[str]:
    try:
        line = file.readline(LONGEST_HEADER)
        while line and _blank(line):
            line = file.readline(LONGEST_HEADER)
    except UnicodeDecodeError:
        raise FileError(
            f"{path} is not UTF-8 text.",
            reasons=("it was saved as UTF-16 or with a national code page", "it is another kind of file"),
            remedy='Save it as "CSV UTF-8".',
        ) from None
    if not line.endswith("\n") and len(line) >= LONGEST_HEADER:
        raise FileError(f"{path}: its first line is far too long for a header; it is no CSV.")
    if "\0" in line:
        raise FileError(f"{path} is not text.")
    for separator, word in ((";", "semicolons"), ("\t", "tabs")):
        if line.count(separator) > line.count(","):
            raise FileError(
                f"{path}: columns are parted by {word}.",
                reasons=("it was saved with a national setting that also writes decimal commas",),
                remedy="Save it with commas between columns and decimal points.",
            )
    names = [name.strip() for name in next(csv.reader([line], skipinitialspace=True))] if line.strip() else []
    if not any(names):
        raise FileError(f"{path} holds no header.")
    if all(_is_number(name) for name in names):
        raise FileError(
            f"{path}: its first line holds numbers, not the names of the columns.",
            remedy="Put a header such as time_s,I1,Q1 above them.",
        )
    twice = sorted({name for name in names if name and names.count(name) > 1})
    if twice:
        raise FileError(f"{path}: two columns are named {twice[0]}.")
    return names


def _table(file: TextIO, path: Path, names: list[str], wanted: list[str]) -> FloatArray:
    """Return the wanted columns, shape (n_rows, n_wanted)."""
    columns = [names.index(name) for name in wanted]
    rows = _rows(file, path, len(names))
    first = next(rows, None)
    if first is None:
        return np.empty((0, len(columns)))

    def lines() -> Iterator[str]:
        yield first
        yield from rows

    try:
        return np.loadtxt(lines(), delimiter=",", comments=None, usecols=columns, ndmin=2, dtype=np.float64)
    except UnicodeDecodeError:
        raise FileError(f"{path} is not UTF-8 text to its end.", reasons=("it is damaged",)) from None
    except ValueError as error:
        file.seek(0)
        raise _bad_cell(file, path, names, columns) or error from None


def _rows(file: TextIO, path: Path, n_columns: int) -> Iterator[str]:
    """Return the lines below the header, each with the right number of columns."""
    n_commas = n_columns - 1
    for line in file:
        if line.count(",") == n_commas and line.strip():
            yield line
        elif not _blank(line):
            raise FileError(
                f"{path}: a row has {line.count(',') + 1} columns, the header {n_columns}: {_shown(line)}",
                reasons=("numbers have decimal commas", "the file was cut off"),
                remedy="Save it with decimal points, one number a column.",
            )


def _bad_cell(file: TextIO, path: Path, names: list[str], columns: list[int]) -> FileError | None:
    header_seen = False
    for number, line in enumerate(file, start=1):
        if _blank(line):
            continue
        if not header_seen:
            header_seen = True
            continue
        cells = line.split(",")
        for column in columns:
            if not _is_number(cells[column]):
                return FileError(
                    f"{path}, line {number}: {_shown(cells[column])} in column {names[column]} is not a number."
                )
    return None


def _blank(line: str) -> bool:
    return not line.strip() or line.startswith("#")


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return "_" not in cell and cell.isascii()


def _shown(line: str) -> str:
    text = line.strip()
    return repr(text if len(text) <= 60 else text[:57] + "...")
