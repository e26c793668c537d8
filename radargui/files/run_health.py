"""The health record in a run file: how the recording went, and how far the live track was from the result."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from radargui.files import hdf5
from radargui.files.run_header import is_run

HEALTH = "health"
_RECORD = "record"


def put_health(file: Any, record: Mapping[str, object]) -> None:
    """Store a record in an open run file, in place of an older one; NaN and infinity are refused."""
    group = file.require_group(HEALTH)
    hdf5.put_text(group.attrs, _RECORD, json.dumps(dict(record), allow_nan=False))
    hdf5.seal(group.attrs)


def read_health(path: Path) -> dict[str, object] | None:
    """Return the health record of a run; None where it holds none, or a damaged one.

    Raises
    ------
    FileError
        Unreadable, or no run file.
    """
    with hdf5.opened(path, "a run file", is_run) as file:
        return health_in(file)


def health_in(file: Any) -> dict[str, object] | None:
    """Return the health record in an open run file; None where it holds none, or a damaged one."""
    if HEALTH not in file or not hdf5.is_sound(file[HEALTH].attrs):
        return None
    try:
        record = json.loads(hdf5.text(file[HEALTH].attrs, _RECORD) or "null")
    except ValueError:
        return None
    return record if isinstance(record, dict) else None
