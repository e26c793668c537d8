"""A place in the setup's models: what a key there may hold, in words."""

from __future__ import annotations

import types
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Annotated, Any, Literal, Union, get_args, get_origin

import annotated_types
from pydantic import BaseModel
from pydantic.fields import FieldInfo

_NAMES: dict[Any, tuple[str, str]] = {
    bool: ("true or false", "of true or false"),
    int: ("a whole number", "whole numbers"),
    float: ("a number", "numbers"),
    str: ("a text", "texts"),
}


@dataclass(frozen=True, slots=True)
class Place:
    """The type wanted at one place.

    Attributes
    ----------
    kind
        The type without Annotated and without None.
    limits
        Constraints on it.
    words
        The model's own words for what is allowed; empty where the limits say it all.
    """

    kind: Any
    limits: list[Any] = field(default_factory=list)
    words: str = ""

    @property
    def is_list(self) -> bool:
        """Whether several values stand here."""
        return get_origin(self.kind) is tuple

    @property
    def is_table(self) -> bool:
        """Whether a table, or several, stands here."""
        return _is_model(self.entry(0).kind) if self.is_list else _is_model(self.kind)

    def keys(self) -> list[str]:
        """Return the keys of the table here, as they are written."""
        fields = self.kind.model_fields if _is_model(self.kind) else {}
        return [info.alias or name for name, info in fields.items()]

    def entry(self, part: int | str) -> Place:
        """Return the place below: a key of a table, an entry of a list.

        Raises
        ------
        KeyError
            There is none.
        """
        if isinstance(part, int) and self.is_list:
            kinds = get_args(self.kind)
            return _place(kinds[0] if kinds[-1] is ... else kinds[min(part, len(kinds) - 1)])
        if _is_model(self.kind):
            for name, info in self.kind.model_fields.items():
                if part in (name, info.alias):
                    return _place(info.annotation, [info])
        raise KeyError(part)

    def allowed(self) -> str:
        """Return in words what may stand here."""
        if self.words:
            return self.words
        if get_origin(self.kind) is Literal:
            return ", ".join(str(value) for value in get_args(self.kind))
        if self.is_list:
            return self._allowed_list()
        if _is_model(self.kind):
            return f"a table with {', '.join(self.keys())}"
        return _names(self.kind)[0] + self.span()

    def _allowed_list(self) -> str:
        entry, kinds = self.entry(0), get_args(self.kind)
        low, high = _bounds(self.limits, "min_length", "max_length")
        count = f"{low} to {high}" if kinds[-1] is ... else str(len(kinds))
        if entry.is_table:
            return f"{count} tables"
        return f"a list of {count} {_names(entry.kind)[1]}{entry.span()}"

    def span(self) -> str:
        """Return the limits in words, with a space before; empty where there are none."""
        if self.kind is str:
            return ", not empty" if _bounds(self.limits, "min_length", "max_length")[0] else ""
        low, high = _bounds(self.limits, "ge", "le")
        above, below = _bounds(self.limits, "gt", "lt")
        start = f" above {above:g}" if above is not None else f" from {low:g}" if low is not None else ""
        end = f" to below {below:g}" if below is not None else f" to {high:g}" if high is not None else " up"
        return (start + end).replace("e+0", "e").replace("e+", "e") if start else ""


def find_place(model: type[BaseModel], loc: Sequence[int | str]) -> Place | None:
    """Return the place that `loc` (keys and list indices from the top) leads to, None where there is none."""
    place = Place(model)
    for part in loc:
        try:
            place = place.entry(part)
        except KeyError:
            return None
    return place


def _names(kind: Any) -> tuple[str, str]:
    return _NAMES.get(kind, ("a value of another kind", "values of another kind"))


def _is_model(kind: Any) -> bool:
    return isinstance(kind, type) and issubclass(kind, BaseModel)


def _bounds(limits: list[Any], low: str, high: str) -> tuple[Any, Any]:
    found: dict[str, Any] = {}
    for limit in limits:
        for name in (low, high):
            bound = getattr(limit, name, None)
            if bound is not None:
                found.setdefault(name, bound)
    return found.get(low), found.get(high)


def _place(kind: Any, limits: Sequence[Any] = ()) -> Place:
    found: list[Any] = list(limits)
    while True:
        if get_origin(kind) is Annotated:
            found += get_args(kind)[1:]
            kind = get_args(kind)[0]
        elif get_origin(kind) in (Union, types.UnionType):
            kind = next(option for option in get_args(kind) if option is not type(None))
        else:
            break
    words = next((info.description for info in found if isinstance(info, FieldInfo) and info.description), "")
    flat = [limit for item in found for limit in (item.metadata if isinstance(item, FieldInfo) else [item])]
    flat = [limit for item in flat for limit in (item if isinstance(item, annotated_types.Interval) else [item])]
    return Place(kind, flat, words)
