"""What a PDF of matplotlib holds: its words, page by page, its bookmarks, and whether its fonts are in it."""

from __future__ import annotations

import re
import zlib
from contextlib import suppress
from pathlib import Path

_STRING = re.compile(rb"\((?:[^()\\]|\\.)*\)", re.DOTALL)
_SHOWN = re.compile(rb"\[((?:[^\]\\(]|\\.|\((?:[^()\\]|\\.)*\))*)\]\s+TJ", re.DOTALL)
_TEXT = re.compile(rb"\bBT\n.*?\bET\n", re.DOTALL)
_ESCAPED = {b"n": b"\n", b"r": b"\r", b"t": b"\t", b"b": b"\b", b"f": b"\f"}


def _unescaped(text: bytes) -> bytes:
    return re.sub(rb"\\(.)", lambda found: _ESCAPED.get(found[1], found[1]), text, flags=re.DOTALL)


def pdf_streams(path: Path) -> list[bytes]:
    """Return what is in the compressed parts of a PDF."""
    found = re.findall(rb"stream\r?\n(.*?)endstream", path.read_bytes(), re.DOTALL)
    contents = []
    for one in found:
        with suppress(zlib.error):
            contents.append(zlib.decompressobj().decompress(one))
    return contents


def pdf_words(path: Path) -> str:
    """Return every text of a PDF, one a line, in the order written; a ligature is one strange sign."""
    lines = []
    for content in pdf_streams(path):
        for text in _TEXT.findall(content):
            parts = (_unescaped(one[1:-1]) for shown in _SHOWN.findall(text) for one in _STRING.findall(shown))
            lines.append(b"".join(parts).decode("utf-16-be", errors="replace"))
    return "\n".join(lines)


def pdf_bookmarks(path: Path) -> list[str]:
    """Return the titles of the bookmarks, in the order of the file's outline objects."""
    found = re.findall(rb"/Title (\((?:[^()\\]|\\.)*\))\s+/Parent", path.read_bytes(), re.DOTALL)
    return [_unescaped(one[1:-1]).decode("utf-16") for one in found]
