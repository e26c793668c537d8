"""Export to CSV: volts with the time of each sample, below a header of comments that holds all other facts."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

import numpy as np

from radargui.files.export_facts import commented
from radargui.files.fixed_point import ByteArray, digits
from radargui.files.progress import Progress
from radargui.files.run_stream import RunStream
from radargui.files.signals import TIME_NAME
from radargui.model.arrays import RawArray
from radargui.model.block import absolute_index
from radargui.model.errors import FileError

_NS = 1e9
_LARGEST_NS = 9e18
"""Just below 2^63: what is larger has no whole number of ns in 64 bits."""
_ROWS = 1 << 14
"""Written at a time: a few MB of text. Chosen by hand."""
_COMMA, _NEWLINE = b",\n"


def write_csv(run: RunStream, path: Path, tell: Progress) -> None:
    """Write `time_s,I1,Q1,...`: UTF-8, comma, decimal point, one row a stored sample, time in s, voltages in the unit.

    The first lines start with `# `; without that they are a TOML text with unit, rate, skew, scaling, lost samples,
    markers and setup.
    """
    facts = run.facts
    names = (TIME_NAME, *facts.digitisation.channel_names)
    with path.open("wb") as file:
        file.write(commented(facts.text().rstrip("\n")).encode("utf-8"))
        file.write((",".join(names) + "\n").encode("utf-8"))
        _write_rows(run, file, tell)


def _write_rows(run: RunStream, file: BinaryIO, tell: Progress) -> None:
    facts = run.facts
    scaling = facts.digitisation.scaling
    tables = None if scaling is None else [_texts_of_codes(row) for row in scaling]
    done = 0
    for piece in run.pieces(tell):
        for first in range(0, piece.shape[1], _ROWS):
            part = piece[:, first : first + _ROWS]
            index = absolute_index(done, part.shape[1], facts.gaps)
            times_ns = index * (_NS / facts.digitisation.sample_rate_hz)
            if times_ns[-1] > _LARGEST_NS:
                raise FileError(f"{run.path}: its gap records tell of more time than a table can hold.")
            times = digits(np.rint(times_ns).astype(np.int64), 3)
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
    count = times.shape[0]
    comma = np.full((count, 1), _COMMA, dtype=np.uint8)
    columns = [times]
    for row, table in zip(codes, tables, strict=True):
        columns += [comma, table[row.astype(np.intp) + 32768]]
    rows = np.concatenate([*columns, np.full((count, 1), _NEWLINE, dtype=np.uint8)], axis=1)
    return rows.tobytes().translate(None, b"\0")


def _rows_of_values(times: ByteArray, values: RawArray) -> Iterator[bytes]:
    columns = [[repr(value) for value in row] for row in values.tolist()]
    starts = (row.tobytes().replace(b"\0", b"").decode("ascii") for row in times)
    for start, *cells in zip(starts, *columns, strict=True):
        yield f"{start},{','.join(cells)}\n".encode("ascii")
