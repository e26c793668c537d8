"""Recognise the layout of a CSV file: separator, names, units and times, as other programs write them."""

import csv
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import chain, permutations
from pathlib import Path

from radargui.model.errors import FileError, worded

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
    return _layout(separator, titles, at, row, path)


def _layout_below_comment(comment: str, number: int, line: str, path: Path) -> CsvLayout:
    separator, titles = _titles(comment, line)
    if not comment or len(titles) != len(line.split() if separator == BLANKS else line.split(separator)):
        raise worded(FileError, "no_names", path=path, line=shown(line))
    return _layout(separator, titles, number, line, path)


def _layout(separator: str, titles: list[str], first_line: int, row: str | None, path: Path) -> CsvLayout:
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
