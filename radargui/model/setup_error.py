"""One clear line from what pydantic says: key, value, allowed range."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, get_args

import annotated_types
from pydantic import BaseModel, ValidationError

NOT_YET: dict[str, tuple[str, ...]] = {"processing.correction": ("adaptive", "joint")}
"""Values of the contract that this version does not offer yet."""


def describe(error: ValidationError, model: type[BaseModel]) -> str:
    """Return the first fault of a setup as one line that names key, value and allowed range."""
    faults = error.errors(include_url=False)
    text = _one(faults[0], model)
    if len(faults) > 1:
        text += f" (and {len(faults) - 1} more)"
    return text


def _one(fault: Any, model: type[BaseModel]) -> str:
    loc = tuple(part for part in fault["loc"] if not _is_branch(part))
    key = dotted(loc)
    kind = fault["type"]
    value = fault["input"]
    if kind == "missing":
        need = " (1 to 4 are needed)" if key == "receiver" else ""
        return f"{bracketed(loc)} is missing{need}" if len(loc) == 1 else f"{key} is missing"
    if kind == "extra_forbidden":
        known = ", ".join(_keys_beside(loc, model))
        return f"{key} = {shown(value)}: unknown key; allowed here: {known}"
    if kind == "value_error":
        text = str(fault["ctx"]["error"]) if "ctx" in fault else fault["msg"]
        return f"{key} = {shown(value)}: {text}" if key else text
    if value in NOT_YET.get(key, ()) if isinstance(value, str) else False:
        return f"{key} = {shown(value)}: not offered by this version yet; allowed: {fault['ctx']['expected']}"
    if key == "schema":
        return f"schema = {shown(value)}: this version reads schema 1; allowed: 1"
    allowed = _allowed(loc, model) or fault["msg"]
    return f"{key} = {shown(value)}: allowed {allowed}"


def _is_branch(part: object) -> bool:
    return isinstance(part, str) and ("[" in part or part in {"float", "int", "str", "bool"})


def dotted(loc: Sequence[object]) -> str:
    """Return a place as the user knows it: receiver[2].tilt_deg, counted from 1."""
    text = ""
    for part in loc:
        if isinstance(part, int):
            text += f"[{part + 1}]"
        else:
            text += f".{part}" if text else str(part)
    return text


def bracketed(loc: Sequence[object]) -> str:
    """Return a table's name as it is written in the file."""
    name = str(loc[0])
    if name == "schema":
        return "schema"
    return f"[[{name}]]" if name == "receiver" else f"[{name}]"


def shown(value: object) -> str:
    """Return a value short enough for one line."""
    text = " ".join(repr(value).split())
    return text if len(text) <= 60 else text[:57] + "..."


def _annotation_models(annotation: Any) -> list[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [model for argument in get_args(annotation) for model in _annotation_models(argument)]


def _walk(loc: Sequence[object], model: type[BaseModel]) -> tuple[type[BaseModel], Any]:
    """Return the innermost model that holds `loc`, and the field there."""
    here, field = model, None
    for part in loc:
        if not isinstance(part, str):
            continue
        if field is not None:
            inner = _annotation_models(field.annotation)
            if not inner:
                break
            here = inner[0]
        field = next((f for n, f in here.model_fields.items() if part in (n, f.alias)), None)
        if field is None:
            break
    return here, field


def _keys_beside(loc: Sequence[object], model: type[BaseModel]) -> list[str]:
    here, _ = _walk(loc, model)
    return [field.alias or name for name, field in here.model_fields.items()]


def _metadata(annotation: Any) -> list[Any]:
    found = list(getattr(annotation, "__metadata__", ()))
    for argument in get_args(annotation):
        found += _metadata(argument)
    return found


def _allowed(loc: Sequence[object], model: type[BaseModel]) -> str:
    _, field = _walk(loc, model)
    if field is None:
        return ""
    if any(hasattr(field.annotation, name) for name in ("model_fields",)):
        return "a table of keys"
    from typing import Literal, get_origin

    def literals(annotation: Any) -> list[object]:
        if get_origin(annotation) is Literal:
            return list(get_args(annotation))
        return [value for argument in get_args(annotation) for value in literals(argument)]

    values = literals(field.annotation)
    if values:
        return ", ".join(str(value) for value in values)
    low = high = ""
    for item in [*field.metadata, *_metadata(field.annotation)]:
        for constraint in getattr(item, "metadata", None) or [item]:
            match constraint:
                case annotated_types.Ge(ge=bound):
                    low = low or f"{bound:g}"
                case annotated_types.Gt(gt=bound):
                    low = low or f"above {bound:g}"
                case annotated_types.Le(le=bound):
                    high = high or f"{bound:g}"
                case annotated_types.Lt(lt=bound):
                    high = high or f"below {bound:g}"
                case _:
                    pass
    kind = _kind(field.annotation)
    span = f"{low} to {high}" if low and high else (f"{low} or more" if low else (f"up to {high}" if high else ""))
    return f"{kind} {span}".strip()


def _kind(annotation: Any) -> str:
    text = str(annotation)
    for word, name in (
        ("tuple", "a list of"),
        ("bool", "true or false"),
        ("int", "a whole number"),
        ("float", "a number"),
    ):
        if word in text:
            return name
    return "a text"
