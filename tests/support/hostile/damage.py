"""Damage: bytes changed, cut, moved, and in texts values that somebody who means harm would write."""

from __future__ import annotations

import random
import re

VALUES = (
    b"-1",
    b"0",
    b"1e999",
    b"-1e308",
    b"nan",
    b"NaN",
    b"inf",
    b"9" * 30,
    b"9" * 5000,
    b"1000000000000",
    b"9223372036854775807",
    b"0x7fffffff",
    b"true",
    b"null",
    b"[]",
    b"{}",
    b'""',
    b'"../../../etc/passwd"',
    b'"/etc/passwd"',
    b'"C:\\\\Windows\\\\win.ini"',
    b'"con"',
    b'"<script>alert(1)</script>"',
    b"\"__import__('os').system('true')\"",
    b'"\\u0000"',
    b"[" * 3000,
    b'{"a":' * 3000,
    b"a" * 20000,
)
_WORDS = re.compile(rb'"[^"\n]*"|-?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?|[A-Za-z_]\w*')
_SIZES = (b"\xff\xff\xff\x7f", b"\xff\xff\xff\xff", b"\0\0\0\x80", b"\xff" * 8, b"\0\0\0\0\0\x01\0\0")


def damaged(content: bytes, chance: random.Random, *, is_text: bool) -> bytes:
    """Return content with one to eight pieces of damage."""
    data = bytearray(content)
    reach = min(len(data), chance.choice([64, 512, 4096, len(data)]))
    for _ in range(chance.choice([1, 1, 1, 2, 3, 8])):
        if is_text and chance.random() < 0.7:
            _exchange(data, chance)
        else:
            chance.choice([_flip, _flip, _flip, _size, _cut, _remove, _insert, _copy])(data, chance, reach)
        if not data:
            break
    return bytes(data)


def _exchange(data: bytearray, chance: random.Random) -> None:
    words = list(_WORDS.finditer(data))
    if words:
        word = chance.choice(words)
        data[word.start() : word.end()] = chance.choice(VALUES)


def _flip(data: bytearray, chance: random.Random, reach: int) -> None:
    data[_place(data, chance, reach)] = chance.choice([0, 1, 127, 128, 255, chance.randrange(256)])


def _size(data: bytearray, chance: random.Random, reach: int) -> None:
    place, size = _place(data, chance, reach), chance.choice(_SIZES)
    data[place : place + len(size)] = size


def _cut(data: bytearray, chance: random.Random, reach: int) -> None:
    del data[chance.randrange(len(data)) :]


def _remove(data: bytearray, chance: random.Random, reach: int) -> None:
    place = _place(data, chance, reach)
    del data[place : place + chance.choice([1, 4, 8, 100])]


def _insert(data: bytearray, chance: random.Random, reach: int) -> None:
    place = _place(data, chance, reach)
    data[place:place] = chance.randbytes(chance.choice([1, 4, 8, 100]))


def _copy(data: bytearray, chance: random.Random, reach: int) -> None:
    first, place = _place(data, chance, len(data)), _place(data, chance, reach)
    piece = data[first : first + chance.choice([4, 16, 200])]
    data[place : place + len(piece)] = piece


def _place(data: bytearray, chance: random.Random, reach: int) -> int:
    return chance.randrange(max(1, min(reach, len(data))))
