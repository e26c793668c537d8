"""Values as JSON knows them: what is not a finite number becomes null."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
from pydantic_core import to_jsonable_python


def plain_value(value: object) -> Any:
    """Return dicts, lists, texts, numbers, booleans and None; NaN and infinities become None.

    Takes mappings, sequences, arrays, dataclasses and models, nested in any way; anything else becomes its text.
    """
    return to_jsonable_python(value, by_alias=True, inf_nan_mode="null", fallback=_unknown)


def _unknown(value: object) -> object:
    return value.tolist() if isinstance(value, (np.generic, np.ndarray)) else str(value)


def json_bytes(value: object) -> bytes:
    """Return a value as indented JSON in UTF-8 that every reader takes: no NaN, no Infinity."""
    return (json.dumps(plain_value(value), ensure_ascii=False, allow_nan=False, indent=2) + "\n").encode(
        errors="replace"
    )
