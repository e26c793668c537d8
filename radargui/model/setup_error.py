"""One clear line from what pydantic says of a setup: key, value, allowed range."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from difflib import get_close_matches
from typing import Any

from pydantic import BaseModel, ValidationError

from radargui.model.setup_place import Place, find_place
from radargui.model.toml_text import key_text, value_text


def describe(error: ValidationError, model: type[BaseModel]) -> str:
    """Return the most telling fault of a setup as one line that names key, value and allowed range."""
    faults = error.errors(include_url=False)
    places = [tuple(fault["loc"]) for fault in faults]
    # pydantic counts a bad entry of a list as absent, and then calls the list too short as well
    faults = [
        fault
        for fault, place in zip(faults, places, strict=True)
        if not (fault["type"] == "too_short" and any(len(p) > len(place) and p[: len(place)] == place for p in places))
    ]
    faults.sort(key=_weight)
    more = len(faults) - 1
    return _line(faults[0], model) + (f" (and {more} more fault{'s'[: more > 1]})" if more else "")


def _weight(fault: Mapping[str, Any]) -> int:
    """Return the rank of a fault: another schema explains all others, a mistyped key explains a missing one."""
    if fault["loc"] == ("schema",):
        return 0
    return 1 if fault["type"] == "extra_forbidden" else 2


def _line(fault: Mapping[str, Any], model: type[BaseModel]) -> str:
    key, value, kind = dotted(fault["loc"]), fault["input"], fault["type"]
    place = find_place(model, fault["loc"])
    allowed = place.allowed() if place else fault["msg"]
    if place and place.is_list and place.is_table:
        allowed += f", each headed [[{key}]]"
    if kind == "missing":
        return f"{_header(fault['loc'], place)} is missing, allowed: {allowed}"
    if kind == "extra_forbidden":
        return f"{key} = {value_text(value)}: unknown key{_hint(fault['loc'], model)}"
    if kind == "value_error":
        text = str(fault["ctx"]["error"])
        return f"{key} = {value_text(value)}, {text}" if key else text
    return f"{key} = {value_text(value)}, allowed: {allowed}"


def _hint(loc: Sequence[int | str], model: type[BaseModel]) -> str:
    parent = find_place(model, loc[:-1])
    known = parent.keys() if parent else []
    close = get_close_matches(str(loc[-1]), known, n=1)
    meant = f" (did you mean {close[0]}?)" if close else ""
    return f"{meant}, allowed here: {', '.join(known)}"


def _header(loc: Sequence[int | str], place: Place | None) -> str:
    """Return a missing key as it is written in the file, a table with its brackets."""
    if place is None or not place.is_table or len(loc) != 1:
        return dotted(loc)
    return f"[[{loc[0]}]]" if place.is_list else f"[{loc[0]}]"


def dotted(loc: Sequence[int | str]) -> str:
    """Return a place as the user knows it: receiver[2].tilt_deg, counted from 1."""
    text = ""
    for part in loc:
        if isinstance(part, int):
            text += f"[{part + 1}]"
        else:
            text += f".{key_text(part)}" if text else key_text(part)
    return text
