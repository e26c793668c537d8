"""Format columns of numbers as lines of text with fixed decimals, a million rows in about a second."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import groupby

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


def _words(texts: Iterable[bytes]) -> WordArray:
    return np.frombuffer(b"".join(text.rjust(4, b"\0") for text in texts), dtype=np.uint32)


_GROUP = 1000  # three digits are looked up at a time
_SIGNED = 100  # below it sign, whole part and point are one word, those with a minus this much further
_NOTHING, _MINUS = _words([b"", b"-"])
_SIGNED_WHOLES = _words(b"%s%d." % (sign, value) for sign in (b"", b"-") for value in range(_SIGNED))


@lru_cache(maxsize=8)
def _groups(end: bytes) -> WordArray:
    """Return the words of three digits with what follows them: all three; without zeros before them but for 0."""
    return _words(form % value + end for form in (b"%03d", b"%d") for value in range(_GROUP))


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


def lines(columns: Sequence[Column]) -> Iterator[bytes | bytearray]:
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
    ends = [b","] * (len(columns) - 1) + [b"\n"]
    for first in range(0, count, _ROWS):
        parts = [
            _text(np.asarray(column.values[first : first + _ROWS], np.float64), column, end)
            for column, end in zip(columns, ends, strict=True)
        ]
        yield _rows(min(_ROWS, count - first), [word for part in parts for word in part])


def _rows(count: int, words: Sequence[WordArray]) -> bytearray:
    """Return the text of rows by their words, each of length n, or 1 where it is that of all rows."""
    blocks: list[WordArray] = []
    for is_same, own in groupby(words, key=lambda word: word.size == 1):
        some = list(own)
        # what is the same in all rows has no gaps from the start
        blocks += [_closed(np.concatenate(some))[None]] if is_same else [word[:, None] for word in some]
    width = sum(block.shape[1] for block in blocks)
    text = bytearray(4 * count * width)
    table, place = np.frombuffer(text, dtype=np.uint32).reshape(count, width), 0
    for block in blocks:
        table[:, place : place + block.shape[1]] = block
        place += block.shape[1]
    return text.translate(None, b"\0")


def _closed(words: WordArray) -> WordArray:
    text = words.tobytes().translate(None, b"\0")
    return np.frombuffer(text.ljust(-(-len(text) // 4) * 4, b"\0"), dtype=np.uint32)


def _text(values: FloatArray, column: Column, end: bytes) -> list[WordArray]:
    """Return the words of each value with the sign that ends its cell; of length n each, or 1 for all."""
    # a flag, a number of pieces, one uncertainty for all: what stays the same is written once
    if values.size > 1 and ((values == values[0]).all() or np.isnan(values).all()):
        values = values[:1]
    known = np.isfinite(values)
    size = np.abs(values if known.all() else np.where(known, values, 0.0))
    if size.max(initial=0.0) > _LARGEST / 10.0**column.decimals:
        return _large_text(values, column.decimals, end)
    size *= 10.0**column.decimals
    count = (np.ceil(size) if column.upwards else np.rint(size)).astype(np.int64)
    words = digits(count, column.decimals // 3, end, (values < 0.0) & (count > 0))
    if not known.all():
        for word, instead in zip(words[::-1], [*_words([b"nan" + end]), *[_NOTHING] * len(words)], strict=False):
            word[~known] = instead
    return words


def digits(
    count: NDArray[np.int64], groups_after: int, end: bytes = b"", negative: BoolArray | None = None
) -> list[WordArray]:
    """Return the characters of whole numbers from 0 up, three digits in a word, those of length n each.

    Parameters
    ----------
    count
        The numbers, shape (n,).
    groups_after
        Of three digits that stand behind the point.
    end
        A character that follows each number, or none.
    negative
        Which have a minus before them, shape (n,).
    """
    groups: list[WordArray] = []
    largest = int(count.max(initial=0))
    # divided three times as fast
    rest: NDArray[np.uint64] | NDArray[np.uint32]
    rest = count.astype(np.uint32) if largest < _HALF_LENGTH else count.astype(np.uint64)
    for _ in range(groups_after):
        higher = rest // _GROUP
        groups.append(_groups(end if not groups else b"").take((rest - higher * _GROUP).astype(np.intp)))
        rest, largest = higher, largest // _GROUP
    if groups and largest < _SIGNED:
        code = rest.astype(np.intp)
        if negative is not None:
            code += _SIGNED * negative
        return [_SIGNED_WHOLES.take(code), *groups[::-1]]
    # the whole part by itself: its last digits with the point, or with what ends the number
    is_last = True
    while is_last or largest > 0:
        higher = rest // _GROUP
        code = (rest - higher * _GROUP).astype(np.intp)
        word = _groups((b"." if groups else end) if is_last else b"").take(code + np.where(higher == 0, _GROUP, 0))
        if not is_last:
            word[rest == 0] = 0
        groups.append(word)
        rest, largest, is_last = higher, largest // _GROUP, False
    sign = [] if negative is None else [np.where(negative, _MINUS, _NOTHING)]
    return [*sign, *groups[::-1]]


def _large_text(values: FloatArray, decimals: int, end: bytes) -> list[WordArray]:
    """Return the words of values too large for 64 bits, made one at a time."""
    texts = [(f"{value:.{decimals}f}".encode() if np.isfinite(value) else b"nan") + end for value in values]
    width = 4 * -(-max(len(text) for text in texts) // 4)
    words = np.frombuffer(b"".join(text.ljust(width, b"\0") for text in texts), dtype=np.uint32)
    return list(words.reshape(len(texts), -1).T)
