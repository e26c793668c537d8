"""Read and write CSV files: a column for each channel, a row for each sample, other facts in comments above.

Recognise the layout of a CSV file: separator, names, units and times, as other programs write them.
"""

import csv
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import chain, permutations
from pathlib import Path
from typing import BinaryIO, TextIO

import numpy as np

from radargui.files.access import Progress, reading, resolved
from radargui.files.fixed_point import ByteArray, digits
from radargui.files.run_file import FORMAT, LARGEST_TEXT, ExportFacts, RunStream, commented, facts_of_text, uncommented
from radargui.files.signals import TIME_NAME, ChannelInfo, Signal, Signals, uniform
from radargui.model.arrays import FloatArray, RawArray
from radargui.model.errors import FileError, worded
from radargui.model.recording import absolute_index

LONGEST_LINE = 100_000
"""Characters of a line above the numbers: thousands of columns fit, a binary file without line ends does not."""
BLANKS = " "
"""Stands for any number of blanks between two columns."""
_SEPARATORS = {";": "semicolons", "\t": "tabs", ",": "commas", BLANKS: "blanks"}
"""Looked for in this order: a semicolon or tab parts columns even where numbers or names hold commas."""
_VOLTS = {"V": 1.0, "mV": 1e-3, "uV": 1e-6, "nV": 1e-9, "kV": 1e3, "volt": 1.0, "volts": 1.0}  # in V (SI)
_SECONDS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0}  # in s (SI)
_SECONDS |= {"sec": 1.0, "secs": 1.0, "second": 1.0, "seconds": 1.0, "msec": 1e-3, "usec": 1e-6}
_WITH_UNIT = re.compile(r"(.*?)\s*(?:[\[(]\s*([^\])]*?)\s*[\])]|\s*/\s*(\S+)|\s+in\s+(\S+))", re.DOTALL)
_TIME_SUFFIX = re.compile(r"(.+)[_ ](s|ms|us|ns|sec)", re.IGNORECASE)
_TIMES = re.compile(
    r"((rel\w*|elapsed|sample|abs\w*)[ _]*)?(time[ _]*stamps?|times?|zeit|temps|tiempo|tempo|tid)|t|x[ _]?values?",
    re.IGNORECASE,
)
_COUNTERS = re.compile(r"index|samples?|sample[ _]?(no|number|index)\.?|no\.?|nr\.?|n|#", re.IGNORECASE)


@dataclass(frozen=True, slots=True)
class CsvColumn:
    """One column.

    Attributes
    ----------
    place
        Counted from 0.
    title
        As the header has it.
    name
        The title without a unit in brackets.
    unit
        V, s, or empty where the header tells none that is known.
    factor
        value in `unit` = factor x number.
    is_time
        Whether it holds times.
    """

    place: int
    title: str
    name: str
    unit: str
    factor: float
    is_time: bool


@dataclass(frozen=True, slots=True)
class CsvLayout:
    """What stands above the numbers.

    Attributes
    ----------
    separator
        What parts columns; `BLANKS` for any number of them.
    columns
        Those with a title.
    n_columns
        All of them.
    first_line
        Number of the first line of numbers, counted from 1.
    first_row
        That line; None where there is none.
    """

    separator: str
    columns: tuple[CsvColumn, ...]
    n_columns: int
    first_line: int
    first_row: str | None

    @property
    def word(self) -> str:
        """What parts columns, for people."""
        return _SEPARATORS[self.separator]

    @property
    def time(self) -> CsvColumn | None:
        """The column that gives the times, the first of several; None where its first cell is no number."""
        for column in self.columns:
            if column.is_time:
                cells = self.cells(self.first_row or "")
                return column if column.place < len(cells) and is_number(_pointed(cells[column.place])) else None
        return None

    @property
    def channels(self) -> dict[str, CsvColumn]:
        """Columns that can be channels, by name; by title where two have one name."""
        usable = [column for column in self.columns if not column.is_time]
        names = [column.name for column in usable]
        return {column.name if names.count(column.name) == 1 else column.title: column for column in usable}

    def cells(self, line: str) -> list[str]:
        """Return the cells of a line of numbers."""
        return line.split() if self.separator == BLANKS else line.split(self.separator)


def is_time_name(name: str) -> bool:
    """Return whether a column or variable of this name holds times or counts samples, and so is no channel."""
    column = _column(0, name)
    return column.is_time or _COUNTERS.fullmatch(column.name) is not None


def is_blank(line: str) -> bool:
    """Return whether a line holds nothing or a comment."""
    return not line.strip() or line.startswith("#")


def is_number(cell: str) -> bool:
    """Return whether a cell holds a number as a file may have it."""
    try:
        float(cell)
    except ValueError:
        return False
    # Python takes more for numbers: 1_000, digits of other scripts
    return "_" not in cell and cell.isascii()


def bad_cell(lines: Iterable[str], path: Path, layout: CsvLayout, wanted: Iterable[CsvColumn]) -> FileError | None:
    """Return what is wrong with the first wanted cell of a whole file that is no number; None where all are numbers."""
    for number, line in enumerate(lines, start=1):
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


