"""SigMF archives looked at before the library unpacks what they claim."""

from __future__ import annotations

import tarfile
from pathlib import Path

LARGEST_META = 50_000_000
"""Bytes of metadata that are read."""


def want_plain_archive(path: Path) -> None:
    """Refuse an archive that is compressed, sparse, cut off, or whose metadata are larger than metadata can be.

    The library reads all metadata into memory and takes any compression, which can swell without end.

    Raises
    ------
    ValueError
        It is so.
    tarfile.TarError
        It is no archive, or compressed.
    """
    held = path.stat().st_size
    with tarfile.open(path, "r:") as archive:
        for member in archive:
            if member.issparse() or member.offset_data + member.size > held:
                raise ValueError(f"{member.name[:60]} in it claims more than the archive holds")
            if member.name.endswith(".sigmf-meta") and member.size > LARGEST_META:
                raise ValueError("its metadata are larger than metadata can be")
