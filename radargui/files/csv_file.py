"""CSV files: one column a channel, one row a sample."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TextIO

import numpy as np

from radargui.files.csv_layout import (
    BLANKS,
    LONGEST_HEADER,
    CsvColumn,
    CsvLayout,
    is_blank,
    is_number,
    read_layout,
    shown,
)
from radargui.files.refusal import reading, resolved
from radargui.files.signals import ChannelInfo, Signal, Signals
from radargui.files.time_axis import uniform
from radargui.model.arrays import FloatArray
from radargui.model.errors import FileError

WHAT = "CSV"


def list_csv(path: Path) -> tuple[ChannelInfo, ...]:
    """Return the columns of a CSV file but its times.

    Raises
    ------
    FileError
        Unreadable or no CSV.
    """
    with reading(path, WHAT), _opened(path) as file:
        layout = _layout(file, path)
        time = layout.time
        if time is None:
            count, rate_hz = sum(1 for _ in _rows(file, path, layout)), None
        else:
            time_s = _table(file, path, layout, [time])[:, 0]
            count = time_s.size
            rate_hz = uniform(time_s, f"{path}, column {time.title}")[0] if count > 1 else None
        return tuple(ChannelInfo(name, count, rate_hz, column.unit) for name, column in layout.channels.items())


def read_csv(path: Path, names: Sequence[str]) -> Signals:
    """Return columns of a CSV file in V where their titles tell mV or alike; a column of times gives those.

    Parameters
    ----------
    path
        The file.
    names
        Of columns, with or without the unit in brackets.

    Raises
    ------
    FileError
        Unreadable, no CSV, a column missing, a cell that is not a number.
    """
    with reading(path, WHAT), _opened(path) as file:
        layout = _layout(file, path)
        known = {**{column.title: column for column in layout.channels.values()}, **layout.channels}
        chosen = [known[name] for name in resolved(path, names, list(known), list(layout.channels))]
        time = layout.time
        table = _table(file, path, layout, chosen if time is None else [*chosen, time])
        signals = tuple(
            Signal(name, np.ascontiguousarray(table[:, k]), unit=column.unit)
            for k, (name, column) in enumerate(zip(names, chosen, strict=True))
        )
        return Signals(signals, time_s=None if time is None else np.ascontiguousarray(table[:, -1]))


def _opened(path: Path) -> TextIO:
    # newline=None: lines end as Windows, Unix or old Macs end them; utf-8-sig: a mark at the start is no part of a name
    return path.open(encoding="utf-8-sig", newline=None)


def _layout(file: TextIO, path: Path) -> CsvLayout:
    try:
        return read_layout(iter(lambda: file.readline(LONGEST_HEADER), ""), path)
    except UnicodeDecodeError:
        raise FileError(
            f"{path} is not UTF-8 text.",
            reasons=("it was saved as UTF-16 or with a national code page", "it is another kind of file"),
            remedy='Save it as "CSV UTF-8".',
        ) from None


def _table(file: TextIO, path: Path, layout: CsvLayout, wanted: Sequence[CsvColumn]) -> FloatArray:
    """Return the wanted columns in their units, shape (n_rows, n_wanted)."""
    places = [column.place for column in wanted]
    rows = _rows(file, path, layout)
    if layout.separator != ",":
        rows = _with_points(rows, path, layout, places)
    first = next(rows, None)
    if first is None:
        return np.empty((0, len(places)))

    def lines() -> Iterator[str]:
        yield first
        yield from rows

    delimiter = None if layout.separator == BLANKS else layout.separator
    try:
        table = np.loadtxt(lines(), delimiter=delimiter, comments=None, usecols=places, ndmin=2, dtype=np.float64)
    except UnicodeDecodeError:
        raise FileError(f"{path} is not UTF-8 text to its end.", reasons=("it is damaged",)) from None
    except ValueError as error:
        file.seek(0)
        raise _bad_cell(file, path, layout, wanted) or error from None
    factors = np.array([column.factor for column in wanted])
    return table if (factors == 1.0).all() else table * factors


def _rows(file: TextIO, path: Path, layout: CsvLayout) -> Iterator[str]:
    """Return the lines of numbers, each with the right number of columns."""
    sign, n_signs = layout.separator, layout.n_columns - 1
    first = () if layout.first_row is None else (layout.first_row,)
    for lines in (first, file):
        for line in lines:
            there = len(line.split()) - 1 if sign == BLANKS else line.count(sign)
            if there == n_signs and line.strip():
                yield line
            elif not is_blank(line):
                raise FileError(
                    f"{path}: a row has {there + 1} columns, the header {layout.n_columns}: {shown(line)}; columns are "
                    f"parted by {layout.word}.",
                    reasons=("numbers have decimal commas", "the file was cut off")
                    if sign == ","
                    else ("it is cut off",),
                    remedy="Save it with semicolons between columns, or with decimal points."
                    if sign == ","
                    else "Save it with one number a column.",
                )


def _with_points(rows: Iterator[str], path: Path, layout: CsvLayout, places: Sequence[int]) -> Iterator[str]:
    """Return lines with decimal points for decimal commas, which only the wanted columns decide on.

    Raises
    ------
    FileError
        Points and commas both: 1,234 may be 1.234 or 1234.
    """
    decimal = ""
    for line in rows:
        comma, point = "," in line, "." in line
        if (comma and decimal != ",") or (point and decimal != "."):
            cells = layout.cells(line)
            found = {sign for sign in ",." for place in places if sign in cells[place]}
            if len(found | {decimal} - {""}) > 1:
                raise FileError(
                    f"{path}: numbers have decimal points and decimal commas: {shown(line)}",
                    remedy="Save it without signs between thousands, all decimals alike.",
                )
            decimal = decimal or "".join(found)
        yield line.replace(",", ".") if comma and decimal == "," else line


def _bad_cell(file: TextIO, path: Path, layout: CsvLayout, wanted: Sequence[CsvColumn]) -> FileError | None:
    for number, line in enumerate(file, start=1):
        if number < layout.first_line or is_blank(line):
            continue
        cells = layout.cells(line)
        for column in wanted:
            cell = cells[column.place] if layout.separator == "," else cells[column.place].replace(",", ".")
            if not is_number(cell):
                return FileError(
                    f"{path}, line {number}: {shown(cells[column.place])} in column {column.title} is not a number."
                )
    return None