def read_layout(lines: Iterator[str], path: Path) -> CsvLayout:
    """Return what stands above the numbers; the lines below the first of them are left in `lines`.

    The header is the line above the first line of numbers, or the last comment above it; units may stand in brackets
    behind the names or in a line of their own.

    Parameters
    ----------
    lines
        Of the file, from its beginning, none longer than `LONGEST_LINE` + 1.
    path
        For messages.

    Raises
    ------
    FileError
        No header, or none that fits the numbers below it.
    """
    numbered = enumerate(chain(lines), start=1)
    comment, header = "", ""
    for number, line in numbered:
        _want_text(line, path)
        if line.startswith("#"):
            comment = line.lstrip("#").strip() or comment
        elif line.strip():
            if _is_numbers(line):
                return _layout_below_comment(comment, number, line, path)
            header = line.strip("\r\n")
            break
    if not header.strip(" ,;\t"):
        raise FileError(f"{path} holds no header.")
    row, units, at = _first_row(numbered, path)
    separator, titles = _titles(header, row)
    if units is not None:
        cells = next(csv.reader([units], delimiter=separator if separator != BLANKS else " "))
        titles = [f"{title} ({cell.strip(' []()')})" for title, cell in zip(titles, cells, strict=False)]
    return _layout_of(separator, titles, at, row, path)


def _layout_below_comment(comment: str, number: int, line: str, path: Path) -> CsvLayout:
    separator, titles = _titles(comment, line)
    if not comment or len(titles) != len(line.split() if separator == BLANKS else line.split(separator)):
        raise worded(FileError, "no_names", path=path, line=shown(line))
    return _layout_of(separator, titles, number, line, path)


def _layout_of(separator: str, titles: list[str], first_line: int, row: str | None, path: Path) -> CsvLayout:
    if not any(titles):
        raise FileError(f"{path} holds no header.")
    twice = sorted({title for title in titles if title and titles.count(title) > 1})
    if twice:
        raise FileError(f"{path}: two columns are named {twice[0]}.")
    columns = tuple(_column(place, title) for place, title in enumerate(titles) if title)
    return CsvLayout(separator, columns, len(titles), first_line, row)


def _first_row(numbered: Iterable[tuple[int, str]], path: Path) -> tuple[str | None, str | None, int]:
    """Return the first line of numbers, the line of units above it where there is one, and the number of the line."""
    units, number = None, 1
    for number, line in numbered:
        _want_text(line, path)
        if is_blank(line):
            continue
        if units is None and _is_units(line):
            units = line.strip("\r\n")
            continue
        return line, units, number
    return None, units, number + 1


def _titles(header: str, row: str | None) -> tuple[str, list[str]]:
    """Return what parts the numbers, and the titles above them.

    Both are parted by the same sign, or else by different ones (numpy.savetxt with a header); the first reading
    in which as many titles as numbers are found holds, else that of the sign which the header holds most often.
    """
    readings = {sign: _split(header, sign) for sign in _SEPARATORS}
    if any(len(readings[sign]) > 1 for sign in _SEPARATORS if sign != BLANKS):
        readings[BLANKS] = []
    if row is not None:
        counts = {sign: len(row.split() if sign == BLANKS else row.split(sign)) for sign in _SEPARATORS}
        pairs = [(sign, sign) for sign in _SEPARATORS] + list(permutations(_SEPARATORS, 2))
        for sign, other in pairs:
            if counts[sign] == len(readings[other]) > 1:
                return sign, readings[other]
    best = max((sign for sign in _SEPARATORS if sign != BLANKS), key=header.count)
    best = best if header.count(best) else ","
    return best, readings[best]


def _split(header: str, sign: str) -> list[str]:
    if sign == BLANKS:
        # a unit in brackets belongs to the word before it
        return [" ".join(match.split()) for match in re.findall(r"\S+(?:\s+[\[(][^\])]*[\])])?", header)]
    return [title.strip() for title in next(csv.reader([header], delimiter=sign, skipinitialspace=True), [])]


def _column(place: int, title: str) -> CsvColumn:
    name, unit, factor = title, "", 1.0
    match = _WITH_UNIT.fullmatch(title)
    if match:
        unit_text = next((group for group in match.groups()[1:] if group is not None), "")
        unit, factor = _unit(unit_text)
        name = match[1] if unit and match[1] else title
    elif (suffix := _TIME_SUFFIX.fullmatch(title)) and _TIMES.fullmatch(suffix[1]):
        unit, factor = _unit(suffix[2].lower())
    base = _TIME_SUFFIX.sub(r"\1", name)
    is_time = unit == "s" or (not unit and _TIMES.fullmatch(base.strip()) is not None)
    return CsvColumn(place, title, name, unit, factor, is_time)


def _unit(text: str) -> tuple[str, float]:
    # micro has two signs
    plain = text.replace("µ", "u").replace("μ", "u").strip()
    # in short ones capitals tell prefixes apart: MV is no mV
    word = plain if len(plain) < 3 else plain.lower()
    unit = "V" if word in _VOLTS else "s" if word in _SECONDS else ""
    return unit, {**_VOLTS, **_SECONDS}.get(word, 1.0)


def _is_numbers(line: str) -> bool:
    cells = re.split(r"[;,\t ]+", line.strip())
    return sum(map(is_number, cells)) > len(cells) / 2


def _is_units(line: str) -> bool:
    cells = [cell.strip() for cell in re.split(r"[;,\t]", line) if cell.strip()]
    return bool(cells) and all(_unit(cell.strip("[]()"))[0] for cell in cells)


def _pointed(cell: str) -> str:
    return cell.strip().replace(",", ".")


def _want_text(line: str, path: Path) -> None:
    if not line.endswith("\n") and len(line) >= LONGEST_LINE:
        raise FileError(f"{path}: its first line is far too long for a header; it is no CSV.")
    if "\0" in line:
        raise FileError(f"{path} is not text.")


def shown(line: str) -> str:
    """Return a part of a file for a message."""
    text = line.strip()
    return repr(text if len(text) <= 60 else text[:57] + "...")


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
