"""Read and write CSV files: a column for each channel, a row for each sample, other facts in comments above."""

from collections.abc import Iterator, Sequence
from itertools import chain
from pathlib import Path
from typing import BinaryIO, TextIO

import numpy as np

from radargui.files.access import Progress, reading, resolved
from radargui.files.csv_layout import BLANKS, LONGEST_LINE, CsvColumn, CsvLayout, bad_cell, is_blank, read_layout, shown
from radargui.files.fixed_point import ByteArray, digits
from radargui.files.run_file import FORMAT, LARGEST_TEXT, ExportFacts, RunStream, commented, facts_of_text, uncommented
from radargui.files.signals import TIME_NAME, ChannelInfo, Signal, Signals, uniform
from radargui.model.arrays import FloatArray, RawArray
from radargui.model.errors import FileError, worded
from radargui.model.recording import absolute_index

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
        return read_layout(iter(lambda: file.readline(LONGEST_LINE), ""), path)
    except UnicodeDecodeError:
        raise worded(FileError, "no_utf8", path=path) from None


def _table(file: TextIO, path: Path, layout: CsvLayout, wanted: Sequence[CsvColumn]) -> FloatArray:
    """Return the wanted columns in their units, shape (n_rows, n_wanted)."""
    places = [column.place for column in wanted]
    rows = _rows(file, path, layout)
    if layout.separator != ",":
        rows = _with_points(rows, path, layout, places)
    # numpy warns of an input without rows
    if (first := next(rows, None)) is None:
        return np.empty((0, len(places)))
    delimiter = None if layout.separator == BLANKS else layout.separator
    try:
        table = np.loadtxt(chain([first], rows), delimiter=delimiter, comments=None, usecols=places, ndmin=2)
    except UnicodeDecodeError:
        raise FileError(f"{path} is not UTF-8 text to its end.", reasons=("it is damaged",)) from None
    except ValueError as error:
        file.seek(0)
        raise bad_cell(file, path, layout, wanted) or error from None
    factors = np.array([column.factor for column in wanted])
    return table if (factors == 1.0).all() else table * factors


def _rows(file: TextIO, path: Path, layout: CsvLayout) -> Iterator[str]:
    """Return the lines of numbers, each with the right number of columns."""
    sign, n_signs = layout.separator, layout.n_columns - 1
    for line in chain(() if layout.first_row is None else (layout.first_row,), file):
        there = len(line.split()) - 1 if sign == BLANKS else line.count(sign)
        if there == n_signs and line.strip():
            yield line
        elif not is_blank(line):
            name, counts = "other_columns_by_commas" if sign == "," else "other_columns", (there + 1, layout.n_columns)
            facts = {"path": path, "line": shown(line), "word": layout.word}
            raise worded(FileError, name, there=counts[0], wanted=counts[1], **facts)


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
                raise worded(FileError, "mixed_decimals", path=path, line=shown(line))
            decimal = decimal or "".join(found)
        yield line.replace(",", ".") if comma and decimal == "," else line


def csv_facts(path: Path) -> ExportFacts | None:
    """Return what the comments at the start of a CSV file tell; None where it is no export of ours."""
    lines: list[str] = []
    size = 0
    with reading(path, WHAT), path.open(encoding="utf-8-sig", errors="replace", newline=None) as file:
        while (line := file.readline(LONGEST_LINE)).startswith("#") and size <= LARGEST_TEXT:
            if not lines and FORMAT not in line:
                return None
            lines.append(line)
            size += len(line)
    return facts_of_text(uncommented(lines))


_NS = 1e9  # in a second
_LARGEST_NS = 9e18
"""Just below 2^63: what is larger has no whole number of ns in 64 bits."""
_ROWS = 1 << 14
"""Written at a time: a few MB of text. Chosen by hand."""


def write_csv(run: RunStream, path: Path, report: Progress) -> None:
    """Write `time_s,I1,Q1,...`: UTF-8, comma, decimal point, one row a stored sample, time in s, voltages in the unit.

    The first lines start with `# `; without that they are a TOML text with unit, rate, skew, scaling, lost samples,
    markers and setup.
    """
    facts = run.facts
    names = (TIME_NAME, *facts.digitisation.channel_names)
    with path.open("wb") as file:
        file.write(commented(facts.text().rstrip("\n")).encode("utf-8"))
        file.write((",".join(names) + "\n").encode("utf-8"))
        _write_rows(run, file, report)


def _write_rows(run: RunStream, file: BinaryIO, report: Progress) -> None:
    facts = run.facts
    scaling = facts.digitisation.scaling
    tables = None if scaling is None else [_texts_of_codes(row) for row in scaling]
    done = 0
    for piece in run.pieces(report):
        for first in range(0, piece.shape[1], _ROWS):
            part = piece[:, first : first + _ROWS]
            index = absolute_index(done, part.shape[1], facts.gaps)
            times_ns = index * (_NS / facts.digitisation.sample_rate_hz)
            if times_ns[-1] > _LARGEST_NS:
                raise FileError(f"{run.path}: its gap records tell of more time than a table can hold.")
            times = np.stack(digits(np.rint(times_ns).astype(np.int64), 3), axis=1).view(np.uint8)
            if tables is None:
                file.writelines(_rows_of_values(times, part))
            else:
                file.write(_rows_of_codes(times, part, tables))
            done += part.shape[1]


def _texts_of_codes(coefficients: tuple[float, ...]) -> ByteArray:
    """Return the text of every code, shape (65536, width), code c in row c + 32768."""
    values = np.polynomial.polynomial.polyval(np.arange(-32768.0, 32768.0), coefficients)
    # Nine digits: a thousandth of the step of a 16-bit code, and better.
    texts = np.array([b"%.9g" % value for value in values.tolist()])
    return texts.view(np.uint8).reshape(65536, -1)


def _rows_of_codes(times: ByteArray, codes: RawArray, tables: list[ByteArray]) -> bytes:
    comma, newline = (np.full((len(times), 1), sign, dtype=np.uint8) for sign in b",\n")
    columns = [times]
    for row, table in zip(codes, tables, strict=True):
        columns += [comma, table[row.astype(np.intp) + 32768]]
    return np.concatenate([*columns, newline], axis=1).tobytes().translate(None, b"\0")


def _rows_of_values(times: ByteArray, values: RawArray) -> Iterator[bytes]:
    columns = [[repr(value) for value in row] for row in values.tolist()]
    starts = (row.tobytes().translate(None, b"\0").decode("ascii") for row in times)
    for cells in zip(starts, *columns, strict=True):
        yield (",".join(cells) + "\n").encode("ascii")
