"""Values as JSON knows them: what is not a finite number becomes null."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np
from pydantic import BaseModel


def plain_value(value: object) -> Any:
    """Return dicts, lists, texts, numbers, booleans and None; NaN and infinities become None.

    Takes mappings, sequences, arrays, dataclasses and models, nested in any way; anything else becomes its text.
    """
    if value is None or isinstance(value, (bool, int, str)):
        return value
    if isinstance(value, float):
        return float(value) if math.isfinite(value) else None
    if isinstance(value, (np.generic, np.ndarray)):
        return plain_value(value.tolist())
    if isinstance(value, BaseModel):
        return plain_value(value.model_dump(mode="json", by_alias=True))
    if is_dataclass(value) and not isinstance(value, type):
        return {field.name: plain_value(getattr(value, field.name)) for field in fields(value)}
    if isinstance(value, Mapping):
        return {str(key): plain_value(item) for key, item in value.items()}
    if isinstance(value, Sequence):
        return [plain_value(item) for item in value]
    return str(value)


def json_bytes(value: object) -> bytes:
    """Return a value as indented JSON in UTF-8 that every reader takes: no NaN, no Infinity."""
    return (json.dumps(plain_value(value), ensure_ascii=False, allow_nan=False, indent=2) + "\n").encode(
        errors="replace"
    )
