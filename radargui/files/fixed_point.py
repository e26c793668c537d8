"""Columns of numbers to lines of text with fixed decimals, a million rows in about a second."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from radargui.model.arrays import BoolArray, FloatArray, IntArray

ByteArray = NDArray[np.uint8]
_ROWS = 1 << 13
_LARGEST = 9.0e18
_NOTHING = 0
_MINUS, _POINT, _COMMA, _NEWLINE = b"-.,\n"
_NAN = np.frombuffer(b"nan", dtype=np.uint8)

_GROUP = 1000
_BLANK, _UNIT = _GROUP, 2 * _GROUP


def _groups() -> ByteArray:
    """Return the characters of 0 to 999 in full, then without leading zeros, then the same with 0 kept."""
    full = [b"%03d" % value for value in range(_GROUP)]
    short = [b"%3d" % value for value in range(_GROUP)]
    blank = [b"   ", *short[1:]]
    characters = np.frombuffer(b"".join(full + blank + short), dtype=np.uint8).reshape(-1, 3).copy()
    characters[characters == b" "[0]] = _NOTHING
    return characters


_CHARACTERS = _groups()


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
    """
    count = len(columns[0].values)
    for first in range(0, count, _ROWS):
        parts: list[ByteArray] = []
        for column in columns:
            part = _text(np.asarray(column.values[first : first + _ROWS], np.float64), column.decimals, column.upwards)
            parts += [part, np.full((len(part), 1), _COMMA, dtype=np.uint8)]
        parts[-1][:] = _NEWLINE
        table = np.concatenate(parts, axis=1)
        yield table.tobytes().translate(None, b"\0")


def _text(values: FloatArray, decimals: int, upwards: bool) -> ByteArray:
    """Return each value's characters, shape (n, width), with zero bytes where a value needs fewer."""
    known = np.isfinite(values)
    size = np.abs(np.where(known, values, 0.0))
    if size.max(initial=0.0) > _LARGEST / 10.0**decimals:
        return _large_text(values, decimals)
    size *= 10.0**decimals
    whole = (np.ceil(size) if upwards else np.rint(size)).astype(np.int64)
    text = digits(whole, decimals // 3)
    text[:, 0] = np.where((values < 0.0) & (whole > 0), _MINUS, _NOTHING)
    if not known.all():
        text[~known] = _NOTHING
        text[~known, : len(_NAN)] = _NAN
    return text


def digits(whole: NDArray[np.int64], groups_after: int) -> ByteArray:
    """Return the characters of whole numbers from 0 up, shape (n, width), with zero bytes where one needs fewer.

    A place for the sign, the digits, and the point before the last `groups_after` groups of three.
    """
    groups: list[ByteArray] = []
    largest = int(whole.max(initial=0))
    while len(groups) <= groups_after or largest > 0:
        higher = whole // _GROUP
        code = whole - higher * _GROUP
        if len(groups) >= groups_after:
            code += np.where(higher == 0, _UNIT if len(groups) == groups_after else _BLANK, 0)
        groups.append(_CHARACTERS.take(code, axis=0))
        whole, largest = higher, largest // _GROUP
    sign = np.zeros((len(whole), 1), dtype=np.uint8)
    before = [sign, *groups[: groups_after - 1 if groups_after else None : -1]]
    if not groups_after:
        return np.concatenate(before, axis=1)
    point = np.full((len(whole), 1), _POINT, dtype=np.uint8)
    return np.concatenate([*before, point, *groups[groups_after - 1 :: -1]], axis=1)


def _large_text(values: FloatArray, decimals: int) -> ByteArray:
    """Return the characters of values too large for 64 bits, one at a time."""
    texts = np.array([f"{value:.{decimals}f}".encode() if np.isfinite(value) else b"nan" for value in values])
    return texts.view(np.uint8).reshape(len(texts), -1)
