"""Columns of numbers to lines of text with fixed decimals, a million rows in about a second."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from radargui.model.arrays import BoolArray, FloatArray, IntArray

ByteArray = NDArray[np.uint8]
WordArray = NDArray[np.uint32]
"""Four characters each, zero bytes where fewer are meant."""
_ROWS = 1 << 13  # written at a time, 64 kB a column: chosen by hand, fewer cost calls, more cost memory
_LARGEST = 9.0e18
"""Just below 2^63: a larger count of last decimals has no whole number in 64 bits."""
_HALF_LENGTH = 1 << 32  # whole numbers below it fit into 32 bits


def _words(*characters: bytes) -> WordArray:
    return np.frombuffer(b"".join(one.rjust(4, b"\0") for one in characters), dtype=np.uint32)


_MINUS, _COMMA, _NEWLINE, _COMMA_MINUS, _NAN = _words(b"-", b",", b"\n", b",-", b"nan")
_GROUP = 1000  # three digits are looked up at a time
_BLANK, _UNIT, _POINT = _GROUP, 2 * _GROUP, 3 * _GROUP  # where the kinds of `_CHARACTERS` begin, a group each
# a word for each group of three digits, in the order of `_BLANK`, `_UNIT`, `_POINT`
_CHARACTERS = _words(
    *(b"%03d" % value for value in range(_GROUP)),
    # without leading zeros; then the same with 0 kept
    b"",
    *(b"%d" % value for value in range(1, _GROUP)),
    *(b"%d" % value for value in range(_GROUP)),
    *(b".%03d" % value for value in range(_GROUP)),
)


@dataclass(frozen=True, slots=True)
class Column:
    """One column of a table.

    Attributes
    ----------
    values
        Shape (n_rows,); NaN and infinities are written as nan.
    decimals
        Digits after the point: 0, 3, 6, 9 or 12.
    upwards
        Round away from zero, so that a small uncertainty never becomes zero.
    """

    values: FloatArray | BoolArray | IntArray
    decimals: int
    upwards: bool = False


def lines(columns: Sequence[Column]) -> Iterator[bytes]:
    r"""Yield the rows as comma separated text, each ended by `\n`, some thousand rows at a time.

    `numpy.savetxt` formats number by number in Python. Here each number becomes a whole count of its last decimal,
    whose digits are looked up three by three, a column at a time; bytes that a row does not need are dropped at the
    end.

    Raises
    ------
    ValueError
        Columns of different lengths.
    """
    count = len(columns[0].values)
    if any(len(column.values) != count for column in columns):
        raise ValueError("the columns of a table have different dimensions")
    for first in range(0, count, _ROWS):
        parts = [
            _text(np.asarray(column.values[first : first + _ROWS], np.float64), column, follows=number > 0)
            for number, column in enumerate(columns)
        ]
        table = np.empty((min(_ROWS, count - first), sum(len(part) for part in parts) + 1), dtype=np.uint32)
        for place, word in enumerate(word for part in parts for word in part):
            table[:, place] = word
        table[:, -1] = _NEWLINE
        yield table.tobytes().translate(None, b"\0")


def _text(values: FloatArray, column: Column, *, follows: bool) -> list[WordArray]:
    """Return the words of each value, its comma first where it follows another; of length n each, or 1 for all."""
    # a flag, a number of pieces, one uncertainty for all: what stays the same is written once
    if values.size > 1 and ((values == values[0]).all() or np.isnan(values).all()):
        values = values[:1]
    known = np.isfinite(values)
    size = np.abs(values if known.all() else np.where(known, values, 0.0))
    comma = _COMMA if follows else _words(b"")[0]
    if size.max(initial=0.0) > _LARGEST / 10.0**column.decimals:
        return [np.full(values.size, comma), *_large_text(values, column.decimals)]
    size *= 10.0**column.decimals
    whole = (np.ceil(size) if column.upwards else np.rint(size)).astype(np.int64)
    minus = _COMMA_MINUS if follows else _MINUS
    words = [np.where((values < 0.0) & (whole > 0), minus, comma), *digits(whole, column.decimals // 3)]
    if not known.all():
        for word, instead in zip(words, (comma, _NAN, *[0] * len(words)), strict=False):
            word[~known] = instead
    return words


def digits(whole: NDArray[np.int64], groups_after: int) -> list[WordArray]:
    """Return the characters of whole numbers from 0 up, three in a word, those of length n each.

    The point stands before the last `groups_after` groups of three.
    """
    groups: list[WordArray] = []
    largest = int(whole.max(initial=0))
    # divided three times as fast
    rest: NDArray[np.uint64] | NDArray[np.uint32]
    rest = whole.astype(np.uint32) if largest < _HALF_LENGTH else whole.astype(np.uint64)
    while len(groups) <= groups_after or largest > 0:
        higher = rest // _GROUP
        code = (rest - higher * _GROUP).astype(np.intp)
        if len(groups) >= groups_after:
            code += np.where(higher == 0, _UNIT if len(groups) == groups_after else _BLANK, 0)
        elif len(groups) == groups_after - 1:
            code += _POINT
        groups.append(_CHARACTERS.take(code))
        rest, largest = higher, largest // _GROUP
    return groups[::-1]


def _large_text(values: FloatArray, decimals: int) -> list[WordArray]:
    """Return the words of values too large for 64 bits, made one at a time."""
    texts = [f"{value:.{decimals}f}".encode() if np.isfinite(value) else b"nan" for value in values]
    width = 4 * -(-max(len(text) for text in texts) // 4)
    words = np.frombuffer(b"".join(text.ljust(width, b"\0") for text in texts), dtype=np.uint32)
    return list(words.reshape(len(texts), -1).T)
