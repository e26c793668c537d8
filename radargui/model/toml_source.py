"""TOML text as plain values, whoever wrote it."""

from __future__ import annotations

import re
import tomllib
from typing import Any

MOST_KEY_PARTS = 32
_PART = r"""(?:[\w-]++|"[^"\n]*+"|'[^'\n]*+')"""
_ENDLESS_KEY = re.compile(rf"(?<![\w-]){_PART}(?:[ \t]*+\.[ \t]*+{_PART}){{{MOST_KEY_PARTS}}}")


def load_toml(text: str) -> dict[str, Any]:
    """Return the tables of a TOML text.

    Raises
    ------
    ValueError
        Not TOML, or nested or long beyond all use; the text says where.
    """
    # The parser's memory grows with the square of the number of parts of a key.
    if _ENDLESS_KEY.search(text):
        raise ValueError("a key of too many parts")
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError:
        raise
    except RecursionError:
        raise ValueError("tables or lists nested too deep") from None
    except ValueError:
        raise ValueError("a number has too many digits") from None
