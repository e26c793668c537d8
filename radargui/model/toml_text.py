"""Keys and values as they stand in a TOML file, on one line and not too long."""

from __future__ import annotations

import json
import re
from itertools import islice

LONGEST = 60


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
