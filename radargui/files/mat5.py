"""MATLAB v5 files through scipy, after a look at their claims.

Every array a file announces must be well formed and fit into the bytes that are there. The reading library believes
types and sizes in the headers: damaged ones make it fill memory or crash. A walk over the headers (MAT-File Format,
MathWorks, level 5) refuses such a file first and names the variables worth reading.
"""

import math
import struct
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

# all numbers down to the flag of complex ones are those of MathWorks, MAT-File Format, level 5
HEADER_BYTES = 128
_INT8, _INT32, _UINT32, _MATRIX, _COMPRESSED = 1, 5, 6, 14, 15  # types of elements: miINT8, ...
_ITEM_BYTES = {1: 1, 2: 1, 3: 2, 4: 2, 5: 4, 6: 4, 7: 4, 9: 8, 12: 8, 13: 8, 16: 1, 17: 2, 18: 4}  # by type
_CELL, _STRUCT, _CHAR = 1, 2, 4  # classes of arrays: mxCELL_CLASS, ...
_NUMERIC = range(6, 16)  # from mxDOUBLE_CLASS to mxUINT64_CLASS
_KNOWN = range(1, 18)  # all classes, and two that it does not name: function handles and opaque objects
_COMPLEX = 0x08  # a flag of an array
_DEEPEST = 32
"""Structures within structures; what people nest ends at a few, and recursion must end. Chosen by hand."""
_RATIO = 1100
"""Deflate makes data at most about 1032 times smaller; what claims more is wrong."""
_TAG_BYTES = 8  # type and length before each element, 4 bytes each


def read_values(path: Path, only: str | None = None) -> dict[str, Any]:
    """Return all variables and fields of structures by dotted name, or `only` one; what scipy raises on damage passes.

    Objects, functions and sparse matrices are left out: they are no samples.
    """
    names = [name for name in sound_variables(path) if only in (None, name)]
    # a quarter of a second to load, for those who read such a file
    from scipy.io import loadmat

    content = loadmat(str(path), variable_names=names, simplify_cells=True) if names else {}
    return dict(_leaves("", {name: content[name] for name in names if name in content}))


def _leaves(prefix: str, content: dict[str, Any]) -> Iterator[tuple[str, Any]]:
    for name, value in content.items():
        if isinstance(value, dict):
            yield from _leaves(f"{prefix}{name}.", value)
        elif isinstance(value, str | int | float | np.ndarray | np.generic):
            yield f"{prefix}{name}", value


def sound_variables(path: Path) -> list[str]:
    """Return the names of the variables that hold numbers, text, cells or structures of these only.

    Raises
    ------
    ValueError
        Not a v5 file, cut off, or an array is malformed or claims more than the file holds.
    """
    data = memoryview(path.read_bytes())
    if len(data) < HEADER_BYTES:
        raise ValueError("it is too short for a header")
    order = {b"IM": "<", b"MI": ">"}.get(bytes(data[126:128]))
    # with a 0 in front the library would take it for version 4, whose headers nobody has looked at
    if 0 in data[:4] or order is None or struct.unpack(order + "H", data[124:126])[0] >> 8 != 1:
        raise ValueError("it is not of MATLAB version 5 to 7.3")
    names = []
    for kind, content in _elements(data[HEADER_BYTES:], order):
        inside = [(kind, content)] if kind != _COMPRESSED else list(_elements(_inflated(content, order), order))
        if len(inside) != 1 or inside[0][0] != _MATRIX:
            raise ValueError("something else than a variable is in it")
        name, sound = _check_matrix(inside[0][1], order, 0)
        if sound and name:
            names.append(name)
    return names


def _inflated(content: memoryview, order: str) -> memoryview:
    inflate = zlib.decompressobj()
    start = inflate.decompress(content, _TAG_BYTES)
    if len(start) < _TAG_BYTES:
        raise ValueError("a compressed variable is cut off")
    _, count = struct.unpack(order + "II", start)
    if count > _RATIO * len(content):
        raise ValueError(f"a variable claims {count / 1e9:.3g} GB, far more than the file holds")
    rest = inflate.decompress(inflate.unconsumed_tail, count + 1)
    # One step more reaches the end of the stream and with it the checksum.
    rest += inflate.decompress(inflate.unconsumed_tail, 1)
    if len(rest) != count or not inflate.eof:
        raise ValueError("a compressed variable is cut off or damaged")
    return memoryview(start + rest)


