"""The seal: checksums that tell a damaged run file from a sound one, where HDF5 itself has none."""

from __future__ import annotations

import zlib
from typing import Any

import numpy as np

from radargui.model.arrays import RawArray

SEAL = "attributes_crc32"


def seal(attributes: Any) -> None:
    """Store the checksum of all attributes of one object among them."""
    attributes[SEAL] = np.uint32(_crc(attributes))


def is_sound(attributes: Any) -> bool:
    """Return whether attributes are as they were sealed; those without a seal are taken as they are."""
    return SEAL not in attributes or int(attributes[SEAL]) == _crc(attributes)


def rows_crc(samples: RawArray, before: list[int]) -> list[int]:
    """Return the checksum of each channel, carried on from `before`."""
    return [zlib.crc32(np.ascontiguousarray(row).data, crc) for row, crc in zip(samples, before, strict=True)]


def _crc(attributes: Any) -> int:
    crc = 0
    for key in sorted(attributes):
        if key != SEAL:
            value = np.asarray(attributes[key])
            content = str(value.tolist()).encode() if value.dtype.kind == "O" else value.tobytes()
            crc = zlib.crc32(key.encode("utf-8", "replace") + b"=" + content, crc)
    return crc
