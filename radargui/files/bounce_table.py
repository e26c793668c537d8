"""The table of bounces in a run file, with the first free fall and the floor's normal beside it."""

from __future__ import annotations

from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from radargui.files import hdf5
from radargui.files import run_layout as layout
from radargui.files.seal import is_sound, seal
from radargui.model.bounce import Bounce, Bounces, FreeFall

_NAME = "bounces"
_METHOD_BYTES = 40
_UNITS = ("s", "m/s", "m/s", "1", "1", "text", "1", "1", "1", "1")
_KINDS: dict[Any, Any] = {"float": "<f8", "bool": "?", "str": h5py.string_dtype("utf-8", _METHOD_BYTES)}
BOUNCE_TYPE = np.dtype([(one.name, _KINDS[one.type]) for one in fields(Bounce)])


def put_bounces(group: Any, bounces: Bounces) -> None:
    """Store bounces in a group of results."""
    rows = np.array([_row(bounce) for bounce in bounces.impacts], dtype=BOUNCE_TYPE)
    # compressed for the checksum that comes with it: a damaged figure is told, not shown
    options = {"chunks": rows.shape, **layout.COMPRESSION} if rows.size else {}
    table = group.create_dataset(_NAME, data=rows, **options)
    hdf5.put_texts(table.attrs, "units", _UNITS)
    if bounces.free_fall is not None:
        for key, value in asdict(bounces.free_fall).items():
            table.attrs[key] = value
    for key in ("normal", "u_tilt_deg"):
        if (value := getattr(bounces, key)) is not None:
            table.attrs[key] = value
    seal(table.attrs)


def bounces_in(group: Any, path: Path) -> Bounces:
    """Return the bounces in a group of results.

    Raises
    ------
    FileError, KeyError, TypeError, ValueError
        They are damaged.
    """
    table = hdf5.dataset(group, _NAME, path, (1,))
    known = table.attrs
    if not is_sound(known):
        raise ValueError
    fall = FreeFall(**{one.name: _value(known, one.name) for one in fields(FreeFall)}) if "g_m_s2" in known else None
    normal = _value(known, "normal") if "normal" in known else None
    u_tilt_deg = _value(known, "u_tilt_deg") if "u_tilt_deg" in known else None
    return Bounces(tuple(_bounce(row) for row in table[:]), fall, normal, u_tilt_deg)


def _value(attributes: Any, key: str) -> Any:
    value = np.asarray(attributes[key], dtype=np.float64).tolist()
    return tuple(value) if isinstance(value, list) else value


def _row(bounce: Bounce) -> tuple[Any, ...]:
    values = asdict(bounce) | {"method": layout.fitted(bounce.method, _METHOD_BYTES)}
    return tuple(values[str(name)] for name in BOUNCE_TYPE.names or ())


def _bounce(row: Any) -> Bounce:
    values = {name: row[name].item() for name in BOUNCE_TYPE.names or () if name != "method"}
    return Bounce(**values, method=bytes(row["method"]).decode("utf-8", "replace"))