def _elements(data: memoryview, order: str) -> Iterator[tuple[int, memoryview]]:
    """Give type and content of the elements that follow one another and fill `data`."""
    place = 0
    while place < len(data):
        if place + _TAG_BYTES > len(data):
            raise ValueError("a variable is cut off")
        first, count = struct.unpack_from(order + "II", data, place)
        start = place + _TAG_BYTES
        if first >> 16:
            first, count, start = first & 0xFFFF, first >> 16, place + 4
            place += _TAG_BYTES
            if count > 4:
                raise ValueError("a small element is larger than 4 bytes")
        else:
            place = start + count + (-count % 8 if first != _COMPRESSED else 0)
        if start + count > len(data) or (count % _ITEM_BYTES.get(first, 1)):
            raise ValueError("a variable is cut off")
        if first not in _ITEM_BYTES and first not in (_MATRIX, _COMPRESSED):
            raise ValueError(f"data of an unknown type {first} are in it")
        yield first, data[start : start + count]


def _check_matrix(content: memoryview, order: str, depth: int) -> tuple[str, bool]:
    """Return name and soundness of an array; what is inside a structure or cell is checked as well."""
    if not len(content):
        return "", True
    if depth > _DEEPEST:
        raise ValueError("structures are nested too deep")
    parts = list(_elements(content, order))
    if not parts or parts[0][0] != _UINT32 or len(parts[0][1]) != 8:
        raise ValueError("an array has no header")
    flags = struct.unpack_from(order + "I", parts[0][1])[0]
    kind = flags & 0xFF
    if kind not in _KNOWN:
        raise ValueError(f"an array is of the unknown class {kind}")
    if kind not in (_CELL, _STRUCT, _CHAR) and kind not in _NUMERIC:
        return "", False
    if len(parts) < 3 or parts[1][0] != _INT32 or parts[2][0] != _INT8:
        raise ValueError("an array has no size or no name")
    sizes = struct.unpack(f"{order}{len(parts[1][1]) // 4}i", parts[1][1])
    if not 2 <= len(sizes) <= 32 or any(size < 0 for size in sizes):
        raise ValueError("the size of an array is malformed")
    name = bytes(parts[2][1]).decode("latin-1")
    count, inside = math.prod(sizes), parts[3:]
    if kind in _NUMERIC or kind == _CHAR:
        _check_numbers(inside, count, bool((flags >> 8) & _COMPLEX), kind == _CHAR)
        return name, True
    if kind == _STRUCT:
        count *= _n_fields(inside, order)
        inside = inside[2:]
    if len(inside) != count or any(one != _MATRIX for one, _ in inside):
        raise ValueError(f"a cell or structure claims {count:.3g} values and holds {len(inside)}")
    # All are looked at, also behind one that is not sound.
    sound = [_check_matrix(one, order, depth + 1)[1] for _, one in inside]
    return name, all(sound)


def _check_numbers(parts: list[tuple[int, memoryview]], count: int, is_complex: bool, is_text: bool) -> None:
    if len(parts) != 1 + is_complex or any(kind not in _ITEM_BYTES for kind, _ in parts):
        raise ValueError("the numbers of an array are malformed")
    for kind, data in parts:
        # Text in UTF-8 or UTF-16 may take more bytes than it has characters.
        held = len(data) // (1 if is_text else _ITEM_BYTES[kind])
        if count > held or (not is_text and count != held):
            raise ValueError(f"an array claims {count:.3g} values and holds {held}")


def _n_fields(parts: list[tuple[int, memoryview]], order: str) -> int:
    if len(parts) < 2 or parts[0][0] != _INT32 or len(parts[0][1]) != 4 or parts[1][0] != _INT8:
        raise ValueError("a structure has no fields")
    length: int = struct.unpack(order + "i", parts[0][1])[0]
    if length < 1 or len(parts[1][1]) % length:
        raise ValueError("the names of fields are malformed")
    return len(parts[1][1]) // length
