"""Turn pydantic's report on a setup into one clear line: key, value, allowed range."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cache
from itertools import islice
from typing import Any

from pydantic import BaseModel, ValidationError

_NAMES = {
    "boolean": ("true or false", "of true or false"),
    "integer": ("a whole number", "whole numbers"),
    "number": ("a number", "numbers"),
    "string": ("a text", "texts"),
}
_OTHER = ("a value of another kind", "values of another kind")
_UNKNOWN_KEY = ("extra_forbidden", "unexpected_keyword_argument")
"""Of a model and of a dataclass."""


@dataclass(frozen=True, slots=True)
class Place:
    """What may stand at one place of the setup, in words.

    Attributes
    ----------
    schema
        JSON schema of this place, as pydantic makes it, resolved and without null.
    definitions
        The schemas that it refers to.
    """

    schema: Mapping[str, Any]
    definitions: Mapping[str, Any]

    @property
    def is_list(self) -> bool:
        """Whether several values stand here."""
        return self.schema.get("type") == "array"

    @property
    def is_table(self) -> bool:
        """Whether a table, or several, stands here."""
        return self.entry(0).is_table if self.is_list else "properties" in self.schema

    def keys(self) -> list[str]:
        """Return the keys of the table here, as they are written."""
        return list(self.schema.get("properties", ()))

    def entry(self, part: int | str) -> Place:
        """Return the place below: a key of a table, an entry of a list.

        Raises
        ------
        KeyError
            There is none.
        """
        if not (isinstance(part, int) and self.is_list):
            return _place(self.schema.get("properties", {})[part], self.definitions)
        kinds = self.schema.get("prefixItems") or [self.schema["items"]]
        return _place(kinds[min(part, len(kinds) - 1)], self.definitions)

    def allowed(self, scale: float = 1.0) -> str:
        """Return in words what may stand here; `scale`: shown value per stored value."""
        if self.is_table and not self.is_list:
            return f"a table with {', '.join(self.keys())}"
        if words := self.schema.get("description"):
            return str(words)
        if choices := self.schema.get("enum") or [self.schema[key] for key in ("const",) if key in self.schema]:
            return ", ".join(map(str, choices))
        if not self.is_list:
            return _names(self)[0] + self.span(scale)
        entry, fixed = self.entry(0), self.schema.get("prefixItems")
        count = str(len(fixed)) if fixed else f"{self.schema.get('minItems')} to {self.schema.get('maxItems')}"
        return f"{count} tables" if entry.is_table else f"a list of {count} {_names(entry)[1]}{entry.span(scale)}"

    def span(self, scale: float = 1.0) -> str:
        """Return the limits in words, as `allowed` shows them, with a space before; empty where there are none."""
        if self.schema.get("type") == "string":
            return ", not empty" if self.schema.get("minLength") else ""
        keys = ("minimum", "maximum", "exclusiveMinimum", "exclusiveMaximum")
        stored = (self.schema.get(key) for key in keys)
        low, high, above, below = (bound if bound is None else scale * bound for bound in stored)
        start = f" above {above:g}" if above is not None else f" from {low:g}" if low is not None else ""
        end = f" to below {below:g}" if below is not None else f" to {high:g}" if high is not None else " up"
        return (start + end).replace("e+0", "e").replace("e+", "e") if start else ""


def find_place(model: type[BaseModel], loc: Sequence[int | str]) -> Place | None:
    """Return the place that `loc` (keys and list indices from the top) leads to, None where there is none."""
    schema = _schema(model)
    place = _place(schema, schema.get("$defs", {}))
    for part in loc:
        try:
            place = place.entry(part)
        except KeyError:
            return None
    return place


def _names(place: Place) -> tuple[str, str]:
    return _NAMES.get(place.schema.get("type", ""), _OTHER)


@cache
def _schema(model: type[BaseModel]) -> dict[str, Any]:
    return model.model_json_schema()


def _place(schema: Mapping[str, Any], definitions: Mapping[str, Any]) -> Place:
    while "$ref" in schema or "anyOf" in schema:
        if "$ref" in schema:
            schema = definitions[schema["$ref"].rpartition("/")[2]]
        else:
            schema = next(option for option in schema["anyOf"] if option.get("type") != "null")
    return Place(schema, definitions)


LONGEST = 60
"""Characters of a key or value in a message: more than a line of it helps nobody. Chosen by hand."""


def describe(error: ValidationError, model: type[BaseModel]) -> str:
    """Return the most telling fault of a setup as one line that names key, value and allowed range."""
    faults = faults_in_order(error)
    more = len(faults) - 1
    return _line(faults[0], model) + (f" (and {more} more fault{'s'[: more > 1]})" if more else "")


def faults_in_order(error: ValidationError) -> list[Mapping[str, Any]]:
    """Return the faults as pydantic tells them, the most telling first, without those that only follow from others."""
    faults: list[Mapping[str, Any]] = list(error.errors(include_url=False))
    places = [tuple(fault["loc"]) for fault in faults]
    # pydantic counts a bad entry of a list as absent, and then calls the list too short as well
    faults = [
        fault
        for fault, place in zip(faults, places, strict=True)
        if not (fault["type"] == "too_short" and any(len(p) > len(place) and p[: len(place)] == place for p in places))
    ]
    return sorted(faults, key=_weight)


def _weight(fault: Mapping[str, Any]) -> int:
    """Return the rank of a fault: another schema explains all others, a mistyped key explains a missing one."""
    if fault["loc"] == ("schema",):
        return 0
    return 1 if fault["type"] in _UNKNOWN_KEY else 2


def _line(fault: Mapping[str, Any], model: type[BaseModel]) -> str:
    key, value, kind = dotted(fault["loc"]), fault["input"], fault["type"]
    place = find_place(model, fault["loc"])
    allowed = place.allowed() if place else fault["msg"]
    if place and place.is_list and place.is_table:
        allowed += f", each headed [[{key}]]"
    if kind == "missing":
        return f"{_header(fault['loc'], place)} is missing, allowed: {allowed}"
    if kind in _UNKNOWN_KEY:
        return f"{key} = {value_text(value)}: unknown key{_hint(fault['loc'], model)}"
    if kind == "value_error":
        text = str(fault["ctx"]["error"])
        if key and place and place.is_table:
            return f"{key}.{text}"
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


def flattened(value: object, place: str = "", *, every: bool = False) -> Iterator[tuple[str, Any]]:
    """Yield each value below tables with its dotted key; tables of a list, or every entry of one, count from 1."""
    if isinstance(value, Mapping):
        for key, below in value.items():
            yield from flattened(below, f"{place}.{key}" if place else str(key), every=every)
    elif isinstance(value, list | tuple) and (every or (value and isinstance(value[0], Mapping))):
        for number, below in enumerate(value, 1):
            yield from flattened(below, f"{place}[{number}]", every=every)
    else:
        yield place, list(value) if isinstance(value, tuple) else value


@dataclass(frozen=True, slots=True)
class ChangedSetting:
    """A dotted key of the setup with two values; None where it is left out."""

    key: str
    before: object
    after: object

    def __str__(self) -> str:
        before, after = ("left out" if value is None else value for value in (self.before, self.after))
        return f"{self.key}: {before} -> {after}"


def changed_settings(before: BaseModel, after: BaseModel) -> tuple[ChangedSetting, ...]:
    """Return the keys that two setups give different values, in the order of the setup file."""
    # of a calibration its file is named, not each covariance
    named: dict[str, Any] = {"exclude": {"calibration": {"content"}}, "mode": "json"}
    old, new = (dict(flattened(one.model_dump(by_alias=True, exclude_none=True, **named))) for one in (before, after))
    keys = dict.fromkeys((*old, *new))
    return tuple(ChangedSetting(key, old.get(key), new.get(key)) for key in keys if old.get(key) != new.get(key))


def key_text(key: str) -> str:
    """Return a key, quoted where TOML wants quotes, cut where it is long."""
    return _short(key if re.fullmatch(r"[A-Za-z0-9_-]+", key) else json.dumps(key, ensure_ascii=False))


def value_text(value: object) -> str:
    """Return a value the way it is written in TOML, cut where it is long."""
    return _short(_written(value))


def _written(value: object) -> str:
    match value:
        case bool():
            return "true" if value else "false"
        case str():
            return json.dumps(value[: 2 * LONGEST], ensure_ascii=False)
        case int():
            return str(value) if abs(value) < 10**LONGEST else "a number of many digits"
        case float():
            return repr(value)
        case dict():
            pairs = (f"{key_text(str(key))} = {_written(item)}" for key, item in islice(value.items(), LONGEST))
            return "{" + ", ".join(pairs) + "}"
        case list() | tuple():
            return "[" + ", ".join(_written(item) for item in value[:LONGEST]) + "]"
        case _:
            return str(value)


def _short(text: str) -> str:
    text = " ".join(text.split())
    return text if len(text) <= LONGEST else text[: LONGEST - 3] + "..."
